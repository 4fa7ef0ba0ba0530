//! Detects that the receive threads of `RustDDS` have ended.
//!
//! `RustDDS` 0.15.1 ends its threads when a wait of theirs is interrupted, and only logs it. This happens when the
//! process is stopped and continued (Ctrl-Z and `fg`, a debugger). The threads can also panic. A node that continued
//! would neither receive nor send anything, and would still look alive.

use std::sync::LazyLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::{panic, thread};

use log::{Level, Record};
use smol::channel::{self, Receiver, Sender};

/// Log messages of the threads when they end: target and text.
const END_MESSAGES: [(&str, &str); 2] = [
    ("rustdds::rtps::dp_event_loop", "poll failed"),
    ("rustdds::discovery", "Failed in waiting of poll in discovery"),
];

static HAS_ENDED: AtomicBool = AtomicBool::new(false);
static NOTICE: LazyLock<(Sender<()>, Receiver<()>)> = LazyLock::new(|| channel::bounded(1));

/// Prefix of the threads' names.
const THREADS: &str = "RustDDS";

/// Checks a line of the log for the end of a thread.
pub fn check_log_record(record: &Record) {
    if is_thread_end(record) {
        note();
    }
}

/// Installs a panic hook that detects panics of the threads.
pub fn watch_panics() {
    let before = panic::take_hook();
    panic::set_hook(Box::new(move |what| {
        before(what);
        if thread::current().name().is_some_and(|name| name.starts_with(THREADS)) {
            note();
        }
    }));
}

fn note() {
    HAS_ENDED.store(true, Ordering::Release);
    let _ = NOTICE.0.try_send(());
}

/// Waits until a receive thread has ended.
pub async fn ended() {
    let _ = NOTICE.1.recv().await;
}

/// Whether a receive thread has ended.
pub fn has_ended() -> bool {
    HAS_ENDED.load(Ordering::Acquire)
}

fn is_thread_end(record: &Record) -> bool {
    let matches = |(target, text): &(&str, &str)| {
        record.target().starts_with(target) && record.args().to_string().contains(text)
    };
    record.level() == Level::Error && END_MESSAGES.iter().any(matches)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_end(target: &str, level: Level, text: &str) -> bool {
        is_thread_end(&Record::builder().target(target).level(level).args(format_args!("{text}")).build())
    }

    #[test]
    fn messages_about_the_end_of_a_thread_are_recognised() {
        let interrupted = "Os { code: 4, kind: Interrupted }";
        let [first, second] = [
            format!("dp_event_loop poll failed: {interrupted}"),
            "Failed in waiting of poll in discovery. x".into(),
        ];
        assert!(is_end("rustdds::rtps::dp_event_loop", Level::Error, &first));
        assert!(is_end("rustdds::discovery::discovery", Level::Error, &second));
        assert!(!is_end("clearance::node", Level::Error, &first));
        assert!(!is_end("rustdds::rtps::dp_event_loop", Level::Warn, &first));
        assert!(!is_end("rustdds::rtps::dp_event_loop", Level::Error, "Cannot remove Writer"));
    }
}
