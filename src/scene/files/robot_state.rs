//! Robot state of scene files: places the frames of links.

use super::text::{MultiDofText, RobotStateText};
use crate::math::Pose;
use crate::robot::{Configuration, LinkPoses, RobotModel};
use crate::scene::{SceneContext, Transform, TransformTree};

/// State of the robot, as far as files give it.
#[derive(Clone, Debug, Default)]
pub struct Situation {
    /// The default configuration when no file gives one.
    configuration: Option<Configuration>,
    /// Where the root stands in the parent frame of its virtual joint, if a file says so.
    transforms: TransformTree,
}

/// Where links and frames are in a situation.
pub struct Place {
    poses: LinkPoses,
    transforms: TransformTree,
}

impl Place {
    pub fn context<'p>(&'p self, robot: &'p RobotModel) -> SceneContext<'p> {
        SceneContext::new(robot, Some(&self.poses), &self.transforms, None, f64::INFINITY)
    }
}

/// Positions (rad, m) by name.
type NamedPositions = Vec<(String, f64)>;

impl Situation {
    pub fn place(&self, robot: &RobotModel) -> Place {
        let mut poses = LinkPoses::new(robot);
        let q = self.configuration.clone().unwrap_or_else(|| robot.default_configuration());
        robot.forward_kinematics(&q, &mut poses);
        Place { poses, transforms: self.transforms.clone() }
    }

    /// Where the robot is, if the state says so.
    pub fn read_state(&mut self, text: &RobotStateText, robot: &RobotModel) -> Result<(), String> {
        let joints = &text.joint_state;
        if joints.name.len() != joints.position.len() {
            return Err(format!(
                "robot_state.joint_state: {} positions for {} names",
                joints.position.len(),
                joints.name.len()
            ));
        }
        let placed = self
            .read_base(&text.multi_dof_joint_state, robot)
            .map_err(|e| format!("robot_state.multi_dof_joint_state: {e}"))?;
        if !(joints.name.is_empty() && placed.is_empty()) {
            let field = if placed.is_empty() { "robot_state.joint_state" } else { "robot_state" };
            let single = joints.name.iter().map(String::as_str).zip(joints.position.iter().copied());
            let several = placed.iter().map(|(name, position)| (name.as_str(), *position));
            let rest = self.configuration.clone().unwrap_or_else(|| robot.default_configuration());
            let q = robot.configuration_over(&rest, single.chain(several));
            self.configuration = Some(q.map_err(|e| format!("{field}: {e}"))?);
        }
        Ok(())
    }

    /// The positions of planar and floating joints, by name. The virtual joint of the root says where the robot stands.
    fn read_base(&mut self, text: &MultiDofText, robot: &RobotModel) -> Result<NamedPositions, String> {
        if text.joint_names.len() != text.transforms.len() {
            let (given, names) = (text.transforms.len(), text.joint_names.len());
            return Err(format!("{given} transforms for {names} joint_names"));
        }
        let mut placed = Vec::new();
        for (name, transform) in text.joint_names.iter().zip(&text.transforms) {
            let pose = transform.pose(name)?;
            let mut virtual_joints = robot.srdf().into_iter().flat_map(|srdf| &srdf.virtual_joints);
            let virtual_joint = virtual_joints.find(|j| j.name == *name && j.child_link == robot.root());
            if robot.joint_by_name(name).is_some() {
                let frame = &text.header.frame_id;
                if !robot.is_model_frame(frame) {
                    let root = &robot.link(robot.root()).name;
                    return Err(format!("header.frame_id is '{frame}', but must be '{root}' or empty"));
                }
                placed.extend(robot.positions_of_transform(name, &pose).map_err(|e| e.to_string())?);
            } else if let Some(joint) = virtual_joint {
                let parent = joint.parent_frame.clone();
                let transform = Transform { parent, pose_pf: pose, stamp: None };
                self.transforms.note(&robot.link(robot.root()).name, transform);
            } else if pose != Pose::identity() {
                return Err(format!(
                    "'{name}' is neither a joint of the robot nor a virtual joint of its root"
                ));
            }
        }
        Ok(placed)
    }
}
