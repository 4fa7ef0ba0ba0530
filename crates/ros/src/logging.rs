//! Log output to stderr and to `/rosout`.

use std::io::{self, Write};
use std::sync::{Mutex, PoisonError};

use chrono::{SecondsFormat, Utc};
use clearance_files::readable_text;
use env_logger::fmt::Formatter;
use log::{Level, LevelFilter, Log, Metadata, Record};

use crate::dds::log_line::LogLine;
use crate::dds::receive_thread_watch::check_log_record;
use crate::threading::mailbox;
use crate::threading::mailbox::{Receiver, Sender};

/// Maximum number of lines that wait for `/rosout`; further lines appear only on stderr.
const WAITING: usize = 1000;

/// Sender of lines to `/rosout`, once it is set up.
static ROSOUT: Mutex<Option<Sender<LogLine>>> = Mutex::new(None);

/// Sets up the log. Only errors of the DDS library are logged: it warns about every datagram over 1500 bytes, and about
/// every message on an interface without multicast.
pub fn start_logging(level: LevelFilter) {
    let quiet = level.min(LevelFilter::Warn);
    let very_quiet = level.min(LevelFilter::Error);
    let stderr = env_logger::Builder::new()
        .filter_level(level)
        .filter_module("rustdds", very_quiet)
        .filter_module("ros2_client", quiet)
        // it warns about the missing terminator of empty texts
        .filter_module("cdr_encoding", quiet)
        // it warns if ROS_DISTRO is not set, although this variable says nothing about the peers
        .filter_module("ros2_client::distributions", very_quiet)
        .format(write_line)
        .build();
    // errors that end the network threads are processed even if nothing is printed
    let most = stderr.filter().max(LevelFilter::Error);
    match log::set_boxed_logger(Box::new(Both { stderr })) {
        Ok(()) => log::set_max_level(most),
        Err(_) => log::debug!("the log was set up before"),
    }
}

/// `[2026-01-31T12:00:00.000Z WARN ] text`, with further lines of the text indented.
fn write_line(stderr: &mut Formatter, record: &Record) -> io::Result<()> {
    let time = Utc::now().to_rfc3339_opts(SecondsFormat::Millis, true);
    let text = record.args().to_string().replace('\n', "\n    ");
    writeln!(stderr, "[{time} {:<5}] {text}", record.level())
}

/// Opens the queue of log lines for `/rosout`. From now on, lines are also sent to it.
#[must_use]
pub fn open_rosout_queue() -> Receiver<LogLine> {
    let (sender, lines) = mailbox::bounded(WAITING);
    *ROSOUT.lock().unwrap_or_else(PoisonError::into_inner) = Some(sender);
    lines
}

/// Copy of a record with a different text.
fn with_text<'r>(record: &Record<'r>, text: std::fmt::Arguments<'r>) -> Record<'r> {
    let mut copy = Record::builder();
    copy.metadata(record.metadata().clone()).args(text);
    copy.module_path(record.module_path()).file(record.file()).line(record.line()).build()
}

struct Both {
    stderr: env_logger::Logger,
}

impl Log for Both {
    fn enabled(&self, metadata: &Metadata) -> bool {
        self.stderr.enabled(metadata)
    }

    fn log(&self, record: &Record) {
        let text = readable_text::lines(&record.args().to_string()).into_owned();
        self.stderr.log(&with_text(record, format_args!("{text}")));
        check_log_record(record);
        // other crates log about the network itself: to publish these lines could cause an endless loop
        if record.level() > Level::Info || !record.target().starts_with("clearance") {
            return;
        }
        if let Some(sender) = &*ROSOUT.lock().unwrap_or_else(PoisonError::into_inner) {
            let _ = sender.send(LogLine {
                level: record.level(),
                text,
                file: record.file_static().unwrap_or_default(),
                line: record.line().unwrap_or_default(),
            });
        }
    }

    fn flush(&self) {
        self.stderr.flush();
    }
}
