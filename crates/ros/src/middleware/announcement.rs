//! A participant that peers come to know before its endpoints.

use std::fmt;
use std::net::Ipv4Addr;
use std::thread;
use std::time::{Duration, Instant};

use rustdds::{DomainParticipant, DomainParticipantBuilder, RTPSEntity as _};

use super::receive_thread_watch::heed_panics;
use super::{MiddlewareError, discovery_probe, refused};
use crate::environment::{Environment, Reach};
use crate::thread_priority::ThreadPriority;

/// From the announcement of the participant to that of its endpoints.
const INTRODUCTION: Duration = Duration::from_millis(200);

/// A participant that is on the network and has no endpoints yet.
///
/// A peer that hears of endpoints before it knows their owner has to ask for them again. Fast DDS then forgets some of them when two
/// such owners come at once, and those topics are never matched (seen in captures: all of discovery acknowledged, one early endpoint
/// ignored). So the participant is announced as early as can be, and its endpoints a little later.
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
    /// Announces a participant, with threads of this priority; files can be read while peers come to know it.
    pub fn make(environment: Environment, priority: ThreadPriority) -> Result<Self, MiddlewareError> {
        heed_panics();
        let mut participant = DomainParticipantBuilder::new(environment.domain);
        if environment.reach == Reach::Localhost {
            participant = participant.with_only_networks([Ipv4Addr::LOCALHOST]);
        }
        let participant = (priority.inherited_by(|| without_signals(|| participant.build())))
            .map_err(refused("cannot start threads of realtime priority"))?
            .map_err(refused("cannot join the ROS network"))?;
        discovery_probe::go_ahead(participant.guid().to_bytes(), environment.domain);
        Ok(Self { environment, priority, participant, since: Instant::now() })
    }

    /// Where it was announced.
    #[must_use]
    pub fn environment(&self) -> Environment {
        self.environment
    }

    /// The priority of its threads, as of all between joint states and answers.
    pub(crate) fn priority(&self) -> ThreadPriority {
        self.priority
    }

    /// The participant, after peers have had the time to know it.
    pub(super) fn heard(self) -> DomainParticipant {
        thread::sleep(INTRODUCTION.saturating_sub(self.since.elapsed()));
        self.participant
    }
}

/// What this starts hears no signals: a thread of `RustDDS` ends when one interrupts its wait (see `deafness`), and the system gives a
/// signal to any thread that takes it while the main thread does not, as when it starts another.
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
