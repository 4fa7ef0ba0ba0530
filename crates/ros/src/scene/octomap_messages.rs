//! Converts `octomap_msgs` messages to `OctomapPlacement`; `clearance_scene` decodes the octree.

use clearance_geometry::math::Pose;
use clearance_scene::{OctomapMessage, OctomapPlacement, SceneRejection};
use ros2_interfaces_jazzy_serde::octomap_msgs::msg::{Octomap, OctomapWithPose};

use crate::scene::transform_messages::pose;

/// Converts a single `octomap_msgs/Octomap`, which is placed in the frame of its header. Without data the octomap is
/// empty.
pub fn octomap_placement(
    message: &Octomap,
    unknown_is_occupied: bool,
) -> Result<OctomapPlacement, SceneRejection> {
    placed(message, (message.header.frame_id.clone(), Pose::identity()), unknown_is_occupied)
}

/// Converts the octomap of a scene message; `None` if the message does not change the octomap.
pub fn octomap_with_pose(
    message: &OctomapWithPose,
    unknown_is_occupied: bool,
) -> Result<Option<OctomapPlacement>, SceneRejection> {
    if fields(&message.octomap, &[]).is_absent() && message.octomap.data.is_empty() {
        return Ok(None);
    }
    let pose_fo = pose(&message.origin, "octomap.origin").map_err(SceneRejection::of_octomap)?;
    placed(&message.octomap, (message.header.frame_id.clone(), pose_fo), unknown_is_occupied).map(Some)
}

fn placed(
    message: &Octomap,
    place: (String, Pose),
    unknown_is_occupied: bool,
) -> Result<OctomapPlacement, SceneRejection> {
    let data: Vec<u8> = message.data.iter().map(|byte| byte.cast_unsigned()).collect();
    let placed = fields(message, &data).placed(place.0, place.1, unknown_is_occupied);
    placed.map_err(|why| SceneRejection::of_octomap(format!("octomap: {why}")))
}

fn fields<'m>(message: &'m Octomap, data: &'m [u8]) -> OctomapMessage<'m> {
    OctomapMessage { id: &message.id, binary: message.binary, resolution: message.resolution, data }
}
