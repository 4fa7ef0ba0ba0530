//! Conversion of transforms to positions of planar and floating joints, as in `sensor_msgs/MultiDOFJointState`.

use clearance_geometry::math::{Extremes, Pose, Vector};

use super::{JointKind, RobotModel, VirtualJoint};

/// Maximum deviation (m, rad) of a transform from the plane of a planar joint; allows for rounding in files and messages.
const PLANE_TOLERANCE: f64 = 1e-6;

/// Reason why a transform gives no positions of a joint.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the message of each variant describes it and its fields")]
pub enum JointTransformError {
    #[error("the robot has no joint '{joint}'{hint}")]
    Unknown { joint: String, hint: String },
    #[error("joint '{joint}' is neither planar nor floating: {instead}")]
    OtherKind { joint: String, instead: &'static str },
    #[error(
        "planar joint '{joint}' can not make this transform, which leaves its plane by {off} (m, rad): give translation and rotation in the \
         plane across the joint's axis"
    )]
    OffPlane { joint: String, off: f64 },
}

impl RobotModel {
    /// The positions, by name, of planar or floating joint `joint` with its child link at `pose_jc` in the joint frame.
    pub fn positions_of_transform(
        &self,
        joint: &str,
        pose_jc: &Pose,
    ) -> Result<Vec<(String, f64)>, JointTransformError> {
        let id = self.joint_by_name(joint).ok_or_else(|| self.unknown(joint))?;
        let kind = &self.joint(id).kind;
        let Some((positions, off)) = kind.positions_at(pose_jc) else {
            let is_fixed = kind.position_suffixes().is_empty();
            let instead = if is_fixed { "leave it out" } else { "give its position in joint_state" };
            return Err(JointTransformError::OtherKind { joint: joint.to_owned(), instead });
        };
        // NaN counts as a deviation, too
        if off <= PLANE_TOLERANCE {
            let suffixes = kind.position_suffixes();
            Ok(suffixes.iter().map(|suffix| format!("{joint}{suffix}")).zip(positions).collect())
        } else {
            Err(JointTransformError::OffPlane { joint: joint.to_owned(), off })
        }
    }

    /// Checks whether a virtual joint may place its child at `pose_jc`: a fixed one at zero only, a planar one in the plane normal to z.
    pub fn check_virtual_transform(joint: &VirtualJoint, pose_jc: &Pose) -> Result<(), JointTransformError> {
        let name = || joint.name.clone();
        match joint.kind.as_str() {
            "floating" => Ok(()),
            "planar" => match JointKind::Planar(Vector::z_axis()).positions_at(pose_jc) {
                Some((_, off)) if off <= PLANE_TOLERANCE => Ok(()),
                off => {
                    let off = off.map_or(f64::NAN, |(_, off)| off);
                    Err(JointTransformError::OffPlane { joint: name(), off })
                }
            },
            _ if pose_jc.translation.vector.norm().greater(pose_jc.rotation.angle()) <= PLANE_TOLERANCE => {
                Ok(())
            }
            _ => Err(JointTransformError::OtherKind { joint: name(), instead: "leave it out, or at zero" }),
        }
    }

    /// True if transforms of joints may be given in this frame, as in `MoveIt`: the frame of the root link, or the parent frame of its
    /// virtual joint. An empty name is allowed, too.
    #[must_use]
    pub fn is_model_frame(&self, frame: &str) -> bool {
        let frame = frame.trim_start_matches('/');
        let mut worlds = self.srdf().into_iter().flat_map(|srdf| &srdf.virtual_joints);
        frame.is_empty()
            || frame == self.link(self.root()).name
            || worlds.any(|joint| joint.child_link == self.root() && joint.parent_frame == frame)
    }

    fn unknown(&self, joint: &str) -> JointTransformError {
        let has_several = |id: &super::JointId| self.joint(*id).kind.position_suffixes().len() > 1;
        let names: Vec<&str> =
            self.joint_ids().filter(has_several).map(|id| self.joint(id).name.as_str()).collect();
        let hint = if names.is_empty() {
            "; none of its joints is planar or floating".to_owned()
        } else {
            format!("; planar or floating are {}", names.join(", "))
        };
        JointTransformError::Unknown { joint: joint.to_owned(), hint }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::{LinkPoses, MeshFiles};
    use clearance_geometry::math::Rotation;

    fn robot(axis: &str) -> RobotModel {
        let joint = |name: &str, kind: &str, parent: &str, child: &str| {
            format!(
                "<joint name='{name}' type='{kind}'><parent link='{parent}'/><child link='{child}'/><origin xyz='1 2 3' rpy='0.1 0.2 0.3'/>\
                 <axis xyz='{axis}'/></joint>"
            )
        };
        let urdf = format!(
            "<robot name='r'><link name='root'/><link name='base'/><link name='head'/><link name='tip'/><link name='end'/>{}{}{}{}</robot>",
            joint("drive", "planar", "root", "base"),
            joint("float", "floating", "base", "head"),
            joint("turn", "continuous", "head", "tip"),
            joint("weld", "fixed", "tip", "end"),
        );
        RobotModel::from_urdf(&urdf, &MeshFiles::default()).unwrap()
    }

    #[test]
    fn positions_make_the_transform_again() {
        for axis in ["0 0 1", "1 0 0", "0.3 -2 1"] {
            let robot = robot(axis);
            for (joint, positions) in [
                ("drive", vec![0.5, -0.25, 3.0]),
                ("drive", vec![-4.0, 7.0, -1.0]),
                ("float", vec![0.5, 6.0, -7.0, 0.0, 0.6, 0.0, 0.8]),
            ] {
                let id = robot.joint_by_name(joint).unwrap();
                let pose = robot.joint(id).kind.motion(&positions);
                let named = robot.positions_of_transform(joint, &pose).unwrap();
                let [a, b] = [named, robot_names(&robot, joint, &positions)].map(|named| {
                    let named = named.iter().map(|(name, value)| (name.as_str(), *value));
                    let mut poses = LinkPoses::new(&robot);
                    robot.forward_kinematics(&robot.configuration_from_names(named).unwrap(), &mut poses);
                    *poses.pose(robot.link_by_name("end").unwrap())
                });
                assert!(
                    (a.inverse() * b).translation.vector.norm() < 1e-9
                        && a.rotation.angle_to(&b.rotation) < 1e-9
                );
            }
        }
    }

    fn robot_names(robot: &RobotModel, joint: &str, positions: &[f64]) -> Vec<(String, f64)> {
        let suffixes = robot.joint(robot.joint_by_name(joint).unwrap()).kind.position_suffixes();
        suffixes.iter().map(|suffix| format!("{joint}{suffix}")).zip(positions.iter().copied()).collect()
    }

    #[test]
    fn what_a_joint_can_not_make_is_rejected_by_name() {
        let robot = robot("0 0 1");
        let error =
            |joint: &str, pose: Pose| robot.positions_of_transform(joint, &pose).unwrap_err().to_string();
        let lifted = Pose::translation(0.5, 0.0, 0.1);
        assert!(
            error("drive", lifted).contains("'drive'") && error("drive", lifted).contains("0.1 (m, rad)")
        );
        let tilted = Rotation::from_axis_angle(&Vector::x_axis(), 0.01);
        assert!(error("drive", Pose::from_parts(Pose::identity().translation, tilted)).contains("0.0"));
        let flipped = Rotation::from_axis_angle(&Vector::x_axis(), PI);
        assert!(error("drive", Pose::from_parts(Pose::identity().translation, flipped)).contains("3.14"));
        assert!(robot.positions_of_transform("float", &Pose::translation(0.5, 0.0, 0.1)).is_ok());
        assert!(
            error("turn", Pose::identity())
                .contains("'turn' is neither planar nor floating: give its position")
        );
        assert!(error("weld", Pose::identity()).contains("'weld'"));
        assert!(error("dirve", Pose::identity()).contains("'dirve'; planar or floating are drive, float"));
    }
}
