//! Publisher of one topic.

use clearance_monitor::SourceId;
use ros2_client::Message;

use crate::names::FullName;
use crate::threading::thread_priority::ThreadPriority;

/// Publisher of one topic.
pub struct Publisher<M: Message> {
    pub(super) inner: ros2_client::Publisher<M>,
    pub(super) name: FullName,
    pub(super) priority: ThreadPriority,
}

impl<M: Message> Publisher<M> {
    /// Identifier that receivers see as the source of its messages.
    #[must_use]
    pub fn source(&self) -> SourceId {
        SourceId(self.inner.guid().to_bytes())
    }

    /// Publishes without waiting, and logs an error. `false` when the message was dropped.
    pub fn publish(&self, message: M) -> bool {
        let _lent = self.priority.lend();
        match self.inner.publish(message) {
            Ok(()) => true,
            Err(error) => {
                log::debug!("a message on {} was dropped: {error}", self.name);
                false
            }
        }
    }
}
