//! Receives the topics that the doctor evaluates.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::time::Duration;

use clearance_monitor::{Now, SourceId, Time};
use clearance_scene::TransformTree;
use futures_lite::future;
use log::Level;
use ros2_interfaces_jazzy_serde::rosgraph_msgs::msg::Clock;
use ros2_interfaces_jazzy_serde::sensor_msgs::msg::JointState;
use ros2_interfaces_jazzy_serde::std_msgs::msg::String as StringMessage;
use ros2_interfaces_jazzy_serde::tf2_msgs::msg::TFMessage;
use smol::Timer;

use super::topic_checks::note_age;
use super::unread_topics;
use crate::clock::RosClock;
use crate::dds::announcement::Announcement;
use crate::dds::log_line::LogLine;
use crate::dds::middleware::Middleware;
use crate::dds::quality::Quality;
use crate::dds::subscription::Subscription;
use crate::dds::type_name::TypeName;
use crate::environment::Environment;
use crate::logging;
use crate::messages::time_and_geometry::time_of;
use crate::names::{NODE_NAME, Names};
use crate::node_error::NodeError;
use crate::parameters::parameter_set::Parameters;
use crate::scene::transform_messages::note_transforms;
use crate::threading::mailbox;
use crate::threading::thread_priority::ThreadPriority;

/// Everything that was received in the listening time.
#[derive(Default)]
pub struct ReceivedTopics {
    pub description: Option<String>,
    pub semantic: Option<String>,
    /// The first joint states, with their publishers and the times of reception.
    pub joint_states: Vec<(JointState, SourceId, Now)>,
    /// Number of joint states received.
    pub joint_state_count: u32,
    pub transforms: TransformTree,
    /// By frame of `tf`: the age (s) of its transforms at their reception that is nearest to zero.
    pub transform_ages: BTreeMap<String, f64>,
    /// Last simulated time, if simulated time is used and any was received.
    pub simulated_time: Option<Time>,
    /// Number of nodes with this node's name.
    pub nodes_of_same_name: usize,
    /// Warnings logged by the middleware.
    pub warnings: Vec<String>,
}

/// Subscriptions of the doctor.
struct Subscriptions {
    joint_states: Subscription<JointState>,
    descriptions: Subscription<StringMessage>,
    semantics: Subscription<StringMessage>,
    transforms: Subscription<TFMessage>,
    static_transforms: Subscription<TFMessage>,
    /// Only if simulated time is used.
    clock: Option<Subscription<Clock>>,
    /// Topics whose publishers the middleware compares with the node; their messages are not read.
    _unread: Vec<Subscription<()>>,
}

impl Subscriptions {
    fn open(middleware: &Middleware, names: &Names, parameters: &Parameters) -> Result<Self, NodeError> {
        let descriptions = |name| -> Result<Subscription<StringMessage>, NodeError> {
            let kind = TypeName::new("std_msgs", "String");
            Ok(middleware.subscription(&names.resolve(name)?, kind, Quality::Latched)?)
        };
        let transforms = |name, quality| -> Result<Subscription<TFMessage>, NodeError> {
            let kind = TypeName::new("tf2_msgs", "TFMessage");
            Ok(middleware.subscription(&names.resolve(name)?, kind, quality)?)
        };
        let clock = || -> Result<Subscription<Clock>, NodeError> {
            let kind = TypeName::new("rosgraph_msgs", "Clock");
            Ok(middleware.subscription(&names.resolve("/clock")?, kind, Quality::BestEffort)?)
        };
        Ok(Self {
            joint_states: middleware.subscription(
                &names.resolve("joint_states")?,
                TypeName::new("sensor_msgs", "JointState"),
                Quality::BestEffort,
            )?,
            descriptions: descriptions("robot_description")?,
            semantics: descriptions("robot_description_semantic")?,
            transforms: transforms("tf", Quality::BestEffort)?,
            static_transforms: transforms("tf_static", Quality::Kept)?,
            clock: parameters.use_sim_time.then(clock).transpose()?,
            _unread: unread_topics::subscribe(middleware, names, &parameters.point_cloud_topics)?,
        })
    }
}

/// Transforms received so far, from both topics.
#[derive(Default)]
struct ReceivedTransforms {
    tree: TransformTree,
    ages: BTreeMap<String, f64>,
}

/// Subscribes to all topics for a while, and returns the messages received.
pub fn receive_topics(
    environment: Environment,
    names: &Names,
    describe: bool,
    parameters: &Parameters,
    duration: Duration,
) -> Result<ReceivedTopics, NodeError> {
    let lines = logging::open_rosout_queue();
    let middleware = Middleware::join(
        Announcement::make(environment, ThreadPriority::Normal)?,
        names.namespace(),
        &format!("{NODE_NAME}_doctor"),
    )?;
    let subscriptions = Subscriptions::open(&middleware, names, parameters)?;
    let clock = RosClock::new(parameters.use_sim_time);
    let transforms = RefCell::new(ReceivedTransforms::default());
    let mut received = ReceivedTopics::default();
    let receive = async {
        let ReceivedTopics { description, semantic, joint_states, joint_state_count, warnings, .. } =
            &mut received;
        let states =
            receive_joint_states(&subscriptions.joint_states, &clock, joint_states, joint_state_count);
        let urdf = async {
            if describe {
                receive_latest(&subscriptions.descriptions, description).await;
            }
        };
        let descriptions = future::zip(urdf, receive_latest(&subscriptions.semantics, semantic));
        let ticks = follow_clock(subscriptions.clock.as_ref(), &clock);
        let frames = future::zip(
            receive_transforms(&subscriptions.transforms, &clock, &transforms),
            receive_static_transforms(&subscriptions.static_transforms, &clock, &transforms),
        );
        let topics = future::zip(future::zip(states, descriptions), future::zip(ticks, frames));
        let network = future::zip(receive_warnings(&lines, warnings), middleware.watch_peers());
        future::zip(topics, network).await;
    };
    smol::block_on(future::or(drop_after(duration), receive));
    let ReceivedTransforms { tree, ages } = transforms.into_inner();
    (received.transforms, received.transform_ages) = (tree, ages);
    received.simulated_time = parameters.use_sim_time.then(|| clock.now()).flatten();
    received.nodes_of_same_name = middleware.publishers_elsewhere(&names.resolve("~/state")?);
    drop(subscriptions);
    middleware.leave();
    Ok(received)
}

/// Keeps the first joint states, and counts all of them. Never returns.
async fn receive_joint_states(
    topic: &Subscription<JointState>,
    clock: &RosClock,
    kept: &mut Vec<(JointState, SourceId, Now)>,
    count: &mut u32,
) {
    /// Limits for the joint states that are kept for the monitor: their number, and the number of names and values in
    /// all of them.
    const MOST: usize = 10_000;
    const MOST_NUMBERS: usize = 1_000_000;
    let mut numbers = 0;
    loop {
        let (state, origin) = topic.next().await;
        *count = count.saturating_add(1);
        numbers += state.name.len() + state.position.len() + state.velocity.len() + state.effort.len();
        if kept.is_empty() || (kept.len() < MOST && numbers < MOST_NUMBERS) {
            kept.push((state, origin.publisher, clock.read()));
        }
    }
}

/// Keeps the last text of a topic. Never returns.
async fn receive_latest(topic: &Subscription<StringMessage>, latest: &mut Option<String>) {
    loop {
        *latest = Some(topic.next().await.0.data);
    }
}

/// Keeps the transforms of `tf`, with the ages of their stamps. Never returns.
async fn receive_transforms(
    topic: &Subscription<TFMessage>,
    clock: &RosClock,
    received: &RefCell<ReceivedTransforms>,
) {
    loop {
        let (message, _) = topic.next().await;
        let mut received = received.borrow_mut();
        note_transform_ages(&mut received.ages, &message, clock.now());
        note_transforms(&mut received.tree, message, clock.now(), false);
    }
}

/// Keeps the transforms of `tf_static`. Never returns.
async fn receive_static_transforms(
    topic: &Subscription<TFMessage>,
    clock: &RosClock,
    received: &RefCell<ReceivedTransforms>,
) {
    loop {
        let (message, _) = topic.next().await;
        note_transforms(&mut received.borrow_mut().tree, message, clock.now(), true);
    }
}

/// Keeps each warning of the middleware once.
async fn receive_warnings(lines: &mailbox::Receiver<LogLine>, warnings: &mut Vec<String>) {
    const MOST_WARNINGS: usize = 100;
    while let Some(line) = lines.receive().await {
        let is_new = warnings.len() < MOST_WARNINGS && !warnings.contains(&line.text);
        if line.level <= Level::Warn && is_new {
            warnings.push(line.text);
        }
    }
}

/// Sets the clock to the simulated time, if there is a subscription to it.
async fn follow_clock(topic: Option<&Subscription<Clock>>, clock: &RosClock) {
    let Some(topic) = topic else { return };
    loop {
        clock.on_simulation_time(time_of(&topic.next().await.0.clock));
    }
}

/// Stores the ages of transforms that are received at `now`.
fn note_transform_ages(ages: &mut BTreeMap<String, f64>, message: &TFMessage, now: Option<Time>) {
    /// Limit for the number of frames.
    const MOST: usize = 10_000;
    let Some(now) = now else { return };
    for transform in &message.transforms {
        let (stamp, frame) = (time_of(&transform.header.stamp), &transform.child_frame_id);
        let is_stored = ages.len() < MOST || ages.contains_key(frame);
        if stamp != Time::ZERO && is_stored {
            let frame = frame.trim_start_matches('/').to_owned();
            note_age(ages.entry(frame).or_insert(f64::INFINITY), now.seconds_since(stamp));
        }
    }
}

async fn drop_after(duration: Duration) {
    Timer::after(duration).await;
}
