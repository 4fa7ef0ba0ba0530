//! Optional realtime priority of the threads between the reception of a joint state and the publication of its result.
//!
//! `RustDDS` and its callers communicate through queues in which one side waits for the other by yielding (the queues
//! of `std::sync::mpsc`). A thread with realtime priority never yields to a thread without it: it could wait for a
//! sender that it has preempted itself, until the kernel stops all realtime threads for a moment
//! (`sched_rt_runtime_us`, 0.95 s). Therefore a thread that calls that library runs with the priority of the library's
//! threads during the call ([`ThreadPriority::lend`]), and the queues between our own threads of both kinds never wait
//! by yielding (`mailbox`).

use std::marker::PhantomData;
use std::thread;

use crate::node_error::NodeError;

/// Scheduling of the threads that receive joint states, check them and publish the results.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ThreadPriority {
    /// Default scheduling of the system.
    #[default]
    Normal,
    /// `SCHED_FIFO`: these threads always run before all threads without realtime priority.
    Realtime,
}

impl ThreadPriority {
    /// Priority selected by the parameter `use_realtime_priority`.
    ///
    /// # Errors
    /// When the system does not permit it for this process.
    pub fn allowed(use_realtime_priority: bool) -> Result<Self, NodeError> {
        let priority = if use_realtime_priority { Self::Realtime } else { Self::Normal };
        priority.inherited_by(|| ()).map(|()| priority).map_err(|why| {
            NodeError::Input(format!(
                "use_realtime_priority: the system refuses it ({why}): allow it by the line 'USER - rtprio 49' in /etc/security/limits.conf, \
                 LimitRTPRIO=49 and RestrictRealtime=no in a unit of systemd, --ulimit rtprio=49 for a container, or turn it off"
            ))
        })
    }

    /// Runs `start`, which starts threads. They inherit this priority; the caller keeps its own.
    pub(crate) fn inherited_by<T: Send>(self, start: impl FnOnce() -> T + Send) -> Result<T, String> {
        if self == Self::Normal {
            return Ok(start());
        }
        let starter = || self.apply().map(|()| start());
        thread::scope(|scope| scope.spawn(starter).join()).unwrap_or_else(|_| Err("it failed".to_owned()))
    }

    /// Sets this priority for the calling thread.
    pub(crate) fn apply(self) -> Result<(), String> {
        if self == Self::Realtime { system::raise() } else { Ok(()) }
    }

    /// Sets this priority for the calling thread until the returned guard is dropped. This takes some microseconds, and
    /// nothing if the thread already has the priority.
    pub(crate) fn lend(self) -> Lent {
        if self == Self::Normal || system::is_raised() {
            return Lent { is_borrowed: false, of_thread: PhantomData };
        }
        let borrowed = self.apply().inspect_err(|why| log::warn!("there is no priority to lend: {why}"));
        Lent { is_borrowed: borrowed.is_ok(), of_thread: PhantomData }
    }
}

/// Guard of a lent priority; resets the thread to the default priority when it is dropped.
#[must_use = "it is given back at once"]
pub(crate) struct Lent {
    is_borrowed: bool,
    /// Makes the guard `!Send`: it belongs to its thread.
    of_thread: PhantomData<*const ()>,
}

impl Drop for Lent {
    fn drop(&mut self) {
        if self.is_borrowed
            && let Err(why) = system::reset()
        {
            log::error!("a thread keeps realtime priority: {why}");
        }
    }
}

#[cfg(unix)]
mod system {
    use thread_priority::{
        Error, NormalThreadSchedulePolicy, RealtimeThreadSchedulePolicy, ScheduleParams, ThreadPriority,
        ThreadSchedulePolicy, set_thread_priority_and_policy, thread_native_id, thread_schedule_policy,
    };

    /// Lower than the kernel's interrupt threads, which have 50. Nav2 uses the same value.
    const PRIORITY: i32 = 49;

    pub fn raise() -> Result<(), String> {
        let fifo = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
        let priority = ThreadPriority::from_posix(ScheduleParams { sched_priority: PRIORITY });
        set_thread_priority_and_policy(thread_native_id(), priority, fifo).map_err(message)
    }

    pub fn is_raised() -> bool {
        matches!(thread_schedule_policy(), Ok(ThreadSchedulePolicy::Realtime(_)))
    }

    pub fn reset() -> Result<(), String> {
        let other = ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Other);
        let not_nice = ThreadPriority::Os(thread_priority::ThreadPriorityOsValue::default());
        let changed = set_thread_priority_and_policy(thread_native_id(), not_nice, other);
        // the thread may not be permitted to lower its nice value again
        if is_raised() { changed.map_err(message) } else { Ok(()) }
    }

    fn message(error: Error) -> String {
        match error {
            Error::OS(code) => std::io::Error::from_raw_os_error(code).to_string(),
            other => format!("{other:?}"),
        }
    }
}

#[cfg(not(unix))]
mod system {
    pub fn raise() -> Result<(), String> {
        Err("there is no SCHED_FIFO here".to_owned())
    }

    pub fn is_raised() -> bool {
        false
    }

    pub fn reset() -> Result<(), String> {
        Ok(())
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_priority_is_lent_and_given_back() {
        let lent_and_back = || {
            {
                let _normal = ThreadPriority::Normal.lend();
                assert!(!system::is_raised());
            }
            let is_allowed = ThreadPriority::allowed(true).is_ok();
            {
                let _outer = ThreadPriority::Realtime.lend();
                {
                    let _inner = ThreadPriority::Realtime.lend();
                }
                assert_eq!(system::is_raised(), is_allowed);
            }
            assert!(!system::is_raised());
        };
        thread::spawn(lent_and_back).join().unwrap();
    }
}
