//! Test helper: random robots, worlds and motions.

use std::fmt::Write;
use std::sync::Arc;

use clearance_geometry::math::{Point, Pose, Vector};
use clearance_geometry::testing::Random;
use clearance_geometry::{Cube, Plane, PointCloud, Primitive, Shape, TriangleMesh, Voxels};
use clearance_motion::{MotionSegment, MovingObstacle, ObstacleLimits, ObstacleUncertainty, SpeedLimit};
use clearance_robot::{JointKind, MeshFiles, RobotModel};
use clearance_scene::{Obstacle, World};

use crate::element::Element;

/// A tree of links with joints of all kinds, some of which follow others.
pub fn robot(random: &mut Random, kinds: &[&str]) -> RobotModel {
    let mut text = "<robot name='tree'>".to_owned();
    let links = 3 + random.below(5);
    for i in 0..links {
        let shapes: String = (0..=random.below(2)).map(|_| shape(random)).collect();
        write!(text, "<link name='l{i}'>{shapes}</link>").unwrap();
    }
    let mut leader = None;
    for i in 1..links {
        let kind = kinds[random.below(kinds.len())];
        // mostly a chain
        let parent = if random.below(3) == 0 { random.below(i) } else { i - 1 };
        let [xyz, rpy, axis] = [0.4, 3.0, 1.0].map(|extent| numbers(&random.vector(extent)));
        write!(text, "<joint name='j{i}' type='{kind}'><parent link='l{parent}'/><child link='l{i}'/>")
            .unwrap();
        write!(text, "<origin xyz='{xyz}' rpy='{rpy}'/><axis xyz='{axis}'/>").unwrap();
        text.push_str("<limit lower='-3' upper='3' effort='1' velocity='1'/>");
        if matches!(kind, "revolute" | "continuous" | "prismatic") {
            match leader {
                Some(joint) if random.below(3) == 0 => {
                    let (multiplier, offset) = (random.within(2.0), random.within(1.0));
                    write!(text, "<mimic joint='j{joint}' multiplier='{multiplier}' offset='{offset}'/>")
                        .unwrap();
                }
                _ => leader = Some(i),
            }
        }
        text.push_str("</joint>");
    }
    text.push_str("</robot>");
    RobotModel::from_urdf(&text, &MeshFiles::default()).unwrap_or_else(|e| panic!("{e}: {text}"))
}

pub const ALL_KINDS: [&str; 6] = ["fixed", "revolute", "continuous", "prismatic", "planar", "floating"];

fn numbers(v: &Vector) -> String {
    format!("{} {} {}", v.x, v.y, v.z)
}

fn shape(random: &mut Random) -> String {
    let mut length = || 0.02 + random.within(0.1).abs();
    let geometry = match [length(), length(), length()] {
        [x, y, z] if x < 0.06 => format!("<box size='{x} {y} {z}'/>"),
        [r, l, _] if l < 0.06 => format!("<cylinder radius='{r}' length='{}'/>", 3.0 * l),
        [r, ..] => format!("<sphere radius='{}'/>", 0.5 * r),
    };
    let [xyz, rpy] = [0.1, 3.0].map(|extent| numbers(&random.vector(extent)));
    format!("<collision><origin xyz='{xyz}' rpy='{rpy}'/><geometry>{geometry}</geometry></collision>")
}

/// A closed mesh of eight triangles, long or flat.
pub fn mesh(random: &mut Random, extent: f64) -> Shape {
    let [x, y, z] = [0, 1, 2].map(|_| extent * (0.05 + random.within(1.0).abs()));
    let corners = [[x, 0., 0.], [-x, 0., 0.], [0., y, 0.], [0., -y, 0.], [0., 0., z], [0., 0., -z]];
    eight_faces(corners.map(|c| Point::from(c) + random.vector(0.2 * extent)))
}

/// A closed mesh over the ends of three crossing lines.
pub fn eight_faces(corners: [Point; 6]) -> Shape {
    let mut faces = Vec::new();
    for top in [4, 5] {
        for (a, b) in [(0, 2), (2, 1), (1, 3), (3, 0)] {
            faces.push(if top == 4 { [a, b, top] } else { [b, a, top] });
        }
    }
    Shape::Mesh(Arc::new(TriangleMesh::new(corners.to_vec(), faces).unwrap()))
}

/// A primitive of any kind.
pub fn primitive(random: &mut Random, extent: f64) -> Shape {
    let [x, y, z] = [0, 1, 2].map(|_| extent * (0.05 + random.within(1.0).abs()));
    Shape::Primitive(match random.below(5) {
        0 => Primitive::Box { half_extents: [x, y, z] },
        1 => Primitive::Sphere { radius: x },
        2 => Primitive::Capsule { radius: x, half_length: y },
        3 => Primitive::Cone { radius: x, half_length: y },
        _ => Primitive::Cylinder { radius: x, half_length: y },
    })
}

/// A few points or cubes.
#[allow(clippy::cast_possible_truncation)]
pub fn grains(random: &mut Random, extent: f64) -> Shape {
    let centres: Vec<[f32; 3]> =
        (0..=random.below(20)).map(|_| <[f64; 3]>::from(random.vector(extent)).map(|c| c as f32)).collect();
    if random.below(2) == 0 {
        let cloud = PointCloud::new(centres, 0.3 * random.within(extent).abs());
        return Shape::Points(Arc::new(cloud.unwrap()));
    }
    let half_edge = |random: &mut Random| 0.3 * random.within(extent).abs() as f32;
    let cubes = centres.into_iter().map(|centre| Cube { centre, half_edge: half_edge(random) });
    Shape::Voxels(Arc::new(Voxels::new(cubes.collect()).unwrap()))
}

/// A plane somewhere near the origin.
pub fn plane(random: &mut Random, extent: f64) -> Shape {
    Shape::Plane(Plane { normal: random.direction(), offset: random.within(extent) })
}

/// A primitive, a mesh and some grains, somewhere around the robot.
pub fn world(random: &mut Random, distance: f64) -> World {
    let mut world = World::default();
    let shapes = [primitive(random, 0.1), mesh(random, 0.1), grains(random, 0.1)];
    for (shape, name) in shapes.into_iter().zip(["solid", "mesh", "grains"]) {
        let away = random.direction().into_inner() * distance;
        let pose_rs = Pose::from_parts((away + random.vector(0.2)).into(), random.rotation());
        world.add(Obstacle::of_shape(name, pose_rs, shape)).unwrap();
    }
    world
}

/// Positions of a configuration.
pub fn positions(random: &mut Random, robot: &RobotModel, extent: f64) -> Vec<f64> {
    let mut positions: Vec<f64> = robot.position_names().iter().map(|_| random.within(extent)).collect();
    for id in robot.joint_ids() {
        if let (JointKind::Floating, Some(first)) = (&robot.joint(id).kind, robot.first_position(id)) {
            positions[first + 3..first + 7].copy_from_slice(random.rotation().coords.as_slice());
        }
    }
    positions
}

fn is_floating(robot: &RobotModel) -> Vec<bool> {
    let mut floating = vec![false; robot.position_names().len()];
    for id in robot.joint_ids() {
        if let (JointKind::Floating, Some(first)) = (&robot.joint(id).kind, robot.first_position(id)) {
            floating[first..first + 7].fill(true);
        }
    }
    floating
}

/// A straight or bent motion, sometimes with a tube, sometimes with obstacles that move.
pub fn motion(random: &mut Random, robot: &RobotModel, extent: f64) -> MotionSegment {
    let (from, change) = (positions(random, robot, 2.0), positions(random, robot, extent));
    let floating = is_floating(robot);
    let motion = if random.below(2) == 0 {
        let ends = from.iter().zip(&change).zip(&floating);
        let to: Vec<f64> = ends.map(|((a, d), floats)| if *floats { *d } else { a + d }).collect();
        let [from, to] = [&from, &to].map(|q| robot.configuration(q).unwrap());
        MotionSegment::straight(robot, &from, &to)
    } else {
        let bent = from.iter().zip(&floating).map(|(a, floats)| {
            let c = [0; 5].map(|_| if *floats { 0.0 } else { random.within(extent) });
            [*a, c[0], c[1], c[2], c[3], c[4]]
        });
        let bent = bent.collect();
        MotionSegment::polynomial(robot, bent).unwrap()
    };
    let motion = if random.below(2) == 0 {
        let tube =
            floating.iter().map(|floats| if *floats { 0.0 } else { random.within(0.05).abs() }).collect();
        motion.with_tube(robot, tube).unwrap()
    } else {
        motion
    };
    let mover = |name: &str, random: &mut Random| MovingObstacle {
        name: name.to_owned(),
        centre: random.vector(0.5).into(),
        linear: random.vector(extent).into(),
        angular: random.vector(extent).into(),
        start: None,
    };
    let motion = if random.below(4) == 0 {
        let limit = |random: &mut Random| SpeedLimit {
            speed: random.within(extent).abs(),
            acceleration: random.within(extent).abs(),
        };
        let by_name = [("mesh".to_owned(), limit(random))].into();
        let limits = ObstacleLimits { default: limit(random), by_name };
        let latency = [0.0, 0.25][random.below(2)];
        let time = [latency, latency + 1.0];
        motion.with_uncertainty(ObstacleUncertainty::new(Arc::new(limits), time).unwrap())
    } else {
        motion
    };
    match random.below(4) {
        0 => motion.with_movers(vec![mover("mesh", random), mover("solid", random)]).unwrap(),
        1 => {
            let [from, to] = [0, 1].map(|_| random.pose(0.3));
            let between = MovingObstacle::between("mesh", Point::from(random.vector(0.5)), &from, &to);
            motion.with_movers(vec![between]).unwrap()
        }
        _ => motion,
    }
}

/// A point of an element.
pub fn point_of(random: &mut Random, element: &Element) -> Point {
    let n = random.direction();
    match element {
        Element::Triangle(t) => {
            let [u, v, w] =
                [0, 1, 2].map(|_| random.within(1.0).abs() * f64::from(u8::from(random.below(3) > 0)));
            let sum = u + v + w;
            if sum == 0.0 {
                t.a
            } else {
                Point::from((t.a.coords * u + t.b.coords * v + t.c.coords * w) / sum)
            }
        }
        Element::Solid(_) | Element::Cone(_) => element.extreme(&n) + n.into_inner() * element.ball(),
    }
}
