//! Lookup of joints by name, and error messages: of unknown joints and objects, and with names of arguments.

use clearance::robot::{JointId, RobotModel};
use clearance::scene::Scene;

/// The joint of this name.
///
/// # Errors
/// If the robot has no such joint; the text says whether the name is that of a position.
pub fn find_joint(robot: &RobotModel, name: &str) -> Result<JointId, String> {
    let is_position = || robot.position_names().iter().any(|position| position == name);
    let of_joint = || name.rsplit_once('/').filter(|_| is_position()).map(|(joint, _)| joint);
    robot.joint_by_name(name).ok_or_else(|| match of_joint() {
        Some(joint) => format!("'{name}' is a position of joint '{joint}': give the joint"),
        None => format!("the robot has no joint '{name}'"),
    })
}

/// Why a scene has no obstacle of this name.
#[must_use]
pub fn why_no_obstacle(scene: &Scene, name: &str) -> String {
    match scene.world.attached_by_name(name) {
        Some(held) => {
            let link = &held.link;
            format!("object '{name}' is attached to link '{link}', and is no obstacle: detach it first")
        }
        None => format!("there is no object '{name}'"),
    }
}

/// The text of an error of the library, with an argument of a binding instead of the option of the command line.
#[must_use]
pub fn with_package_paths(text: &str, argument: &str) -> String {
    let text = text.replace("with --package-path DIR", &format!("as DIR in {argument}"));
    text.replace("with --package-path", &format!("in {argument}"))
}

#[cfg(test)]
mod tests {
    use clearance::robot::MeshFiles;

    use super::*;

    const URDF: &str = "<robot name='r'><link name='world'/><link name='base'/>
        <joint name='drive' type='planar'><parent link='world'/><child link='base'/><axis xyz='0 0 1'/></joint></robot>";

    #[test]
    fn a_position_is_told_from_a_joint() {
        let robot = RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap();
        assert_eq!(find_joint(&robot, "drive"), Ok(robot.joint_by_name("drive").unwrap()));
        let why = |name: &str| find_joint(&robot, name).unwrap_err();
        assert_eq!(why("drive/x"), "'drive/x' is a position of joint 'drive': give the joint");
        assert_eq!(why("drive/y/x"), "the robot has no joint 'drive/y/x'");
        assert_eq!(why("arm"), "the robot has no joint 'arm'");
    }
}
