//! Test helper: an arm with a tool, for the tests of this crate.

use clearance_robot::{MeshFiles, RobotModel, RobotText};

/// An arm that turns about z a metre above its base, with a tool a metre along its x.
pub fn robot() -> RobotModel {
    robot_on("fixed")
}

/// The same arm on a virtual joint of this kind.
pub fn robot_on(virtual_joint: &str) -> RobotModel {
    let fixed = |name: &str, parent: &str, child: &str, xyz: &str| {
        format!(
            "<joint name='{name}' type='fixed'><parent link='{parent}'/><child link='{child}'/><origin xyz='{xyz}'/></joint>"
        )
    };
    let urdf = format!(
        "<robot name='r'><link name='base'/><link name='mount'/><link name='arm'/><link name='tool'/>
        <joint name='j' type='continuous'><parent link='base'/><child link='arm'/><origin xyz='0 0 1'/><axis xyz='0 0 1'/></joint>
        {}{}</robot>",
        fixed("m", "base", "mount", "0 0 0.5"),
        fixed("t", "arm", "tool", "1 0 0")
    );
    let srdf = format!(
        "<robot name='r'><virtual_joint name='stand' type='{virtual_joint}' parent_frame='world' child_link='base'/></robot>"
    );
    let text = RobotText { urdf: &urdf, urdf_name: None, srdf: Some(&srdf), srdf_name: None };
    RobotModel::from_text(&text, &MeshFiles::default()).unwrap_or_else(|e| panic!("{e}"))
}
