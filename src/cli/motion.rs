//! `clearance motion`: reads motions, reports proofs or contacts.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Args;
use clearance::checker::{
    CollisionChecker, MotionClearanceOptions, MotionOptions, MotionOrder, MotionVerdict, TrajectoryReport,
};
use clearance::motion::{ContinuousTurn, MotionSegment, Trajectory};
use clearance::robot::{Configuration, RobotModel};
use clearance::scene::BodyId;
use clearance_files::readable_text::on_one_line;
use rayon::prelude::*;
use serde::Serialize;

use super::certificate_file;
use super::exit_status::ExitStatus;
use super::failure::Failure;
use super::model_args::{ModelArgs, WorldArgs};
use super::motion_args::MotionInputArgs;
use super::motion_clearance::ClearanceResult;
use super::progress::Progress;
use super::rounded_bounds::{at_least, at_most};
use super::run_args::{Format, RunArgs, Stats, internal, not_negative, positive, print_line};
use super::summary::Summary;
use super::timing::{self, Timing};

#[derive(Args)]
#[command(mut_group("motion", |group| group.required(true)))]
pub struct MotionArgs {
    #[command(flatten)]
    model: ModelArgs,

    #[command(flatten)]
    world: WorldArgs,

    #[command(flatten)]
    motion: MotionInputArgs,

    /// Decision threshold in metres: pairs that stay farther apart than this are always decided
    #[arg(long, value_name = "M", default_value_t = 5e-4, allow_negative_numbers = true)]
    tolerance: f64,

    /// Contact to search for
    #[arg(long, value_enum, default_value_t = Order::Earliest)]
    order: Order,

    /// Time limit per motion in seconds; a motion that is not decided by then is reported as undecided
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    deadline: Option<f64>,

    /// Write a certificate (proof that the motion is free) to this file, as JSON; check it with `clearance verify`
    #[arg(long, value_name = "FILE")]
    certificate: Option<PathBuf>,

    /// Report proven bounds on the least distance along each motion, of the robot from itself and from the world
    #[arg(long)]
    clearance: bool,

    /// Distance in metres that pairs have to keep, besides their paddings: find the first time at which a pair is nearer
    #[arg(long, value_name = "M", default_value_t = 0.0, allow_negative_numbers = true)]
    margin: f64,

    /// Report bounding volumes of the region that each link sweeps, in this many intervals (with --format json)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    swept_volumes: Option<u32>,

    #[command(flatten)]
    run: RunArgs,
}

#[derive(clap::ValueEnum, Clone, Copy, PartialEq, Eq)]
enum Order {
    /// The earliest: all before it is proven free
    Earliest,
    /// Any, as soon as possible
    Any,
}

/// Output in JSON format.
#[derive(Serialize)]
struct MotionOutput {
    robot: String,
    joints: Vec<String>,
    pairs_checked: usize,
    load_seconds: f64,
    results: Vec<MotionResult>,
    stats: Stats,
    #[serde(skip_serializing_if = "Option::is_none")]
    timing: Option<Timing>,
}

#[derive(Serialize)]
struct MotionResult {
    verdict: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    t: Option<[f64; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pair: Option<[String; 2]>,
    /// Common point of the pair (root frame) at the second t.
    #[serde(skip_serializing_if = "Option::is_none")]
    witness_point: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    distance: Option<[Option<f64>; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<&'static str>,
    /// For a trajectory: index of the straight or curved segment that the result is about; and time in seconds from the start.
    #[serde(skip_serializing_if = "Option::is_none")]
    segment: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    time: Option<[f64; 2]>,
    /// The continuous joints that turn. They move through all positions from the first to the last.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    turns: Vec<TurnResult>,
    #[serde(skip_serializing_if = "Option::is_none")]
    swept_volumes: Option<Vec<SweptVolumeResult>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    clearance: Option<ClearanceResult>,
    #[serde(skip)]
    reason_text: String,
}

#[derive(Serialize)]
struct TurnResult {
    joint: String,
    from: f64,
    to: f64,
}

/// Capsule: all points within `radius` of the line segment from `a` to `b`.
#[derive(Serialize)]
struct SweptVolumeResult {
    link: String,
    segment: usize,
    t: [f64; 2],
    a: [f64; 3],
    b: [f64; 3],
    radius: f64,
}

pub fn run(args: &MotionArgs) -> Result<ExitStatus, Failure> {
    let options = args.options()?;
    let start = Instant::now();
    let checker = args.run.pairs.checker(&args.model, &args.world)?;
    let load_seconds = start.elapsed().as_secs_f64();
    let robot = checker.robot();
    let robot_trajectories = args.motion.trajectories(robot)?;
    let trajectories = args.motion.with_obstacles(&robot_trajectories, checker.world())?;
    if args.certificate.is_some() && trajectories.len() != 1 {
        let count = trajectories.len();
        return Err(Failure::Input(format!("--certificate is for one way, but {count} are given")));
    }
    if let Some(path) = &args.certificate {
        // checked before the work whose result is written there
        certificate_file::check(path)?;
    }
    if checker.pairs().is_empty() {
        log::warn!("there is no pair to check: every motion counts as free");
    }
    let ends = |trajectory: &Trajectory| trajectory.segments().iter().flat_map(MotionSegment::ends).collect();
    let ends: Vec<Vec<Configuration>> = robot_trajectories.iter().map(ends).collect();
    if let Some(note) = robot.limits_note("way", &ends) {
        log::warn!("{note}");
    }
    if let Some(note) = long_turn_note(&robot_trajectories, robot) {
        log::warn!("{note}");
    }
    if let Some(path) = &args.certificate {
        certificate_file::remove(path)?;
    }
    let reports = check_all(&checker, &trajectories, &options, args)?;
    if let Some(path) = &args.certificate {
        write_certificate(&checker, &trajectories[0], &args.starting_now(&options), path)?;
    }
    let timing = time_passes(&checker, &trajectories, &options, args);
    let is_trajectory = args.motion.is_trajectory();
    let results = reports.iter().zip(&trajectories).zip(&robot_trajectories).map(
        |((report, trajectory), robot_trajectory)| {
            let swept = args.swept_volumes.map(|n| swept_volumes(&checker, robot_trajectory, n as usize));
            let turns = robot_trajectory.continuous_turns(robot).into_iter();
            let turns =
                turns.map(|ContinuousTurn { joint, from, to }| TurnResult { joint, from, to }).collect();
            MotionResult {
                turns,
                swept_volumes: swept,
                clearance: args.clearance(&checker, trajectory),
                ..MotionResult::new(report, trajectory, &checker, is_trajectory)
            }
            .with_margin(args.margin)
        },
    );
    let output = MotionOutput {
        robot: robot.name().to_owned(),
        joints: robot.position_names().to_vec(),
        pairs_checked: checker.pairs().len(),
        load_seconds,
        results: results.collect(),
        stats: Stats::total(reports.iter().map(|report| report.work)),
        timing,
    };
    match args.run.format {
        Format::Json => print_line(&serde_json::to_string(&output).map_err(internal)?)?,
        Format::Text => print_line(&text(&output))?,
    }
    let all_free = reports.iter().all(TrajectoryReport::is_free);
    Ok(ExitStatus::of_answer(all_free))
}

impl MotionArgs {
    fn options(&self) -> Result<MotionOptions, Failure> {
        self.deadline.map(|s| positive("--deadline", s)).transpose()?;
        not_negative("--margin", self.margin)?;
        self.motion.check_effect(self.run.pairs)?;
        if self.swept_volumes.is_some() && self.run.format == Format::Text {
            return Err(Failure::Input("--swept-volumes needs --format json".to_owned()));
        }
        Ok(MotionOptions {
            tolerance: positive("--tolerance", self.tolerance)?,
            margin: self.margin,
            order: match self.order {
                Order::Earliest => MotionOrder::Earliest,
                Order::Any => MotionOrder::Any,
            },
            ..MotionOptions::default()
        })
    }

    /// The least distances along a motion, if they are wanted.
    fn clearance(&self, checker: &CollisionChecker, trajectory: &Trajectory) -> Option<ClearanceResult> {
        let options =
            || MotionClearanceOptions { deadline: self.ends_at(), ..MotionClearanceOptions::default() };
        let is_trajectory = self.motion.is_trajectory();
        self.clearance.then(|| ClearanceResult::along(checker, trajectory, &options(), is_trajectory))
    }

    /// The deadline of a check that starts now.
    fn ends_at(&self) -> Option<Instant> {
        let span = self.deadline.and_then(|s| Duration::try_from_secs_f64(s).ok());
        span.and_then(|span| Instant::now().checked_add(span))
    }

    /// Options for a check that starts now.
    fn starting_now(&self, options: &MotionOptions) -> MotionOptions {
        MotionOptions { deadline: self.ends_at(), ..options.clone() }
    }
}

/// Warning about the first motion in which a continuous joint turns far, and the number of further ones.
fn long_turn_note(trajectories: &[Trajectory], robot: &RobotModel) -> Option<String> {
    let mut notes = trajectories
        .iter()
        .enumerate()
        .filter_map(|(i, trajectory)| Some((i, trajectory.long_turn_note(robot)?)));
    let (i, note) = notes.next()?;
    let which = if trajectories.len() > 1 { format!("motion {i}: ") } else { String::new() };
    let others = match notes.count() {
        0 => String::new(),
        others => format!("; likewise in {others} more motions"),
    };
    Some(format!("{which}{note}{others}"))
}

/// One report per motion, in the order of the motions, independent of the number of threads.
fn check_all(
    checker: &CollisionChecker,
    trajectories: &[Trajectory],
    options: &MotionOptions,
    args: &MotionArgs,
) -> Result<Vec<TrajectoryReport>, Failure> {
    let progress = Progress::new(trajectories.len());
    let pool = args.run.pool(trajectories.len())?;
    Ok(pool.install(|| {
        (trajectories.par_iter())
            .map_init(
                || checker.workspace(),
                |workspace, trajectory| {
                    let report = checker.check_trajectory(trajectory, &args.starting_now(options), workspace);
                    progress.piece_done();
                    report
                },
            )
            .collect()
    }))
}

fn time_passes(
    checker: &CollisionChecker,
    trajectories: &[Trajectory],
    options: &MotionOptions,
    args: &MotionArgs,
) -> Option<Timing> {
    let mut workspace = checker.workspace();
    timing::measure(args.run.repeat, trajectories.len(), || {
        for trajectory in trajectories {
            std::hint::black_box(checker.check_trajectory(
                trajectory,
                &args.starting_now(options),
                &mut workspace,
            ));
        }
    })
}

/// Writes the certificate of the single motion, if it is free.
fn write_certificate(
    checker: &CollisionChecker,
    trajectory: &Trajectory,
    options: &MotionOptions,
    path: &Path,
) -> Result<(), Failure> {
    let (report, certificate) = checker.certify_trajectory(trajectory, options, &mut checker.workspace());
    let Some(certificate) = certificate else {
        let verdict = match report.verdict {
            MotionVerdict::Contact { .. } if options.margin > 0.0 => "within the margin",
            _ => verdict_name(&report.verdict),
        };
        log::warn!("the way is {verdict}: no certificate is written to {}", path.display());
        return Ok(());
    };
    certificate_file::write(path, &certificate)
}

fn swept_volumes(
    checker: &CollisionChecker,
    trajectory: &Trajectory,
    intervals: usize,
) -> Vec<SweptVolumeResult> {
    let mut workspace = checker.workspace();
    let segments = trajectory.segments().iter().enumerate();
    segments
        .flat_map(|(segment, motion)| {
            let volumes = checker.swept_volumes(motion, intervals, &mut workspace);
            volumes.into_iter().map(move |v| (segment, v))
        })
        .map(|(segment, v)| SweptVolumeResult {
            link: checker.body_name(v.body).to_owned(),
            segment,
            t: v.t,
            a: v.a.coords.into(),
            b: v.b.coords.into(),
            radius: v.radius,
        })
        .collect()
}

fn verdict_name(verdict: &MotionVerdict) -> &'static str {
    match verdict {
        MotionVerdict::Free => "free",
        MotionVerdict::Contact { .. } => "contact",
        MotionVerdict::Undecided { .. } => "undecided",
    }
}

impl MotionResult {
    fn new(
        report: &TrajectoryReport,
        trajectory: &Trajectory,
        checker: &CollisionChecker,
        is_trajectory: bool,
    ) -> Self {
        let names = |(a, b): (BodyId, BodyId)| {
            let mut names = [a, b].map(|body| checker.body_name(body).to_owned());
            names.sort();
            names
        };
        let free = report.is_free();
        // index in the given trajectory, not in the parts into which moving obstacles split it
        let origin = |t: f64| trajectory.origin(report.segment, t);
        let mut output = Self {
            verdict: verdict_name(&report.verdict),
            t: None,
            pair: None,
            witness_point: None,
            distance: None,
            reason: None,
            segment: (is_trajectory && !free).then_some(origin(0.0).0),
            time: report.time,
            turns: Vec::new(),
            swept_volumes: None,
            clearance: None,
            reason_text: String::new(),
        };
        match report.verdict {
            MotionVerdict::Free => {}
            MotionVerdict::Contact { t, pair, witness } => {
                (output.t, output.pair) = (Some(t.map(|t| origin(t).1)), Some(names(pair)));
                output.witness_point = witness.map(|p| p.coords.into());
            }
            MotionVerdict::Undecided { t, pair, distance, reason } => {
                (output.t, output.pair) = (Some(t.map(|t| origin(t).1)), pair.map(names));
                output.distance = Some(distance.map(|d| d.is_finite().then_some(d)));
                output.reason = Some(reason.code());
                output.reason_text = reason.to_string();
            }
        }
        output
    }

    /// With a margin, a pair within it need not touch.
    fn with_margin(mut self, margin: f64) -> Self {
        if margin > 0.0 && self.verdict == "contact" {
            self.verdict = "within_margin";
        }
        self
    }

    /// The part of the motion that is not proven, for t from 0 to 1.
    fn when(&self, [first, last]: [f64; 2]) -> String {
        let [from, to] = [at_least(first, 6), at_most(last, 6)];
        // with the order "any", nothing before the contact is checked
        let is_any = first == 0.0 && last > 0.0;
        match self.verdict {
            "contact" if is_any => format!(", colliding at t = {to}"),
            "within_margin" if is_any => format!(", within the margin at t = {to}"),
            "within_margin" => format!(", farther until t = {from}, within the margin at t = {to}"),
            "contact" => format!(", free until t = {from}, colliding at t = {to}"),
            _ => format!(", open from t = {from} to {to}: {}", self.reason_text),
        }
    }

    fn text(&self) -> String {
        let verdict = if self.verdict == "free" {
            "free, proven".to_owned()
        } else {
            self.verdict.to_uppercase().replace('_', " ")
        };
        let pair = self.pair.as_ref().map_or_else(String::new, |[a, b]| format!(": {a} – {b}"));
        let when = self.t.map_or_else(String::new, |t| self.when(t));
        let segment = self.segment.map_or_else(String::new, |segment| format!(", in segment {segment}"));
        let time = self.time.map_or_else(String::new, |[lo, _]| format!(" after {} s", at_least(lo, 3)));
        let turn = |TurnResult { joint, from, to }: &TurnResult| format!("{joint} from {from} to {to}");
        let turns: Vec<String> = self.turns.iter().map(turn).collect();
        let turns = if turns.is_empty() { String::new() } else { format!("; turning {}", turns.join(", ")) };
        let clearance = self.clearance.as_ref().map_or_else(String::new, ClearanceResult::text);
        [verdict, pair, when, segment, time, turns, clearance].concat()
    }
}

/// One line per motion, and a summary.
fn text(output: &MotionOutput) -> String {
    let mut lines: Vec<String> =
        (output.results.iter().enumerate()).map(|(i, r)| format!("motion {i}: {}", r.text())).collect();
    let summary = Summary {
        robot: &output.robot,
        item: "motion",
        free: output.results.iter().filter(|r| r.verdict == "free").count(),
        count: output.results.len(),
        pairs_checked: output.pairs_checked,
        load_seconds: output.load_seconds,
        timing: output.timing,
    };
    lines.extend(summary.lines());
    lines.iter().map(|line| on_one_line(line)).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_claim_no_more_than_is_proven() {
        let text = |verdict: &'static str, t: [f64; 2]| {
            let result = MotionResult {
                verdict,
                t: Some(t),
                pair: None,
                witness_point: None,
                distance: None,
                reason: None,
                segment: None,
                time: Some([1.2349, 1.2351]),
                turns: Vec::new(),
                swept_volumes: None,
                clearance: None,
                reason_text: "why".to_owned(),
            };
            result.text()
        };
        let t = [0.560_546_875, 0.561_279_296_875];
        for (verdict, words) in [
            ("contact", "CONTACT, free until t = 0.560546, colliding at t = 0.561280 after 1.234 s"),
            (
                "within_margin",
                "WITHIN MARGIN, farther until t = 0.560546, within the margin at t = 0.561280 after 1.234 s",
            ),
            ("undecided", "UNDECIDED, open from t = 0.560546 to 0.561280: why after 1.234 s"),
        ] {
            assert_eq!(text(verdict, t), words);
        }
        assert_eq!(text("contact", [0.0, 0.5]), "CONTACT, colliding at t = 0.500000 after 1.234 s");
    }
}
