//! Test helper: random robots, worlds, states and motions.

use std::sync::Arc;

use clearance_geometry::math::{Point, Pose, Rotation, Vector};
use clearance_geometry::testing::Random;
use clearance_geometry::{Plane, Primitive, Shape, TriangleMesh};
use clearance_motion::{MotionSegment, ObstacleLimits, ObstacleUncertainty, SpeedLimit};
use clearance_robot::{Configuration, MeshFiles, RobotModel};
use clearance_scene::{AttachedObject, Obstacle, ObstacleShape, Settings, World};

use crate::CollisionChecker;

/// Lengths are multiples of this (m), so that many bodies touch exactly.
pub const GRID: f64 = 0.05;

/// A checker of a random robot in a random world.
pub fn checker(random: &mut Random) -> CollisionChecker {
    let (robot, world) = (Arc::new(robot(random)), world(random));
    CollisionChecker::new(robot, &world, settings(random)).unwrap()
}

/// A random state.
pub fn state(robot: &RobotModel, random: &mut Random) -> Configuration {
    let positions: Vec<f64> = robot.position_names().iter().map(|_| coordinate(random, 1.0)).collect();
    robot.configuration(&positions).unwrap()
}

/// A curved motion from a state.
pub fn curved_motion(robot: &RobotModel, from: &Configuration, random: &mut Random) -> MotionSegment {
    let polynomial = |q: &f64| [*q, random.within(0.3), random.within(0.3), random.within(0.1), 0.0, 0.0];
    MotionSegment::polynomial(robot, from.positions().iter().map(polynomial).collect()).unwrap()
}

/// A motion during which obstacles may move: all, or only one of them.
pub fn with_uncertainty(motion: MotionSegment, random: &mut Random) -> MotionSegment {
    let limit = |random: &mut Random| SpeedLimit {
        speed: [0.0, 0.01, 0.1][random.below(3)],
        acceleration: [0.0, 0.1][random.below(2)],
    };
    let default = if random.below(2) == 0 { SpeedLimit::default() } else { limit(random) };
    let limits = Arc::new(ObstacleLimits { default, by_name: [("o0".to_owned(), limit(random))].into() });
    let latency = [0.0, 0.1][random.below(2)];
    motion.with_uncertainty(ObstacleUncertainty::new(limits, [latency, latency + 1.0]).unwrap())
}

/// A multiple of [`GRID`], or any number.
pub fn coordinate(random: &mut Random, extent: f64) -> f64 {
    let any = random.within(extent);
    if random.below(3) == 0 { any } else { (any / GRID).round() * GRID }
}

fn pose(random: &mut Random, extent: f64) -> Pose {
    let place = Vector::from_fn(|_, _| coordinate(random, extent));
    let turn = if random.below(2) == 0 { Rotation::identity() } else { random.rotation() };
    Pose::from_parts(place.into(), turn)
}

fn shape(random: &mut Random) -> Shape {
    let size = |random: &mut Random| [0.05, 0.1, 0.15][random.below(3)];
    match random.below(9) {
        0 => Shape::Primitive(Primitive::Sphere { radius: size(random) }),
        1 => Shape::Primitive(Primitive::Cylinder { radius: size(random), half_length: size(random) }),
        2..4 => {
            let corners = (0..18).map(|_| Point::from(random.vector(0.2))).collect();
            let faces = (0..6).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
            Shape::Mesh(Arc::new(TriangleMesh::new(corners, faces).unwrap()))
        }
        4 if random.below(8) == 0 => Shape::Plane(Plane::from_coefficients([0.0, 0.1, 1.0, 0.7]).unwrap()),
        _ => Shape::Primitive(Primitive::Box { half_extents: [0; 3].map(|_| size(random)) }),
    }
}

/// A tree of links of boxes and balls.
pub fn robot(random: &mut Random) -> RobotModel {
    let links = 1 + random.below(7);
    let elements: String = (0..links).map(|i| link(i, random)).collect();
    let joints: String = (1..links).map(|i| joint(i, random)).collect();
    RobotModel::from_urdf(&format!("<robot name='r'>{elements}{joints}</robot>"), &MeshFiles::default())
        .unwrap()
}

fn link(index: usize, random: &mut Random) -> String {
    let geometry = match random.below(5) {
        0 => return format!("<link name='l{index}'/>"),
        1 => "<sphere radius='0.1'/>".to_owned(),
        _ => {
            let [x, y, z] = [0; 3].map(|_| [0.1, 0.2, 0.3][random.below(3)]);
            format!("<box size='{x} {y} {z}'/>")
        }
    };
    let [x, y, z] = [0; 3].map(|_| coordinate(random, 0.1));
    format!(
        "<link name='l{index}'><collision><origin xyz='{x} {y} {z}'/><geometry>{geometry}</geometry></collision></link>"
    )
}

/// The joint between a link and one of the links before it.
fn joint(index: usize, random: &mut Random) -> String {
    let parent = random.below(index);
    let kind = ["revolute", "continuous", "prismatic", "prismatic", "fixed"][random.below(5)];
    let [x, y, z] = [0; 3].map(|_| coordinate(random, 0.4));
    let axis = ["1 0 0", "0 1 0", "0 0 1"][random.below(3)];
    format!(
        "<joint name='j{index}' type='{kind}'><parent link='l{parent}'/><child link='l{index}'/><origin xyz='{x} {y} {z}'/>
         <axis xyz='{axis}'/><limit lower='-2' upper='2' effort='1' velocity='1'/></joint>"
    )
}

/// Obstacles of any shape around a robot, and objects attached to it.
pub fn world(random: &mut Random) -> World {
    let mut world = World::default();
    for obstacle in 0..[0, 1, 3, 8][random.below(4)] {
        let of = |random: &mut Random| ObstacleShape { pose_os: pose(random, 0.1), shape: shape(random) };
        let shapes: Vec<_> = (0..=random.below(2)).map(|_| of(random)).collect();
        let placed = Obstacle { pose_ro: pose(random, 0.9), ..Obstacle::new(format!("o{obstacle}"), shapes) };
        world.add(placed).unwrap();
    }
    for attached in 0..[0, 0, 1, 2][random.below(4)] {
        let object = Obstacle::of_shape(format!("a{attached}"), pose(random, 0.3), shape(random));
        world.attach(AttachedObject::grasped(&object, "l0", &pose(random, 0.2), Vec::new())).unwrap();
    }
    world
}

/// Paddings, mostly none.
pub fn settings(random: &mut Random) -> Settings {
    let padding = [0.0, 0.0, 1e-7, GRID, 0.03][random.below(5)];
    let mut settings = Settings { padding, pad_self: random.below(2) == 0, ..Settings::default() };
    if random.below(3) == 0 {
        settings.link_padding.insert("l0".to_owned(), GRID);
    }
    if random.below(3) == 0 {
        settings.object_padding.insert("o0".to_owned(), 0.02);
    }
    settings
}
