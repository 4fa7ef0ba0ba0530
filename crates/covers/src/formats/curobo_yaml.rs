//! Writer of sphere covers for cuRobo: the content of `collision_spheres` of a robot configuration.

use crate::formats::text::spheres_by_link;
use crate::sphere_cover::SphereCover;
use clearance_robot::RobotModel;

/// YAML file with `collision_spheres`, as the entry of this name in a cuRobo configuration names it.
#[must_use]
pub fn curobo_yaml(robot: &RobotModel, cover: &SphereCover) -> String {
    format!("collision_spheres:\n{}", spheres_by_link(robot, cover, "  "))
}
