//! Measures the cost of each kind of bounding volume: `T = T_0 + N_bv * C_bv + N_p * C_p`.
//! Gottschalk, Lin & Manocha 1996.

use std::hint::black_box;

use clearance::checker::{CollisionChecker, CollisionReport, Question, Workspace};
use clearance::geometry::VolumeKind;
use clearance::proximity::Work;
use clearance::robot::Configuration;
use clearance::scene::{AllowedCollisionMatrix, Settings, VolumeSelection, World};
use cpu_time::ThreadTime;
use serde::Serialize;

use super::{PASSES, best};
use crate::cli::failure::Failure;
use crate::cli::run_args::print_line;

/// Least time (µs) of one measurement: shorter queries are repeated.
const LEAST_TIME: f64 = 50.0;

const QUESTIONS: [(&str, Question); 3] = [
    ("free", Question::Free),
    ("least distance", Question::Distance { limit: 1.0 }),
    ("distance of each pair", Question::PairDistances { limit: 1.0 }),
];

/// Costs of one kind for one query, in the mean of the states. All kinds have the same results, and the same cost of a test of two triangles.
#[derive(Serialize)]
pub struct VolumeCosts {
    pub query: &'static str,
    pub kind: &'static str,
    /// Tests of two volumes (per state).
    pub volume_tests: f64,
    /// Time of such a test (ns), fitted.
    pub volume_test_ns: f64,
    /// Tests of two triangles or primitives, eight at a time (per state).
    pub primitive_tests: f64,
    /// Time of such a test (ns), fitted.
    pub primitive_test_ns: f64,
    /// Time of the query (µs per state), kinematics included.
    pub query_us: f64,
    /// Time of the query relative to that of `obb`, geometric mean of the states.
    pub relative_time: f64,
    /// Memory of all hierarchies and their triangles (bytes).
    pub bytes: usize,
}

/// Costs of all kinds, and the time of kinematics and capsules.
pub struct Comparison {
    pub level_0_us: f64,
    pub costs: Vec<VolumeCosts>,
}

/// Robot and world whose checks are measured.
pub struct Subject<'s> {
    pub checker: &'s CollisionChecker,
    pub world: &'s World,
    pub matrix: Option<&'s AllowedCollisionMatrix>,
}

impl Subject<'_> {
    fn with(&self, kind: VolumeKind) -> Result<CollisionChecker, Failure> {
        let settings = Settings { volumes: VolumeSelection::of_all(kind), ..self.checker.settings().clone() };
        self.checker.with_world(self.world, settings, self.matrix).map_err(Failure::input)
    }
}

/// Counts and time of one query on one state.
#[derive(Clone, Copy)]
struct Sample {
    volume_tests: f64,
    primitive_tests: f64,
    us: f64,
}

/// Measures every kind on the same states, in turn.
pub fn compare(subject: &Subject, states: &[Configuration]) -> Result<Comparison, Failure> {
    let checkers: Vec<(VolumeKind, CollisionChecker)> = (VolumeKind::ALL.into_iter())
        .map(|kind| Ok((kind, subject.with(kind)?)))
        .collect::<Result<_, Failure>>()?;
    let mut workspace = subject.checker.workspace();
    let level_0_us = best(states.len(), || {
        black_box(subject.checker.count_near_pairs(states, &mut workspace));
    });
    let mut costs = Vec::new();
    for (query, question) in QUESTIONS {
        let mut samples = vec![Vec::new(); checkers.len()];
        for q in states {
            for (of_kind, sample) in samples.iter_mut().zip(measured(&checkers, q, question)?) {
                of_kind.push(sample);
            }
        }
        let fit = Fit::of(&samples, level_0_us);
        for (((kind, checker), of_kind), volume_test_ns) in
            checkers.iter().zip(&samples).zip(fit.volume_test_ns)
        {
            costs.push(VolumeCosts {
                query,
                kind: kind.name(),
                volume_tests: mean(of_kind, |s| s.volume_tests),
                volume_test_ns,
                primitive_tests: mean(of_kind, |s| s.primitive_tests),
                primitive_test_ns: fit.primitive_test_ns,
                query_us: mean(of_kind, |s| s.us),
                relative_time: relative_time(of_kind, &samples[0]),
                bytes: checker.hierarchy_size().0,
            });
        }
    }
    Ok(Comparison { level_0_us, costs })
}

/// One state with each checker, in turn: the best of several passes. Fails if their reports differ.
#[allow(clippy::cast_precision_loss)] // counts of work fit 52 bits
fn measured(
    checkers: &[(VolumeKind, CollisionChecker)],
    q: &Configuration,
    question: Question,
) -> Result<Vec<Sample>, Failure> {
    let mut workspaces: Vec<Workspace> = checkers.iter().map(|(_, checker)| checker.workspace()).collect();
    let mut samples = Vec::new();
    let mut expected = None;
    for ((kind, checker), workspace) in checkers.iter().zip(&mut workspaces) {
        let report = checker.check(q, question, workspace);
        let Work { volume_tests, screened_pairs, .. } = report.work;
        samples.push(Sample {
            volume_tests: volume_tests as f64,
            primitive_tests: screened_pairs as f64,
            us: f64::INFINITY,
        });
        let report = CollisionReport { work: Work::default(), ..report };
        if *expected.get_or_insert_with(|| report.clone()) != report {
            return Err(Failure::Internal(format!("the volumes {kind} give another result than boxes")));
        }
    }
    for _ in 0..PASSES {
        for (((_, checker), workspace), sample) in checkers.iter().zip(&mut workspaces).zip(&mut samples) {
            let us = time(|| drop(black_box(checker.check(q, question, workspace))));
            sample.us = if us < sample.us { us } else { sample.us };
        }
    }
    Ok(samples)
}

/// Time (µs) of a query that is repeated long enough to be measured.
fn time(mut query: impl FnMut()) -> f64 {
    let mut repeats = 1_u32;
    loop {
        let start = ThreadTime::now();
        for _ in 0..repeats {
            query();
        }
        let us = start.elapsed().as_secs_f64() * 1e6;
        if us >= LEAST_TIME || repeats >= 1 << 10 {
            return us / f64::from(repeats);
        }
        repeats *= 4;
    }
}

/// Least squares of relative errors. The time of a volume test depends on the kind, that of a test of two triangles does not.
struct Fit {
    volume_test_ns: Vec<f64>,
    primitive_test_ns: f64,
}

impl Fit {
    fn of(samples: &[Vec<Sample>], level_0_us: f64) -> Self {
        let sums: Vec<Sums> = samples.iter().map(|of_kind| Sums::of(of_kind, level_0_us)).collect();
        // the volume test of each kind is eliminated first
        let (mut over, mut under) = (0.0, 0.0);
        for s in sums.iter().filter(|s| s.vv > 0.0) {
            over += s.pt - s.vp * s.vt / s.vv;
            under += s.pp - s.vp * s.vp / s.vv;
        }
        let of_primitives = if under > 0.0 && over > 0.0 { over / under } else { 0.0 };
        let of_volumes = |s: &Sums| {
            let time = s.vt - of_primitives * s.vp;
            if s.vv > 0.0 && time > 0.0 { 1e3 * time / s.vv } else { 0.0 }
        };
        Self { volume_test_ns: sums.iter().map(of_volumes).collect(), primitive_test_ns: 1e3 * of_primitives }
    }
}

/// Sums of products of the counts and the times of trees, each divided by the time of its query.
#[derive(Clone, Copy, Default)]
struct Sums {
    vv: f64,
    vp: f64,
    pp: f64,
    vt: f64,
    pt: f64,
}

impl Sums {
    fn of(samples: &[Sample], level_0_us: f64) -> Self {
        let mut sums = Self::default();
        for sample in samples.iter().filter(|s| s.us > 0.0) {
            let (v, p) = (sample.volume_tests / sample.us, sample.primitive_tests / sample.us);
            let t = (sample.us - level_0_us) / sample.us;
            sums.vv += v * v;
            sums.vp += v * p;
            sums.pp += p * p;
            sums.vt += v * t;
            sums.pt += p * t;
        }
        sums
    }
}

#[allow(clippy::cast_precision_loss)] // counts of states
fn mean(samples: &[Sample], of: impl Fn(&Sample) -> f64) -> f64 {
    samples.iter().map(of).sum::<f64>() / samples.len().max(1) as f64
}

#[allow(clippy::cast_precision_loss)] // counts of states
fn relative_time(samples: &[Sample], boxes: &[Sample]) -> f64 {
    let logarithms = samples.iter().zip(boxes).map(|(sample, boxes)| (sample.us / boxes.us).ln());
    (logarithms.sum::<f64>() / samples.len().max(1) as f64).exp()
}

pub fn print_text(robot: &str, states: usize, comparison: &Comparison) -> Result<(), Failure> {
    print_line(&format!(
        "{robot}: {states} random states, all with the same results; CPU time, best of {PASSES}; kinematics and capsules: {:.2} µs a state",
        comparison.level_0_us
    ))?;
    for (query, _) in QUESTIONS {
        print_line(&format!(
            "\n  {query:<22} {:>10} {:>10} {:>10} {:>10} {:>10} {:>8} {:>10}",
            "N_bv", "C_bv (ns)", "N_p", "C_p (ns)", "T (µs)", "T / obb", "memory (B)"
        ))?;
        for cost in comparison.costs.iter().filter(|cost| cost.query == query) {
            let VolumeCosts {
                kind, volume_tests, volume_test_ns, primitive_tests, primitive_test_ns, ..
            } = cost;
            let VolumeCosts { query_us, relative_time, bytes, .. } = cost;
            print_line(&format!(
                "  {kind:<22} {volume_tests:>10.1} {volume_test_ns:>10.2} {primitive_tests:>10.1} {primitive_test_ns:>10.2} {query_us:>10.2} {relative_time:>8.2} {bytes:>10}"
            ))?;
        }
    }
    Ok(())
}
