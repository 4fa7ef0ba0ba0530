//! Test helper: samples the motion of a certificate for contacts of balls and boxes, with geometry of its own.

use std::collections::HashMap;

use clearance::geometry::math::{Point, Pose, Rotation, Vector};
use clearance::geometry::{Primitive, Shape};
use clearance::motion::{Certificate, MovingObstacle, SegmentText};
use clearance::robot::{JointKind, LinkPoses};

use super::Scene;
use crate::random::Random;

/// Between two samples nothing moves farther (m), as long as there are few enough.
const STEP: f64 = 4e-3;

/// Halvings of one of the first pieces.
const MOST_HALVINGS: u32 = 8;

/// Pieces of a segment to begin with.
const PIECES: u32 = 48;

/// Of a pair one is a ball.
#[derive(Clone, Copy, Debug)]
enum Solid {
    Ball(f64),
    /// Half extents (m); a sheet has one that is zero.
    Cuboid([f64; 3]),
}

#[derive(Clone, Copy, Debug)]
enum Carrier {
    Link(usize),
    Obstacle(usize),
}

struct Body {
    carrier: Carrier,
    pose: Pose,
    solid: Solid,
}

/// The bodies of a scene, by name, and the pairs that have to stay apart.
pub struct Room<'s> {
    scene: &'s Scene,
    obstacles: Vec<String>,
    pairs: Vec<([Vec<Body>; 2], f64)>,
    floating: Vec<usize>,
}

impl<'s> Room<'s> {
    /// The pairs are those of a certificate that the verifier accepts.
    pub fn new(scene: &'s Scene, pairs: &[[String; 2]]) -> Self {
        let Scene { robot, world, settings, .. } = scene;
        let obstacles: Vec<String> = world.obstacles().map(|o| o.name.clone()).collect();
        let bodies = |name: &str| -> Vec<Body> {
            if let Some(link) = robot.links().iter().position(|link| link.name == name) {
                let shapes = &robot.links()[link].collisions;
                return shapes.iter().map(|c| body(Carrier::Link(link), c.pose_ls, &c.shape)).collect();
            }
            if let Some(held) = world.attached_by_name(name) {
                let link = robot.link_by_name(&held.link).unwrap().index();
                let shapes = held.shapes.iter();
                return shapes
                    .map(|s| body(Carrier::Link(link), held.pose_lo * s.pose_os, &s.shape))
                    .collect();
            }
            let place = obstacles.iter().position(|other| other == name).unwrap();
            let shapes = world.obstacle_by_name(name).unwrap().placed_shapes();
            shapes.map(|(pose, shape)| body(Carrier::Obstacle(place), pose, shape)).collect()
        };
        let with_world = |name: &String| obstacles.contains(name);
        let pairs = pairs.iter().map(|[a, b]| {
            let padding = if with_world(a) || with_world(b) { settings.padding } else { 0.0 };
            ([bodies(a), bodies(b)], padding)
        });
        let pairs = pairs.collect();
        let floats = robot.joint_ids().filter(|id| robot.joint(*id).kind == JointKind::Floating);
        let floating = floats.filter_map(|id| robot.first_position(id)).collect();
        Self { scene, obstacles, pairs, floating }
    }

    /// Where something touches, if a sample finds it.
    pub fn touch(&self, certificate: &Certificate, random: &mut Random) -> Option<String> {
        let mut last: Option<Moment> = None;
        for (segment, proof) in certificate.segments.iter().enumerate() {
            let text = &proof.motion;
            let start = self.moment(text, 0.0);
            if let Some(last) = &last {
                // between two segments
                for i in 0..=24 {
                    let moment = last.towards(&start, f64::from(i) / 24.0, &self.floating);
                    if let Some(found) = self.touching(&moment) {
                        return Some(format!("before segment {segment}: {found}"));
                    }
                }
            }
            let mut found = None;
            for i in 0..PIECES {
                let [from, to] = [i, i + 1].map(|i| f64::from(i) / f64::from(PIECES));
                found = found.or_else(|| self.touch_within(text, [from, to], MOST_HALVINGS, random));
            }
            if let Some(found) = found {
                return Some(format!("segment {segment}: {found}"));
            }
            last = Some(self.moment(text, 1.0));
        }
        None
    }

    fn touch_within(
        &self,
        text: &SegmentText,
        [from, to]: [f64; 2],
        halvings: u32,
        random: &mut Random,
    ) -> Option<String> {
        let ends = [from, to].map(|t| self.moment(text, t));
        for moment in &ends {
            let nominal = self.touching(moment);
            let off = || self.touching(&moment.loosened(&text.tube, random));
            if let Some(found) = nominal.or_else(off) {
                return Some(format!("{found} between {from} and {to}"));
            }
        }
        let middle = 0.5 * (from + to);
        let too_far = self.farthest(&ends) > STEP;
        if halvings == 0 || !too_far {
            return None;
        }
        let first = self.touch_within(text, [from, middle], halvings - 1, random);
        first.or_else(|| self.touch_within(text, [middle, to], halvings - 1, random))
    }

    /// The positions and the displacements of obstacles at t.
    fn moment(&self, text: &SegmentText, t: f64) -> Moment {
        let straight = || -> Vec<f64> {
            let (from, to) = (text.from.as_ref().unwrap(), text.to.as_ref().unwrap());
            let mut q: Vec<f64> = from.iter().zip(to).map(|(a, b)| a + t * (b - a)).collect();
            for first in &self.floating {
                let of = |q: &[f64]| {
                    let [x, y, z, w] = [3, 4, 5, 6].map(|i| q[first + i]);
                    Rotation::from_quaternion(nalgebra::Quaternion::new(w, x, y, z))
                };
                let (a, b) = (of(from), of(to));
                let turned = Rotation::from_scaled_axis((b * a.inverse()).scaled_axis() * t) * a;
                q[first + 3..first + 7].copy_from_slice(turned.coords.as_slice());
            }
            q
        };
        let bent = |all: &Vec<[f64; 6]>| -> Vec<f64> {
            let power = |p: &[f64; 6]| (0..6).map(|i| p[i] * t.powi(i32::try_from(i).unwrap())).sum();
            all.iter().map(power).collect()
        };
        let q = text.polynomials.as_ref().map_or_else(straight, bent);
        let by_name: HashMap<&str, &MovingObstacle> =
            text.obstacles.iter().map(|o| (o.name.as_str(), o)).collect();
        let displacement =
            |name: &String| by_name.get(name.as_str()).map_or_else(Pose::identity, |o| displacement(o, t));
        Moment { q, obstacles: self.obstacles.iter().map(displacement).collect() }
    }

    fn placed(&self, moment: &Moment) -> Option<LinkPoses> {
        let robot = &self.scene.robot;
        let mut poses = LinkPoses::new(robot);
        robot.forward_kinematics(&robot.configuration(&moment.q).ok()?, &mut poses);
        Some(poses)
    }

    fn pose(&self, body: &Body, poses: &LinkPoses, moment: &Moment) -> Pose {
        match body.carrier {
            Carrier::Link(link) => *poses.pose(self.scene.robot.link_ids().nth(link).unwrap()) * body.pose,
            Carrier::Obstacle(place) => moment.obstacles[place] * body.pose,
        }
    }

    /// Names no pair: it is enough that there is one.
    fn touching(&self, moment: &Moment) -> Option<String> {
        let Some(poses) = self.placed(moment) else { return Some("no configuration".to_owned()) };
        for (number, (bodies, padding)) in self.pairs.iter().enumerate() {
            for a in &bodies[0] {
                for b in &bodies[1] {
                    let placed = [a, b].map(|body| self.pose(body, &poses, moment));
                    let distance = distance((a.solid, &placed[0]), (b.solid, &placed[1]));
                    if distance <= *padding {
                        return Some(format!("pair {number} at distance {distance:e}, {:?}", moment.q));
                    }
                }
            }
        }
        None
    }

    /// How far (m) any body's centre moves between two moments.
    fn farthest(&self, ends: &[Moment; 2]) -> f64 {
        let [Some(first), Some(last)] = [&ends[0], &ends[1]].map(|moment| self.placed(moment)) else {
            return 0.0;
        };
        let bodies = self.pairs.iter().flat_map(|(bodies, _)| bodies.iter().flatten());
        let moved = bodies.map(|body| {
            let [a, b] = [(&first, &ends[0]), (&last, &ends[1])].map(|(poses, m)| self.pose(body, poses, m));
            let corner = Point::new(0.3, 0.3, 0.3);
            (a.translation.vector - b.translation.vector).norm().max((a * corner - b * corner).norm())
        });
        moved.fold(0.0, f64::max)
    }
}

/// Where robot and obstacles are.
struct Moment {
    q: Vec<f64>,
    obstacles: Vec<Pose>,
}

impl Moment {
    /// A share of the straight way. A quaternion and its negative are one rotation: it goes from the nearer of the two.
    fn towards(&self, other: &Self, share: f64, floating: &[usize]) -> Self {
        let mut q = self.q.clone();
        for first in floating {
            let quaternion = first + 3..first + 7;
            let product: f64 = quaternion.clone().map(|i| self.q[i] * other.q[i]).sum();
            q[quaternion].iter_mut().for_each(|c| *c *= product.signum());
        }
        let obstacles = self.obstacles.iter().zip(&other.obstacles).map(|(a, b)| {
            let turn = Rotation::from_scaled_axis((b.rotation * a.rotation.inverse()).scaled_axis() * share);
            let shift = a.translation.vector.lerp(&b.translation.vector, share);
            Pose::from_parts(shift.into(), turn * a.rotation)
        });
        Self {
            q: q.iter().zip(&other.q).map(|(a, b)| a + share * (b - a)).collect(),
            obstacles: obstacles.collect(),
        }
    }

    fn loosened(&self, tube: &[f64], random: &mut Random) -> Self {
        let mut q = self.q.clone();
        for (q, tube) in q.iter_mut().zip(tube) {
            *q += tube * [-1.0, 1.0, random.within(-1.0, 1.0)][random.below(3) as usize];
        }
        Self { q, obstacles: self.obstacles.clone() }
    }
}

fn displacement(mover: &MovingObstacle, t: f64) -> Pose {
    let centre = Vector::from(mover.centre);
    let turn = Rotation::from_scaled_axis(Vector::from(mover.angular) * t);
    let start = mover.start.map_or_else(Pose::identity, |(xyz, [x, y, z, w])| {
        let rotation = Rotation::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
        Pose::from_parts(Vector::from(xyz).into(), rotation)
    });
    let shift = centre + Vector::from(mover.linear) * t - turn * centre;
    Pose::from_parts(shift.into(), turn) * start
}

fn body(carrier: Carrier, pose: Pose, shape: &Shape) -> Body {
    let solid = match shape {
        Shape::Primitive(Primitive::Sphere { radius }) => Solid::Ball(*radius),
        Shape::Primitive(Primitive::Box { half_extents }) => Solid::Cuboid(*half_extents),
        // the only mesh of these scenes
        Shape::Mesh(_) => Solid::Cuboid([0.0, 0.5, 0.5]),
        other => panic!("{}", other.kind()),
    };
    Body { carrier, pose, solid }
}

fn distance((a, pose_a): (Solid, &Pose), (b, pose_b): (Solid, &Pose)) -> f64 {
    let centre = |pose: &Pose| Point::from(pose.translation.vector);
    match (a, b) {
        (Solid::Ball(r), Solid::Ball(s)) => (centre(pose_a) - centre(pose_b)).norm() - r - s,
        (Solid::Ball(r), Solid::Cuboid(half)) => {
            let p = pose_b.inverse_transform_point(&centre(pose_a));
            let outside = |i: usize| (p[i].abs() - half[i]).max(0.0);
            Vector::new(outside(0), outside(1), outside(2)).norm() - r
        }
        (Solid::Cuboid(_), Solid::Ball(_)) => distance((b, pose_b), (a, pose_a)),
        (Solid::Cuboid(_), Solid::Cuboid(_)) => panic!("one of a pair is a ball"),
    }
}
