//! Conversion of messages about the world to commands of the loader. Live messages and recorded messages use the same
//! functions.

use clearance_monitor::{Now, Observation, Time};
use clearance_scene::{SceneRejection, SceneUpdate};
use ros2_interfaces_jazzy_serde::moveit_msgs::msg::{
    AttachedCollisionObject, CollisionObject, PlanningScene, PlanningSceneWorld,
};
use ros2_interfaces_jazzy_serde::octomap_msgs::msg::{Octomap, OctomapWithPose};

use crate::messages::clearance_msgs::ObstacleStates;
use crate::messages::time_and_geometry::time_of;
use crate::recording::step::SceneSource;
use crate::scene::obstacle_state_reader::obstacle_states;
use crate::scene::octomap_messages::octomap_placement;
use crate::scene::scene_command::CLEAR_OCTOMAP;
use crate::scene::scene_command::SceneCommand;
use crate::scene::scene_message_reader::{attached_change, object_change, scene_change, world_change};

#[must_use]
pub fn object_command(message: &CollisionObject) -> SceneCommand {
    let command = SceneCommand::on(SceneSource::CollisionObject.name());
    match object_change(message) {
        Ok(change) => command.with_update(SceneUpdate::Object(Box::new(change))),
        Err(rejection) => command.with_rejections(vec![rejection]),
    }
}

#[must_use]
pub fn attached_command(message: &AttachedCollisionObject) -> SceneCommand {
    let command = SceneCommand::on(SceneSource::AttachedCollisionObject.name());
    match attached_change(message) {
        Ok(change) => command.with_update(SceneUpdate::Attached(Box::new(change))),
        Err(rejection) => command.with_rejections(vec![rejection]),
    }
}

/// Command for a message that was received at `received_at`.
#[must_use]
pub fn states_command(message: &ObstacleStates, received_at: Now) -> SceneCommand {
    let read = obstacle_states(message, received_at);
    let command = SceneCommand::on(SceneSource::ObstacleStates.name());
    command.with_update(SceneUpdate::States(read.change)).with_rejections(read.rejections)
}

/// Command for a message that was received at `received_at`.
#[must_use]
pub fn world_command(
    message: PlanningSceneWorld,
    unknown_is_occupied: bool,
    received_at: Now,
) -> SceneCommand {
    let read = world_change(&message, unknown_is_occupied);
    let command = SceneCommand::on(SceneSource::PlanningSceneWorld.name());
    let command = command.with_update(SceneUpdate::World(Box::new(read.change)));
    command
        .with_rejections(read.rejections)
        .with_octomap(message.octomap, observation(Time::ZERO, received_at))
}

/// Command to apply a whole or partial scene.
#[must_use]
pub fn scene_command(
    by: SceneSource,
    message: PlanningScene,
    unknown_is_occupied: bool,
    received_at: Now,
) -> SceneCommand {
    let mut read = scene_change(&message, unknown_is_occupied);
    read.change.keeps_octomap = by == SceneSource::GetPlanningScene && read.change.world.octomap.is_none();
    let command = SceneCommand::on(by.name()).with_update(SceneUpdate::Scene(Box::new(read.change)));
    command
        .with_rejections(read.rejections)
        .with_octomap(message.world.octomap, observation(Time::ZERO, received_at))
}

#[must_use]
pub fn octomap_command(
    by: SceneSource,
    message: Octomap,
    unknown_is_occupied: bool,
    received_at: Now,
) -> SceneCommand {
    let command = SceneCommand::on(by.name());
    match octomap_placement(&message, unknown_is_occupied) {
        Err(rejection) => command.with_rejections(vec![rejection]),
        Ok(placement) => {
            let observation = observation(time_of(&message.header.stamp), received_at);
            let header = message.header.clone();
            let octomap = OctomapWithPose { header, octomap: message, ..OctomapWithPose::default() };
            command.with_update(SceneUpdate::Octomap(Some(placement))).with_octomap(octomap, observation)
        }
    }
}

/// Command for a message that cannot be decoded. It counts as lost, since it may have been about any part of the scene;
/// an octomap is replaced by the next one.
#[must_use]
pub fn undecodable_command(by: SceneSource) -> SceneCommand {
    const WHY: &str = "a message could not be decoded: is it of this type, and are its texts UTF-8?";
    let command = SceneCommand::on(by.name());
    match by {
        SceneSource::OctomapBinary | SceneSource::OctomapFull => {
            command.with_rejections(vec![SceneRejection::of_octomap(WHY)])
        }
        _ => command.with_rejections(vec![SceneRejection::new(WHY)]).after(1),
    }
}

/// Command that reports publishers from which the node cannot receive: what is wrong with each.
#[must_use]
pub fn unreceivable_command(publishers: Vec<String>) -> SceneCommand {
    SceneCommand::on("publishers").with_unreceivable(publishers)
}

#[must_use]
pub fn clear_octomap() -> SceneCommand {
    SceneCommand::on(CLEAR_OCTOMAP).with_update(SceneUpdate::Octomap(None))
}

/// Time of the measurement in a message; without a stamp, the time of reception.
fn observation(stamp: Time, received_at: Now) -> Observation {
    let stamp = if stamp == Time::ZERO { received_at.ros.unwrap_or_default() } else { stamp };
    Observation { stamp, at: received_at.steady }
}
