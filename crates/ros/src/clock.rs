//! ROS time: the system clock, or the clock of a simulation.

use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use clearance_monitor::{Now, Time};

/// Clock for the stamps of messages.
#[derive(Debug)]
pub struct RosClock {
    started: Instant,
    simulated: AtomicBool,
    /// Nanoseconds of the last `/clock` message; `NEVER` before the first.
    simulation: AtomicI64,
}

const NEVER: i64 = i64::MIN;

impl RosClock {
    #[must_use]
    pub fn new(use_sim_time: bool) -> Self {
        Self {
            started: Instant::now(),
            simulated: AtomicBool::new(use_sim_time),
            simulation: AtomicI64::new(NEVER),
        }
    }

    pub fn use_sim_time(&self, simulated: bool) {
        self.simulated.store(simulated, Ordering::Relaxed);
    }

    /// Stores the time of a `/clock` message.
    pub fn on_simulation_time(&self, time: Time) {
        self.simulation.store(time.nanoseconds(), Ordering::Relaxed);
    }

    /// ROS time; `None` if time is simulated and no `/clock` message was received yet.
    #[must_use]
    pub fn now(&self) -> Option<Time> {
        if !self.simulated.load(Ordering::Relaxed) {
            return Some(system_time());
        }
        match self.simulation.load(Ordering::Relaxed) {
            NEVER => None,
            nanoseconds => Some(Time::from_nanoseconds(nanoseconds)),
        }
    }

    /// Reads all clocks at once.
    #[must_use]
    pub fn read(&self) -> Now {
        Now { ros: self.now(), steady: self.steady() }
    }

    /// Steady time since the start of the node. It never jumps.
    #[must_use]
    pub fn steady(&self) -> Duration {
        self.started.elapsed()
    }
}

fn system_time() -> Time {
    // times before 1970 and after 2262 are not supported
    let since_epoch = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    Time::from_nanoseconds(i64::try_from(since_epoch.as_nanos()).unwrap_or(i64::MAX))
}
