//! When the network is heard no more.
//!
//! `RustDDS` 0.15.1 ends its threads when a wait of theirs is interrupted, as it is when the process was stopped and goes on (Ctrl-Z
//! and `fg`, a debugger), and tells its log alone; or they panic. A node that went on would neither hear nor say anything, and look alive.

use std::sync::LazyLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::{panic, thread};

use log::{Level, Record};
use smol::channel::{self, Receiver, Sender};

/// What the threads log at their end, and where.
const LAST_WORDS: [(&str, &str); 2] = [
    ("rustdds::rtps::dp_event_loop", "poll failed"),
    ("rustdds::discovery", "Failed in waiting of poll in discovery"),
];

static IS_DEAF: AtomicBool = AtomicBool::new(false);
static NEWS: LazyLock<(Sender<()>, Receiver<()>)> = LazyLock::new(|| channel::bounded(1));

/// What the names of the threads begin with.
const THREADS: &str = "RustDDS";

/// Heeds a line of the log.
pub fn heed(record: &Record) {
    if are_last_words(record) {
        note();
    }
}

/// From now on panics of the threads are heeded too.
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

/// Waits until nothing is heard any more.
pub async fn deafness() {
    let _ = NEWS.1.recv().await;
}

/// Whether nothing is heard any more.
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
