//! Pools of threads, made at their first use. A forked process makes its own: threads do not survive a fork.

use std::num::NonZero;
use std::sync::{Arc, Mutex, PoisonError};

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::status::{Failure, Outcome};

/// Largest number of threads.
const MOST_THREADS: usize = 1024;

#[derive(Debug)]
struct Pool {
    process: u32,
    threads: usize,
    workers: Arc<ThreadPool>,
}

static POOLS: Mutex<Vec<Pool>> = Mutex::new(Vec::new());

/// The number of cores that the process may use.
fn default_threads() -> usize {
    std::thread::available_parallelism().map_or(1, NonZero::get)
}

/// The pool of this process with so many threads; 0 is one for each core that the process may use.
pub fn pool(threads: usize) -> Outcome<Arc<ThreadPool>> {
    let threads = if threads == 0 { default_threads() } else { threads };
    if !(1..=MOST_THREADS).contains(&threads) {
        return Err(Failure::argument(format!("threads is {threads}, but must be 0 to {MOST_THREADS}")));
    }
    let process = std::process::id();
    let mut pools = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = pools.iter().find(|pool| pool.process == process && pool.threads == threads) {
        return Ok(Arc::clone(&known.workers));
    }
    let made =
        ThreadPoolBuilder::new().num_threads(threads).thread_name(|i| format!("clearance-{i}")).build();
    let pool = Arc::new(made.map_err(|e| Failure::rejected(format!("no pool of {threads} threads: {e}")))?);
    // pools of the parent process have no threads here: the end of one would wait for them forever
    let (own, parents): (Vec<_>, Vec<_>) = pools.drain(..).partition(|pool| pool.process == process);
    std::mem::forget(parents);
    *pools = own;
    pools.push(Pool { process, threads, workers: Arc::clone(&pool) });
    Ok(pool)
}
