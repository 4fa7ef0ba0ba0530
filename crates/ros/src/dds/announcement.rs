//! DDS participant that is announced before its endpoints.

use std::fmt;
use std::net::Ipv4Addr;
use std::thread;
use std::time::{Duration, Instant};

use rustdds::{DomainParticipant, DomainParticipantBuilder, RTPSEntity as _};

use crate::dds::discovery_probe;
use crate::dds::middleware_error::{MiddlewareError, error_with};
use crate::dds::receive_thread_watch::watch_panics;
use crate::environment::{Environment, Reach};
use crate::threading::thread_priority::ThreadPriority;

/// Delay between the announcement of the participant and the announcement of its endpoints.
const DISCOVERY_DELAY: Duration = Duration::from_millis(200);

/// An announced DDS participant without endpoints.
///
/// A peer that discovers endpoints before their participant has to request them again. If two such participants appear
/// at once, Fast DDS then drops some of the endpoints, and those topics are never matched. Captures show this: all of
/// discovery is acknowledged, and one early endpoint is ignored. So the participant is announced as early as possible,
/// and its endpoints a little later.
pub struct Announcement {
    environment: Environment,
    priority: ThreadPriority,
    participant: DomainParticipant,
    since: Instant,
}

impl fmt::Debug for Announcement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Announcement").field("environment", &self.environment).finish_non_exhaustive()
    }
}

impl Announcement {
    /// Announces a participant whose threads have this priority. The caller can read files while peers discover it.
    pub fn make(environment: Environment, priority: ThreadPriority) -> Result<Self, MiddlewareError> {
        watch_panics();
        let mut participant = DomainParticipantBuilder::new(environment.domain);
        if environment.reach == Reach::Localhost {
            participant = participant.with_only_networks([Ipv4Addr::LOCALHOST]);
        }
        let participant = (priority.inherited_by(|| without_signals(|| participant.build())))
            .map_err(error_with("cannot start threads of realtime priority"))?
            .map_err(error_with("cannot join the ROS network"))?;
        discovery_probe::start_probe(participant.guid().to_bytes(), environment.domain);
        Ok(Self { environment, priority, participant, since: Instant::now() })
    }

    /// The environment in which the participant was announced.
    #[must_use]
    pub fn environment(&self) -> Environment {
        self.environment
    }

    /// Priority of its threads, and of all threads between a joint state and the response to it.
    pub(crate) fn priority(&self) -> ThreadPriority {
        self.priority
    }

    /// Returns the participant once peers have had time to discover it.
    pub(super) fn discovered(self) -> DomainParticipant {
        thread::sleep(DISCOVERY_DELAY.saturating_sub(self.since.elapsed()));
        self.participant
    }
}

/// Starts threads that receive no signals. A `RustDDS` thread ends when a signal interrupts its wait (see
/// `receive_thread_watch`). The system delivers a signal to any thread that accepts it while the main thread does not,
/// for example while the main thread starts another thread.
#[cfg(unix)]
fn without_signals<T>(start: impl FnOnce() -> T) -> T {
    use nix::sys::signal::{SigSet, SigmaskHow};
    let before = SigSet::all().thread_swap_mask(SigmaskHow::SIG_SETMASK);
    let started = start();
    if let Err(error) = before.and_then(|mask| mask.thread_set_mask()) {
        log::error!("signals may not end this node: {error}");
    }
    started
}

#[cfg(not(unix))]
fn without_signals<T>(start: impl FnOnce() -> T) -> T {
    start()
}
