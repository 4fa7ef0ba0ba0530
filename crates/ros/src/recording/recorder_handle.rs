//! Recorder handle: the queue of events to the recorder, for which the node never waits.

use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};

use ros2_interfaces_jazzy_serde::geometry_msgs::msg::TransformStamped;
use ros2_interfaces_jazzy_serde::moveit_msgs::msg::{AttachedCollisionObject, CollisionObject};
use ros2_interfaces_jazzy_serde::sensor_msgs::msg::JointState;

use crate::messages::clearance_msgs::{BodyPair, CollisionState};
use crate::recording::recorded_event::{OriginalMessage, RecordedEvent};
use crate::recording::step::RecordedMonitorEvent;
use crate::threading::mailbox::{SendError, Sender};

/// Largest total size (bytes) of the events in the queue.
const LONGEST_QUEUE: usize = 256 << 20;

/// An event in the queue to the recorder.
pub struct Item {
    /// Time of the event (ns since 1970).
    pub at: u64,
    pub what: RecordedEvent,
    pub bytes: usize,
}

/// Connection to the recorder, if there is one.
#[derive(Clone, Debug, Default)]
pub struct RecorderHandle(Option<Arc<Line>>);

#[derive(Debug)]
struct Line {
    items: Sender<Item>,
    backlog: Arc<Backlog>,
}

/// Counters of the queue: bytes that wait, and events that did not fit.
#[derive(Debug, Default)]
pub struct Backlog {
    pub bytes: AtomicUsize,
    pub lost: AtomicU64,
    /// The recording has ended: later events are not part of it.
    pub ended: AtomicBool,
    /// Why the file is incomplete or was moved, if either is true.
    pub fault: Mutex<Option<String>>,
}

impl Backlog {
    pub fn fault(&self) -> Option<String> {
        self.fault.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    pub fn set_fault(&self, fault: Option<String>) {
        *self.fault.lock().unwrap_or_else(PoisonError::into_inner) = fault;
    }
}

impl RecorderHandle {
    pub fn to(items: Sender<Item>, backlog: Arc<Backlog>) -> Self {
        Self(Some(Arc::new(Line { items, backlog })))
    }

    /// Whether a recorder runs.
    #[must_use]
    pub fn is_on(&self) -> bool {
        self.0.is_some()
    }

    /// Why the recording cannot be written, or not completely, if either is true.
    #[must_use]
    pub fn fault(&self) -> Option<String> {
        self.0.as_ref()?.backlog.fault()
    }

    /// Size of the events in the queue (bytes).
    #[must_use]
    pub fn waiting_bytes(&self) -> usize {
        self.0.as_ref().map_or(0, |line| line.backlog.bytes.load(Ordering::Relaxed))
    }

    /// Counts this number of steps as lost.
    #[cfg(test)]
    pub fn lose(&self, steps: u64) {
        if let Some(line) = &self.0 {
            line.backlog.lost.fetch_add(steps, Ordering::Relaxed);
        }
    }

    /// Records an event, if a recorder runs; never waits. An event that does not fit into the queue is lost and
    /// counted.
    pub fn note(&self, what: impl FnOnce() -> RecordedEvent) {
        let Some(line) = &self.0 else { return };
        let what = what();
        let bytes = size(&what);
        let waiting = line.backlog.bytes.fetch_add(bytes, Ordering::Relaxed);
        let sent = waiting <= LONGEST_QUEUE && {
            match line.items.send(Item { at: system_time(), what, bytes }) {
                Ok(()) => true,
                Err(SendError::Full) => false,
                // after the end of the recording, events are not counted as lost
                Err(SendError::Closed) => return,
            }
        };
        if !sent {
            line.backlog.bytes.fetch_sub(bytes, Ordering::Relaxed);
            line.backlog.lost.fetch_add(1, Ordering::Relaxed);
        }
    }
}

pub fn system_time() -> u64 {
    let since_epoch = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(since_epoch.as_nanos()).unwrap_or(u64::MAX)
}

/// Estimated size (bytes) of a name.
const NAME: usize = 100;

fn of_attached(attached: &[AttachedCollisionObject]) -> usize {
    let of_one = |attached: &AttachedCollisionObject| {
        of_objects(std::slice::from_ref(&attached.object)) + NAME * attached.touch_links.len()
    };
    attached.iter().map(of_one).sum()
}

/// Estimated size (bytes) of an event.
fn size(what: &RecordedEvent) -> usize {
    const ANY: usize = 1000;
    let of_original = |original: &OriginalMessage| match original {
        OriginalMessage::Text(text) => text.len(),
        OriginalMessage::Scene(scene) => {
            let matrix = &scene.allowed_collision_matrix;
            let names = scene.link_padding.len() + scene.link_scale.len() + scene.object_colors.len();
            of_objects(&scene.world.collision_objects)
                + scene.world.octomap.octomap.data.len()
                + of_attached(&scene.robot_state.attached_collision_objects)
                + matrix.entry_values.iter().map(|row| NAME + row.enabled.len()).sum::<usize>()
                + NAME * (names + matrix.default_entry_names.len())
        }
        OriginalMessage::World(world) => {
            of_objects(&world.collision_objects) + world.octomap.octomap.data.len()
        }
        OriginalMessage::Object(object) => of_objects(std::slice::from_ref(object)),
        OriginalMessage::Attached(attached) => of_attached(std::slice::from_ref(attached)),
        OriginalMessage::States(states) => {
            states.obstacles.iter().map(|state| size_of_val(state) + state.name.len()).sum()
        }
        OriginalMessage::Octomap(octomap) => octomap.data.len(),
    };
    ANY + match what {
        RecordedEvent::Pass { commands, clouds, .. } => {
            let clouds: usize = clouds.iter().map(|recorded| recorded.cloud.data.len()).sum();
            clouds
                + commands
                    .iter()
                    .filter_map(|(_, original)| original.as_ref())
                    .map(of_original)
                    .sum::<usize>()
        }
        RecordedEvent::JointStateReceived { message, .. } => of_joint_state(message),
        RecordedEvent::Evaluated(evaluated) => {
            let received = evaluated.joint_state.as_ref().map_or(0, |(state, _)| of_joint_state(state));
            received + of_collision_state(&evaluated.result.state)
        }
        RecordedEvent::Transforms { message, .. } => {
            let name = |transform: &TransformStamped| {
                transform.child_frame_id.len() + transform.header.frame_id.len()
            };
            message.transforms.iter().map(|transform| 200 + name(transform)).sum()
        }
        RecordedEvent::Meshes(meshes) => ANY * meshes.len(),
        RecordedEvent::MonitorEvent(RecordedMonitorEvent::ModelFault(fault)) => fault.len(),
        _ => 0,
    }
}

fn of_texts(texts: &[String]) -> usize {
    texts.iter().map(|text| size_of::<String>() + text.len()).sum()
}

fn of_joint_state(state: &JointState) -> usize {
    let numbers = state.position.len() + state.velocity.len() + state.effort.len();
    of_texts(&state.name) + size_of::<f64>() * numbers
}

fn of_collision_state(state: &CollisionState) -> usize {
    let names = |pair: &BodyPair| pair.body_a.len() + pair.body_b.len();
    let colliding = state.colliding_pairs.iter().map(|pair| size_of_val(pair) + names(pair));
    let distances = state.pair_distances.iter().map(|pair| size_of_val(pair) + names(&pair.pair));
    let skipped = state.skipped.iter().map(|skipped| size_of_val(skipped) + skipped.reason.len());
    state.reason.len() + of_texts(&state.warnings) + colliding.chain(distances).chain(skipped).sum::<usize>()
}

fn of_objects(objects: &[CollisionObject]) -> usize {
    let meshes = objects.iter().flat_map(|object| &object.meshes);
    let meshes: usize = meshes.map(|mesh| 24 * mesh.vertices.len() + 12 * mesh.triangles.len()).sum();
    500 * objects.len() + meshes
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::messages::clearance_msgs::PairDistance;
    use crate::recording::recorded_event::{RecordedEvaluation, RecordedResult};
    use crate::threading::mailbox;
    use crate::threading::timed_wait::wait_at_most;
    use clearance_monitor::{Evaluation, Expiry, LeftOut, Now, Reason, Status};

    fn evaluation() -> Evaluation {
        Evaluation {
            status: Status::Unknown(Reason::NoJointState),
            stamp: None,
            age: None,
            checked_state: None,
            robot_state: None,
            speed_scale: 0.0,
            separation: None,
            left_out: LeftOut::Nothing,
            is_swapping: false,
            stale_world: None,
            motion_since_previous: clearance_monitor::MotionSincePrevious::default(),
            history: clearance_monitor::ContactHistory::default(),
            revision: None,
            warnings: Arc::from([]),
            expiry: Expiry::default(),
        }
    }

    fn evaluated(pairs: usize, warning: usize) -> RecordedEvent {
        let mut result = RecordedResult::from(&evaluation());
        result.state.pair_distances = vec![PairDistance::default(); pairs];
        result.state.warnings = vec!["w".repeat(warning)];
        let now = Now { ros: None, steady: std::time::Duration::ZERO };
        RecordedEvent::Evaluated(Box::new(RecordedEvaluation { now, joint_state: None, result }))
    }

    #[test]
    fn the_size_of_a_result_includes_all_parts() {
        let (bare, full) = (size(&evaluated(0, 0)), size(&evaluated(1000, 5000)));
        assert_eq!(full - bare, 1000 * size_of::<PairDistance>() + 5000);
    }

    #[test]
    fn what_waits_has_a_bound_in_bytes() {
        let (items, waiting) = mailbox::bounded(1000);
        let backlog = Arc::new(Backlog::default());
        let recording = RecorderHandle::to(items, Arc::clone(&backlog));
        let large = LONGEST_QUEUE / 4;
        for _ in 0..10 {
            recording.note(|| evaluated(0, large));
        }
        let mut queued = 0;
        while wait_at_most(Duration::ZERO, waiting.receive()).is_some() {
            queued += 1;
        }
        assert!((4..=5).contains(&queued), "{queued}");
        assert_eq!(backlog.lost.load(Ordering::Relaxed), 10 - queued);
        assert!(backlog.bytes.load(Ordering::Relaxed) <= LONGEST_QUEUE + large + 2000);
    }
}
