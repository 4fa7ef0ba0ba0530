//! `clearance check`: reads states, reports collisions and distances.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use clap::Args;
use clearance::checker::{CollisionChecker, CollisionReport, ConstantContacts, Question, Workspace};
use clearance::robot::Configuration;
use clearance::scene::BodyId;
use clearance_files::readable_text::on_one_line;
use rayon::prelude::*;
use serde::Serialize;

use super::check_gradient::{self, GradientResult};
use super::failure::Failure;
use super::model_args::{ModelArgs, WorldArgs};
use super::progress::Progress;
use super::run_args::{Format, RunArgs, Stats, internal, print_line};
use super::states;
use super::timing::{self, Timing};

/// Number of states that are compared at once, before it is decided whether more are needed.
const STATES_AT_ONCE: usize = 64;

#[derive(Args)]
pub struct CheckArgs {
    #[command(flatten)]
    model: ModelArgs,

    #[command(flatten)]
    world: WorldArgs,

    #[command(flatten)]
    input: StateArgs,

    /// Query on each state
    #[arg(long, value_enum, default_value_t = Query::Free)]
    query: Query,

    /// Largest distance in metres that is reported [default: no limit]
    #[arg(
        long,
        value_name = "M",
        default_value_t = f64::INFINITY,
        hide_default_value = true,
        allow_negative_numbers = true
    )]
    limit: f64,

    /// With --query pair-distances: also signed distances, normals and witness points of the pairs, and derivatives with respect to each
    /// joint
    #[arg(long)]
    gradient: bool,

    #[command(flatten)]
    run: RunArgs,
}

#[derive(Args)]
#[group(required = true, multiple = false)]
struct StateArgs {
    /// States: JSON {"joints": [...], "states": [[...]]}, the YAML of a sensor_msgs/JointState or moveit_msgs/RobotState, or CSV with a
    /// header of joint names
    #[arg(long, value_name = "FILE")]
    states: Option<PathBuf>,

    /// One state, such as "j1=0.1 j2=-1.2"; other joints take 0, or the middle of limits that exclude 0
    #[arg(long, value_name = "J=X ...", allow_hyphen_values = true)]
    state: Option<String>,
}

#[derive(clap::ValueEnum, Clone, Copy, PartialEq, Eq)]
enum Query {
    /// Whether the state is free; stops at the first collision
    Free,
    /// All colliding pairs
    Pairs,
    /// The smallest distance, its pair and witness points
    Distance,
    /// The distance of every pair
    PairDistances,
}

/// Output in JSON format.
#[derive(Serialize)]
struct CheckOutput {
    robot: String,
    joints: Vec<String>,
    pairs_checked: usize,
    load_seconds: f64,
    results: Vec<StateResult>,
    /// Sums over all states.
    stats: Stats,
    #[serde(skip_serializing_if = "Option::is_none")]
    timing: Option<Timing>,
}

#[derive(Serialize)]
struct StateResult {
    free: bool,
    self_collision: bool,
    world_collision: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    pairs: Option<Vec<[String; 2]>>,
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    distance: Option<DistanceResult>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pair_distances: Option<Vec<(String, String, f64)>>,
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    gradient: Option<GradientResult>,
}

#[derive(Serialize)]
struct DistanceResult {
    /// In metres; null beyond the limit.
    distance: Option<f64>,
    nearest: Option<[String; 2]>,
    witness_points: Option<[[f64; 3]; 2]>,
}

pub fn run(args: &CheckArgs) -> Result<ExitCode, Failure> {
    if args.limit.is_nan() || args.limit < 0.0 {
        return Err(Failure::Input("--limit must be zero or more metres".to_owned()));
    }
    if args.gradient && args.query != Query::PairDistances {
        return Err(Failure::Input("--gradient needs --query pair-distances".to_owned()));
    }
    let start = Instant::now();
    let checker = args.run.pairs.checker(&args.model, &args.world)?;
    let load_seconds = start.elapsed().as_secs_f64();
    let robot = checker.robot();
    let states = match (&args.input.states, &args.input.state) {
        (Some(path), _) => states::from_file(path, robot)?,
        (None, Some(text)) => vec![states::from_text("--state", text, robot)?],
        (None, None) => return Err(Failure::Input("give --states or --state".to_owned())),
    };
    if checker.pairs().is_empty() {
        log::warn!("there is no pair to check: every state counts as free");
    }
    if let Some(note) = robot.limits_note("state", states.iter().map(|q| [q])) {
        log::warn!("{note}");
    }
    let question = args.question();
    let reports = check_all(&checker, &states, question, &args.run)?;
    if let Some(remark) = constant_contacts(&checker, &states, &reports, args)? {
        log::warn!("{remark}");
    }
    let gradients = args.gradients(&checker, &states)?;
    let timing = time_passes(&checker, &states, args);
    let output = CheckOutput {
        robot: robot.name().to_owned(),
        joints: robot.position_names().to_vec(),
        pairs_checked: checker.pairs().len(),
        load_seconds,
        stats: Stats::total(reports.iter().map(|report| report.work)),
        results: (reports.iter().zip(gradients))
            .map(|(report, gradient)| StateResult {
                gradient,
                ..StateResult::new(args.query, report, &checker)
            })
            .collect(),
        timing,
    };
    match args.run.format {
        Format::Json => print_line(&serde_json::to_string(&output).map_err(internal)?)?,
        Format::Text => print_line(&text(&output))?,
    }
    let all_free = reports.iter().all(CollisionReport::is_free);
    Ok(ExitCode::from(u8::from(!all_free)))
}

impl CheckArgs {
    fn question(&self) -> Question {
        let limit = self.limit;
        match self.query {
            Query::Free => Question::Free,
            Query::Pairs => Question::Pairs,
            Query::Distance => Question::Distance { limit },
            Query::PairDistances => Question::PairDistances { limit },
        }
    }

    /// The derivatives of each state, if they are requested.
    fn gradients(
        &self,
        checker: &CollisionChecker,
        states: &[Configuration],
    ) -> Result<Vec<Option<GradientResult>>, Failure> {
        if !self.gradient {
            return Ok(states.iter().map(|_| None).collect());
        }
        let found = check_gradient::clearances(checker, states, self.limit, &self.run)?;
        Ok(found.iter().map(|clearance| Some(GradientResult::new(clearance, checker))).collect())
    }
}

/// One report per state, in the order of the states, independent of the number of threads.
fn check_all(
    checker: &CollisionChecker,
    states: &[Configuration],
    question: Question,
    run: &RunArgs,
) -> Result<Vec<CollisionReport>, Failure> {
    let progress = Progress::new(states.len());
    let pool = run.pool(states.len())?;
    Ok(pool.install(|| {
        (states.par_iter())
            .map_init(
                || checker.workspace(),
                |workspace, q| {
                    let report = checker.check(q, question, workspace);
                    progress.piece_done();
                    report
                },
            )
            .collect()
    }))
}

/// Remark about link pairs that are in contact in all states, if every state collides and there are enough states.
fn constant_contacts(
    checker: &CollisionChecker,
    states: &[Configuration],
    reports: &[CollisionReport],
    args: &CheckArgs,
) -> Result<Option<String>, Failure> {
    if states.len() < ConstantContacts::FEWEST_STATES || reports.iter().any(CollisionReport::is_free) {
        return Ok(None);
    }
    let mut contacts = ConstantContacts::default();
    let pool = args.run.pool(states.len())?;
    for (states, reports) in states.chunks(STATES_AT_ONCE).zip(reports.chunks(STATES_AT_ONCE)) {
        // other queries do not report all pairs
        let pairs = |workspace: &mut Workspace, q: &Configuration, report: &CollisionReport| {
            if args.query == Query::Pairs {
                return report.colliding_pairs.clone();
            }
            checker.check(q, Question::Pairs, workspace).colliding_pairs
        };
        let all: Vec<Vec<(BodyId, BodyId)>> = pool.install(|| {
            let each = states.par_iter().zip(reports);
            each.map_init(|| checker.workspace(), |workspace, (q, report)| pairs(workspace, q, report))
                .collect()
        });
        states.iter().zip(&all).for_each(|(q, pairs)| contacts.add(q, pairs));
        if !contacts.is_open() {
            return Ok(None);
        }
    }
    Ok(contacts.remark(&format!("all {} states", states.len()), checker))
}

fn time_passes(checker: &CollisionChecker, states: &[Configuration], args: &CheckArgs) -> Option<Timing> {
    let (question, mut workspace) = (args.question(), checker.workspace());
    timing::measure(args.run.repeat, states.len(), || {
        for q in states {
            if args.gradient {
                std::hint::black_box(checker.clearance(q, args.limit, &mut workspace));
            } else if question == Question::Free {
                std::hint::black_box(checker.is_free(q, &mut workspace));
            } else {
                std::hint::black_box(checker.check(q, question, &mut workspace));
            }
        }
    })
}

impl StateResult {
    fn new(query: Query, report: &CollisionReport, checker: &CollisionChecker) -> Self {
        let names = |a: BodyId, b: BodyId| sorted_names(checker, a, b);
        let sorted_pairs = || {
            let mut pairs: Vec<_> = (report.colliding_pairs.iter()).map(|&(a, b)| names(a, b)).collect();
            pairs.sort();
            pairs
        };
        let distances = || {
            let pairs = report.pair_distances.iter();
            pairs
                .map(|p| {
                    let [a, b] = names(p.a, p.b);
                    (a, b, p.distance)
                })
                .collect()
        };
        Self {
            free: report.is_free(),
            self_collision: report.self_collision,
            world_collision: report.world_collision,
            pairs: (query == Query::Pairs).then(sorted_pairs),
            distance: (query == Query::Distance).then(|| DistanceResult::new(report, checker)),
            pair_distances: (query == Query::PairDistances).then(distances),
            gradient: None,
        }
    }
}

impl DistanceResult {
    /// Sorts the names, and the witness points with them.
    fn new(report: &CollisionReport, checker: &CollisionChecker) -> Self {
        let nearest = report.nearest;
        Self {
            distance: nearest.map(|n| n.distance),
            nearest: nearest.map(|n| sorted_names(checker, n.a, n.b)),
            witness_points: nearest.map(|n| {
                let mut points = n.witness_points.map(|p| [p.x, p.y, p.z]);
                if checker.body_name(n.a) > checker.body_name(n.b) {
                    points.swap(0, 1);
                }
                points
            }),
        }
    }
}

fn sorted_names(checker: &CollisionChecker, a: BodyId, b: BodyId) -> [String; 2] {
    let mut names = [a, b].map(|body| checker.body_name(body).to_owned());
    names.sort();
    names
}

/// One line per state, and a summary.
fn text(output: &CheckOutput) -> String {
    let mut lines: Vec<String> =
        (output.results.iter().enumerate()).flat_map(|(i, r)| state_lines(i, r)).collect();
    let free = output.results.iter().filter(|r| r.free).count();
    lines.push(format!(
        "{}: {free} of {} states free; {} pairs checked; loaded in {:.3} s",
        output.robot,
        output.results.len(),
        output.pairs_checked,
        output.load_seconds
    ));
    if let Some(t) = output.timing {
        lines.push(format!(
            "{:.3} µs a state (best of {} passes; median {:.3} µs)",
            t.us_min, t.passes, t.us_median
        ));
    }
    lines.iter().map(|line| on_one_line(line)).collect::<Vec<_>>().join("\n")
}

fn state_lines(index: usize, result: &StateResult) -> Vec<String> {
    let verdict = match (result.self_collision, result.world_collision) {
        (false, false) => "free",
        (true, false) => "COLLIDING with itself",
        (false, true) => "COLLIDING with the world",
        (true, true) => "COLLIDING with itself and the world",
    };
    let distance = result.distance.as_ref().map_or_else(String::new, |d| match (d.distance, &d.nearest) {
        (Some(m), Some([a, b])) => format!(", least distance {m:.6} m: {a} – {b}"),
        _ => ", nothing within the limit".to_owned(),
    });
    let first = format!("state {index}: {verdict}{distance}");
    let pairs = result.pairs.iter().flatten();
    let distances = result.pair_distances.iter().flatten();
    (std::iter::once(first))
        .chain(pairs.map(|[a, b]| format!("  {a} – {b}")))
        .chain(distances.enumerate().map(|(i, (a, b, m))| {
            let gradient = result.gradient.as_ref().map(|gradient| format!(", {}", gradient.words(i)));
            format!("  {m:.6} m: {a} – {b}{}", gradient.unwrap_or_default())
        }))
        .collect()
}
