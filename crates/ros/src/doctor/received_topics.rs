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

/// Subscribes to all topics for a while, and returns the messages received.
pub fn receive_topics(
    environment: Environment,
    names: &Names,
    describe: bool,
    parameters: &Parameters,
    duration: Duration,
) -> Result<ReceivedTopics, NodeError> {
    /// Limits for the joint states that are kept for the monitor: their number, and the number of names and values in
    /// all of them.
    const MOST: usize = 10_000;
    const MOST_NUMBERS: usize = 1_000_000;
    const MOST_WARNINGS: usize = 100;
    let lines = logging::open_rosout_queue();
    let middleware = Middleware::join(
        Announcement::make(environment, ThreadPriority::Normal)?,
        names.namespace(),
        &format!("{NODE_NAME}_doctor"),
    )?;
    let text = TypeName::new("std_msgs", "String");
    let states = middleware.subscription::<JointState>(
        &names.resolve("joint_states")?,
        TypeName::new("sensor_msgs", "JointState"),
        Quality::BestEffort,
    )?;
    let [descriptions, semantics] = ["robot_description", "robot_description_semantic"].map(|name| {
        let name = names.resolve(name)?;
        Ok::<_, NodeError>(middleware.subscription::<StringMessage>(&name, text, Quality::Latched)?)
    });
    let (descriptions, semantics) = (descriptions?, semantics?);
    let kind = TypeName::new("tf2_msgs", "TFMessage");
    let [moving, fixed] =
        [("tf", Quality::BestEffort), ("tf_static", Quality::Kept)].map(|(name, quality)| {
            Ok::<_, NodeError>(middleware.subscription::<TFMessage>(&names.resolve(name)?, kind, quality)?)
        });
    let (moving, fixed) = (moving?, fixed?);
    let unread = unread_topics::subscribe(&middleware, names, &parameters.point_cloud_topics)?;
    let use_sim_time = parameters.use_sim_time;
    let clock = RosClock::new(use_sim_time);
    let kind = TypeName::new("rosgraph_msgs", "Clock");
    let clock_topic = names.resolve("/clock")?;
    let subscribe = || middleware.subscription::<Clock>(&clock_topic, kind, Quality::BestEffort);
    let ticks = use_sim_time.then(subscribe).transpose()?;
    let tree = RefCell::new(TransformTree::default());
    let transform_ages = RefCell::new(BTreeMap::new());
    let mut received = ReceivedTopics::default();
    let ReceivedTopics { description, semantic, joint_states, joint_state_count, warnings, .. } =
        &mut received;
    let mut numbers = 0;
    smol::block_on(future::or(drop_after(duration), async {
        let receive_states = async {
            loop {
                let (state, origin) = states.next().await;
                *joint_state_count = joint_state_count.saturating_add(1);
                numbers +=
                    state.name.len() + state.position.len() + state.velocity.len() + state.effort.len();
                if joint_states.is_empty() || (joint_states.len() < MOST && numbers < MOST_NUMBERS) {
                    joint_states.push((state, origin.publisher, clock.read()));
                }
            }
        };
        let receive_description = async {
            if describe {
                loop {
                    *description = Some(descriptions.next().await.0.data);
                }
            }
        };
        let receive_semantic = async {
            loop {
                *semantic = Some(semantics.next().await.0.data);
            }
        };
        let receive_transforms = async |topic: &Subscription<TFMessage>, fixed: bool| {
            loop {
                let (message, _) = topic.next().await;
                if !fixed {
                    note_transform_ages(&mut transform_ages.borrow_mut(), &message, clock.now());
                }
                note_transforms(&mut tree.borrow_mut(), message, clock.now(), fixed);
            }
        };
        let receive_warnings = async {
            while let Some(line) = lines.receive().await {
                let is_new = warnings.len() < MOST_WARNINGS && !warnings.contains(&line.text);
                if line.level <= Level::Warn && is_new {
                    warnings.push(line.text);
                }
            }
        };
        let follow_clock = async {
            if let Some(ticks) = &ticks {
                loop {
                    clock.on_simulation_time(time_of(&ticks.next().await.0.clock));
                }
            }
        };
        let robot = future::zip(future::zip(receive_description, receive_semantic), follow_clock);
        let transforms = future::zip(receive_transforms(&moving, false), receive_transforms(&fixed, true));
        let topics = future::zip(receive_states, future::zip(robot, transforms));
        future::zip(topics, future::zip(receive_warnings, middleware.watch_peers())).await;
    }));
    received.transforms = tree.into_inner();
    received.transform_ages = transform_ages.into_inner();
    received.simulated_time = use_sim_time.then(|| clock.now()).flatten();
    received.nodes_of_same_name = middleware.publishers_elsewhere(&names.resolve("~/state")?);
    drop((states, descriptions, semantics, moving, fixed, ticks, unread));
    middleware.leave();
    Ok(received)
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
