//! SIGINT and SIGTERM: orderly shutdown, and a watchdog that ends the process when the shutdown takes too long.

use std::process;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread;
use std::time::Duration;

use crate::node::node_threads::StopSignal;
use crate::node_error::NodeError;

/// Exit code if the node was ended by a signal and its shutdown was not complete.
const FORCED: i32 = 4;

/// Exit code if a signal ended the node before it ran: the same as for a process that SIGTERM ends by default. The
/// kernel's default action is not enough: it does not apply to the first process of a container, nor to a background
/// job whose shell ignores SIGINT.
const NOT_STARTED: i32 = 143;

/// Exit code if the node exceeded its memory limit.
pub const OUT_OF_MEMORY: i32 = 5;

/// Time limit of the shutdown, which closes the recording and notifies peers.
const TIME_TO_END: Duration = Duration::from_millis(1500);

/// Further time for the end of the process: its output may block on a pipe that is not read.
const TIME_TO_EXIT: Duration = Duration::from_millis(200);

static ENDING: AtomicBool = AtomicBool::new(false);

/// Whether a signal has requested the end of the node.
#[must_use]
pub fn is_ending() -> bool {
    ENDING.load(Ordering::Relaxed)
}

/// The node that signals end; `None` before it runs.
static NODE: Mutex<Option<StopSignal>> = Mutex::new(None);

fn node() -> MutexGuard<'static, Option<StopSignal>> {
    NODE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// From now on a signal ends the process: at once before the node runs, afterwards by an orderly shutdown with a
/// watchdog. A second signal ends the process at once.
pub fn end_on_signals() -> Result<(), NodeError> {
    static HANDLED: OnceLock<Result<(), String>> = OnceLock::new();
    let handled = HANDLED.get_or_init(|| {
        let is_armed = AtomicBool::new(false);
        let on_signal = move || {
            ENDING.store(true, Ordering::Relaxed);
            if is_armed.swap(true, Ordering::Relaxed) {
                exit(FORCED);
            }
            let node = node();
            let Some(end) = node.as_ref() else { exit(NOT_STARTED) };
            // before the stop request, which must not be able to delay the watchdog
            arm_watchdog(FORCED);
            end.send();
        };
        ctrlc::set_handler(on_signal).map_err(|error| error.to_string())
    });
    handled.clone().map_err(|error| NodeError::Internal(format!("signals can not be handled: {error}")))
}

/// From now on, signals shut down this node.
pub fn hand_signals_to(end: StopSignal) {
    *node() = Some(end);
}

/// Ends the process with this exit code if the shutdown, which starts now, takes too long.
pub fn arm_watchdog(code: i32) {
    if thread::Builder::new().name("watchdog".to_owned()).spawn(move || watch(code)).is_err() {
        exit(code);
    }
}

fn watch(code: i32) {
    thread::sleep(TIME_TO_END);
    // on a separate thread: the log may be a pipe that is not read
    let warn = move || log::error!("the node did not end in time; the process ends with exit code {code}");
    let warned = thread::Builder::new().spawn(warn);
    thread::sleep(TIME_TO_EXIT / 4);
    drop(warned);
    exit(code);
}

/// Ends the process, if necessary by a signal that cannot be blocked.
pub fn exit(code: i32) -> ! {
    #[cfg(unix)]
    let _ = thread::Builder::new().spawn(|| {
        thread::sleep(TIME_TO_EXIT);
        let _ = nix::sys::signal::raise(nix::sys::signal::Signal::SIGKILL);
        // the first process of a container cannot kill itself
        process::abort();
    });
    process::exit(code)
}
