//! Thread pool of a batch query, for the number of threads that C gives.

use std::sync::Arc;

use clearance_bindings::{default_threads, pool};
use rayon::ThreadPool;

use crate::status::{Failure, Outcome};

/// Largest number of threads.
const MOST_THREADS: usize = 1024;

/// The pool with so many threads; 0 is one for each core that the process may use.
pub fn batch_pool(threads: usize) -> Outcome<Arc<ThreadPool>> {
    if threads > MOST_THREADS {
        return Err(Failure::argument(format!("threads is {threads}, but must be 0 to {MOST_THREADS}")));
    }
    let threads = if threads == 0 { default_threads() } else { threads };
    pool(threads).map_err(|e| Failure::rejected(format!("no pool of {threads} threads: {e}")))
}
