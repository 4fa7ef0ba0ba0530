//! Subscription to one topic: decoded messages with their source and reception time.

use std::sync::Mutex;
use std::time::{Duration, Instant, UNIX_EPOCH};

use clearance_monitor::SourceId;
use futures_lite::future;
use ros2_client::Message;

use crate::dds::decode_error_log::DecodeErrorLog;
use crate::dds::lock::lock;
use crate::dds::sequence_gaps::SequenceGaps;
use crate::dds::wakeup;
use crate::names::FullName;
use crate::threading::thread_priority::ThreadPriority;

/// Source of a message and time of its reception.
#[derive(Clone, Copy, Debug)]
pub struct Origin {
    pub publisher: SourceId,
    /// When it was received.
    pub received: Instant,
    /// The same time (ns, system clock), as the middleware's thread read it: orders messages of several topics.
    pub arrival: u64,
    /// Sequence number among the publisher's messages; `None` for a message that no network carried.
    pub number: Option<i64>,
}

impl Origin {
    /// For a message of this process, received now.
    #[must_use]
    pub fn here(publisher: SourceId) -> Self {
        Self { publisher, received: Instant::now(), arrival: system_time(), number: None }
    }

    /// Time between the reception and now.
    #[must_use]
    pub fn waited(&self) -> Duration {
        self.received.elapsed()
    }
}

/// Error: a message was received that cannot be decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Undecodable;

/// Subscription to one topic: returns the messages of each publisher in the order in which they were sent.
///
/// A best-effort sample that arrives after a newer one of the same publisher is skipped, as RTPS 2.5, 8.4.12.1 requires
/// of best-effort readers; `RustDDS` 0.15.1 delivers it as if it were newer. It counts as lost.
pub struct Subscription<M> {
    pub(super) inner: ros2_client::Subscription<M>,
    pub(super) name: FullName,
    pub(super) decode_errors: DecodeErrorLog,
    pub(super) sequence_gaps: Mutex<SequenceGaps>,
    pub(super) priority: ThreadPriority,
}

impl<M: Message + 'static> Subscription<M> {
    /// Waits for the next message. A message that cannot be decoded is logged and skipped.
    pub async fn next(&self) -> (M, Origin) {
        loop {
            if let Ok(received) = self.next_or_undecodable().await {
                return received;
            }
        }
    }

    /// Waits for the next message. A message that cannot be decoded is logged and returned as an error.
    pub async fn next_or_undecodable(&self) -> Result<(M, Origin), Undecodable> {
        loop {
            // a topic with continuous traffic must not starve the futures beside it, such as the shutdown request
            future::yield_now().await;
            match wakeup::wait(self.priority, self.inner.async_take()).await {
                Ok((_, info)) if self.is_overtaken(&info) => {}
                Ok((message, info)) => return Ok((message, origin(&info))),
                Err(error) => {
                    self.log_decode_error(&error);
                    return Err(Undecodable);
                }
            }
        }
    }

    /// The next message, if one was received already. A message that cannot be decoded is logged and skipped.
    pub fn try_next(&self) -> Option<(M, Origin)> {
        loop {
            if let Ok(received) = self.try_next_or_undecodable()? {
                return Some(received);
            }
        }
    }

    /// The next message, if one was received already. A message that cannot be decoded is logged and returned as an error.
    pub fn try_next_or_undecodable(&self) -> Option<Result<(M, Origin), Undecodable>> {
        let _lent = self.priority.lend();
        loop {
            match self.inner.take() {
                Ok(Some((_, info))) if self.is_overtaken(&info) => {}
                Ok(taken) => return taken.map(|(message, info)| Ok((message, origin(&info)))),
                Err(error) => {
                    self.log_decode_error(&error);
                    return Some(Err(Undecodable));
                }
            }
        }
    }

    fn is_overtaken(&self, info: &ros2_client::MessageInfo) -> bool {
        let (publisher, number) = (SourceId(info.publisher_gid().to_bytes16()), info.sequence_number());
        let is_overtaken = lock(&self.sequence_gaps).is_overtaken(publisher, number);
        if is_overtaken {
            log::debug!("message {number} on {} came after a newer one of its publisher", self.name);
        }
        is_overtaken
    }

    fn log_decode_error(&self, error: &ros2_client::ReadError) {
        self.decode_errors.warn(|| format!("a message on {} could not be read: {error}", self.name));
    }
}

/// Now (ns, system clock).
pub fn system_time() -> u64 {
    let since_epoch = UNIX_EPOCH.elapsed().unwrap_or_default();
    u64::try_from(since_epoch.as_nanos()).unwrap_or(u64::MAX)
}

fn origin(info: &ros2_client::MessageInfo) -> Origin {
    // the middleware's thread records the system time once the message is complete; no earlier time is available
    let since_epoch = info.received_timestamp().and_then(|t| u64::try_from(t.to_nanos()).ok());
    let received = since_epoch.map(|nanoseconds| UNIX_EPOCH + Duration::from_nanos(nanoseconds));
    let waited = received.and_then(|received| received.elapsed().ok()).unwrap_or_default();
    let now = Instant::now();
    Origin {
        publisher: SourceId(info.publisher_gid().to_bytes16()),
        received: now.checked_sub(waited).unwrap_or(now),
        arrival: since_epoch.unwrap_or_else(system_time),
        number: Some(info.sequence_number()),
    }
}
