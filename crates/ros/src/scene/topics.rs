//! Subscriptions of the world topics. Messages become orders of the loader; transforms are stored in the tree directly.

use std::cell::Cell;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use clearance_monitor::{JointStateHistory, Now, Time};
use clearance_scene::{AnchorFrames, OCTOMAP, Transform, TransformTree};
use futures_lite::{FutureExt, future};
use ros2_interfaces_jazzy_serde::moveit_msgs::msg::{
    AttachedCollisionObject, CollisionObject, PlanningScene, PlanningSceneWorld,
};
use ros2_interfaces_jazzy_serde::octomap_msgs::msg::Octomap;
use ros2_interfaces_jazzy_serde::sensor_msgs::msg::PointCloud2;
use ros2_interfaces_jazzy_serde::tf2_msgs::msg::TFMessage;
use smol::channel::{self, Receiver, Sender};

use super::clouds::{CloudMessage, CloudMessages};
use super::orders::{
    attached_order, object_order, octomap_order, scene_order, unreadable_order, world_order,
};
use super::reading::transform_pose;
use super::scene_request::SceneRequester;
use crate::clock::RosClock;
use crate::mailbox;
use crate::messages::time_of;
use crate::middleware::{
    DecodeErrorLog, MessageKind, Middleware, MiddlewareError, Origin, Quality, Subscription,
};
use crate::monitor_loop::{Event, WorldUpdate};
use crate::names::Names;
use crate::order::Order;
use crate::parameter_services::ParameterStore;
use crate::recording::{OrderStep, OriginalMessage, RecordedEvent, RecorderHandle, SceneDoor};
use crate::scene_keeper::CurrentScene;
use crate::scene_order::SceneOrder;
use crate::sequence_gaps::SequenceGaps;

/// Transforms from tf, shared between the subscriptions and their users.
pub type Transforms = Arc<Mutex<TransformTree>>;

/// The two octomap topics.
const OCTOMAP_DOORS: [SceneDoor; 2] = [SceneDoor::OctomapBinary, SceneDoor::OctomapFull];

/// All subscriptions about the world.
pub struct SceneTopics {
    pub(super) middleware: Middleware,
    pub(super) names: Names,
    scenes: Subscription<PlanningScene>,
    worlds: Subscription<PlanningSceneWorld>,
    objects: Subscription<CollisionObject>,
    attached: Subscription<AttachedCollisionObject>,
    /// Each octomap topic has two subscriptions, one for each kind of publisher.
    octomaps: [[Subscription<Octomap>; 2]; 2],
    tf: Subscription<TFMessage>,
    tf_static: Subscription<TFMessage>,
    pub shared: Shared,
    orders: Sender<Order>,
    events: mailbox::Sender<Event>,
    /// Receives a notice when a parameter changed.
    changes: Receiver<()>,
    /// Number of messages about objects, and whether some were lost since the last query.
    changes_heard: Cell<u64>,
    is_lost: Cell<bool>,
}

/// Data shared with the loader.
#[derive(Clone)]
pub struct Shared {
    pub scene: CurrentScene,
    pub transforms: Transforms,
    /// The frames in which the loader places obstacles.
    pub grounds: Arc<Mutex<AnchorFrames>>,
    pub clouds: Arc<CloudMessages>,
    /// History of joint states. Lock order: a holder of both this and the evaluation takes the evaluation first.
    pub joint_state_history: Arc<Mutex<JointStateHistory>>,
    pub store: ParameterStore,
    pub clock: Arc<RosClock>,
    pub tape: RecorderHandle,
}

impl Shared {
    #[must_use]
    pub fn new(
        scene: CurrentScene,
        store: ParameterStore,
        clock: Arc<RosClock>,
        tape: RecorderHandle,
    ) -> Self {
        Self {
            scene,
            transforms: Transforms::default(),
            grounds: Arc::default(),
            clouds: Arc::default(),
            joint_state_history: Arc::default(),
            store,
            clock,
            tape,
        }
    }
}

/// Detects duplicates on a topic with two subscriptions, which must not count twice.
#[derive(Default)]
struct Twins {
    last: Option<(usize, Octomap, Instant)>,
}

impl SceneTopics {
    pub fn open(
        middleware: &Middleware,
        names: &Names,
        shared: Shared,
        (orders, events): (Sender<Order>, mailbox::Sender<Event>),
        changes: Receiver<()>,
    ) -> Result<Self, MiddlewareError> {
        let moveit = |kind| MessageKind("moveit_msgs", kind);
        let octomap = |name: &str| -> Result<_, MiddlewareError> {
            let (name, kind) = (names.resolve(name)?, MessageKind("octomap_msgs", "Octomap"));
            Ok([
                middleware.subscription(&name, kind, Quality::ReliableBulk)?,
                middleware.subscription(&name, kind, Quality::LatchedBulk)?,
            ])
        };
        let tf = MessageKind("tf2_msgs", "TFMessage");
        let reliable = Quality::Reliable;
        Ok(Self {
            scenes: middleware.subscription(
                &names.resolve("planning_scene")?,
                moveit("PlanningScene"),
                reliable,
            )?,
            worlds: middleware.subscription(
                &names.resolve("planning_scene_world")?,
                moveit("PlanningSceneWorld"),
                reliable,
            )?,
            objects: middleware.subscription(
                &names.resolve("collision_object")?,
                moveit("CollisionObject"),
                reliable,
            )?,
            attached: middleware.subscription(
                &names.resolve("attached_collision_object")?,
                moveit("AttachedCollisionObject"),
                reliable,
            )?,
            octomaps: [octomap("octomap_binary")?, octomap("octomap_full")?],
            tf: middleware.subscription(&names.resolve("tf")?, tf, Quality::BestEffort)?,
            tf_static: middleware.subscription(&names.resolve("tf_static")?, tf, Quality::Kept)?,
            middleware: middleware.clone(),
            names: names.clone(),
            shared,
            orders,
            events,
            changes,
            changes_heard: Cell::default(),
            is_lost: Cell::default(),
        })
    }

    /// Receives messages. Never returns.
    pub async fn listen(&self) {
        let twins: [Mutex<Twins>; 2] = Default::default();
        let after = |order: SceneOrder, lost: u64| {
            if lost > 0 {
                self.is_lost.set(true);
                self.changes_heard.set(self.changes_heard.get() + 1);
            }
            Some(order.after(lost))
        };
        let objects =
            self.receive(SceneDoor::CollisionObject, &self.objects, |m, lost| after(self.object(m), lost));
        let attached = self.receive(SceneDoor::AttachedCollisionObject, &self.attached, |m, lost| {
            after(self.attached(m), lost)
        });
        let worlds = self.receive(SceneDoor::PlanningSceneWorld, &self.worlds, |m, _| Some(self.world(m)));
        let scenes = self.receive(SceneDoor::PlanningScene, &self.scenes, |m, lost| {
            after(self.scene(SceneDoor::PlanningScene, m), lost)
        });
        let octomap = |topic: usize, twin: usize| {
            let last = &twins[topic];
            self.receive(OCTOMAP_DOORS[topic], &self.octomaps[topic][twin], move |m, _| {
                let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
                last.is_new(twin, &m).then(|| self.octomap(topic, m))
            })
        };
        let scenes = future::zip(future::zip(objects, attached), future::zip(worlds, scenes));
        let octomaps =
            future::zip(future::zip(octomap(0, 0), octomap(0, 1)), future::zip(octomap(1, 0), octomap(1, 1)));
        let transforms = future::zip(self.follow(&self.tf, false), self.follow(&self.tf_static, true));
        let others = future::zip(self.watch(), SceneRequester::default().go_on(self));
        future::zip(future::zip(scenes, octomaps), future::zip(transforms, others)).await;
    }

    /// Converts messages to orders. `read` receives the number of messages that were lost right before each.
    async fn receive<M: crate::middleware::Message + 'static>(
        &self,
        by: SceneDoor,
        topic: &Subscription<M>,
        read: impl Fn(M, u64) -> Option<SceneOrder>,
    ) {
        let mut arrivals = SequenceGaps::default();
        loop {
            let Ok((message, Origin { publisher, number, received })) = topic.next_or_unreadable().await
            else {
                self.note_update(Instant::now());
                if self.orders.send(Order::Scene(Box::new(self.unreadable(by)))).await.is_err() {
                    return;
                }
                continue;
            };
            if self.middleware.is_own(publisher) {
                // this node's own scene, if both topics have the same name
                continue;
            }
            let lost = number.map_or(0, |number| arrivals.missing_before(publisher, number));
            self.note_update(received);
            let Some(order) = read(message, lost) else {
                self.tell(WorldUpdate::Withdrawn);
                continue;
            };
            if self.orders.send(Order::Scene(Box::new(order))).await.is_err() {
                return;
            }
        }
    }

    /// Reports the reception of a message about the world to the monitor, before the message is read, since reading takes long as
    /// well. One order to the loader has to follow.
    pub(super) fn note_update(&self, received: Instant) {
        let at = self.shared.clock.steady().saturating_sub(received.elapsed());
        self.tell(WorldUpdate::Received { steady: u64::try_from(at.as_nanos()).unwrap_or(u64::MAX) });
    }

    fn tell(&self, update: WorldUpdate) {
        // a monitor that has ended publishes nothing
        let _ = self.events.send(Event::WorldUpdate(update));
    }

    /// Whether a robot model is loaded, which a scene requires.
    pub(super) fn has_robot(&self) -> bool {
        self.shared.scene.lock().unwrap_or_else(PoisonError::into_inner).is_some()
    }

    /// Number of messages about objects.
    pub(super) fn changes_heard(&self) -> u64 {
        self.changes_heard.get()
    }

    /// Whether messages about objects were lost since the last call.
    pub(super) fn take_lost(&self) -> bool {
        self.is_lost.take()
    }

    /// Sends an order that the monitor was notified of, and waits until it is in force. Returns whether all of it was applied.
    pub(super) async fn have_done(&self, order: SceneOrder) -> bool {
        let (done, is_done) = channel::bounded(1);
        let order = Order::Scene(Box::new(order.answered_on(done)));
        // a loader that has ended processes no order
        self.orders.send(order).await.is_ok() && is_done.recv().await.unwrap_or(false)
    }

    /// Order for a message, together with the message itself if a recorder runs.
    fn order<M: Clone>(
        &self,
        by: SceneDoor,
        message: M,
        keep: impl FnOnce(M) -> OriginalMessage,
        read: impl FnOnce(M, bool, Now) -> SceneOrder,
    ) -> SceneOrder {
        let Shared { store, clock, tape, .. } = &self.shared;
        let (came, unknown_is_occupied) = (clock.read(), store.get().unknown_is_occupied());
        let original = tape.is_on().then(|| {
            let step = OrderStep::Scene { by, came: came.into(), unknown_is_occupied, lost: 0 };
            (step, Some(keep(message.clone())))
        });
        let order = read(message, unknown_is_occupied, came).made_of(original);
        if by != SceneDoor::GetPlanningScene && order.tells_of_objects() {
            self.changes_heard.set(self.changes_heard.get() + 1);
        }
        order
    }

    /// Order for a message that could not be decoded. The scene of `move_group` is requested again.
    fn unreadable(&self, by: SceneDoor) -> SceneOrder {
        self.is_lost.set(true);
        self.changes_heard.set(self.changes_heard.get() + 1);
        let is_recorded = self.shared.tape.is_on();
        unreadable_order(by).made_of(is_recorded.then_some((OrderStep::Unreadable { by }, None)))
    }

    fn object(&self, message: CollisionObject) -> SceneOrder {
        let keep = |m| OriginalMessage::Object(Box::new(m));
        self.order(SceneDoor::CollisionObject, message, keep, |m, _, _| object_order(&m))
    }

    fn attached(&self, message: AttachedCollisionObject) -> SceneOrder {
        let keep = |m| OriginalMessage::Attached(Box::new(m));
        self.order(SceneDoor::AttachedCollisionObject, message, keep, |m, _, _| attached_order(&m))
    }

    fn world(&self, message: PlanningSceneWorld) -> SceneOrder {
        self.order(
            SceneDoor::PlanningSceneWorld,
            message,
            |m| OriginalMessage::World(Box::new(m)),
            world_order,
        )
    }

    /// Order to apply a whole or partial scene.
    pub fn scene(&self, by: SceneDoor, message: PlanningScene) -> SceneOrder {
        let read = |m, unknown_is_occupied, came| scene_order(by, m, unknown_is_occupied, came);
        self.order(by, message, |m| OriginalMessage::Scene(Box::new(m)), read)
    }

    fn octomap(&self, topic: usize, message: Octomap) -> SceneOrder {
        let by = OCTOMAP_DOORS[topic];
        let read = |m, unknown_is_occupied, came| octomap_order(by, m, unknown_is_occupied, came);
        self.order(by, message, |m| OriginalMessage::Octomap(Box::new(m)), read)
    }

    async fn follow(&self, topic: &Subscription<TFMessage>, fixed: bool) {
        let complaints = DecodeErrorLog::default();
        loop {
            let (message, _) = topic.next().await;
            let (fault, is_elsewhere) = self.heed(message, fixed);
            if let Some(fault) = fault {
                complaints.warn(|| fault);
            }
            if is_elsewhere && self.orders.send(Order::Frames).await.is_err() {
                return;
            }
        }
    }

    /// Stores transforms. Returns what is wrong with them, and whether obstacles have to be moved now.
    fn heed(&self, message: TFMessage, fixed: bool) -> (Option<String>, bool) {
        let Shared { transforms, grounds, clock, tape, .. } = &self.shared;
        let now = clock.now();
        let mut tree = transforms.lock().unwrap_or_else(PoisonError::into_inner);
        // the recording has to contain it before any result that depends on this tree
        tape.note(|| RecordedEvent::Transforms { message: message.clone(), now, fixed });
        let fault = note_transforms(&mut tree, message, now, fixed);
        (fault, grounds.lock().unwrap_or_else(PoisonError::into_inner).are_elsewhere(&tree))
    }

    /// Subscribes to the clouds that the parameters name. Never returns.
    async fn watch(&self) {
        let mut watched: HashMap<String, Subscription<PointCloud2>> = HashMap::new();
        loop {
            let topics = self.shared.store.get().point_cloud_topics;
            watched.retain(|topic, _| topics.contains(topic));
            for topic in
                topics.iter().filter(|topic| !watched.contains_key(*topic)).cloned().collect::<Vec<_>>()
            {
                match self.subscribe(&topic) {
                    Ok(subscription) => drop(watched.insert(topic, subscription)),
                    Err(error) => log::error!("point_cloud_topics: {error}"),
                }
            }
            let change = async {
                if self.changes.recv().await.is_err() {
                    future::pending::<()>().await;
                }
            };
            let clouds = watched.iter().map(|(topic, clouds)| self.clouds(topic, clouds).boxed_local());
            let clouds =
                clouds.fold(future::pending().boxed_local(), |all, one| future::or(all, one).boxed_local());
            future::or(change, clouds).await;
        }
    }

    fn subscribe(&self, topic: &str) -> Result<Subscription<PointCloud2>, MiddlewareError> {
        let kind = MessageKind("sensor_msgs", "PointCloud2");
        self.middleware.subscription(&self.names.resolve(topic)?, kind, Quality::Bulk)
    }

    async fn clouds(&self, topic: &str, clouds: &Subscription<PointCloud2>) {
        loop {
            let (cloud, origin) = clouds.next().await;
            let (came, since) = (self.shared.clock.read(), origin.received);
            let message = CloudMessage { cloud: Arc::new(cloud), came, since };
            self.shared.clouds.put(topic, message);
            if self.orders.send(Order::Clouds).await.is_err() {
                return;
            }
        }
    }
}

/// Stores transforms received at `now` in the tree, and returns what is wrong with them; `fixed` transforms never expire.
pub fn note_transforms(
    tree: &mut TransformTree,
    message: TFMessage,
    now: Option<Time>,
    fixed: bool,
) -> Option<String> {
    let (mut wrong, mut too_many) = (None, false);
    for transform in message.transforms {
        let stamp = match time_of(&transform.header.stamp) {
            Time::ZERO => now.unwrap_or_default(),
            stamp => stamp,
        };
        let pose_pf = match transform_pose(&transform.transform) {
            Ok(pose_pf) => pose_pf,
            Err(why) => {
                wrong = Some((transform.child_frame_id, why));
                continue;
            }
        };
        let parent = transform.header.frame_id;
        let stamp = (!fixed).then_some(stamp);
        too_many |= !tree.insert(&transform.child_frame_id, Transform { parent, pose_pf, stamp });
    }
    match wrong {
        Some((frame, why)) => {
            Some(format!("tf: the transform of '{}' is no pose: {why}", frame.escape_debug()))
        }
        None => too_many.then(|| "tf: there are too many frames; the rest is not heeded".to_owned()),
    }
}

impl Twins {
    /// Whether a message is not the other subscription's copy of the previous one.
    fn is_new(&mut self, way: usize, message: &Octomap) -> bool {
        const SOON: Duration = Duration::from_secs(2);
        let is_copy = (self.last.take())
            .is_some_and(|(other, before, at)| other != way && at.elapsed() < SOON && before == *message);
        if !is_copy {
            self.last = Some((way, message.clone(), Instant::now()));
        }
        !is_copy
    }
}

/// Name of the octomap as a world source.
pub const OCTOMAP_SOURCE: &str = OCTOMAP;
