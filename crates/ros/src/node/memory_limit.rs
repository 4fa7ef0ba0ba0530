//! Memory limit: publishes UNKNOWN and ends the node before the process uses more memory than it is allowed to.

use std::sync::{Arc, OnceLock, PoisonError};
use std::thread;
use std::time::Duration;

use futures_lite::future;
use smol::Timer;
use sysinfo::{MemoryRefreshKind, Pid, ProcessRefreshKind, ProcessesToUpdate, RefreshKind, System};

use crate::monitor_events::monitor_event::MonitorEvent;
use crate::node::termination::{OUT_OF_MEMORY, arm_watchdog, exit};
use crate::parameters::parameter_store::ParameterStore;
use crate::recording::recorder_handle::RecorderHandle;
use crate::scene::active_scene::CurrentScene;
use crate::threading::mailbox;

/// Period of the measurements. A network at full speed transfers about 5 MB in this time.
const PERIOD: Duration = Duration::from_millis(50);

/// Time that the monitor has to publish the status UNKNOWN.
const TIME_TO_PUBLISH: Duration = Duration::from_millis(500);

/// Further growth after the limit at which the process ends at once: a fraction (1/4) of the limit, but at least
/// `LEAST_LAST_GROWTH`. A flood of packets adds more than 1 GB per second.
const LAST_GROWTH: u64 = 4;
const LEAST_LAST_GROWTH: u64 = 64 * MIB;

/// Period of the measurements above the limit.
const PERIOD_BEYOND: Duration = Duration::from_millis(10);

/// Default limit (MiB) if `memory_limit` is 0; a quarter of the machine's memory, if that is less.
const DEFAULT_LIMIT: u64 = 2048;

const MIB: u64 = 1 << 20;

/// Error message; set when the limit was exceeded.
pub type OutOfMemory = Arc<OnceLock<String>>;

/// Monitors the resident memory of this process.
pub struct MemoryWatch {
    store: ParameterStore,
    events: mailbox::Sender<MonitorEvent>,
    components: Components,
    out_of_memory: OutOfMemory,
}

impl MemoryWatch {
    #[must_use]
    pub fn new(store: ParameterStore, events: mailbox::Sender<MonitorEvent>, components: Components) -> Self {
        Self { store, events, components, out_of_memory: OutOfMemory::default() }
    }

    #[must_use]
    pub fn out_of_memory(&self) -> OutOfMemory {
        Arc::clone(&self.out_of_memory)
    }

    /// Returns after the limit was exceeded and the status was published.
    pub async fn run(self) {
        let Some(mut process) = Process::this() else {
            return future::pending().await;
        };
        let most = process.memory_for_one_node();
        let mut at_start = None;
        loop {
            let used = process.resident_memory();
            let limit = limit(self.store.get().memory_limit, most);
            // memory for the robot and its first world is not counted as growth
            at_start = at_start.or_else(|| self.components.has_robot().then(|| self.components.usage(used)));
            if used > limit * MIB {
                end_far_beyond(process, used + (limit * MIB / LAST_GROWTH).max(LEAST_LAST_GROWTH));
                return self.end(used, limit, &at_start.unwrap_or_default()).await;
            }
            Timer::after(PERIOD).await;
        }
    }

    async fn end(self, used: u64, limit: u64, at_start: &Usage) {
        arm_watchdog(OUT_OF_MEMORY);
        let growth = self.components.usage(used).growth_since(at_start);
        let used = used.div_ceil(MIB);
        let why = format!(
            "the node takes {used} MiB of memory, and memory_limit is {limit} MiB: {growth}; raise memory_limit if the robot and its world need that much"
        );
        // log first, as the later steps may not be reached; on a separate thread, as the log may be a pipe that is not
        // read
        let _ = thread::Builder::new().spawn(move || log::error!("{why}"));
        let (published, is_published) = mailbox::bounded(1);
        if self.events.send(MonitorEvent::Memory { used, limit, published }).is_ok() {
            let give_up = async {
                Timer::after(TIME_TO_PUBLISH).await;
                None
            };
            future::or(is_published.receive(), give_up).await;
        }
        // the value is set only here
        let _ = self.out_of_memory.set(format!("memory_limit ({limit} MiB) was exceeded"));
    }
}

/// Ends the process at once when it uses more than `most` bytes of memory, even if the orderly shutdown still waits.
fn end_far_beyond(mut process: Process, most: u64) {
    let watch = move || {
        loop {
            if process.resident_memory() > most {
                exit(OUT_OF_MEMORY);
            }
            thread::sleep(PERIOD_BEYOND);
        }
    };
    if thread::Builder::new().name("memory".to_owned()).spawn(watch).is_err() {
        exit(OUT_OF_MEMORY);
    }
}

/// Monitors the resident memory of this process until the node runs.
pub struct StartupWatch {
    process: Process,
    limit: u64,
}

impl StartupWatch {
    /// Creates a watch for the limit `memory_limit` (MiB).
    pub fn new(memory_limit: f64) -> Option<Self> {
        let process = Process::this()?;
        let limit = limit(memory_limit, process.memory_for_one_node());
        Some(Self { process, limit })
    }

    /// Ends the process when the limit is exceeded. At this time there is no state to publish and no data to save.
    pub fn run(mut self, has_ended: impl Fn() -> bool) {
        while !has_ended() {
            let used = self.process.resident_memory();
            if used > self.limit * MIB {
                let (used, limit) = (used.div_ceil(MIB), self.limit);
                log::error!(
                    "the node takes {used} MiB of memory while it starts, and memory_limit is {limit} MiB: raise it if the robot and the world of the command line need that much"
                );
                exit(OUT_OF_MEMORY);
            }
            thread::sleep(PERIOD);
        }
    }
}

/// Active limit (MiB), from the parameter's value and the memory available to one node (bytes).
fn limit(parameter: f64, most: u64) -> u64 {
    if parameter > 0.0 {
        // the parameter's range makes it a whole number far below 2^53
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive and small")]
        return parameter.ceil() as u64;
    }
    // if the machine does not report its memory, the default applies
    if most == 0 { DEFAULT_LIMIT } else { DEFAULT_LIMIT.min(most / MIB) }
}

/// This process in the view of the operating system.
struct Process {
    system: System,
    id: Pid,
}

impl Process {
    fn this() -> Option<Self> {
        let id = sysinfo::get_current_pid()
            .inspect_err(|error| log::warn!("memory_limit has no effect: this process is not found: {error}"))
            .ok()?;
        let memory = MemoryRefreshKind::nothing().with_ram();
        Some(Self { system: System::new_with_specifics(RefreshKind::nothing().with_memory(memory)), id })
    }

    /// Memory available to one node (bytes): a quarter of the machine's memory, or nearly all of the container's memory
    /// if that is less.
    fn memory_for_one_node(&self) -> u64 {
        let quarter = self.system.total_memory() / 4;
        self.system.cgroup_limits().map_or(quarter, |group| quarter.min(group.total_memory / 10 * 9))
    }

    fn resident_memory(&mut self) -> u64 {
        let memory = ProcessRefreshKind::nothing().with_memory();
        self.system.refresh_processes_specifics(ProcessesToUpdate::Some(&[self.id]), false, memory);
        self.system.process(self.id).map_or(0, sysinfo::Process::memory)
    }
}

/// Components of the node whose memory is measured.
pub struct Components {
    pub scene: CurrentScene,
    pub recording: RecorderHandle,
}

impl Components {
    fn has_robot(&self) -> bool {
        self.scene.lock().unwrap_or_else(PoisonError::into_inner).is_some()
    }

    fn usage(&self, used: u64) -> Usage {
        let scene = self.scene.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let hierarchies = scene.map_or(0, |scene| scene.revision.checker.hierarchy_size().0);
        let hierarchies = u64::try_from(hierarchies).unwrap_or(u64::MAX);
        let recording = u64::try_from(self.recording.waiting_bytes()).unwrap_or(u64::MAX);
        let rest = used.saturating_sub(hierarchies).saturating_sub(recording);
        Usage { hierarchies, recording, rest }
    }
}

/// Memory in bytes per component.
#[derive(Clone, Copy, Debug, Default)]
struct Usage {
    /// Bounding volumes of the robot and of the obstacles in use.
    hierarchies: u64,
    recording: u64,
    /// Memory of all other components, which is not measured for each of them.
    rest: u64,
}

impl Usage {
    /// The component that grew most, and the growth of each component.
    fn growth_since(&self, before: &Self) -> String {
        let grown = |now: u64, then: u64| now.saturating_sub(then) / MIB;
        let mut growth = [
            ("bounding volumes of robot and world", grown(self.hierarchies, before.hierarchies)),
            ("recording queue", grown(self.recording, before.recording)),
            (
                "the rest (messages that wait or are processed, network library, other data of the world)",
                grown(self.rest, before.rest),
            ),
        ];
        growth.sort_by_key(|(_, grown)| std::cmp::Reverse(*grown));
        let parts: Vec<_> = growth.iter().map(|(name, grown)| format!("{name} by {grown} MiB")).collect();
        format!("grown since the robot was loaded: {}", parts.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_is_two_gibibytes_or_a_quarter_of_the_machine() {
        assert_eq!(limit(0.0, 24 << 30), 2048);
        assert_eq!(limit(0.0, 1 << 30), 1024);
        assert_eq!(limit(0.0, 0), 2048);
        assert_eq!(limit(100.0, 1 << 30), 100);
    }

    #[test]
    fn what_grew_most_is_named_first() {
        let before = Usage { hierarchies: 900 * MIB, recording: 0, rest: 100 * MIB };
        let now = Usage { hierarchies: 910 * MIB, recording: MIB, rest: 700 * MIB };
        assert_eq!(
            now.growth_since(&before),
            "grown since the robot was loaded: the rest (messages that wait or are processed, network library, \
             other data of the world) by 600 MiB, bounding volumes of robot and world by 10 MiB, recording queue \
             by 1 MiB"
        );
    }

    #[test]
    fn this_process_takes_memory_of_this_machine() {
        let mut process = Process::this().expect("this process is found");
        let before = process.resident_memory();
        let block = vec![1_u8; 64 << 20];
        let after = process.resident_memory();
        assert!(after >= before + (60 << 20), "{before} and {after} with {} more", block.len());
        assert!(process.memory_for_one_node() > 0);
    }
}
