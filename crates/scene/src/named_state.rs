//! Robot states by name, as in the messages `sensor_msgs/JointState` and `moveit_msgs/RobotState`.

use std::sync::Arc;

use clearance_geometry::math::Pose;
use clearance_robot::RobotModel;

use super::MultiDofJoint;
use super::files::{JointStateText, MultiDofText, RobotStateText};

/// Positions (rad, m) by the names of [`RobotModel::position_names`]; only those contained in a message.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedState {
    /// Names of positions.
    pub names: Arc<[String]>,
    /// One position (rad, m) for each name.
    pub positions: Vec<f64>,
}

impl NamedState {
    /// Reads the fields of a `sensor_msgs/JointState`.
    ///
    /// # Errors
    /// If names have no positions, or the reverse.
    pub fn of_joints(names: impl Into<Arc<[String]>>, positions: Vec<f64>) -> Result<Self, String> {
        let names = names.into();
        if names.len() != positions.len() {
            return Err(match positions.len() {
                0 => format!("it names {} joints, but has no position", names.len()),
                given => format!("it has {given} positions for {} names", names.len()),
            });
        }
        Ok(Self { names, positions })
    }

    /// Reads a `moveit_msgs/RobotState`; transforms of planar and floating joints become their positions.
    ///
    /// # Errors
    /// The field and its error. Attached objects are not read here; they belong to the world.
    pub fn of_robot(text: RobotStateText, robot: &RobotModel) -> Result<Self, String> {
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
            if robot.joint_by_name(name).is_none() {
                check_root_stays(name, &pose, robot)?;
                continue;
            }
            let frame = &text.header.frame_id;
            if !robot.is_model_frame(frame) {
                let root = &robot.link(robot.root()).name;
                return Err(format!("header.frame_id is '{frame}', but must be '{root}' or empty"));
            }
            let placed = robot.positions_of_transform(name, &pose).map_err(|error| error.to_string())?;
            for (position_name, position) in placed {
                all_names.push(position_name);
                self.positions.push(position);
            }
        }
        self.names = all_names.into();
        Ok(())
    }
}

/// Rejects a transform of a joint that the robot does not have, unless it is the identity. A virtual joint gives the root's pose in the
/// world: a state does not move it, since obstacles are in the root frame.
fn check_root_stays(joint: &str, pose: &Pose, robot: &RobotModel) -> Result<(), String> {
    if *pose == Pose::identity() {
        return Ok(());
    }
    if MultiDofJoint::find(robot, joint).virtual_joint.is_some() {
        return Err(format!(
            "virtual joint '{joint}' can not be moved here: leave it out, or at zero; where the robot stands among obstacles, the \
             robot_state of a planning scene says (--world)"
        ));
    }
    robot.positions_of_transform(joint, pose).map(drop).map_err(|unknown| unknown.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clearance_robot::{MeshFiles, RobotText};

    const URDF: &str = "<robot name='r'><link name='base'/><link name='a'/><link name='b'/>
        <joint name='drive' type='planar'><parent link='base'/><child link='a'/><axis xyz='0 0 1'/></joint>
        <joint name='fly' type='floating'><parent link='a'/><child link='b'/></joint></robot>";

    fn robot() -> RobotModel {
        RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap()
    }

    /// A robot with a virtual joint.
    fn mounted() -> RobotModel {
        let srdf = "<robot name='r'><virtual_joint name='mount' type='floating' parent_frame='map' child_link='base'/></robot>";
        let text = RobotText { urdf: URDF, srdf: Some(srdf), ..RobotText::default() };
        RobotModel::from_text(&text, &MeshFiles::default()).unwrap()
    }

    fn read(robot: &RobotModel, frame: &str, joint: &str, transform: &str) -> Result<NamedState, String> {
        let text = format!(
            "{{multi_dof_joint_state: {{header: {{frame_id: '{frame}'}}, joint_names: ['{joint}'], transforms: [{transform}]}}}}"
        );
        Ok(NamedState::list_from_text(&text, robot)?.states.remove(0))
    }

    #[test]
    fn transforms_of_joints_that_the_robot_does_not_have_are_rejected_by_name() {
        for robot in [robot(), mounted()] {
            for joint in ["Drive", "drive/x", "world_joint", "base", "mount", ""] {
                for moved in
                    ["{translation: {x: 5}}", "{translation: {z: 1.0e-6}}", "{rotation: {z: 1, w: 0}}"]
                {
                    let why = read(&robot, "", joint, moved).unwrap_err();
                    assert!(
                        why.contains("multi_dof_joint_state") && why.contains(&format!("'{joint}'")),
                        "{why}"
                    );
                }
                // the robot is already there
                for still in ["{}", "{rotation: {w: -1}}"] {
                    assert!(read(&robot, "", joint, still).unwrap().names.is_empty(), "{joint}");
                }
            }
        }
        let why = read(&mounted(), "map", "mount", "{translation: {x: 5}}").unwrap_err();
        assert!(why.contains("virtual joint 'mount'") && why.contains("--world"), "{why}");
        let why = read(&robot(), "", "Drive", "{translation: {x: 5}}").unwrap_err();
        assert!(why.contains("planar or floating are drive, fly"), "{why}");
    }

    #[test]
    fn transforms_are_in_the_frame_of_the_root_as_in_scenes() {
        for joint in ["drive", "fly"] {
            let x = "{translation: {x: 1}}";
            for (robot, frame) in [(robot(), ""), (robot(), "base"), (robot(), "/base"), (mounted(), "map")] {
                assert_eq!(read(&robot, frame, joint, x).unwrap().positions[0], 1.0, "{frame}");
            }
            for frame in ["map", "elsewhere", "a"] {
                let why = read(&robot(), frame, joint, x).unwrap_err();
                assert!(why.contains(&format!("'{frame}'")) && why.contains("'base'"), "{why}");
            }
        }
    }

    #[test]
    fn planar_joints_stay_in_their_plane_as_in_scenes() {
        let robot = robot();
        for off in
            ["{translation: {z: 1.0e-5}}", "{translation: {z: 9.0e-4}}", "{rotation: {x: 0.00045, w: 1}}"]
        {
            let why = read(&robot, "", "drive", off).unwrap_err();
            assert!(why.contains("'drive'") && why.contains("leaves its plane"), "{why}");
        }
        assert!(read(&robot, "", "drive", "{translation: {x: 1, z: 1.0e-7}}").is_ok());
    }
}
