//! Quality of service of topics and services.

use ros2_client::QosProfile;
use ros2_client::qos::{Durability, History, Reliability, WhenFull};

/// Quality of service of a topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quality {
    /// Latest samples; lost samples are not sent again. A subscription of this kind receives from every publisher.
    BestEffort,
    /// Every sample is delivered. A publisher of this kind is compatible with every subscription.
    Reliable,
    /// Transient local: the last sample is kept for subscriptions that come later.
    Latched,
    /// As `Latched`, with a history of many samples: later subscriptions receive all of them.
    Kept,
    /// As `BestEffort`, for samples so large that only few may be held at a time.
    Bulk,
    /// As `Reliable`, for samples so large that only few may be held at a time.
    ReliableBulk,
    /// As `Latched`, for samples so large that only few may be held at a time.
    LatchedBulk,
}

impl Quality {
    /// Samples kept for each topic.
    const DEPTH: usize = 10;
    /// Samples kept for each topic of quality `Kept`.
    const KEPT_DEPTH: usize = 100;

    /// Number of samples that are held for a topic even if a subscription has not received them; `None` for the limit
    /// of `RustDDS`. Without a limit, a publisher that keeps samples for later subscriptions holds 8192 of them, whatever
    /// its depth, until there is a subscription.
    pub(super) fn limit(self) -> Option<i32> {
        match self {
            Self::BestEffort | Self::Reliable => None,
            Self::Kept => Some(512),
            Self::Latched => Some(64),
            Self::Bulk | Self::ReliableBulk | Self::LatchedBulk => Some(4),
        }
    }

    pub(super) fn profile(self) -> QosProfile {
        // a subscriber that has stopped reading must never block the monitor: its samples are dropped instead
        let reliable = Reliability::Reliable { when_full: WhenFull::Fail };
        let base = QosProfile::subscription_default();
        match self {
            Self::BestEffort => base.history(History::KeepLast { depth: Self::DEPTH }),
            Self::Bulk => base.history(History::KeepLast { depth: 1 }),
            Self::ReliableBulk => base.reliability(reliable).history(History::KeepLast { depth: 1 }),
            Self::Kept => (base.reliability(reliable))
                .durability(Durability::TransientLocal)
                .history(History::KeepLast { depth: Self::KEPT_DEPTH }),
            Self::Reliable => base.reliability(reliable).history(History::KeepLast { depth: Self::DEPTH }),
            Self::Latched | Self::LatchedBulk => (base.reliability(reliable))
                .durability(Durability::TransientLocal)
                .history(History::KeepLast { depth: 1 }),
        }
    }
}
