//! Octomaps as obstacles.

use ros2_interfaces_jazzy_serde::octomap_msgs::msg::{Octomap as OctomapMessage, OctomapWithPose};

use super::reading::pose;
use crate::geometry::Shape;
use crate::math::Pose;
use crate::monitor::scene::{OctomapPlacement, SceneRefusal};
use crate::world::Octomap;

/// The only kind of tree that is taken, as in MoveIt.
const KIND: &str = "OcTree";

/// An `octomap_msgs/Octomap` by itself, which stands in the frame of its header. Without data it is empty.
pub fn octomap_placement(
    message: &OctomapMessage,
    unknown_is_occupied: bool,
) -> Result<OctomapPlacement, SceneRefusal> {
    let frame = message.header.frame_id.clone();
    let (shape, is_blank) = shape(message, unknown_is_occupied)?;
    Ok(OctomapPlacement { frame, pose_fo: Pose::identity(), shape, is_blank })
}

/// That of a scene, which as in `MoveIt` takes the map away where it has an id and no data; `None` when the scene says nothing about it.
pub fn octomap_with_pose(
    message: &OctomapWithPose,
    unknown_is_occupied: bool,
) -> Result<Option<OctomapPlacement>, SceneRefusal> {
    if message.octomap.data.is_empty() && message.octomap.id.is_empty() {
        return Ok(None);
    }
    let pose_fo = pose(&message.origin, "octomap.origin").map_err(SceneRefusal::of_octomap)?;
    let (shape, is_blank) = shape(&message.octomap, unknown_is_occupied)?;
    Ok(Some(OctomapPlacement { frame: message.header.frame_id.clone(), pose_fo, shape, is_blank }))
}

/// What of a map is occupied, and whether no cell of it is known.
fn shape(message: &OctomapMessage, unknown_is_occupied: bool) -> Result<(Option<Shape>, bool), SceneRefusal> {
    let refuse = |why: String| SceneRefusal::of_octomap(format!("octomap: {why}"));
    if message.id != KIND {
        return Err(refuse(format!(
            "id: trees of type '{}' are not taken; {KIND} are",
            message.id.escape_debug()
        )));
    }
    if message.data.is_empty() {
        return Ok((None, true));
    }
    let data: Vec<u8> = message.data.iter().map(|byte| byte.cast_unsigned()).collect();
    let tree = Octomap::from_message(message.binary, &message.id, message.resolution, &data)
        .map_err(|error| refuse(error.to_string()))?;
    let voxels = tree.to_voxels(unknown_is_occupied).map_err(|error| refuse(error.to_string()))?;
    Ok((voxels.map(Shape::Voxels), !tree.has_known_cells()))
}
