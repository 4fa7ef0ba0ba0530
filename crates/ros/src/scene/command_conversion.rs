//! Conversion of messages about the world to orders of the loader. Live messages and recorded messages use the same functions.

use clearance_monitor::{Now, Observation, Time};
use clearance_scene::{SceneRejection, SceneUpdate};
use ros2_interfaces_jazzy_serde::moveit_msgs::msg::{
    AttachedCollisionObject, CollisionObject, PlanningScene, PlanningSceneWorld,
};
use ros2_interfaces_jazzy_serde::octomap_msgs::msg::{Octomap, OctomapWithPose};

use crate::messages::time_and_geometry::time_of;
use crate::recording::step::SceneDoor;
use crate::scene::octomap_messages::octomap_placement;
use crate::scene::scene_command::CLEAR_OCTOMAP;
use crate::scene::scene_command::SceneOrder;
use crate::scene::scene_message_reader::{attached_change, object_change, scene_change, world_change};

#[must_use]
pub fn object_order(message: &CollisionObject) -> SceneOrder {
    let order = SceneOrder::on(SceneDoor::CollisionObject.name());
    match object_change(message) {
        Ok(change) => order.to(SceneUpdate::Object(Box::new(change))),
        Err(refusal) => order.refused(vec![refusal]),
    }
}

#[must_use]
pub fn attached_order(message: &AttachedCollisionObject) -> SceneOrder {
    let order = SceneOrder::on(SceneDoor::AttachedCollisionObject.name());
    match attached_change(message) {
        Ok(change) => order.to(SceneUpdate::Attached(Box::new(change))),
        Err(refusal) => order.refused(vec![refusal]),
    }
}

/// Order for a message that was received at `came`.
#[must_use]
pub fn world_order(message: PlanningSceneWorld, unknown_is_occupied: bool, came: Now) -> SceneOrder {
    let read = world_change(&message, unknown_is_occupied);
    let order = SceneOrder::on(SceneDoor::PlanningSceneWorld.name());
    let order = order.to(SceneUpdate::World(Box::new(read.change)));
    order.refused(read.refusals).with_octomap(message.octomap, sight(Time::ZERO, came))
}

/// Order to apply a whole or partial scene.
#[must_use]
pub fn scene_order(
    by: SceneDoor,
    message: PlanningScene,
    unknown_is_occupied: bool,
    came: Now,
) -> SceneOrder {
    let mut read = scene_change(&message, unknown_is_occupied);
    read.change.keeps_octomap = by == SceneDoor::GetPlanningScene && read.change.world.octomap.is_none();
    let order = SceneOrder::on(by.name()).to(SceneUpdate::Scene(Box::new(read.change)));
    order.refused(read.refusals).with_octomap(message.world.octomap, sight(Time::ZERO, came))
}

#[must_use]
pub fn octomap_order(by: SceneDoor, message: Octomap, unknown_is_occupied: bool, came: Now) -> SceneOrder {
    let order = SceneOrder::on(by.name());
    match octomap_placement(&message, unknown_is_occupied) {
        Err(refusal) => order.refused(vec![refusal]),
        Ok(placement) => {
            let sight = sight(time_of(&message.header.stamp), came);
            let header = message.header.clone();
            let octomap = OctomapWithPose { header, octomap: message, ..OctomapWithPose::default() };
            order.to(SceneUpdate::Octomap(Some(placement))).with_octomap(octomap, sight)
        }
    }
}

/// Order for a message that cannot be decoded. It counts as lost, since it may have been about any part of the scene; an octomap is
/// replaced by the next one.
#[must_use]
pub fn unreadable_order(by: SceneDoor) -> SceneOrder {
    const WHY: &str = "a message could not be decoded: is it of this type, and are its texts UTF-8?";
    let order = SceneOrder::on(by.name());
    match by {
        SceneDoor::OctomapBinary | SceneDoor::OctomapFull => {
            order.refused(vec![SceneRejection::of_octomap(WHY)])
        }
        _ => order.refused(vec![SceneRejection::new(WHY)]).after(1),
    }
}

#[must_use]
pub fn clear_octomap() -> SceneOrder {
    SceneOrder::on(CLEAR_OCTOMAP).to(SceneUpdate::Octomap(None))
}

/// Time of the measurement in a message; without a stamp, the time of reception.
fn sight(stamp: Time, came: Now) -> Observation {
    let stamp = if stamp == Time::ZERO { came.ros.unwrap_or_default() } else { stamp };
    Observation { stamp, at: came.steady }
}
