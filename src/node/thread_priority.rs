//! Whether the threads between a joint state and its answer run before whatever else the machine does.

use std::thread;

use super::NodeError;

/// How the threads are scheduled that hear joint states, check them and say what was found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ThreadPriority {
    /// As all others.
    #[default]
    Normal,
    /// `SCHED_FIFO`: they run whenever they can, before all threads that are not of this kind.
    Realtime,
}

impl ThreadPriority {
    /// What the parameter `use_realtime_priority` means here.
    ///
    /// # Errors
    /// When the system refuses it to this process.
    pub fn allowed(use_realtime_priority: bool) -> Result<Self, NodeError> {
        let priority = if use_realtime_priority { Self::Realtime } else { Self::Normal };
        priority.inherited_by(|| ()).map(|()| priority).map_err(|why| {
            NodeError::Input(format!(
                "use_realtime_priority: the system refuses it ({why}): allow it by the line 'USER - rtprio 49' in /etc/security/limits.conf, \
                 LimitRTPRIO=49 and RestrictRealtime=no in a unit of systemd, --ulimit rtprio=49 for a container, or turn it off"
            ))
        })
    }

    /// Does what starts threads, which inherit this priority; that of the caller stays.
    pub(super) fn inherited_by<T: Send>(self, start: impl FnOnce() -> T + Send) -> Result<T, String> {
        if self == Self::Normal {
            return Ok(start());
        }
        let starter = || self.apply().map(|()| start());
        thread::scope(|scope| scope.spawn(starter).join()).unwrap_or_else(|_| Err("it failed".to_owned()))
    }

    /// Gives this priority to the thread that calls it.
    #[cfg(unix)]
    pub(super) fn apply(self) -> Result<(), String> {
        use thread_priority::{
            Error, RealtimeThreadSchedulePolicy, ScheduleParams, ThreadSchedulePolicy,
            set_thread_priority_and_policy, thread_native_id,
        };
        if self == Self::Normal {
            return Ok(());
        }
        let fifo = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
        let priority =
            thread_priority::ThreadPriority::from_posix(ScheduleParams { sched_priority: PRIORITY });
        set_thread_priority_and_policy(thread_native_id(), priority, fifo).map_err(|error| match error {
            Error::OS(code) => std::io::Error::from_raw_os_error(code).to_string(),
            other => format!("{other:?}"),
        })
    }

    #[cfg(not(unix))]
    pub(super) fn apply(self) -> Result<(), String> {
        match self {
            Self::Normal => Ok(()),
            Self::Realtime => Err("there is no SCHED_FIFO here".to_owned()),
        }
    }
}

/// Below the kernel's own threads for interrupts, which have 50; as Nav2 does.
#[cfg(unix)]
const PRIORITY: i32 = 49;
