//! ROS time: the system's clock, or a simulation's.

use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use clearance_monitor::{Now, Time};

/// The time in which messages are stamped.
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

    /// A `/clock` message came.
    pub fn on_simulation_time(&self, time: Time) {
        self.simulation.store(time.nanoseconds(), Ordering::Relaxed);
    }

    /// ROS time; `None` while it is simulated and nothing came.
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

    /// All clocks.
    #[must_use]
    pub fn read(&self) -> Now {
        Now { ros: self.now(), steady: self.steady() }
    }

    /// Time since the node started, which never jumps.
    #[must_use]
    pub fn steady(&self) -> Duration {
        self.started.elapsed()
    }
}

fn system_time() -> Time {
    // before 1970 and after 2262 no robot runs
    let since_epoch = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    Time::from_nanoseconds(i64::try_from(since_epoch.as_nanos()).unwrap_or(i64::MAX))
}
