//! Collision checks of batches of straight motions, such as the edges of a roadmap.

use std::sync::atomic::{AtomicUsize, Ordering};

use clearance::checker::Watch;
use clearance::{MotionOptions, MotionReport, MotionSegment, MotionVerdict, Workspace};
use clearance_bindings::default_threads;
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::arrays::{Pairing, Rows, Table, array};
use crate::batches::{Stop, run, run_briefly};
use crate::checker_core::CheckerCore;
use crate::error::error;
use crate::memory::{collected, filled};
use crate::motion_options::{MotionSettings, is_over};
use crate::motion_queries::{reason_code, verdict_code};
use crate::result_builder::result;
use crate::workspaces::{QueryMemory, with_memory};

/// Largest number of edges that a thread takes at a time.
const LARGEST_BLOCK: usize = 64;

/// Code of an edge whose check has not begun: `Reason` of `clearance._results`.
const UNCHECKED: i8 = 8;

/// Arguments of a batch of edges.
pub struct EdgeArguments<'a, 'py> {
    pub ends: [&'a Bound<'py, PyAny>; 2],
    pub settings: MotionSettings,
    pub threads: Option<usize>,
}

/// Whether edges are proven free: a bool, or an array of them.
pub fn are_edges_free<'py>(
    py: Python<'py>,
    core: &CheckerCore,
    arguments: &EdgeArguments<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let check = |segments: &[MotionSegment],
                 options: &MotionOptions,
                 workspace: &mut Workspace,
                 free: &mut [bool]| {
        core.checker.are_motions_free_with(segments, options, workspace, free);
    };
    let (free, shape) = evaluate(py, core, arguments, false, check)?;
    match free[..] {
        [free] if shape.is_empty() => Ok(free.into_pyobject(py)?.to_owned().into_any()),
        _ => Ok(array(py, free, &shape)?.into_any()),
    }
}

/// The parts of an edge's report that arrays hold.
#[derive(Clone, Copy)]
struct EdgeVerdict {
    verdict: i8,
    reason: i8,
    t: [f64; 2],
}

impl EdgeVerdict {
    const UNCHECKED: Self = Self { verdict: -1, reason: UNCHECKED, t: [0.0, 1.0] };

    fn new(report: &MotionReport) -> Self {
        let (reason, t) = match report.verdict {
            MotionVerdict::Free => (0, [f64::NAN; 2]),
            MotionVerdict::Contact { t, .. } => (0, t),
            MotionVerdict::Undecided { t, reason, .. } => (reason_code(reason), t),
        };
        Self { verdict: verdict_code(&report.verdict), reason, t }
    }
}

/// Arrays of verdicts, reasons and fractions.
pub fn check_edges<'py>(
    py: Python<'py>,
    core: &CheckerCore,
    arguments: &EdgeArguments<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let check = |segments: &[MotionSegment],
                 options: &MotionOptions,
                 workspace: &mut Workspace,
                 verdicts: &mut [EdgeVerdict]| {
        for (segment, verdict) in segments.iter().zip(verdicts) {
            if is_over(options.deadline) || options.watch.as_ref().is_some_and(Watch::is_stopped) {
                return;
            }
            *verdict = EdgeVerdict::new(&core.checker.check_motion_with(segment, options, workspace));
        }
    };
    let (verdicts, shape) = evaluate(py, core, arguments, EdgeVerdict::UNCHECKED, check)?;
    let count = verdicts.len();
    let codes = |of: fn(&EdgeVerdict) -> i8| array(py, collected(verdicts.iter().map(of), count)?, &shape);
    let t = collected(verdicts.iter().flat_map(|edge| edge.t), 2 * count)?;
    result!(py, "EdgeReports",
        verdicts: codes(|edge| edge.verdict)?, reasons: codes(|edge| edge.reason)?,
        t: array(py, t, &[&shape[..], &[2]].concat())?)
}

/// Evaluates every edge into its place in the result, in blocks, on all threads; returns the shape, too. Edges that are not reached in
/// time keep `initial`. All rows are validated, in time or not.
fn evaluate<T: Send + Clone>(
    py: Python<'_>,
    core: &CheckerCore,
    arguments: &EdgeArguments<'_, '_>,
    initial: T,
    check: impl Fn(&[MotionSegment], &MotionOptions, &mut Workspace, &mut [T]) + Sync,
) -> PyResult<(Vec<T>, Vec<usize>)> {
    let names = ["q0", "q1"];
    let [q0, q1] = arguments.ends;
    let rows = [Rows::new(q0, names[0], core.space.names())?, Rows::new(q1, names[1], core.space.names())?];
    let pairing = Pairing::new([&rows[0], &rows[1]], names)?;
    let watch = Watch::default();
    let mut results = filled(initial, pairing.count())?;
    let batch = EdgeBatch {
        core,
        tables: [rows[0].table(), rows[1].table()],
        pairing,
        options: arguments.settings.options(&watch),
        first_error: AtomicUsize::new(usize::MAX),
    };
    let is_done = results.len() == 1
        && run_briefly(py, &batch.options, |options| batch.block(0, &mut results, options, &check)).is_some();
    if !is_done {
        batch.check_all(py, (arguments.threads, &watch), &mut results, &check)?;
    }
    match batch.first_error.load(Ordering::Relaxed) {
        usize::MAX => Ok((results, batch.pairing.shape)),
        edge => Err(batch.error_of(edge, &rows)),
    }
}

/// Edges that threads check block by block.
struct EdgeBatch<'a> {
    core: &'a CheckerCore,
    tables: [Table<'a>; 2],
    pairing: Pairing,
    options: MotionOptions,
    /// First edge with an invalid row; all before it are valid.
    first_error: AtomicUsize,
}

impl EdgeBatch<'_> {
    /// Checks all edges, on the threads of a pool.
    fn check_all<T: Send>(
        &self,
        py: Python<'_>,
        (threads, watch): (Option<usize>, &Watch),
        results: &mut [T],
        check: &(impl Fn(&[MotionSegment], &MotionOptions, &mut Workspace, &mut [T]) + Sync),
    ) -> PyResult<()> {
        let size = results.len() / (8 * threads.unwrap_or_else(default_threads));
        let size = size.clamp(1, LARGEST_BLOCK);
        let work = |stop: &Stop| {
            results.par_chunks_mut(size).enumerate().for_each(|(i, results)| {
                if !stop.is_requested() {
                    self.block(i * size, results, &self.options, check);
                }
            });
        };
        run(py, threads, || watch.stop(), work)
    }

    /// Checks the edges from `first` on.
    fn block<T>(
        &self,
        first: usize,
        results: &mut [T],
        options: &MotionOptions,
        check: &impl Fn(&[MotionSegment], &MotionOptions, &mut Workspace, &mut [T]),
    ) {
        if first > self.first_error.load(Ordering::Relaxed) {
            return;
        }
        with_memory(self.core, |memory| {
            let mut segments = Vec::with_capacity(results.len());
            for edge in first..first + results.len() {
                let Some(segment) = self.segment(edge, memory) else {
                    self.first_error.fetch_min(edge, Ordering::Relaxed);
                    return;
                };
                segments.push(segment);
            }
            check(&segments, options, &mut memory.workspace, results);
        });
    }

    /// The motion of an edge; none if a row is invalid.
    fn segment(&self, edge: usize, memory: &mut QueryMemory) -> Option<MotionSegment> {
        let QueryMemory { block, row, .. } = memory;
        if block.len() < 2 {
            block.push(self.core.space.rest().clone());
        }
        for (side, q) in block[..2].iter_mut().enumerate() {
            let given = self.tables[side].row(self.pairing.row(side, edge));
            self.core.space.read_into(given, row, q).ok()?;
        }
        Some(MotionSegment::straight(self.core.space.robot(), &block[0], &block[1]))
    }

    /// The error of an edge with an invalid row.
    fn error_of(&self, edge: usize, rows: &[Rows<'_>; 2]) -> PyErr {
        for (side, name) in ["q0", "q1"].into_iter().enumerate() {
            let row = self.pairing.row(side, edge);
            if let Err(why) = self.core.space.read(self.tables[side].row(row)) {
                return error(format!("{name}{}: {why}", rows[side].place(row)));
            }
        }
        error("q0 or q1 was changed during the call")
    }
}
