//! Test helper: a random world of a plane, a cone, a point cloud and voxels.

use clearance::geometry::math::{Pose, Vector};
use clearance::geometry::{Primitive, Shape};
use clearance::scene::{Obstacle, ObstacleShape, World};

use crate::random::Random;

/// A floor, a cone, a cloud, voxels, and a thing made of several, some `distance` (m) around the origin.
pub fn world(random: &mut Random, distance: f64) -> World {
    let mut world = World::default();
    let mut add = |name: &str, shapes: Vec<ObstacleShape>| {
        world.add(Obstacle::new(name, shapes)).unwrap();
    };
    let floor = Pose::from_parts(Vector::new(0.0, 0.0, -0.7 * distance).into(), nalgebra::one());
    let tilt = Shape::Plane(clearance::geometry::Plane::from_coefficients([0.1, 0.05, 1.0, 0.0]).unwrap());
    add("floor", vec![ObstacleShape { pose_os: floor, shape: tilt.clone() }]);
    let mut around = || {
        let away = random.vector(1.0).normalize() * distance;
        Pose::from_parts(away.into(), random.rotation())
    };
    let places = [around(), around(), around(), around()];
    let size = 0.3 * distance;
    let cone = Shape::Primitive(Primitive::cone(0.5 * size, size).unwrap());
    add("cone", vec![ObstacleShape { pose_os: places[0], shape: cone.clone() }]);
    let points = random.points(400, size, 0.02 * distance);
    add("cloud", vec![ObstacleShape { pose_os: places[1], shape: points }]);
    let voxels = random.voxels(200, size, 0.05 * distance);
    add("voxels", vec![ObstacleShape { pose_os: places[2], shape: voxels }]);
    let several = [cone, random.points(50, size, 0.0), random.voxels(50, size, 0.05 * distance)];
    let placed = |shape: Shape| ObstacleShape { pose_os: places[3], shape };
    add(
        "several",
        several.into_iter().map(placed).chain([ObstacleShape { pose_os: floor, shape: tilt }]).collect(),
    );
    world
}
