//! What the parts of the node tell the recorder: they never wait for it.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};

use clearance_monitor::{Evaluation, LeftOut, Now, SourceId, Time};
use clearance_robot::{MeshLog, MeshUse};
use ros2_interfaces_jazzy_serde::geometry_msgs::msg::TransformStamped;
use ros2_interfaces_jazzy_serde::moveit_msgs::msg::{
    AttachedCollisionObject, CollisionObject, PlanningScene, PlanningSceneWorld,
};
use ros2_interfaces_jazzy_serde::octomap_msgs::msg::Octomap;
use ros2_interfaces_jazzy_serde::rosgraph_msgs::msg::Clock;
use ros2_interfaces_jazzy_serde::sensor_msgs::msg::{JointState, PointCloud2};
use ros2_interfaces_jazzy_serde::tf2_msgs::msg::TFMessage;

use super::step::{OrderStep, RecordedMonitorEvent};
use crate::clearance_msgs::{BodyPair, CollisionState};
use crate::mailbox::{Refused, Sender};
use crate::messages::collision_state;
use crate::parameters::Parameters;

/// Bytes that wait to be written at most.
const LONGEST_QUEUE: usize = 256 << 20;

/// What the command line gave a node, for those who run it again.
#[derive(Clone, Debug, Default)]
pub struct Given {
    /// Known to the command line alone.
    pub arguments: serde_json::Value,
    /// Files that the arguments name.
    pub files: Vec<PathBuf>,
    /// Where the meshes came from.
    pub meshes: MeshLog,
}

/// A message as it came.
#[derive(Clone, Debug)]
pub enum OriginalMessage {
    Text(String),
    Scene(Box<PlanningScene>),
    World(Box<PlanningSceneWorld>),
    Object(Box<CollisionObject>),
    Attached(Box<AttachedCollisionObject>),
    Octomap(Box<Octomap>),
}

/// One thing that changed what is known or said.
#[derive(Debug)]
pub enum RecordedEvent {
    Meshes(Vec<MeshUse>),
    Pass {
        now: Now,
        parameters: Box<Parameters>,
        orders: Vec<(OrderStep, Option<OriginalMessage>)>,
        clouds: Vec<(String, Now, Arc<PointCloud2>)>,
    },
    Told(RecordedMonitorEvent),
    Parameters(Box<Parameters>),
    Enabled(bool),
    /// The monitor looked at the transforms.
    Looked,
    /// A joint state was heard, and not judged by itself.
    Heard {
        now: Now,
        message: Box<JointState>,
        source: SourceId,
    },
    Judged(Box<Judged>),
    Transforms {
        message: TFMessage,
        now: Option<Time>,
        fixed: bool,
    },
    Clock(Clock),
}

/// A evaluation as it is said, and what it was made from: a joint state, or the time that passed.
#[derive(Debug)]
pub struct Judged {
    pub now: Now,
    pub heard: Option<(JointState, SourceId)>,
    pub answer: RecordedResult,
}

/// What is written of a evaluation. It holds no checker: what waits for a slow disk must not keep robots and worlds of old.
#[derive(Debug)]
pub struct RecordedResult {
    pub state: CollisionState,
    pub is_free: bool,
    pub distance: f64,
    pub speed_scale: f64,
    pub left_out: LeftOut,
}

impl From<&Evaluation> for RecordedResult {
    fn from(evaluation: &Evaluation) -> Self {
        Self {
            state: collision_state(evaluation),
            is_free: evaluation.status.is_free(),
            distance: evaluation.distance(),
            speed_scale: evaluation.speed_scale,
            left_out: evaluation.left_out,
        }
    }
}

/// Something on its way to the recorder.
pub(super) struct Item {
    /// Nanoseconds since 1970 when it happened.
    pub at: u64,
    pub what: RecordedEvent,
    pub bytes: usize,
}

/// Leads to the recorder, if there is one.
#[derive(Clone, Debug, Default)]
pub struct RecorderHandle(Option<Arc<Line>>);

#[derive(Debug)]
struct Line {
    items: Sender<Item>,
    backlog: Arc<Backlog>,
}

/// What waits, and what did not fit.
#[derive(Debug, Default)]
pub(super) struct Backlog {
    pub bytes: AtomicUsize,
    pub lost: AtomicU64,
    /// Nothing that comes later belongs to the recording.
    pub ended: AtomicBool,
    /// Why the file lacks something, or is not where it was, if it is so.
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
    pub(super) fn to(items: Sender<Item>, backlog: Arc<Backlog>) -> Self {
        Self(Some(Arc::new(Line { items, backlog })))
    }

    /// Whether somebody records.
    #[must_use]
    pub fn is_on(&self) -> bool {
        self.0.is_some()
    }

    /// Why the recording can not be written, or not completely, if it is so.
    #[must_use]
    pub fn fault(&self) -> Option<String> {
        self.0.as_ref()?.backlog.fault()
    }

    /// Bytes that wait to be written.
    #[must_use]
    pub fn waiting_bytes(&self) -> usize {
        self.0.as_ref().map_or(0, |line| line.backlog.bytes.load(Ordering::Relaxed))
    }

    /// As if so many steps had not fitted.
    #[cfg(test)]
    pub(super) fn lose(&self, steps: u64) {
        if let Some(line) = &self.0 {
            line.backlog.lost.fetch_add(steps, Ordering::Relaxed);
        }
    }

    /// Tells what happened, if somebody records; never waits. What does not fit is lost and counted.
    pub fn note(&self, what: impl FnOnce() -> RecordedEvent) {
        let Some(line) = &self.0 else { return };
        let what = what();
        let bytes = size(&what);
        let waiting = line.backlog.bytes.fetch_add(bytes, Ordering::Relaxed);
        let sent = waiting <= LONGEST_QUEUE && {
            match line.items.send(Item { at: system_time(), what, bytes }) {
                Ok(()) => true,
                Err(Refused::Full) => false,
                // a recording that has ended misses nothing
                Err(Refused::Unread) => return,
            }
        };
        if !sent {
            line.backlog.bytes.fetch_sub(bytes, Ordering::Relaxed);
            line.backlog.lost.fetch_add(1, Ordering::Relaxed);
        }
    }
}

pub(super) fn system_time() -> u64 {
    let since_epoch = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(since_epoch.as_nanos()).unwrap_or(u64::MAX)
}

/// Bytes that go to a name.
const NAME: usize = 100;

fn of_attached(attached: &[AttachedCollisionObject]) -> usize {
    let of_one = |attached: &AttachedCollisionObject| {
        of_objects(std::slice::from_ref(&attached.object)) + NAME * attached.touch_links.len()
    };
    attached.iter().map(of_one).sum()
}

/// Roughly, the bytes that something takes.
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
        OriginalMessage::Octomap(octomap) => octomap.data.len(),
    };
    ANY + match what {
        RecordedEvent::Pass { orders, clouds, .. } => {
            let clouds: usize = clouds.iter().map(|(_, _, cloud)| cloud.data.len()).sum();
            clouds
                + orders.iter().filter_map(|(_, original)| original.as_ref()).map(of_original).sum::<usize>()
        }
        RecordedEvent::Heard { message, .. } => of_joint_state(message),
        RecordedEvent::Judged(judged) => {
            let heard = judged.heard.as_ref().map_or(0, |(state, _)| of_joint_state(state));
            heard + of_collision_state(&judged.answer.state)
        }
        RecordedEvent::Transforms { message, .. } => {
            let name = |transform: &TransformStamped| {
                transform.child_frame_id.len() + transform.header.frame_id.len()
            };
            message.transforms.iter().map(|transform| 200 + name(transform)).sum()
        }
        RecordedEvent::Meshes(meshes) => ANY * meshes.len(),
        RecordedEvent::Told(RecordedMonitorEvent::ModelFault(fault)) => fault.len(),
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
    use crate::clearance_msgs::PairDistance;
    use crate::mailbox;
    use crate::waiting::wait_at_most;
    use clearance_monitor::{Expiry, Reason, Status};

    fn evaluation() -> Evaluation {
        Evaluation {
            status: Status::Unknown(Reason::NoJointState),
            stamp: None,
            age: None,
            checked_state: None,
            placement: None,
            speed_scale: 0.0,
            left_out: LeftOut::Nothing,
            is_swapping: false,
            stale_world: None,
            revision: None,
            warnings: Arc::from([]),
            expiry: Expiry::default(),
        }
    }

    fn judged(pairs: usize, warning: usize) -> RecordedEvent {
        let mut answer = RecordedResult::from(&evaluation());
        answer.state.pair_distances = vec![PairDistance::default(); pairs];
        answer.state.warnings = vec!["w".repeat(warning)];
        let now = Now { ros: None, steady: std::time::Duration::ZERO };
        RecordedEvent::Judged(Box::new(Judged { now, heard: None, answer }))
    }

    #[test]
    fn an_answer_counts_with_all_that_it_holds() {
        let (bare, full) = (size(&judged(0, 0)), size(&judged(1000, 5000)));
        assert_eq!(full - bare, 1000 * size_of::<PairDistance>() + 5000);
    }

    #[test]
    fn what_waits_has_a_bound_in_bytes() {
        let (items, waiting) = mailbox::bounded(1000);
        let backlog = Arc::new(Backlog::default());
        let tape = RecorderHandle::to(items, Arc::clone(&backlog));
        let large = LONGEST_QUEUE / 4;
        for _ in 0..10 {
            tape.note(|| judged(0, large));
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
