//! Conversion of pose and transform messages, and storage of transforms in the transform tree.

use clearance_geometry::math::{Pose, pose_from_xyz_quaternion};
use clearance_monitor::Time;
use clearance_scene::{Transform as FrameTransform, TransformTree, message_pose};
use ros2_interfaces_jazzy_serde::geometry_msgs::msg::{Pose as PoseMessage, Transform};
use ros2_interfaces_jazzy_serde::tf2_msgs::msg::TFMessage;

use crate::messages::time_and_geometry::time_of;

/// Converts a pose; a quaternion of zeros is the identity.
pub fn pose(message: &PoseMessage, field: &str) -> Result<Pose, String> {
    let (p, q) = (&message.position, &message.orientation);
    message_pose([p.x, p.y, p.z], [q.x, q.y, q.z, q.w]).map_err(|why| format!("{field}: {why}"))
}

/// Converts a transform to the pose of the child in the parent. A rotation of length zero, which a publisher did not
/// set, is rejected.
pub fn transform_pose(message: &Transform) -> Result<Pose, String> {
    let (p, q) = (&message.translation, &message.rotation);
    pose_from_xyz_quaternion([p.x, p.y, p.z], [q.x, q.y, q.z, q.w]).ok_or_else(|| {
        "translation and rotation must be finite, the translation near and the quaternion not zero".to_owned()
    })
}

/// Stores transforms received at `now` in the tree, and returns what is wrong with them; `fixed` transforms never
/// expire.
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
        let placed = FrameTransform { parent, pose_pf, stamp };
        too_many |= !tree.insert_received(&transform.child_frame_id, placed, now);
    }
    match wrong {
        Some((frame, why)) => {
            Some(format!("tf: the transform of '{}' is no pose: {why}", frame.escape_debug()))
        }
        None => too_many.then(|| "tf: there are too many frames; further ones are ignored".to_owned()),
    }
}
