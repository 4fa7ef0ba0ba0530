//! SIGINT and SIGTERM: the orderly end, and a watchdog that ends the process when that takes too long.

use std::process;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread;
use std::time::Duration;

use super::run::NodeError;
use super::threads::End;

/// Exit code of a node that a signal ended before its orderly end was complete.
const FORCED: i32 = 4;

/// Exit code of a node that a signal ended before it ran: as that of a process that SIGTERM ends by default. What only the kernel does by
/// default is not done to the first process of a container, nor to a background job whose shell has it ignore SIGINT.
const NOT_STARTED: i32 = 143;

/// Exit code of a node that took more memory than it may.
pub const OUT_OF_MEMORY: i32 = 5;

/// Time for the orderly end: it closes the recording and tells peers.
const TIME_TO_END: Duration = Duration::from_millis(1500);

/// Time after that for the end of the process: what it writes may meet a pipe that nobody reads.
const TIME_TO_EXIT: Duration = Duration::from_millis(200);

static ENDING: AtomicBool = AtomicBool::new(false);

/// Whether a signal has asked the node to end.
#[must_use]
pub fn is_ending() -> bool {
    ENDING.load(Ordering::Relaxed)
}

/// The node that signals ask to end, once there is one.
static NODE: Mutex<Option<End>> = Mutex::new(None);

fn node() -> MutexGuard<'static, Option<End>> {
    NODE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// From now on a signal ends the process: before there is a node at once, afterwards by asking it to end, with a watchdog. A second one
/// ends the process at once.
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
            // before the order to end, which must not be able to delay it
            arm_watchdog(FORCED);
            end.tell();
        };
        ctrlc::set_handler(on_signal).map_err(|error| error.to_string())
    });
    handled.clone().map_err(|error| NodeError::Internal(format!("signals can not be handled: {error}")))
}

/// From now on signals ask this node to end.
pub fn hand_signals_to(end: End) {
    *node() = Some(end);
}

/// The process ends with this exit code if its orderly end, which begins now, takes too long.
pub fn arm_watchdog(code: i32) {
    if thread::Builder::new().name("watchdog".to_owned()).spawn(move || watch(code)).is_err() {
        exit(code);
    }
}

fn watch(code: i32) {
    thread::sleep(TIME_TO_END);
    // on a thread of its own: the log may be a pipe that nobody reads
    let warn = move || log::error!("the node did not end in time; the process ends with exit code {code}");
    let warned = thread::Builder::new().spawn(warn);
    thread::sleep(TIME_TO_EXIT / 4);
    drop(warned);
    exit(code);
}

/// Ends the process, by a signal that nothing can hold up if need be.
pub fn exit(code: i32) -> ! {
    #[cfg(unix)]
    let _ = thread::Builder::new().spawn(|| {
        thread::sleep(TIME_TO_EXIT);
        let _ = nix::sys::signal::raise(nix::sys::signal::Signal::SIGKILL);
        // the first process of a container can not kill itself
        process::abort();
    });
    process::exit(code)
}
