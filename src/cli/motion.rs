//! `clearance motion`: reads motions, reports proofs or contacts.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::Args;
use clearance::checker::{CollisionChecker, MotionOptions, MotionOrder, MotionVerdict, TrajectoryReport};
use clearance::input_files;
use clearance::motion::{Certificate, ContinuousTurn, MotionSegment, Trajectory};
use clearance::readable_text::on_one_line;
use clearance::robot::{Configuration, RobotModel};
use clearance::scene::BodyId;
use rayon::prelude::*;
use serde::Serialize;

use super::failure::Failure;
use super::model::{ModelArgs, WorldArgs};
use super::progress::Progress;
use super::run_args::{Format, RunArgs, Stats, internal, positive, print_line};
use super::timing::{self, Timing};
use super::way::WayArgs;

#[derive(Args)]
#[command(mut_group("way", |group| group.required(true)))]
pub struct MotionArgs {
    #[command(flatten)]
    model: ModelArgs,

    #[command(flatten)]
    world: WorldArgs,

    #[command(flatten)]
    way: WayArgs,

    /// What keeps farther apart than this many metres is always decided
    #[arg(long, value_name = "M", default_value_t = 5e-4, allow_negative_numbers = true)]
    tolerance: f64,

    /// Which contact to look for
    #[arg(long, value_enum, default_value_t = Order::Earliest)]
    order: Order,

    /// Give up on a way after this many seconds, and say so
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    deadline: Option<f64>,

    /// Write the proof that the way is free here, as JSON; `clearance verify` with the same arguments checks it
    #[arg(long, value_name = "FILE")]
    certificate: Option<PathBuf>,

    /// Tell volumes around what each link sweeps over, in this many intervals (with --format json)
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
struct Answer {
    robot: String,
    joints: Vec<String>,
    pairs_checked: usize,
    load_seconds: f64,
    results: Vec<WayAnswer>,
    stats: Stats,
    #[serde(skip_serializing_if = "Option::is_none")]
    timing: Option<Timing>,
}

#[derive(Serialize)]
struct WayAnswer {
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
    turns: Vec<TurnAnswer>,
    #[serde(skip_serializing_if = "Option::is_none")]
    swept_volumes: Option<Vec<SweptVolumeAnswer>>,
    #[serde(skip)]
    reason_text: String,
}

#[derive(Serialize)]
struct TurnAnswer {
    joint: String,
    from: f64,
    to: f64,
}

/// Capsule: all points within `radius` of the line segment from `a` to `b`.
#[derive(Serialize)]
struct SweptVolumeAnswer {
    link: String,
    segment: usize,
    t: [f64; 2],
    a: [f64; 3],
    b: [f64; 3],
    radius: f64,
}

pub fn run(args: &MotionArgs) -> Result<ExitCode, Failure> {
    let options = args.options()?;
    let start = Instant::now();
    let checker = args.run.pairs.checker(&args.model, &args.world)?;
    let load_seconds = start.elapsed().as_secs_f64();
    let robot = checker.robot();
    let robots_ways = args.way.ways(robot)?;
    let ways = args.way.with_obstacles(&robots_ways, checker.world())?;
    if args.certificate.is_some() && ways.len() != 1 {
        let count = ways.len();
        return Err(Failure::Input(format!("--certificate is for one way, but {count} are given")));
    }
    if let Some(path) = &args.certificate {
        // checked before the work whose result is written there
        input_files::check_target(path).map_err(Failure::input)?;
    }
    if checker.pairs().is_empty() {
        log::warn!("there is no pair to check: every motion counts as free");
    }
    let ends = |way: &Trajectory| way.segments().iter().flat_map(MotionSegment::ends).collect();
    let ends: Vec<Vec<Configuration>> = robots_ways.iter().map(ends).collect();
    if let Some(note) = robot.limits_note("way", &ends) {
        log::warn!("{note}");
    }
    if let Some(note) = long_turn_note(&robots_ways, robot) {
        log::warn!("{note}");
    }
    if let Some(path) = &args.certificate {
        remove_old_certificate(path)?;
    }
    let reports = check_all(&checker, &ways, &options, args)?;
    if let Some(path) = &args.certificate {
        write_certificate(&checker, &ways[0], &args.starting_now(&options), path)?;
    }
    let timing = time_passes(&checker, &ways, &options, args);
    let is_trajectory = args.way.is_trajectory();
    let results = reports.iter().zip(&ways).zip(&robots_ways).map(|((report, way), robots_way)| {
        let swept = args.swept_volumes.map(|n| swept_volumes(&checker, robots_way, n as usize));
        let turns = robots_way.continuous_turns(robot).into_iter();
        let turns = turns.map(|ContinuousTurn { joint, from, to }| TurnAnswer { joint, from, to }).collect();
        WayAnswer { turns, swept_volumes: swept, ..WayAnswer::new(report, way, &checker, is_trajectory) }
    });
    let answer = Answer {
        robot: robot.name().to_owned(),
        joints: robot.position_names().to_vec(),
        pairs_checked: checker.pairs().len(),
        load_seconds,
        results: results.collect(),
        stats: Stats::total(reports.iter().map(|report| report.work)),
        timing,
    };
    match args.run.format {
        Format::Json => print_line(&serde_json::to_string(&answer).map_err(internal)?)?,
        Format::Text => print_line(&text(&answer))?,
    }
    let all_free = reports.iter().all(TrajectoryReport::is_free);
    Ok(ExitCode::from(u8::from(!all_free)))
}

impl MotionArgs {
    fn options(&self) -> Result<MotionOptions, Failure> {
        self.deadline.map(|s| positive("--deadline", s)).transpose()?;
        if self.swept_volumes.is_some() && self.run.format == Format::Text {
            return Err(Failure::Input("--swept-volumes are told with --format json only".to_owned()));
        }
        Ok(MotionOptions {
            tolerance: positive("--tolerance", self.tolerance)?,
            order: match self.order {
                Order::Earliest => MotionOrder::Earliest,
                Order::Any => MotionOrder::Any,
            },
            ..MotionOptions::default()
        })
    }

    /// Options for a check that starts now.
    fn starting_now(&self, options: &MotionOptions) -> MotionOptions {
        let span = self.deadline.and_then(|s| Duration::try_from_secs_f64(s).ok());
        MotionOptions { deadline: span.and_then(|span| Instant::now().checked_add(span)), ..options.clone() }
    }
}

/// Warning about the first motion in which a continuous joint turns far, and the number of further ones.
fn long_turn_note(ways: &[Trajectory], robot: &RobotModel) -> Option<String> {
    let mut notes = ways.iter().enumerate().filter_map(|(i, way)| Some((i, way.long_turn_note(robot)?)));
    let (i, note) = notes.next()?;
    let which = if ways.len() > 1 { format!("motion {i}: ") } else { String::new() };
    let others = match notes.count() {
        0 => String::new(),
        others => format!("; likewise in {others} more motions"),
    };
    Some(format!("{which}{note}{others}"))
}

/// One report per motion, in the order of the motions, independent of the number of threads.
fn check_all(
    checker: &CollisionChecker,
    ways: &[Trajectory],
    options: &MotionOptions,
    args: &MotionArgs,
) -> Result<Vec<TrajectoryReport>, Failure> {
    let progress = Progress::new(ways.len());
    let pool = args.run.pool(ways.len())?;
    Ok(pool.install(|| {
        (ways.par_iter())
            .map_init(
                || checker.workspace(),
                |workspace, way| {
                    let report = checker.check_trajectory(way, &args.starting_now(options), workspace);
                    progress.piece_done();
                    report
                },
            )
            .collect()
    }))
}

fn time_passes(
    checker: &CollisionChecker,
    ways: &[Trajectory],
    options: &MotionOptions,
    args: &MotionArgs,
) -> Option<Timing> {
    let mut workspace = checker.workspace();
    timing::measure(args.run.repeat, ways.len(), || {
        for way in ways {
            std::hint::black_box(checker.check_trajectory(way, &args.starting_now(options), &mut workspace));
        }
    })
}

/// Removes the file that the certificate will replace: if writing fails, no older certificate must remain in its place.
fn remove_old_certificate(path: &Path) -> Result<(), Failure> {
    // standard output must not be removed, wherever it leads
    let is_device = ["/dev", "/proc"].iter().any(|folder| path.starts_with(folder));
    let Ok(file) = path.canonicalize() else { return Ok(()) };
    if is_device || !file.is_file() {
        return Ok(());
    }
    std::fs::remove_file(&file).map_err(|e| Failure::Input(format!("{}: {e}", path.display())))
}

/// Writes the certificate of the single motion, if it is free.
fn write_certificate(
    checker: &CollisionChecker,
    way: &Trajectory,
    options: &MotionOptions,
    path: &Path,
) -> Result<(), Failure> {
    let (report, certificate) = checker.certify_trajectory(way, options, &mut checker.workspace());
    let Some(certificate) = certificate else {
        let verdict = verdict_name(&report.verdict);
        log::warn!("the way is {verdict}: no certificate is written to {}", path.display());
        return Ok(());
    };
    let text = Certificate::to_json(&certificate) + "\n";
    input_files::write(path, text.as_bytes()).map_err(Failure::input)
}

fn swept_volumes(checker: &CollisionChecker, way: &Trajectory, intervals: usize) -> Vec<SweptVolumeAnswer> {
    let mut workspace = checker.workspace();
    let segments = way.segments().iter().enumerate();
    segments
        .flat_map(|(segment, motion)| {
            let volumes = checker.swept_volumes(motion, intervals, &mut workspace);
            volumes.into_iter().map(move |v| (segment, v))
        })
        .map(|(segment, v)| SweptVolumeAnswer {
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

impl WayAnswer {
    fn new(
        report: &TrajectoryReport,
        way: &Trajectory,
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
        let origin = |t: f64| way.origin(report.segment, t);
        let mut answer = Self {
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
            reason_text: String::new(),
        };
        match report.verdict {
            MotionVerdict::Free => {}
            MotionVerdict::Contact { t, pair, witness } => {
                (answer.t, answer.pair) = (Some(t.map(|t| origin(t).1)), Some(names(pair)));
                answer.witness_point = witness.map(|p| p.coords.into());
            }
            MotionVerdict::Undecided { t, pair, distance, reason } => {
                (answer.t, answer.pair) = (Some(t.map(|t| origin(t).1)), pair.map(names));
                answer.distance = Some(distance.map(|d| d.is_finite().then_some(d)));
                answer.reason = Some(reason.code());
                answer.reason_text = reason.to_string();
            }
        }
        answer
    }

    fn text(&self) -> String {
        let verdict =
            if self.verdict == "free" { "free, proven".to_owned() } else { self.verdict.to_uppercase() };
        let pair = self.pair.as_ref().map_or_else(String::new, |[a, b]| format!(": {a} – {b}"));
        let when = self.t.map_or_else(String::new, |[lo, hi]| match self.verdict {
            // with the order "any", nothing before the contact is checked
            "contact" if lo == 0.0 && hi > 0.0 => format!(", colliding at t = {hi:.6}"),
            "contact" => format!(", free until t = {lo:.6}, colliding at t = {hi:.6}"),
            _ => format!(", open from t = {lo:.6} to {hi:.6}: {}", self.reason_text),
        });
        let segment = self.segment.map_or_else(String::new, |segment| format!(", in segment {segment}"));
        let time = self.time.map_or_else(String::new, |[lo, _]| format!(" after {lo:.3} s"));
        let turn = |TurnAnswer { joint, from, to }: &TurnAnswer| format!("{joint} from {from} to {to}");
        let turns: Vec<String> = self.turns.iter().map(turn).collect();
        let turns = if turns.is_empty() { String::new() } else { format!("; turning {}", turns.join(", ")) };
        [verdict, pair, when, segment, time, turns].concat()
    }
}

/// One line per motion, and a summary.
fn text(answer: &Answer) -> String {
    let mut lines: Vec<String> =
        (answer.results.iter().enumerate()).map(|(i, r)| format!("motion {i}: {}", r.text())).collect();
    let free = answer.results.iter().filter(|r| r.verdict == "free").count();
    lines.push(format!(
        "{}: {free} of {} motions free; {} pairs checked; loaded in {:.3} s",
        answer.robot,
        answer.results.len(),
        answer.pairs_checked,
        answer.load_seconds
    ));
    if let Some(t) = answer.timing {
        lines.push(format!(
            "{:.3} µs a motion (best of {} passes; median {:.3} µs)",
            t.us_min, t.passes, t.us_median
        ));
    }
    lines.iter().map(|line| on_one_line(line)).collect::<Vec<_>>().join("\n")
}
