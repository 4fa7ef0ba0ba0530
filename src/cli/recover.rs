//! `clearance recover`: reads states, searches free states near those that collide.

use std::time::{Duration, Instant};

use clap::Args;
use clearance::checker::{CollisionChecker, FreeState, Recovery, RecoveryOptions};
use clearance::robot::{Configuration, JointId, RobotModel};
use clearance::scene::BodyId;
use clearance_files::readable_text::on_one_line;
use rayon::prelude::*;
use serde::Serialize;

use super::exit_status::ExitStatus;
use super::failure::Failure;
use super::model_args::{ModelArgs, WorldArgs};
use super::progress::Progress;
use super::rounded_bounds::at_most;
use super::run_args::{Format, RunArgs, internal, positive, print_line};
use super::state_args::StateArgs;
use super::timing::{self, Timing};

#[derive(Args)]
pub struct RecoverArgs {
    #[command(flatten)]
    model: ModelArgs,

    #[command(flatten)]
    world: WorldArgs,

    #[command(flatten)]
    input: StateArgs,

    /// Only the joints of this group of the SRDF move, without its passive joints [default: all joints that are not passive, planar or
    /// floating]
    #[arg(long, value_name = "NAME")]
    group: Option<String>,

    /// Joints that stay where they are, as passive joints of the SRDF do
    #[arg(long, value_name = "JOINT,...", value_delimiter = ',')]
    locked: Vec<String>,

    /// Largest distance of the free state: the Euclidean norm of all changes (rad, m)
    #[arg(
        long,
        value_name = "D",
        default_value_t = RecoveryOptions::LARGEST_DISTANCE,
        allow_negative_numbers = true
    )]
    max_distance: f64,

    /// Distance in metres that the free state keeps from every collision
    #[arg(long, value_name = "M", default_value_t = RecoveryOptions::CLEARANCE, allow_negative_numbers = true)]
    clearance: f64,

    /// Largest number of states that are checked on the search from each given state
    #[arg(long, value_name = "N", default_value_t = RecoveryOptions::MOST_CHECKS)]
    max_checks: u64,

    /// Time limit in seconds for each given state
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    deadline: Option<f64>,

    #[command(flatten)]
    run: RunArgs,
}

/// Output in JSON format.
#[derive(Serialize)]
struct RecoverOutput {
    robot: String,
    joints: Vec<String>,
    pairs_checked: usize,
    load_seconds: f64,
    results: Vec<RecoverResult>,
    #[serde(skip_serializing_if = "Option::is_none")]
    timing: Option<Timing>,
}

#[derive(Serialize)]
struct RecoverResult {
    /// `already_free`, `found` or `none_found`.
    result: &'static str,
    /// The free state, in the order of the joints.
    #[serde(skip_serializing_if = "Option::is_none")]
    state: Option<Vec<f64>>,
    /// Its distance from the given state (rad, m).
    #[serde(skip_serializing_if = "Option::is_none")]
    distance: Option<f64>,
    /// t at the first exit from collision on the straight motion; proven free from here on.
    #[serde(skip_serializing_if = "Option::is_none")]
    exit: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<&'static str>,
    /// The pair that no joint moves apart.
    #[serde(skip_serializing_if = "Option::is_none")]
    pair: Option<[String; 2]>,
    checks: u64,
}

pub fn run(args: &RecoverArgs) -> Result<ExitStatus, Failure> {
    args.deadline.map(|s| positive("--deadline", s)).transpose()?;
    let start = Instant::now();
    let checker = args.run.pairs.checker(&args.model, &args.world)?;
    let load_seconds = start.elapsed().as_secs_f64();
    let robot = checker.robot();
    let options = args.options(robot)?;
    let states = args.input.read(robot)?;
    if checker.pairs().is_empty() {
        log::warn!("there is no pair to check: every state counts as free");
    }
    if let Some(note) = robot.limits_note("state", states.iter().map(|q| [q])) {
        log::warn!("{note}");
    }
    let found = recover_all(&checker, &states, &options, args)?;
    let timing = time_passes(&checker, &states, &options, args);
    let output = RecoverOutput {
        robot: robot.name().to_owned(),
        joints: robot.position_names().to_vec(),
        pairs_checked: checker.pairs().len(),
        load_seconds,
        results: found.iter().map(|recovery| RecoverResult::new(recovery, &checker)).collect(),
        timing,
    };
    match args.run.format {
        Format::Json => print_line(&serde_json::to_string(&output).map_err(internal)?)?,
        Format::Text => print_line(&text(&output, &states))?,
    }
    let all_free = !found.iter().any(|recovery| matches!(recovery, Recovery::NoneFound(_)));
    Ok(ExitStatus::of_answer(all_free))
}

impl RecoverArgs {
    fn options(&self, robot: &RobotModel) -> Result<RecoveryOptions, Failure> {
        for (option, value) in [("--max-distance", self.max_distance), ("--clearance", self.clearance)] {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(Failure::Input(format!("{option} must be a finite number, zero or more")));
            }
        }
        let of_group = |name: &String| {
            RecoveryOptions::of_group(robot, name).map_err(|e| Failure::Input(format!("--group: {e}")))
        };
        let options = self.group.as_ref().map(of_group).transpose()?.unwrap_or_default();
        let joint = |name: &String| {
            let of_position = name.rsplit_once('/').and_then(|(joint, _)| robot.joint_by_name(joint));
            let is_position = robot.position_names().contains(name);
            robot.joint_by_name(name).ok_or_else(|| match of_position.filter(|_| is_position) {
                Some(joint) => {
                    let joint = &robot.joint(joint).name;
                    Failure::Input(format!(
                        "--locked: '{name}' is a position of joint '{joint}': give the joint"
                    ))
                }
                None => Failure::Input(format!("--locked: the robot has no joint '{name}'")),
            })
        };
        Ok(RecoveryOptions {
            locked: self.locked.iter().map(joint).collect::<Result<Vec<JointId>, Failure>>()?,
            largest_distance: self.max_distance,
            clearance: self.clearance,
            most_checks: self.max_checks,
            ..options
        })
    }

    /// Options for a search that starts now.
    fn starting_now(&self, options: &RecoveryOptions) -> RecoveryOptions {
        let span = self.deadline.and_then(|s| Duration::try_from_secs_f64(s).ok());
        RecoveryOptions {
            deadline: span.and_then(|span| Instant::now().checked_add(span)),
            ..options.clone()
        }
    }
}

/// One result per state, in the order of the states, independent of the number of threads.
fn recover_all(
    checker: &CollisionChecker,
    states: &[Configuration],
    options: &RecoveryOptions,
    args: &RecoverArgs,
) -> Result<Vec<Recovery>, Failure> {
    let progress = Progress::new(states.len());
    let pool = args.run.pool(states.len())?;
    let found: Result<Vec<Recovery>, _> = pool.install(|| {
        let each = states.par_iter().map_init(
            || checker.workspace(),
            |workspace, q| {
                let found = checker.find_free_state(q, &args.starting_now(options), workspace);
                progress.piece_done();
                found
            },
        );
        each.collect()
    });
    found.map_err(internal)
}

fn time_passes(
    checker: &CollisionChecker,
    states: &[Configuration],
    options: &RecoveryOptions,
    args: &RecoverArgs,
) -> Option<Timing> {
    let mut workspace = checker.workspace();
    timing::measure(args.run.repeat, states.len(), || {
        for q in states {
            let _ =
                std::hint::black_box(checker.find_free_state(q, &args.starting_now(options), &mut workspace));
        }
    })
}

/// Which part of the way is proven free.
fn proven_part(exit: f64) -> String {
    if exit == 0.0 {
        return "the whole way is proven free".to_owned();
    }
    if exit >= 1.0 {
        return "collides on the way, only its end is proven free".to_owned();
    }
    format!("collides on the way, proven free from t = {} on", at_most(exit, 4))
}

impl RecoverResult {
    fn new(recovery: &Recovery, checker: &CollisionChecker) -> Self {
        let none = Self {
            result: "already_free",
            state: None,
            distance: None,
            exit: None,
            reason: None,
            pair: None,
            checks: 1,
        };
        match recovery {
            Recovery::AlreadyFree => none,
            Recovery::Found(FreeState { state, distance, exit, checks }) => Self {
                result: "found",
                state: Some(state.positions().to_vec()),
                distance: Some(*distance),
                exit: Some(*exit),
                checks: *checks,
                ..none
            },
            Recovery::NoneFound(no_free_state) => Self {
                result: "none_found",
                reason: Some(no_free_state.reason()),
                pair: no_free_state.unmoved.map(|(a, b)| names(a, b, checker)),
                checks: no_free_state.checks,
                ..none
            },
        }
    }

    fn lines(&self, index: usize, joints: &[String], from: &Configuration) -> Vec<String> {
        let checks = self.checks;
        let (Some(state), Some(distance), Some(exit)) = (&self.state, self.distance, self.exit) else {
            let why = match (&self.pair, self.reason) {
                (Some([a, b]), _) => format!(
                    "no joint that may move moves {a} and {b} apart by the clearance: let other joints move, or choose less --clearance"
                ),
                (None, Some("unfinished")) => format!(
                    "--max-checks or --deadline ended the search after {checks} checks: allow more, or a larger --max-distance"
                ),
                (None, Some(_)) => format!(
                    "none found within --max-distance, after {checks} checks: allow a larger one, or less --clearance"
                ),
                (None, None) => "already free".to_owned(),
            };
            return vec![format!("state {index}: {why}")];
        };
        let first = format!(
            "state {index}: free state at a distance of {distance:.4}; {}; {checks} checks",
            proven_part(exit)
        );
        let changes = joints.iter().zip(from.positions()).zip(state).filter(|((_, from), to)| from != to);
        let changes = changes.map(|((joint, from), to)| format!("  {joint}: {from:.4} to {to:.4}"));
        std::iter::once(first).chain(changes).collect()
    }
}

fn names(a: BodyId, b: BodyId, checker: &CollisionChecker) -> [String; 2] {
    let mut names = [a, b].map(|body| checker.body_name(body).to_owned());
    names.sort();
    names
}

/// Some lines per state, and a summary.
fn text(output: &RecoverOutput, states: &[Configuration]) -> String {
    let each = output.results.iter().zip(states).enumerate();
    let mut lines: Vec<String> =
        each.flat_map(|(i, (result, from))| result.lines(i, &output.joints, from)).collect();
    let count = |result: &str| output.results.iter().filter(|r| r.result == result).count();
    lines.push(format!(
        "{}: {} of {} states were free, {} free states found; {} pairs checked; loaded in {:.3} s",
        output.robot,
        count("already_free"),
        states.len(),
        count("found"),
        output.pairs_checked,
        output.load_seconds
    ));
    if let Some(Timing { passes, us_min, us_median }) = output.timing {
        lines.push(format!("{us_min:.3} µs a state (best of {passes} passes; median {us_median:.3} µs)"));
    }
    lines.iter().map(|line| on_one_line(line)).collect::<Vec<_>>().join("\n")
}
