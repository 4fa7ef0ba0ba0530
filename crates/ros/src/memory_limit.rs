//! Memory limit: publishes UNKNOWN and ends the node before the process takes more memory than it may.

use std::sync::{Arc, OnceLock, PoisonError};
use std::thread;
use std::time::Duration;

use futures_lite::future;
use smol::Timer;
use sysinfo::{MemoryRefreshKind, Pid, ProcessRefreshKind, ProcessesToUpdate, RefreshKind, System};

use super::mailbox;
use super::monitor_loop::Event;
use super::parameter_services::ParameterStore;
use super::recording::RecorderHandle;
use super::scene_keeper::CurrentScene;
use super::termination::{OUT_OF_MEMORY, arm_watchdog, exit};

/// Time between two readings. A network at full speed brings some 5 MB in it.
const PERIOD: Duration = Duration::from_millis(50);

/// Time that the monitor has to publish that nothing is known any more.
const TIME_TO_PUBLISH: Duration = Duration::from_millis(500);

/// How much the memory may still grow beyond its limit until the process ends at once, as a part of the limit and at least: a flood of
/// packets brings over a GB a second.
const LAST_GROWTH: u64 = 4;
const LEAST_LAST_GROWTH: u64 = 64 * MIB;

/// Time between two readings beyond the limit.
const PERIOD_BEYOND: Duration = Duration::from_millis(10);

/// The limit (MiB) where `memory_limit` is 0, unless a quarter of the machine is less.
const DEFAULT_LIMIT: u64 = 2048;

const MIB: u64 = 1 << 20;

/// Message of the memory limit, once it was exceeded.
pub type OutOfMemory = Arc<OnceLock<String>>;

/// Watches the resident memory of this process.
pub struct MemoryWatch {
    store: ParameterStore,
    events: mailbox::Sender<Event>,
    components: Components,
    out_of_memory: OutOfMemory,
}

impl MemoryWatch {
    #[must_use]
    pub fn new(store: ParameterStore, events: mailbox::Sender<Event>, components: Components) -> Self {
        Self { store, events, components, out_of_memory: OutOfMemory::default() }
    }

    #[must_use]
    pub fn out_of_memory(&self) -> OutOfMemory {
        Arc::clone(&self.out_of_memory)
    }

    /// Returns once the limit was exceeded and that was published.
    pub async fn work(self) {
        let Some(mut process) = Process::this() else {
            return future::pending().await;
        };
        let most = process.memory_for_one_node();
        let mut at_start = None;
        loop {
            let used = process.resident_memory();
            let limit = limit(self.store.get().memory_limit, most);
            // what the robot and its first world take is no growth
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
        // first of all, as the rest may not be reached; on a thread of its own, as the log may be a pipe that nobody reads
        let _ = thread::Builder::new().spawn(move || log::error!("{why}"));
        let (published, is_published) = mailbox::bounded(1);
        if self.events.send(Event::Memory { used, limit, published }).is_ok() {
            let give_up = async {
                Timer::after(TIME_TO_PUBLISH).await;
                None
            };
            future::or(is_published.receive(), give_up).await;
        }
        // nothing else sets it
        let _ = self.out_of_memory.set(format!("memory_limit ({limit} MiB) was exceeded"));
    }
}

/// Ends the process at once when it takes more than `most` bytes of memory, whatever the orderly end waits for.
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

/// Watches the resident memory of this process until the node runs.
pub struct StartupWatch {
    process: Process,
    limit: u64,
}

impl StartupWatch {
    /// With the limit that `memory_limit` (MiB) sets.
    pub fn new(memory_limit: f64) -> Option<Self> {
        let process = Process::this()?;
        let limit = limit(memory_limit, process.memory_for_one_node());
        Some(Self { process, limit })
    }

    /// Ends the process when the limit is exceeded. There is no state yet that could be published, and nothing to complete.
    pub fn work(mut self, has_ended: impl Fn() -> bool) {
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

/// The limit in force (MiB), of the parameter's value and what one node may take of the machine (bytes).
fn limit(parameter: f64, most: u64) -> u64 {
    if parameter > 0.0 {
        // whole and far below 2^53, by its range
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive and small")]
        return parameter.ceil() as u64;
    }
    // of a machine that does not report its memory, nothing is known but the default
    if most == 0 { DEFAULT_LIMIT } else { DEFAULT_LIMIT.min(most / MIB) }
}

/// This process, as the operating system sees it.
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

    /// A quarter of the machine's memory (bytes), or nearly all of the container's that the process runs in, whichever is less.
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

/// The components of the node whose memory is known.
pub struct Components {
    pub scene: CurrentScene,
    pub tape: RecorderHandle,
}

impl Components {
    fn has_robot(&self) -> bool {
        self.scene.lock().unwrap_or_else(PoisonError::into_inner).is_some()
    }

    fn usage(&self, used: u64) -> Usage {
        let scene = self.scene.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let hierarchies = scene.map_or(0, |scene| scene.revision.checker.hierarchy_size().0);
        let model_and_world = u64::try_from(hierarchies).unwrap_or(u64::MAX);
        let recording = u64::try_from(self.tape.waiting_bytes()).unwrap_or(u64::MAX);
        let rest = used.saturating_sub(model_and_world).saturating_sub(recording);
        Usage { model_and_world, recording, rest }
    }
}

/// Bytes by component.
#[derive(Clone, Copy, Debug, Default)]
struct Usage {
    model_and_world: u64,
    recording: u64,
    rest: u64,
}

impl Usage {
    /// Which component grew most, and by how much each did.
    fn growth_since(&self, before: &Self) -> String {
        let grown = |now: u64, then: u64| now.saturating_sub(then) / MIB;
        let mut growth = [
            ("robot model and world", grown(self.model_and_world, before.model_and_world)),
            ("recording queue", grown(self.recording, before.recording)),
            ("network library and messages that wait", grown(self.rest, before.rest)),
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
        let before = Usage { model_and_world: 900 * MIB, recording: 0, rest: 100 * MIB };
        let now = Usage { model_and_world: 910 * MIB, recording: MIB, rest: 700 * MIB };
        assert_eq!(
            now.growth_since(&before),
            "grown since the robot was loaded: network library and messages that wait by 600 MiB, \
             robot model and world by 10 MiB, recording queue by 1 MiB"
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
