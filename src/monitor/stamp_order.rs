//! The newest stamp of every publisher.

use super::{SourceId, Time};

/// Publishers remembered at most: restarts make new ones, and memory must not grow with them.
const REMEMBERED: usize = 32;

/// Newest judged stamps by publisher, the one heard last at the end.
#[derive(Clone, Debug, Default)]
pub(super) struct StampOrder(Vec<(SourceId, Time)>);

impl StampOrder {
    /// The newest stamp judged from `source`.
    pub fn newest(&self, source: SourceId) -> Option<Time> {
        self.0.iter().find_map(|&(s, t)| (s == source).then_some(t))
    }

    pub fn note(&mut self, source: SourceId, stamp: Time) {
        self.0.retain(|&(s, _)| s != source);
        if self.0.len() == REMEMBERED {
            self.0.remove(0);
        }
        self.0.push((source, stamp));
    }

    /// Forgets everything: the clock that the stamps refer to was set back.
    pub fn clear(&mut self) {
        self.0.clear();
    }
}
