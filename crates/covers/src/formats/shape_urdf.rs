//! Writer of a URDF with capsules or boxes as collision geometry.

use clearance_robot::RobotModel;

use crate::cover_shape::{CoverShape, ShapeSize};
use crate::formats::collision_elements::{Element, elements_text, with_collisions};
use crate::formats::text::number;
use crate::options::CoverError;
use crate::shape_cover::ShapeCover;

/// The URDF text of a robot with its collision elements replaced by the shapes of a cover. A capsule, which URDF does not have, is a cylinder
/// and two spheres. All else is unchanged.
///
/// # Errors
/// If the text is not the one that the robot was read from: its number of links differs, or it ends within an element.
pub fn shape_urdf(robot: &RobotModel, cover: &ShapeCover, urdf: &str) -> Result<String, CoverError> {
    with_collisions(robot, urdf, |id| {
        let shapes = &cover.links.iter().find(|link| link.link == id)?.shapes;
        let name = robot.described_name(id);
        let elements = shapes.iter().enumerate().flat_map(|(i, (shape, _))| elements_of(name, i, shape));
        Some(elements_text(elements))
    })
}

fn elements_of(link: &str, i: usize, shape: &CoverShape) -> Vec<Element> {
    let xyz = |p: clearance_geometry::math::Point| [p.x, p.y, p.z];
    let pose = [xyz(shape.centre), shape.rpy];
    match shape.size {
        ShapeSize::Box { half_extents } => {
            let size = half_extents.map(|half| number(2.0 * half)).join(" ");
            let geometry = format!("<box size=\"{size}\"/>");
            vec![Element { name: format!("{link}_box_{i}"), pose, geometry }]
        }
        ShapeSize::Capsule { radius, half_length } => {
            let (radius, length) = (number(radius), number(2.0 * half_length));
            let name = |part: &str| format!("{link}_capsule_{i}_{part}");
            let end = |part: &str, side: f64| Element {
                name: name(part),
                pose: [xyz(shape.end(side)), [0.0; 3]],
                geometry: format!("<sphere radius=\"{radius}\"/>"),
            };
            // a cylinder without length is none
            let has_length = half_length > 0.0;
            let cylinder = has_length.then(|| Element {
                name: name("cylinder"),
                pose,
                geometry: format!("<cylinder radius=\"{radius}\" length=\"{length}\"/>"),
            });
            let upper = has_length.then(|| end("upper", 1.0));
            cylinder.into_iter().chain([end("lower", -1.0)]).chain(upper).collect()
        }
    }
}
