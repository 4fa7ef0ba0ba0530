//! Name prefixes: one of several equal robots, with its own names of joints and links.

use super::RobotModel;

impl RobotModel {
    /// The same robot with prefixes for the names of its joints and links. Names of groups, and of frames outside of the robot, are
    /// unchanged.
    #[must_use]
    pub fn with_prefixes(mut self, of_joints: &str, of_links: &str) -> Self {
        let rename = |name: &mut String, prefix: &str| name.insert_str(0, prefix);
        self.joints.iter_mut().for_each(|joint| rename(&mut joint.name, of_joints));
        self.position_names.iter_mut().for_each(|name| rename(name, of_joints));
        self.links.iter_mut().for_each(|link| rename(&mut link.name, of_links));
        self.link_prefix.insert_str(0, of_links);
        self
    }
}

#[cfg(test)]
mod tests {
    use crate::{MeshFiles, RobotModel};

    #[test]
    fn joints_and_links_are_renamed_and_nothing_else() {
        let text = include_str!("../../../urdf/two_link/two_link.urdf");
        let plain = RobotModel::from_urdf(text, &MeshFiles::default()).unwrap();
        let left = plain.clone().with_prefixes("left_", "left/");
        assert_eq!(left.position_names(), ["left_joint1", "left_joint2"]);
        assert!(left.joint_by_name("left_joint1").is_some() && left.joint_by_name("joint1").is_none());
        assert_eq!(left.link(left.root()).name, "left/base");
        assert_eq!(left.described_name(left.root()), "base");
        assert_eq!(left.name(), plain.name());
        let q = left.configuration_from_names([("left_joint2", 1.0)]).unwrap();
        assert_eq!(q, plain.configuration_from_names([("joint2", 1.0)]).unwrap());
    }
}
