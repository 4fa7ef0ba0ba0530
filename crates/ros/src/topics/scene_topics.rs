//! Subscriptions of the world topics. Messages become commands of the loader; transforms are stored in the tree
//! directly.

use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;
use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant};

use futures_lite::{FutureExt, future};
use ros2_interfaces_jazzy_serde::moveit_msgs::msg::{
    AttachedCollisionObject, CollisionObject, PlanningScene, PlanningSceneWorld,
};
use ros2_interfaces_jazzy_serde::octomap_msgs::msg::Octomap;
use ros2_interfaces_jazzy_serde::sensor_msgs::msg::PointCloud2;
use ros2_interfaces_jazzy_serde::tf2_msgs::msg::TFMessage;
use smol::channel::Receiver;

use crate::dds::Message;
use crate::dds::decode_error_log::DecodeErrorLog;
use crate::dds::middleware::Middleware;
use crate::dds::middleware_error::MiddlewareError;
use crate::dds::quality::Quality;
use crate::dds::sequence_gaps::SequenceGaps;
use crate::dds::subscription::{Origin, Subscription, Undecodable, system_time};
use crate::dds::type_name::TypeName;
use crate::messages::clearance_msgs::ObstacleStates;
use crate::names::Names;
use crate::recording::recorded_event::RecordedEvent;
use crate::recording::step::SceneSource;
use crate::scene::cloud_inbox::CloudMessage;
use crate::scene::loader_command::LoaderCommand;
use crate::scene::scene_command::SceneCommand;
use crate::scene::scene_command_sender::SceneCommandSender;
use crate::scene::shared_state::SharedState;
use crate::scene::transform_messages::note_transforms;
use crate::topics::scene_requester::{RequestContext, SceneRequester};
use crate::topics::shared_topic::SharedTopic;
use crate::topics::topic_merger::{Arrival, MergedTopic, Next, TopicMerger};
use crate::topics::unreceivable_publishers;

/// The two octomap topics.
const OCTOMAP_SOURCES: [SceneSource; 2] = [SceneSource::OctomapBinary, SceneSource::OctomapFull];

/// All subscriptions about the world.
pub struct SceneTopics {
    middleware: Middleware,
    names: Names,
    scenes: Subscription<PlanningScene>,
    worlds: Subscription<PlanningSceneWorld>,
    objects: Subscription<CollisionObject>,
    attached: Subscription<AttachedCollisionObject>,
    states: Subscription<ObstacleStates>,
    /// Each octomap topic has two subscriptions, one for each kind of publisher.
    octomaps: [[Subscription<Octomap>; 2]; 2],
    tf: Subscription<TFMessage>,
    tf_static: Subscription<TFMessage>,
    pub sender: SceneCommandSender,
    /// Receives a notice when a parameter changed.
    changes: Receiver<()>,
}

/// Subscription to the point clouds of a topic.
struct CloudSubscription {
    clouds: Subscription<PointCloud2>,
    /// When it was created.
    since: Instant,
    /// Its last publishers.
    publishers: RefCell<SharedTopic>,
}

/// Reports the reception of a message to the monitor, and converts it to a command, unless it is a duplicate.
type Conversion<'t> = Box<dyn FnOnce() -> Option<SceneCommand> + 't>;

/// A topic whose messages change the scene.
struct SceneTopic<'t, M, F> {
    topics: &'t SceneTopics,
    by: SceneSource,
    subscription: &'t Subscription<M>,
    sequence_gaps: RefCell<SequenceGaps>,
    /// Converts a message, with its origin and the number of messages that were lost right before it.
    read: Rc<F>,
}

/// An octomap topic with two subscriptions, which receive the same messages.
#[derive(Default)]
struct OctomapTopic {
    detector: DuplicateDetector,
    publishers: SharedTopic,
}

/// Detects duplicates on a topic with two subscriptions, which must not count twice.
#[derive(Default)]
struct DuplicateDetector {
    last: Option<(usize, Octomap, Instant)>,
}

impl SceneTopics {
    pub fn open(
        middleware: &Middleware,
        names: &Names,
        sender: SceneCommandSender,
        changes: Receiver<()>,
    ) -> Result<Self, MiddlewareError> {
        let moveit = |kind| TypeName::new("moveit_msgs", kind);
        let octomap = |name: &str| -> Result<_, MiddlewareError> {
            let (name, kind) = (names.resolve(name)?, TypeName::new("octomap_msgs", "Octomap"));
            Ok([
                middleware.subscription(&name, kind, Quality::ReliableBulk)?,
                middleware.subscription(&name, kind, Quality::LatchedBulk)?,
            ])
        };
        let tf = TypeName::new("tf2_msgs", "TFMessage");
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
            // a state that is lost is replaced by the next one
            states: middleware.subscription(
                &names.resolve("~/obstacle_states")?,
                TypeName::new("clearance_msgs", "ObstacleStates"),
                Quality::BestEffort,
            )?,
            octomaps: [octomap("octomap_binary")?, octomap("octomap_full")?],
            tf: middleware.subscription(&names.resolve("tf")?, tf, Quality::BestEffort)?,
            tf_static: middleware.subscription(&names.resolve("tf_static")?, tf, Quality::Kept)?,
            middleware: middleware.clone(),
            names: names.clone(),
            sender,
            changes,
        })
    }

    /// Receives messages. Never returns.
    pub async fn receive(&self) {
        let transforms = future::zip(
            self.receive_transforms(&self.tf, false),
            self.receive_transforms(&self.tf_static, true),
        );
        let requests =
            RequestContext { middleware: &self.middleware, names: &self.names, sender: &self.sender };
        let checks =
            future::zip(SceneRequester::default().run(requests), unreceivable_publishers::report(requests));
        let others = future::zip(self.receive_clouds(), checks);
        future::zip(self.receive_scenes(), future::zip(transforms, others)).await;
    }

    /// Sends the messages of all scene topics to the loader, in the order of their reception.
    async fn receive_scenes(&self) {
        let octomap_topics: [RefCell<OctomapTopic>; 2] = Default::default();
        let mut topics = TopicMerger::new(self.scene_topics(&octomap_topics));
        loop {
            for convert in topics.next().await {
                let Some(command) = convert() else {
                    self.sender.note_update_withdrawn();
                    continue;
                };
                if !self.sender.send(LoaderCommand::Scene(Box::new(command))).await {
                    return;
                }
            }
        }
    }

    /// All topics whose messages change the scene.
    fn scene_topics<'t>(
        &'t self,
        octomap_topics: &'t [RefCell<OctomapTopic>; 2],
    ) -> Vec<Box<dyn MergedTopic<Conversion<'t>> + 't>> {
        let sender = &self.sender;
        let mut topics: Vec<Box<dyn MergedTopic<Conversion<'t>> + 't>> = vec![
            self.scene_topic(SceneSource::CollisionObject, &self.objects, |m, _, lost| {
                Some(sender.after(sender.object(m), lost))
            }),
            self.scene_topic(SceneSource::AttachedCollisionObject, &self.attached, |m, _, lost| {
                Some(sender.after(sender.attached(m), lost))
            }),
            self.scene_topic(SceneSource::ObstacleStates, &self.states, |m, _, _| Some(sender.states(m))),
            self.scene_topic(SceneSource::PlanningSceneWorld, &self.worlds, |m, _, _| Some(sender.world(m))),
            self.scene_topic(SceneSource::PlanningScene, &self.scenes, |m, _, lost| {
                Some(sender.after(sender.scene(SceneSource::PlanningScene, m), lost))
            }),
        ];
        for (number, topic) in octomap_topics.iter().enumerate() {
            for subscription in 0..2 {
                let octomaps = &self.octomaps[number][subscription];
                topics.push(self.scene_topic(OCTOMAP_SOURCES[number], octomaps, move |m, origin, _| {
                    let is_shared = topic.borrow_mut().note(subscription, &m, origin)?;
                    Some(sender.octomap(OCTOMAP_SOURCES[number], m).of_shared_topic(is_shared))
                }));
            }
        }
        topics
    }

    fn scene_topic<'t, M: Message + 'static>(
        &'t self,
        by: SceneSource,
        subscription: &'t Subscription<M>,
        read: impl Fn(M, &Origin, u64) -> Option<SceneCommand> + 't,
    ) -> Box<dyn MergedTopic<Conversion<'t>> + 't> {
        let sequence_gaps = RefCell::default();
        Box::new(SceneTopic { topics: self, by, subscription, sequence_gaps, read: Rc::new(read) })
    }

    async fn receive_transforms(&self, topic: &Subscription<TFMessage>, fixed: bool) {
        let decode_errors = DecodeErrorLog::default();
        loop {
            let (message, _) = topic.next().await;
            let (fault, is_elsewhere) = self.store_transforms(message, fixed);
            if let Some(fault) = fault {
                decode_errors.warn(|| fault);
            }
            if is_elsewhere && !self.sender.send(LoaderCommand::Frames).await {
                return;
            }
        }
    }

    /// Stores transforms. Returns what is wrong with them, and whether obstacles have to be moved now.
    fn store_transforms(&self, message: TFMessage, fixed: bool) -> (Option<String>, bool) {
        let SharedState { transforms, anchor_frames, clock, recording, .. } = &self.sender.shared;
        let now = clock.now();
        let mut tree = transforms.lock().unwrap_or_else(PoisonError::into_inner);
        // the recording has to contain it before any result that depends on this tree
        recording.note(|| RecordedEvent::Transforms { message: message.clone(), now, fixed });
        let fault = note_transforms(&mut tree, message, now, fixed);
        (fault, anchor_frames.lock().unwrap_or_else(PoisonError::into_inner).are_elsewhere(&tree))
    }

    /// Subscribes to the clouds that the parameters name. Never returns.
    async fn receive_clouds(&self) {
        let mut watched: HashMap<String, CloudSubscription> = HashMap::new();
        loop {
            let topics = self.sender.shared.store.get().point_cloud_topics;
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
            let clouds = watched
                .iter()
                .map(|(topic, subscription)| self.receive_cloud_topic(topic, subscription).boxed_local());
            let clouds =
                clouds.fold(future::pending().boxed_local(), |all, one| future::or(all, one).boxed_local());
            future::or(change, clouds).await;
        }
    }

    fn subscribe(&self, topic: &str) -> Result<CloudSubscription, MiddlewareError> {
        let kind = TypeName::new("sensor_msgs", "PointCloud2");
        let since = Instant::now();
        let clouds = self.middleware.subscription(&self.names.resolve(topic)?, kind, Quality::Bulk)?;
        Ok(CloudSubscription { clouds, since, publishers: RefCell::default() })
    }

    async fn receive_cloud_topic(&self, topic: &str, subscription: &CloudSubscription) {
        loop {
            let (cloud, origin) = subscription.clouds.next().await;
            if origin.received < subscription.since {
                // the network library keeps it for a topic that was watched before
                continue;
            }
            let is_shared = subscription.publishers.borrow_mut().note(origin.publisher, origin.received);
            let (received_at, since) = (self.sender.shared.clock.read(), origin.received);
            let message = CloudMessage { cloud: Arc::new(cloud), received_at, since, is_shared };
            if !self.sender.shared.clouds.put(topic, message) {
                log::debug!("a cloud of '{topic}' is older than the one before it, and is dropped");
            }
            if !self.sender.send(LoaderCommand::Clouds).await {
                return;
            }
        }
    }
}

impl<'t, M, F> SceneTopic<'t, M, F>
where
    M: Message + 'static,
    F: Fn(M, &Origin, u64) -> Option<SceneCommand> + 't,
{
    /// The message with its time of reception; `None` if it is this node's own.
    fn arrival(&self, taken: Result<(M, Origin), Undecodable>) -> Option<Arrival<Conversion<'t>>> {
        let (by, sender) = (self.by, &self.topics.sender);
        let Ok((message, origin)) = taken else {
            let received = Instant::now();
            let item: Conversion = Box::new(move || {
                sender.note_update(received);
                Some(sender.undecodable(by))
            });
            return Some(Arrival { received: system_time(), item });
        };
        let Origin { publisher, number, received, arrival } = origin;
        if self.topics.middleware.is_own(publisher) {
            // this node's own scene, if both topics have the same name
            return None;
        }
        let missing = |number| self.sequence_gaps.borrow_mut().missing_before(publisher, number);
        let lost = number.map_or(0, missing);
        let read = Rc::clone(&self.read);
        let convert = move || {
            sender.note_update(received);
            read(message, &origin, lost)
        };
        Some(Arrival { received: arrival, item: Box::new(convert) })
    }
}

impl<'t, M, F> MergedTopic<Conversion<'t>> for SceneTopic<'t, M, F>
where
    M: Message + 'static,
    F: Fn(M, &Origin, u64) -> Option<SceneCommand> + 't,
{
    fn next(&self) -> Next<'_, Conversion<'t>> {
        Box::pin(async {
            loop {
                if let Some(arrival) = self.arrival(self.subscription.next_or_undecodable().await) {
                    return arrival;
                }
            }
        })
    }

    fn try_next(&self) -> Option<Arrival<Conversion<'t>>> {
        loop {
            if let Some(arrival) = self.arrival(self.subscription.try_next_or_undecodable()?) {
                return Some(arrival);
            }
        }
    }
}

impl OctomapTopic {
    /// Whether several publishers send on the topic; `None` for the other subscription's copy of the last message.
    fn note(&mut self, subscription: usize, message: &Octomap, origin: &Origin) -> Option<bool> {
        let is_new = self.detector.is_new(subscription, message);
        is_new.then(|| self.publishers.note(origin.publisher, origin.received))
    }
}

impl DuplicateDetector {
    /// Whether a message is not the other subscription's copy of the previous one.
    fn is_new(&mut self, subscription: usize, message: &Octomap) -> bool {
        const SOON: Duration = Duration::from_secs(2);
        let is_copy = (self.last.take()).is_some_and(|(other, before, at)| {
            other != subscription && at.elapsed() < SOON && before == *message
        });
        if !is_copy {
            self.last = Some((subscription, message.clone(), Instant::now()));
        }
        !is_copy
    }
}
