//! Pools of threads, made at their first use. A forked process makes its own: threads do not survive a fork.

use std::num::NonZero;
use std::sync::{Arc, Mutex, PoisonError};

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

/// Number of pools that are kept; the threads of the least recently used one end.
const MOST_POOLS: usize = 8;

#[derive(Debug)]
struct Pool {
    process: u32,
    threads: usize,
    workers: Arc<ThreadPool>,
}

/// The most recently used last.
static POOLS: Mutex<Vec<Pool>> = Mutex::new(Vec::new());

/// The number of cores that the process may use.
#[must_use]
pub fn default_threads() -> usize {
    std::thread::available_parallelism().map_or(1, NonZero::get)
}

/// The pool of this process with so many threads.
///
/// # Errors
/// If the system gives no threads.
pub fn pool(threads: usize) -> Result<Arc<ThreadPool>, ThreadPoolBuildError> {
    let process = std::process::id();
    let mut pools = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = pools.iter().position(|pool| pool.process == process && pool.threads == threads) {
        pools[known..].rotate_left(1);
        return Ok(Arc::clone(&pools[pools.len() - 1].workers));
    }
    let made =
        ThreadPoolBuilder::new().num_threads(threads).thread_name(|i| format!("clearance-{i}")).build();
    let pool = Arc::new(made?);
    // pools of the parent process have no threads here: the end of one would wait for them forever
    let (own, parents): (Vec<_>, Vec<_>) = pools.drain(..).partition(|pool| pool.process == process);
    std::mem::forget(parents);
    *pools = own;
    if pools.len() == MOST_POOLS {
        // calls that still use it keep its threads until they end
        pools.remove(0);
    }
    pools.push(Pool { process, threads, workers: Arc::clone(&pool) });
    Ok(pool)
}
