//! Detects that the receive threads of `RustDDS` have ended.
//!
//! `RustDDS` 0.15.1 ends its threads when a wait of theirs is interrupted, and only logs it. This happens when the process is
//! stopped and continued (Ctrl-Z and `fg`, a debugger). The threads can also panic. A node that continued would neither receive nor
//! send anything, and would still look alive.

use std::sync::LazyLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::{panic, thread};

use log::{Level, Record};
use smol::channel::{self, Receiver, Sender};

/// Log messages of the threads when they end: target and text.
const LAST_WORDS: [(&str, &str); 2] = [
    ("rustdds::rtps::dp_event_loop", "poll failed"),
    ("rustdds::discovery", "Failed in waiting of poll in discovery"),
];

static IS_DEAF: AtomicBool = AtomicBool::new(false);
static NEWS: LazyLock<(Sender<()>, Receiver<()>)> = LazyLock::new(|| channel::bounded(1));

/// Prefix of the threads' names.
const THREADS: &str = "RustDDS";

/// Checks a line of the log for the end of a thread.
pub fn heed(record: &Record) {
    if are_last_words(record) {
        note();
    }
}

/// Installs a panic hook that detects panics of the threads.
pub fn heed_panics() {
    let before = panic::take_hook();
    panic::set_hook(Box::new(move |what| {
        before(what);
        if thread::current().name().is_some_and(|name| name.starts_with(THREADS)) {
            note();
        }
    }));
}

fn note() {
    IS_DEAF.store(true, Ordering::Release);
    let _ = NEWS.0.try_send(());
}

/// Waits until a receive thread has ended.
pub async fn deafness() {
    let _ = NEWS.1.recv().await;
}

/// Whether a receive thread has ended.
pub fn is_deaf() -> bool {
    IS_DEAF.load(Ordering::Acquire)
}

fn are_last_words(record: &Record) -> bool {
    let said = |(target, words): &(&str, &str)| {
        record.target().starts_with(target) && record.args().to_string().contains(words)
    };
    record.level() == Level::Error && LAST_WORDS.iter().any(said)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_end(target: &str, level: Level, text: &str) -> bool {
        are_last_words(&Record::builder().target(target).level(level).args(format_args!("{text}")).build())
    }

    #[test]
    fn last_words_are_told_from_others() {
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
