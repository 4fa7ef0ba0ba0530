//! `clearance plan`: searches a path between two states whose edges are proven free.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;
use clearance::checker::{CollisionChecker, MotionOptions};
use clearance::motion::Certificate;
use clearance::planner::{self, NoPlan, Path, Plan, PlanError, PlanOptions};
use clearance::robot::{Configuration, GroupState, JointGroup, JointId, JointKind, RobotModel};
use clearance_files::readable_text::on_one_line;
use serde::Serialize;

use super::certificate_file;
use super::exit_status::ExitStatus;
use super::failure::Failure;
use super::model_args::{ModelArgs, WorldArgs};
use super::run_args::{Format, PairArgs, internal, positive, print_line};
use super::states;

#[derive(Args)]
pub struct PlanArgs {
    #[command(flatten)]
    model: ModelArgs,

    #[command(flatten)]
    world: WorldArgs,

    /// Only the joints of this group of the SRDF move, without its passive joints [default: all joints that are not passive, planar or
    /// floating]
    #[arg(long, value_name = "NAME")]
    group: Option<String>,

    /// Start: "j1=0.1 j2=-1.2", or the name of a group state of the SRDF. Joints that are not named take 0, or
    /// the middle of limits that exclude 0
    #[arg(long, value_name = "J=X ...", allow_hyphen_values = true)]
    from: String,

    /// Goal, as --from. Joints that are not named stay at the start
    #[arg(long, value_name = "J=X ...", allow_hyphen_values = true)]
    to: String,

    /// Seed of the random states
    #[arg(long, value_name = "N", default_value_t = 1, allow_negative_numbers = true)]
    seed: u64,

    /// Time limit in seconds
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    deadline: Option<f64>,

    /// Largest number of edges that are checked
    #[arg(long, value_name = "N", default_value_t = PlanOptions::default().most_edges, allow_negative_numbers = true)]
    max_edges: u64,

    /// Largest length of an edge of the search trees: the Euclidean norm of all changes (rad, m)
    #[arg(long, value_name = "D", default_value_t = PlanOptions::default().range, allow_negative_numbers = true)]
    range: f64,

    /// Number of shortcuts that are tried on the path
    #[arg(long, value_name = "N", default_value_t = PlanOptions::default().shortcuts, allow_negative_numbers = true)]
    shortcuts: u32,

    /// Write a certificate (proof that the path is free) to this file, as JSON; check it with `clearance verify`
    #[arg(long, value_name = "FILE")]
    certificate: Option<PathBuf>,

    #[command(flatten)]
    pairs: PairArgs,

    /// Output format
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

/// Output in JSON format.
#[derive(Serialize)]
struct PlanOutput {
    robot: String,
    /// Joints of the group.
    joints: Vec<String>,
    pairs_checked: usize,
    load_seconds: f64,
    plan_seconds: f64,
    /// `found` or `not_found`.
    result: &'static str,
    /// Positions of the joints at each state of the path.
    #[serde(skip_serializing_if = "Option::is_none")]
    states: Option<Vec<Vec<f64>>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    length: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    edges: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    nodes: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<&'static str>,
    #[serde(skip)]
    reason_text: String,
}

pub fn run(args: &PlanArgs) -> Result<ExitStatus, Failure> {
    let options = args.options()?;
    if let Some(file) = &args.certificate {
        certificate_file::check(file)?;
    }
    let start = Instant::now();
    let checker = args.pairs.checker(&args.model, &args.world)?;
    let load_seconds = start.elapsed().as_secs_f64();
    let robot = checker.robot();
    let of_name =
        |name: &String| robot.joint_group(name).map_err(|e| Failure::Input(format!("--group: {e}")));
    let group = args.group.as_ref().map_or_else(|| Ok(joints_by_default(robot)), of_name)?;
    let from = state("--from", &args.from, robot, &robot.default_configuration())?;
    let to = state("--to", &args.to, robot, &from)?;
    if checker.pairs().is_empty() {
        log::warn!("there is no pair to check: every motion counts as free");
    }
    if let Some(file) = &args.certificate {
        certificate_file::remove(file)?;
    }
    let begin = Instant::now();
    let deadline = args.deadline.and_then(|s| Duration::try_from_secs_f64(s).ok());
    let options = PlanOptions { deadline: deadline.and_then(|span| begin.checked_add(span)), ..options };
    let mut workspace = checker.workspace();
    let plan = planner::plan(&checker, &group, &from, &to, &options, &mut workspace);
    let plan = plan.map_err(|error| args.rejected(error))?;
    let plan_seconds = begin.elapsed().as_secs_f64();
    if let Some(note) = robot.limits_note("way", [[&from, &to]]) {
        log::warn!("{note}");
    }
    if let Some(file) = &args.certificate {
        match &plan {
            Plan::Found(path) => {
                certificate_file::write(file, &certificate(&checker, path, options.tolerance)?)?;
            }
            Plan::NotFound(_) => {
                log::warn!("no path was found: no certificate is written to {}", file.display());
            }
        }
    }
    let none = PlanOutput {
        robot: robot.name().to_owned(),
        joints: group.joint_names().to_vec(),
        pairs_checked: checker.pairs().len(),
        load_seconds,
        plan_seconds,
        result: "not_found",
        states: None,
        length: None,
        edges: None,
        nodes: None,
        reason: None,
        reason_text: String::new(),
    };
    let output = match &plan {
        Plan::Found(path) => none.with_path(path, &group),
        Plan::NotFound(reason) => none.with_reason(reason),
    };
    match args.format {
        Format::Json => print_line(&serde_json::to_string(&output).map_err(internal)?)?,
        Format::Text => print_line(&text(&output))?,
    }
    Ok(ExitStatus::of_answer(matches!(plan, Plan::Found(_))))
}

impl PlanArgs {
    fn options(&self) -> Result<PlanOptions, Failure> {
        self.deadline.map(|s| positive("--deadline", s)).transpose()?;
        Ok(PlanOptions {
            seed: self.seed,
            range: positive("--range", self.range)?,
            most_edges: self.max_edges,
            shortcuts: self.shortcuts,
            ..PlanOptions::default()
        })
    }

    /// Why there is nothing to plan; errors about a group that was not given name the kinds of joints instead.
    fn rejected(&self, error: PlanError) -> Failure {
        match error {
            PlanError::OtherJoint { joint, .. } if self.group.is_none() => Failure::Input(format!(
                "start and goal differ in {joint} of a planar or floating joint, which no path moves: leave it out of --to"
            )),
            PlanError::EmptyGroup(robot) if self.group.is_none() => Failure::Input(format!(
                "robot '{robot}' has no joint that a path moves: all are fixed, passive, planar or floating"
            )),
            error => Failure::input(error),
        }
    }
}

/// The joints that move without --group.
fn joints_by_default(robot: &RobotModel) -> JointGroup {
    let moves = |id: &JointId| {
        let joint = robot.joint(*id);
        let has_several_positions = matches!(joint.kind, JointKind::Planar(_) | JointKind::Floating);
        joint.mimic.is_none() && !joint.passive && !has_several_positions
    };
    JointGroup::of_joints(robot, robot.name(), &robot.joint_ids().filter(moves).collect::<Vec<_>>())
}

/// The state that an argument names; other joints are as in `rest`.
fn state(
    argument: &str,
    text: &str,
    robot: &RobotModel,
    rest: &Configuration,
) -> Result<Configuration, Failure> {
    let name = text.trim();
    let is_name =
        |state: &GroupState| state.name == name || format!("{}/{}", state.group, state.name) == name;
    let has_state = robot.srdf().is_some_and(|srdf| srdf.group_states.iter().any(is_name));
    if !has_state && (name.contains('=') || name.is_empty()) {
        states::from_text_over(argument, text, robot, rest)
    } else {
        robot.group_state_over(rest, name).map_err(|e| Failure::Input(format!("{argument}: {e}")))
    }
}

fn certificate(checker: &CollisionChecker, path: &Path, tolerance: f64) -> Result<Certificate, Failure> {
    let options = MotionOptions { tolerance, ..MotionOptions::default() };
    let certificate = path.certificate(checker, &options, &mut checker.workspace());
    certificate.ok_or_else(|| internal("a proven path could not be certified"))
}

impl PlanOutput {
    fn with_path(self, path: &Path, group: &JointGroup) -> Self {
        let positions = |q: &Configuration| {
            let mut positions = vec![0.0; group.len()];
            group.get(q, &mut positions);
            positions
        };
        Self {
            result: "found",
            states: Some(path.states.iter().map(positions).collect()),
            length: Some(path.length()),
            edges: Some(path.edges),
            nodes: Some(path.nodes),
            ..self
        }
    }

    fn with_reason(self, reason: &NoPlan) -> Self {
        Self { reason: Some(reason.reason()), reason_text: reason.to_string(), ..self }
    }
}

/// One line per state, and a summary.
fn text(output: &PlanOutput) -> String {
    let state = |(i, positions): (usize, &Vec<f64>)| {
        let named =
            output.joints.iter().zip(positions).map(|(joint, position)| format!("{joint}={position:.4}"));
        format!("state {i}: {}", named.collect::<Vec<_>>().join(" "))
    };
    let states = output.states.iter().flatten().enumerate().map(state);
    let found = match (&output.states, output.length, output.edges, output.nodes) {
        (Some(states), Some(length), Some(edges), Some(nodes)) => format!(
            "path of {} states, length {length:.3}, every edge proven free; edges checked: {edges}, nodes: {nodes}",
            states.len()
        ),
        _ => output.reason_text.clone(),
    };
    let summary = format!(
        "{}: {found}; planned in {:.1} ms; {} pairs checked; loaded in {:.3} s",
        output.robot,
        1e3 * output.plan_seconds,
        output.pairs_checked,
        output.load_seconds
    );
    states.chain([summary]).map(|line| on_one_line(&line).into_owned()).collect::<Vec<_>>().join("\n")
}
