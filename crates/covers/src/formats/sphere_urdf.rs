//! Writer of a URDF with spheres as collision geometry, as VAMP and foam read it.

use clearance_robot::RobotModel;

use crate::formats::collision_elements::{Element, elements_text, with_collisions};
use crate::formats::text::number;
use crate::options::CoverError;
use crate::sphere_cover::{CoverSphere, LinkCover, SphereCover};

/// The URDF text of a robot with its collision elements replaced by the spheres of a cover. All else is unchanged; a link without spheres
/// gets no collision element.
///
/// # Errors
/// If the text is not the one that the robot was read from: its number of links differs, or it ends within an element.
pub fn sphere_urdf(robot: &RobotModel, cover: &SphereCover, urdf: &str) -> Result<String, CoverError> {
    with_collisions(robot, urdf, |id| {
        let link = cover.links.iter().find(|link| link.link == id)?;
        Some(collision_elements(robot.described_name(id), link))
    })
}

fn collision_elements(name: &str, link: &LinkCover) -> String {
    let spheres = link.spheres.iter().enumerate().map(|(i, CoverSphere { centre, radius, .. })| Element {
        name: format!("{name}_sphere_{i}"),
        pose: [[centre.x, centre.y, centre.z], [0.0; 3]],
        geometry: format!("<sphere radius=\"{}\"/>", number(*radius)),
    });
    elements_text(spheres)
}
