//! Writer of sphere covers in the Extended Robot Description Format (XRDF 1.0) of Isaac.

use std::fmt::Write;

use crate::formats::text::{number, quoted, spheres_by_link};
use crate::sphere_cover::SphereCover;
use clearance_robot::{JointKind, RobotModel};

/// Name of the group of spheres.
const GROUP: &str = "clearance_spheres";

/// Limits of joints, which URDF does not have (rad/s² or m/s², rad/s³ or m/s³): cuRobo's defaults.
const ACCELERATION: f64 = 15.0;
const JERK: f64 = 500.0;

/// XRDF file with the spheres, for collisions with the world and with the robot itself.
///
/// URDF has no accelerations, jerks and tool frames. The file has cuRobo's default limits, and as tool frames the links without children; check
/// them. The pairs of links that the SRDF disables are ignored.
#[must_use]
pub fn xrdf(robot: &RobotModel, cover: &SphereCover) -> String {
    let mut text = String::from("format: xrdf\nformat_version: 1.0\n\n");
    let moving = || {
        robot.joints().iter().filter(|joint| {
            joint.mimic.is_none()
                && matches!(
                    joint.kind,
                    JointKind::Revolute(_) | JointKind::Continuous(_) | JointKind::Prismatic(_)
                )
        })
    };
    let list = |items: Vec<String>| format!("[{}]", items.join(", "));
    // writing to a string does not fail
    let _ = writeln!(text, "cspace:\n  joint_names: {}", list(moving().map(|j| quoted(&j.name)).collect()));
    let limits = |limit: f64| list(moving().map(|_| number(limit)).collect());
    let _ =
        writeln!(text, "  acceleration_limits: {}\n  jerk_limits: {}", limits(ACCELERATION), limits(JERK));
    let is_leaf = |link: clearance_robot::LinkId| robot.joints().iter().all(|joint| joint.parent != link);
    let leaves = robot.link_ids().filter(|link| is_leaf(*link));
    let _ = writeln!(
        text,
        "\ntool_frames: {}",
        list(leaves.map(|link| quoted(robot.described_name(link))).collect())
    );
    let _ = writeln!(text, "\ncollision:\n  geometry: {GROUP}\n\nself_collision:\n  geometry: {GROUP}");
    text.push_str(&ignored(robot));
    let _ =
        write!(text, "\ngeometry:\n  {GROUP}:\n    spheres:\n{}", spheres_by_link(robot, cover, "      "));
    text
}

/// The pairs of links that the SRDF disables, by their first link.
fn ignored(robot: &RobotModel) -> String {
    let Some(srdf) = robot.srdf() else { return String::new() };
    let mut text = String::new();
    for first in robot.link_ids() {
        let others = srdf.disabled_pairs.iter().filter(|pair| pair.a == first);
        let names: Vec<String> = others.map(|pair| quoted(robot.described_name(pair.b))).collect();
        if !names.is_empty() {
            let _ = writeln!(text, "    {}: [{}]", quoted(robot.described_name(first)), names.join(", "));
        }
    }
    if text.is_empty() { text } else { format!("  ignore:\n{text}") }
}
