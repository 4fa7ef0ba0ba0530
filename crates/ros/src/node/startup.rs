//! Guard for the loading phase: until the node runs, signals and `memory_limit` end the process. In this phase the
//! program loads the robot and the world from the command line.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use crate::node::memory_limit::StartupWatch;
use crate::node::termination;
use crate::node_error::NodeError;

/// Created before any work that takes time, and dropped when the node runs.
#[derive(Debug)]
pub struct Startup {
    has_ended: Arc<AtomicBool>,
}

impl Startup {
    /// From now on, the process ends on a signal, or when it exceeds `memory_limit` (MiB; 0: the default).
    ///
    /// # Errors
    /// When signals cannot be handled.
    pub fn begin(memory_limit: f64) -> Result<Self, NodeError> {
        termination::end_on_signals()?;
        let has_ended = Arc::new(AtomicBool::new(false));
        if let Some(watch) = StartupWatch::new(memory_limit) {
            let has_ended = Arc::clone(&has_ended);
            let run = move || watch.run(|| has_ended.load(Ordering::Relaxed));
            if let Err(error) = thread::Builder::new().name("memory at start".to_owned()).spawn(run) {
                log::warn!("memory_limit has no effect until the node runs: {error}");
            }
        }
        Ok(Self { has_ended })
    }
}

impl Drop for Startup {
    fn drop(&mut self) {
        self.has_ended.store(true, Ordering::Relaxed);
    }
}
