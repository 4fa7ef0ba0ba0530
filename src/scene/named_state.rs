//! A state of the robot as messages have it: `sensor_msgs/JointState`, `moveit_msgs/RobotState`.

use std::sync::Arc;

use super::files::{JointStateText, MultiDofText, RobotStateText};
use crate::math::Pose;
use crate::robot::RobotModel;

/// Largest deviation (m, rad) of a transform from the plane of a planar joint.
const PLANE_SLACK: f64 = 1e-3;

/// Positions (rad, m) by the names of [`RobotModel::position_names`], as far as a message has them.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedState {
    pub names: Arc<[String]>,
    pub positions: Vec<f64>,
    /// Parts of the message that say nothing about the state.
    pub remarks: Vec<String>,
}

impl NamedState {
    /// Reads the fields of a `sensor_msgs/JointState`.
    ///
    /// # Errors
    /// Names without positions, and the reverse.
    pub fn of_joints(names: impl Into<Arc<[String]>>, positions: Vec<f64>) -> Result<Self, String> {
        let names = names.into();
        if names.len() != positions.len() {
            return Err(match positions.len() {
                0 => format!("it names {} joints, but has no position", names.len()),
                given => format!("it has {given} positions for {} names", names.len()),
            });
        }
        Ok(Self { names, positions, remarks: Vec::new() })
    }

    /// Reads a `moveit_msgs/RobotState`; transforms of planar and floating joints become their positions.
    ///
    /// # Errors
    /// The field, and what is wrong with it. What the robot holds belongs to the world.
    pub(crate) fn of_robot(text: RobotStateText, robot: &RobotModel) -> Result<Self, String> {
        if let Some(attached) = text.attached_collision_objects.first() {
            return Err(format!(
                "attached_collision_objects: a state brings no objects ('{}'): give them with --world, as robot_state of a planning scene",
                attached.object.id
            ));
        }
        let JointStateText { name, position, .. } = text.joint_state;
        let mut state = Self::of_joints(name, position).map_err(|e| format!("joint_state: {e}"))?;
        state
            .add_transforms(&text.multi_dof_joint_state, robot)
            .map_err(|e| format!("multi_dof_joint_state: {e}"))?;
        Ok(state)
    }

    fn add_transforms(&mut self, text: &MultiDofText, robot: &RobotModel) -> Result<(), String> {
        let (given, names) = (text.transforms.len(), text.joint_names.len());
        if given != names {
            return Err(format!("{given} transforms for {names} joint_names"));
        }
        let mut all_names = self.names.to_vec();
        for (name, transform) in text.joint_names.iter().zip(&text.transforms) {
            let pose = transform.pose(name)?;
            let joint = robot.joint_by_name(name).map(|id| robot.joint(id));
            match joint.and_then(|joint| Some((joint, joint.kind.positions_at(&pose)?))) {
                Some((_, (_, off))) if off > PLANE_SLACK => {
                    return Err(format!(
                        "the transform of planar joint '{name}' leaves its plane by {off:.4} (m, rad)"
                    ));
                }
                Some((joint, (positions, _))) => {
                    let suffixes = joint.kind.position_suffixes().iter();
                    all_names.extend(suffixes.map(|suffix| format!("{name}{suffix}")));
                    self.positions.extend(positions);
                }
                None if joint.is_some() => {
                    return Err(format!(
                        "joint '{name}' is neither planar nor floating: give its position in joint_state"
                    ));
                }
                // where the robot stands; obstacles are in the frame of its root
                None if pose == Pose::identity() => {}
                None => {
                    let remark =
                        format!("multi_dof_joint_state: the robot has no joint '{name}': it is not read");
                    self.remarks.push(remark);
                }
            }
        }
        self.names = all_names.into();
        Ok(())
    }
}
