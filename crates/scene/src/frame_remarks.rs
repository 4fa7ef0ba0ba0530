//! Remarks on poses that hold only at the time a scene is read: a file is read once, while the robot moves on.

use super::{AttachedChange, Scene, SceneContext};

impl SceneContext<'_> {
    /// The reason, as a clause, why an object placed in a frame is not expected to keep its present pose; `None` for a frame that does
    /// not move.
    pub(super) fn frame_remark(&self, frame: &str, scene: &Scene) -> Option<String> {
        let name = frame.trim_start_matches('/');
        if let Some(joint) = self.virtual_joint_from(name) {
            let is_assumed = joint.kind != "fixed" && self.pose_by_tf(name).is_none();
            return is_assumed.then(|| {
                format!(
                    "the {} virtual joint from frame '{name}' is taken at zero, so that it is the root frame",
                    joint.kind
                )
            });
        }
        if let Some(link) = self.robot.link_by_name(name) {
            let moves = !self.robot.same_rigid_body(link, self.robot.root());
            return moves.then(|| {
                format!("link '{name}' moves: what is given in its frame stays where the robot's state puts it now")
            });
        }
        Self::attached_frame(name, scene).map(|_| {
            format!("'{name}' is held by the robot: what is given in its frame stays where it is now")
        })
    }

    /// As above, for an object that is to be attached: the robot's state determines its pose on the link, unless the object's frame is
    /// rigidly connected with the link.
    pub(super) fn attachment_remark(&self, change: &AttachedChange, scene: &Scene) -> Option<String> {
        let link = self.robot.link_by_name(&change.link)?;
        let object = &change.object;
        let has_pose_on_link = scene.world.attached_by_name(&object.id).is_some() && object.keeps_pose();
        let frame = self.robot.link_by_name(object.frame.trim_start_matches('/'));
        let is_rigid = frame.is_some_and(|frame| self.robot.same_rigid_body(frame, link));
        let is_grasped = object.shapes.is_empty();
        (is_grasped || !(is_rigid || has_pose_on_link))
            .then(|| format!("it is held where the robot's state puts it against link '{}' now", change.link))
    }
}
