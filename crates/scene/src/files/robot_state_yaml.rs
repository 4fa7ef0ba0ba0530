//! Robot state of scene files: reads joint positions and the root's pose, and computes link poses from them.

use clearance_geometry::math::Pose;
use clearance_robot::{Configuration, LinkPoses, RobotModel, VirtualJoint};

use super::text::{MultiDofText, RobotStateText};
use crate::{MultiDofJoint, SceneContext, Transform, TransformTree, VirtualJointRole};

/// State of the robot, as far as the files contain it.
#[derive(Clone, Debug, Default)]
pub struct FileRobotState {
    /// The default configuration when no file gives one.
    configuration: Option<Configuration>,
    /// Pose of the root in the parent frame of its virtual joint, if a file gives it.
    transforms: TransformTree,
}

/// Poses of links and frames in a robot state.
pub struct PlacedRobot {
    poses: LinkPoses,
    transforms: TransformTree,
}

impl PlacedRobot {
    pub fn context<'p>(&'p self, robot: &'p RobotModel) -> SceneContext<'p> {
        SceneContext::new(robot, Some(&self.poses), &self.transforms, None, f64::INFINITY)
    }
}

/// Positions (rad, m) by name.
type NamedPositions = Vec<(String, f64)>;

impl FileRobotState {
    pub fn placed(&self, robot: &RobotModel) -> PlacedRobot {
        let mut poses = LinkPoses::new(robot);
        let q = self.configuration.clone().unwrap_or_else(|| robot.default_configuration());
        robot.forward_kinematics(&q, &mut poses);
        PlacedRobot { poses, transforms: self.transforms.clone() }
    }

    /// Applies the robot pose of the state, if it contains one. `is_scene_empty`: no object was placed yet.
    pub fn read_state(
        &mut self,
        text: &RobotStateText,
        robot: &RobotModel,
        is_scene_empty: bool,
    ) -> Result<(), String> {
        let joints = &text.joint_state;
        if joints.name.len() != joints.position.len() {
            return Err(format!(
                "robot_state.joint_state: {} positions for {} names",
                joints.position.len(),
                joints.name.len()
            ));
        }
        let placed = self
            .read_base(&text.multi_dof_joint_state, robot, is_scene_empty)
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

    /// The positions of planar and floating joints, by name. The virtual joint of the root gives the robot's pose in the world.
    fn read_base(
        &mut self,
        text: &MultiDofText,
        robot: &RobotModel,
        is_scene_empty: bool,
    ) -> Result<NamedPositions, String> {
        if text.joint_names.len() != text.transforms.len() {
            let (given, names) = (text.transforms.len(), text.joint_names.len());
            return Err(format!("{given} transforms for {names} joint_names"));
        }
        let frame = &text.header.frame_id;
        let (mut placed, mut root) = (Vec::new(), None);
        for (name, transform) in text.joint_names.iter().zip(&text.transforms) {
            let pose = transform.pose(name)?;
            let joint = MultiDofJoint::find(robot, name);
            if let Some(VirtualJointRole::OtherOfRoot { first }) = joint.virtual_joint {
                return Err(format!("the root is placed by virtual joint '{}', not by '{name}'", first.name));
            }
            let is_known = joint.is_of_model || joint.placement_of_root().is_some();
            if is_known && !robot.is_model_frame(frame) {
                let root = &robot.link(robot.root()).name;
                return Err(format!("header.frame_id is '{frame}', but must be '{root}' or empty"));
            }
            if joint.is_of_model {
                placed.extend(robot.positions_of_transform(name, &pose).map_err(|e| e.to_string())?);
            } else if let Some(joint) = joint.placement_of_root() {
                RobotModel::check_virtual_transform(joint, &pose).map_err(|e| e.to_string())?;
                if root.replace((joint, pose)).is_some_and(|(_, earlier)| earlier != pose) {
                    return Err(format!("virtual joint '{name}' is given twice, at two places"));
                }
            } else if pose != Pose::identity() {
                return Err(format!(
                    "'{name}' is neither a joint of the robot nor a virtual joint of its root"
                ));
            }
        }
        if let Some((joint, pose_pr)) = root {
            self.place_root(joint, pose_pr, robot, is_scene_empty)?;
        }
        Ok(placed)
    }

    /// The root's pose in the parent frame of its virtual joint. It cannot change after an object was placed by another root pose.
    fn place_root(
        &mut self,
        joint: &VirtualJoint,
        pose_pr: Pose,
        robot: &RobotModel,
        is_scene_empty: bool,
    ) -> Result<(), String> {
        let root = &robot.link(robot.root()).name;
        let parent = joint.parent_frame.clone();
        if parent.trim_start_matches('/') == root && pose_pr != Pose::identity() {
            return Err(format!(
                "virtual joint '{}' places link '{root}' in a frame of the same name, but not at zero",
                joint.name
            ));
        }
        let before = self.transforms.path(&parent, root).map_or(Pose::identity(), |path| path.pose());
        if before != pose_pr && !is_scene_empty {
            return Err(format!(
                "virtual joint '{}' puts the robot elsewhere than the files before this one were read with: give the robot's state in the first file",
                joint.name
            ));
        }
        self.transforms.insert(root, Transform { parent, pose_pf: pose_pr, stamp: None });
        Ok(())
    }
}
