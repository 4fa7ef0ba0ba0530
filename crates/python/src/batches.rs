//! Runs batches and other long work on a thread pool, without the GIL; Ctrl-C ends it.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

use clearance::MotionOptions;
use clearance_bindings::{default_threads, pool};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::arrays::{Rows, Table};
use crate::checker_core::CheckerCore;
use crate::error::error;
use crate::memory::filled;
use crate::workspaces::{QueryMemory, with_memory};

/// Interval at which the waiting thread looks for signals.
const SIGNAL_INTERVAL: Duration = Duration::from_millis(50);

/// Time that a check may take on the calling thread, where Ctrl-C does not end it. To give it to a pool takes longer than most checks do.
const BRIEF: Duration = Duration::from_millis(20);

/// Largest number of states that a thread takes at a time, and that the calling thread checks by itself.
const LARGEST_BLOCK: usize = 256;
const FEW: usize = 8;

/// Request to end work early, which the work has to look at.
#[derive(Debug, Default)]
pub struct Stop(AtomicBool);

impl Stop {
    pub fn is_requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// True once the work has to end.
    pub fn flag(&self) -> &AtomicBool {
        &self.0
    }
}

/// Runs `work` on a pool, and waits for it without the GIL. A signal whose Python handler raises requests the stop; `on_stop` passes
/// this on. The handler's exception is raised once the work has ended.
pub fn run<T: Send>(
    py: Python<'_>,
    threads: Option<usize>,
    on_stop: impl Fn() + Send,
    work: impl FnOnce(&Stop) -> T + Send,
) -> PyResult<T> {
    let threads = threads.unwrap_or_else(default_threads);
    let pool =
        pool(threads).map_err(|e| PyRuntimeError::new_err(format!("no pool of {threads} threads: {e}")))?;
    let stop = Stop::default();
    let end = End::default();
    let mut result = None;
    let raised = py.detach(|| {
        let (result, stop, end) = (&mut result, &stop, &end);
        pool.in_place_scope(move |scope| {
            scope.spawn(move |_| {
                let _ended = EndGuard(end);
                *result = Some(work(stop));
            });
            end.wait(|| {
                Python::attach(handle_signals).inspect_err(|_| {
                    stop.0.store(true, Ordering::Relaxed);
                    on_stop();
                })
            })
        })
    });
    raised?;
    // a panic of the work has been passed on
    result.ok_or_else(|| error("the work ended without a result"))
}

/// Runs a check of a motion on this thread, without the GIL. `None` if that took too long: then [`run`] has to do it again.
pub fn run_briefly<T: Send>(
    py: Python<'_>,
    options: &MotionOptions,
    check: impl FnOnce(&MotionOptions) -> T + Send,
) -> Option<T> {
    let brief = Instant::now() + BRIEF;
    let deadline = options.deadline.map_or(brief, |deadline| deadline.min(brief));
    let options = MotionOptions { deadline: Some(deadline), ..options.clone() };
    let result = py.detach(|| check(&options));
    // what ended before this deadline does not depend on it
    (Instant::now() < brief).then_some(result)
}

/// Runs the Python handlers of signals that have come, if this is the main thread.
fn handle_signals(py: Python<'_>) -> PyResult<()> {
    py.check_signals()
}

/// End of the work.
#[derive(Default)]
struct End {
    has_ended: Mutex<bool>,
    changed: Condvar,
}

impl End {
    /// Waits for the end, and calls `look` now and then until it fails.
    fn wait(&self, look: impl Fn() -> PyResult<()>) -> PyResult<()> {
        let mut has_ended = self.has_ended.lock().unwrap_or_else(PoisonError::into_inner);
        while !*has_ended {
            let waited = self.changed.wait_timeout(has_ended, SIGNAL_INTERVAL);
            has_ended = waited.unwrap_or_else(PoisonError::into_inner).0;
            if !*has_ended {
                drop(has_ended);
                // the scope waits for the end of the work
                look()?;
                has_ended = self.has_ended.lock().unwrap_or_else(PoisonError::into_inner);
            }
        }
        Ok(())
    }
}

/// Reports the end, also of work that panics.
struct EndGuard<'e>(&'e End);

impl Drop for EndGuard<'_> {
    fn drop(&mut self) {
        *self.0.has_ended.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.0.changed.notify_all();
    }
}

/// Evaluates every row of `rows` into its place in the result, in blocks, on all threads.
pub fn evaluate<T: Send + Clone>(
    core: &CheckerCore,
    rows: &Rows<'_>,
    threads: Option<usize>,
    initial: T,
    evaluate: impl Fn(&mut QueryMemory, usize, &mut [T]) + Sync,
    py: Python<'_>,
) -> PyResult<Vec<T>> {
    let mut results = filled(initial, rows.count())?;
    let batch = Batch { core, table: rows.table(), first_error: AtomicUsize::new(usize::MAX), evaluate };
    if results.len() <= FEW && threads.is_none_or(|threads| threads == 1) {
        py.detach(|| batch.block(0, &mut results));
    } else {
        let threads_count = threads.unwrap_or_else(default_threads);
        let size = (results.len() / (8 * threads_count.max(1))).clamp(8, LARGEST_BLOCK).next_multiple_of(8);
        let results = &mut results;
        run(
            py,
            threads,
            || {},
            |stop| {
                results.par_chunks_mut(size).enumerate().for_each(|(i, results)| {
                    if !stop.is_requested() {
                        batch.block(i * size, results);
                    }
                });
            },
        )?;
    }
    match batch.first_error.into_inner() {
        usize::MAX => Ok(results),
        row => Err(row_error(core, rows, row)),
    }
}

/// The error of an invalid row.
fn row_error(core: &CheckerCore, rows: &Rows<'_>, row: usize) -> PyErr {
    let mut q = core.space.rest().clone();
    match core.space.move_into(rows.table().row(row), &mut Vec::new(), &mut q) {
        Err(why) => error(format!("q{}: {why}", rows.place(row))),
        Ok(()) => error(format!("q{} was changed during the call", rows.place(row))),
    }
}

/// Rows that threads evaluate block by block.
struct Batch<'a, F> {
    core: &'a CheckerCore,
    table: Table<'a>,
    /// First invalid row; all rows before it are evaluated or valid.
    first_error: AtomicUsize,
    evaluate: F,
}

impl<F> Batch<'_, F> {
    /// Evaluates the rows from `first` on.
    fn block<T>(&self, first: usize, results: &mut [T])
    where
        F: Fn(&mut QueryMemory, usize, &mut [T]),
    {
        if first > self.first_error.load(Ordering::Relaxed) {
            return;
        }
        with_memory(self.core, |memory| {
            let missing = results.len().saturating_sub(memory.block.len());
            memory.block.extend(std::iter::repeat_n(self.core.space.rest(), missing).cloned());
            for (i, q) in memory.block[..results.len()].iter_mut().enumerate() {
                let row = self.table.row(first + i);
                if self.core.space.move_into(row, &mut memory.row, q).is_err() {
                    self.first_error.fetch_min(first + i, Ordering::Relaxed);
                    return;
                }
            }
            (self.evaluate)(memory, results.len(), results);
        });
    }
}
