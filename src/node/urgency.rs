//! Whether the threads between a joint state and its answer run before whatever else the machine does.

use std::thread;

use super::NodeError;

/// How urgent the threads are that hear joint states, check them and say what was found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Urgency {
    /// As any other's.
    #[default]
    Usual,
    /// `SCHED_FIFO`: they run whenever they can, before all threads that are not of this kind.
    Realtime,
}

impl Urgency {
    /// What the parameter `use_realtime_priority` means here.
    ///
    /// # Errors
    /// When the system refuses it to this process.
    pub fn allowed(use_realtime_priority: bool) -> Result<Self, NodeError> {
        let urgency = if use_realtime_priority { Self::Realtime } else { Self::Usual };
        urgency.starting(|| ()).map(|()| urgency).map_err(|why| {
            NodeError::Input(format!(
                "use_realtime_priority: the system refuses it ({why}): allow it by 'rtprio 49' in /etc/security/limits.conf, \
                 LimitRTPRIO=49 and RestrictRealtime=no in a unit of systemd, --ulimit rtprio=49 for a container, or turn it off"
            ))
        })
    }

    /// Does what starts threads, which are as urgent.
    pub(super) fn starting<T: Send>(self, start: impl FnOnce() -> T + Send) -> Result<T, String> {
        if self == Self::Usual {
            return Ok(start());
        }
        // threads are as urgent as the one that starts them: one that ends right after
        let starter = || self.take().map(|()| start());
        thread::scope(|scope| scope.spawn(starter).join()).unwrap_or_else(|_| Err("it failed".to_owned()))
    }

    /// Makes the thread that calls this as urgent.
    #[cfg(unix)]
    pub(super) fn take(self) -> Result<(), String> {
        use thread_priority::{
            Error, RealtimeThreadSchedulePolicy, ScheduleParams, ThreadPriority, ThreadSchedulePolicy,
            set_thread_priority_and_policy, thread_native_id,
        };
        if self == Self::Usual {
            return Ok(());
        }
        let fifo = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
        let priority = ThreadPriority::from_posix(ScheduleParams { sched_priority: PRIORITY });
        set_thread_priority_and_policy(thread_native_id(), priority, fifo).map_err(|error| match error {
            Error::OS(code) => std::io::Error::from_raw_os_error(code).to_string(),
            other => format!("{other:?}"),
        })
    }

    #[cfg(not(unix))]
    pub(super) fn take(self) -> Result<(), String> {
        match self {
            Self::Usual => Ok(()),
            Self::Realtime => Err("there is no SCHED_FIFO here".to_owned()),
        }
    }
}

/// Below the kernel's own threads for interrupts, which have 50; as Nav2 does.
#[cfg(unix)]
const PRIORITY: i32 = 49;
