//! SIGINT and SIGTERM: the orderly end, and a watchdog that ends the process when that takes too long.

use std::process;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use super::run::NodeError;
use super::threads::End;

/// Exit code of a node that a signal ended before its orderly end was complete.
const FORCED: i32 = 4;

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

/// From now on the first signal asks the node to end and arms the watchdog; a second one ends the process at once.
pub fn end_on_signals(end: End) -> Result<(), NodeError> {
    let is_armed = AtomicBool::new(false);
    let on_signal = move || {
        ENDING.store(true, Ordering::Relaxed);
        if is_armed.swap(true, Ordering::Relaxed) {
            exit(FORCED);
        }
        // before the order to end, which must not be able to delay it
        arm_watchdog(FORCED);
        end.tell();
    };
    ctrlc::set_handler(on_signal)
        .map_err(|error| NodeError::Internal(format!("signals can not be handled: {error}")))
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
fn exit(code: i32) -> ! {
    #[cfg(unix)]
    let _ = thread::Builder::new().spawn(|| {
        thread::sleep(TIME_TO_EXIT);
        nix::sys::signal::raise(nix::sys::signal::Signal::SIGKILL)
    });
    process::exit(code)
}
