//! Meshes that cannot be solid.

use crate::geometry::Shape;
use crate::robot::RobotModel;
use crate::world::World;

/// Names of the meshes that are not closed, hence stay surfaces even where meshes are solid.
#[must_use]
pub fn open_meshes(robot: &RobotModel, world: &World) -> Vec<String> {
    let is_open = |shape: &Shape| matches!(shape, Shape::Mesh(m) if !m.is_closed());
    let of_links = robot.links().iter().flat_map(|link| {
        (link.collisions.iter().enumerate())
            .filter(|(_, c)| is_open(&c.shape))
            .map(|(i, _)| format!("mesh of link '{}' (collision {i})", link.name))
    });
    let of_obstacles = world.obstacles().flat_map(|obstacle| {
        (obstacle.shapes.iter().enumerate())
            .filter(|(_, s)| is_open(&s.shape))
            .map(|(i, _)| format!("mesh {i} of object '{}'", obstacle.name))
    });
    let of_attached = world.attached().iter().flat_map(|object| {
        (object.shapes.iter().enumerate())
            .filter(|(_, s)| is_open(&s.shape))
            .map(|(i, _)| format!("mesh {i} of attached object '{}'", object.name))
    });
    of_links.chain(of_obstacles).chain(of_attached).collect()
}
