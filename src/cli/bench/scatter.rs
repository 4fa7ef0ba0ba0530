//! Random box obstacles around a robot.

use clearance::geometry::math::{Pose, Rotation, Vector};
use clearance::geometry::{Primitive, Shape};
use clearance::proximity::bvh::AxisBox;
use clearance::scene::{Obstacle, World};

use crate::cli::failure::Failure;
use crate::cli::run_args::internal;

/// Obstacles per cubic metre.
const DENSITY: f64 = 2.0;

/// Range of the edge lengths of obstacles (m).
const EDGES: [f64; 2] = [0.05, 0.2];

/// Minimum distance of obstacles from the root's origin (m), where the base is.
const KEPT_FREE: f64 = 0.3;

/// Bounding box of all boxes.
pub fn around<'b>(boxes: impl IntoIterator<Item = &'b AxisBox>) -> AxisBox {
    boxes.into_iter().fold(AxisBox::EMPTY, |all, one| all.union(one))
}

/// A number of boxes in a cube around a region; the density is the same everywhere.
pub fn boxes(count: u32, region: &AxisBox, random: &mut fastrand::Rng) -> Result<World, Failure> {
    let middle = Vector::from(region.doubled_centre().map(f64::from)) * 0.5;
    let half_edge = 0.5 * (f64::from(count) / DENSITY).cbrt();
    let mut world = World::default();
    let mut number = 0;
    while number < count {
        let mut within = |size: f64| size * (2.0 * random.f64() - 1.0);
        let at = middle + Vector::new(within(half_edge), within(half_edge), within(half_edge));
        if at.norm() < KEPT_FREE {
            continue;
        }
        let turn = Rotation::from_scaled_axis(Vector::new(within(2.0), within(2.0), within(2.0)));
        let mut edge = || EDGES[0] + (EDGES[1] - EDGES[0]) * random.f64();
        let cuboid = Primitive::cuboid([edge(), edge(), edge()]).map_err(internal)?;
        let pose = Pose::from_parts(at.into(), turn);
        world
            .add(Obstacle::of_shape(format!("box_{number}"), pose, Shape::Primitive(cuboid)))
            .map_err(internal)?;
        number += 1;
    }
    Ok(world)
}
