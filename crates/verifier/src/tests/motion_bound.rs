//! Tests of the motion bound: no sampled point of a robot comes nearer to another than the bound allows.

use clearance_geometry::math::{Point, Pose, Rotation, Vector};
use clearance_geometry::testing::Random;
use clearance_geometry::{Primitive, Shape};
use clearance_motion::{MotionSegment, MovingObstacle};
use clearance_robot::{LinkPoses, RobotModel};
use clearance_scene::Settings;
use clearance_scene::{AttachedObject, Obstacle, ObstacleId, World};

use super::scenes::{ALL_KINDS, motion, plane, point_of, robot, world};
use crate::Verifier;
use crate::proof_interval::ProofInterval;
use crate::segment_kinematics::SegmentKinematics;
use crate::segment_verifier::SegmentVerifier;

/// Where a body is at t, the robot anywhere in its tube.
struct Scene<'s> {
    robot: &'s RobotModel,
    world: &'s World,
    motion: &'s MotionSegment,
    poses: LinkPoses,
    t: f64,
    /// Direction in which obstacles deviate from their motion, as far as their limits allow; shorter for less.
    deviation: Vector,
}

impl Scene<'_> {
    fn go_to(&mut self, t: f64, off: impl Fn(usize) -> f64) {
        let mut positions = self.motion.at(t).positions().to_vec();
        for (i, (position, tube)) in positions.iter_mut().zip(self.motion.tube()).enumerate() {
            *position += tube * off(i);
        }
        self.t = t;
        self.robot.forward_kinematics(&self.robot.configuration(&positions).unwrap(), &mut self.poses);
    }

    fn pose(&self, body: usize) -> Pose {
        let (links, attached) = (self.robot.links().len(), self.world.attached());
        let Some(obstacle) = body.checked_sub(links + attached.len()) else {
            let link = |name: &str| self.robot.link_by_name(name).unwrap();
            let carrier = body.checked_sub(links).map(|held| link(&attached[held].link));
            return *self.poses.pose(carrier.unwrap_or_else(|| self.robot.link_ids().nth(body).unwrap()));
        };
        let name = &self.world.obstacle(ObstacleId(u32::try_from(obstacle).unwrap())).name;
        let mover = self.motion.obstacles().iter().find(|m| m.name == *name);
        let pose = mover.map_or(Pose::identity(), |m| m.displacement(self.t));
        let unknown = self.motion.uncertainty().map_or(0.0, |uncertainty| uncertainty.of(name, self.t));
        Pose::from_parts((self.deviation * unknown).into(), Rotation::identity()) * pose
    }
}

/// Random points of both bodies, each in its body's frame.
fn point_pairs(random: &mut Random, segment_verifier: &SegmentVerifier, pair: usize) -> Vec<[Point; 2]> {
    let bodies = segment_verifier.bodies(pair).map(|(_, body, _)| body);
    let mut point = |i: usize| {
        let elements = bodies[i].elements();
        let element = &elements[random.below(elements.len())];
        point_of(random, element)
    };
    (0..6).map(|_| [point(0), point(1)]).collect()
}

/// Which share of the rough and of the exact bound sampled points used up at most.
fn worst(random: &mut Random, extent: f64) -> f64 {
    let robot = robot(random, &ALL_KINDS);
    let world = world(random, 0.5);
    let motion = motion(random, &robot, extent);
    let verifier = Verifier::new(&robot, &world, &Settings::default(), None).unwrap();
    let kinematics = SegmentKinematics::new(&robot, &world, 0, motion.clone()).unwrap();
    let mut segment_verifier = SegmentVerifier::new(&verifier.model, 0, 0.0, &kinematics);
    let mut scene = Scene {
        robot: &robot,
        world: &world,
        motion: &motion,
        poses: LinkPoses::new(&robot),
        t: 0.0,
        deviation: Vector::zeros(),
    };
    let from = random.within(0.5) + 0.5;
    let to = (from + random.within(0.4).abs() * random.within(1.0).abs()).min(1.0);
    let interval = ProofInterval::new(from, to);
    segment_verifier.go_to(interval);
    let mut worst: f64 = 0.0;
    for pair in 0..verifier.model.required.pairs.len() {
        segment_verifier.place(pair);
        let rough = segment_verifier.bound(pair, interval, false);
        let exact = segment_verifier.bound(pair, interval, true);
        // polygons around discs may stick out of the box: both hold
        let exact = exact.min(rough);
        let points = point_pairs(random, &segment_verifier, pair);
        let indices = segment_verifier.bodies(pair).map(|(index, ..)| index);
        let distances = |scene: &Scene| {
            let poses = indices.map(|i| scene.pose(i));
            points
                .iter()
                .map(|[a, b]| nalgebra::distance(&(poses[0] * a), &(poses[1] * b)))
                .collect::<Vec<_>>()
        };
        scene.deviation = Vector::zeros();
        scene.go_to(interval.middle, |_| 0.0);
        let before = distances(&scene);
        for k in 0..12 {
            let t = [from, to, interval.middle + random.within(interval.half_width)][k % 3].clamp(from, to);
            let signs = random.bits();
            let share = if k < 6 { 1.0 } else { random.within(1.0) };
            scene.deviation = random.direction().into_inner() * share;
            scene.go_to(t, |i| if signs >> (i % 64) & 1 == 0 { share } else { -share });
            for (before, now) in before.iter().zip(distances(&scene)) {
                assert!(before - now <= exact + 1e-9, "{before} to {now}, but at most {exact}: pair {pair}");
                worst = worst.max((before - now) / exact.max(1e-6));
            }
        }
    }
    worst
}

#[test]
fn no_point_comes_nearer_than_bound() {
    for extent in [0.01, 0.1, 1.0, 3.0] {
        let mut random = Random::new(71);
        let worst = (0..400).map(|_| worst(&mut random, extent)).fold(0.0, f64::max);
        println!("motions of {extent}: up to {worst:.4} of the bound");
        // the samples come near enough to it to find one that is too small
        assert!(worst > 0.5, "{worst}");
    }
}

/// The same of a plane, which has no points to sample and stands, moves or is held: others come nearer to it by no more than the
/// bound. Of what is part of it too, nothing is said here.
#[test]
fn no_point_comes_nearer_to_a_plane() {
    let mut random = Random::new(76);
    let mut worst = [0.0_f64; 3];
    for i in 0..900 {
        let robot = robot(&mut random, &ALL_KINDS);
        let motion = motion(&mut random, &robot, 0.5).with_movers(vec![]).unwrap();
        let wall = Obstacle::of_shape("wall", Pose::identity(), plane(&mut random, 1.0));
        let mut world = World::default();
        let motion = match i % 3 {
            0 => motion,
            1 => {
                let [from, to] = [0, 1].map(|_| random.pose(0.3));
                let centre = Point::from(random.vector(0.5));
                motion.with_movers(vec![MovingObstacle::between("wall", centre, &from, &to)]).unwrap()
            }
            _ => {
                let link = &robot.links()[random.below(robot.links().len())].name;
                let held = AttachedObject::grasped(&wall, link, &random.pose(0.3), vec![]);
                world.attach(held).unwrap();
                let ball = Shape::Primitive(Primitive::Sphere { radius: 0.1 });
                world.add(Obstacle::of_shape("ball", random.pose(1.0), ball)).unwrap();
                motion
            }
        };
        if world.is_empty() {
            world.add(wall).unwrap();
        }
        worst[i % 3] = worst[i % 3].max(worst_before_planes(&mut random, (&robot, &world), &motion));
    }
    println!("planes that stand, move, are held: up to {worst:?} of the bound");
    assert!(worst.iter().all(|worst| *worst > 0.5), "{worst:?}");
}

/// Which share of the bound sampled points used up at most, of all pairs of which one body is a plane.
fn worst_before_planes(
    random: &mut Random,
    (robot, world): (&RobotModel, &World),
    motion: &MotionSegment,
) -> f64 {
    let verifier = Verifier::new(robot, world, &Settings::default(), None).unwrap();
    let kinematics = SegmentKinematics::new(robot, world, 0, motion.clone()).unwrap();
    let mut segment_verifier = SegmentVerifier::new(&verifier.model, 0, 0.0, &kinematics);
    let interval = ProofInterval::new(0.2, 0.2 + 0.8 * random.within(1.0).abs());
    segment_verifier.go_to(interval);
    let mut scene =
        Scene { robot, world, motion, poses: LinkPoses::new(robot), t: 0.0, deviation: Vector::zeros() };
    let mut worst: f64 = 0.0;
    for pair in 0..verifier.model.required.pairs.len() {
        segment_verifier.place(pair);
        let bound =
            segment_verifier.bound(pair, interval, true).min(segment_verifier.bound(pair, interval, false));
        let both = segment_verifier.bodies(pair);
        let Some(side) = both.iter().position(|(_, body, _)| !body.planes().is_empty()) else { continue };
        let ((at, wall, _), (other, body, _)) = (both[side], both[1 - side]);
        let points: Vec<Point> = (0..4).map(|_| point_of(random, &body.elements()[0])).collect();
        let heights = |scene: &Scene| -> Vec<f64> {
            let seen = scene.pose(at).inverse() * scene.pose(other);
            points.iter().map(|p| wall.planes()[0].height(&(seen * p)).abs()).collect()
        };
        scene.go_to(interval.middle, |_| 0.0);
        let before = heights(&scene);
        for end in [-1.0, 1.0, random.within(1.0)] {
            let signs = random.bits();
            scene.go_to(interval.middle + end * interval.half_width, |i| {
                if signs >> (i % 64) & 1 == 0 { 1.0 } else { -1.0 }
            });
            for (before, now) in before.iter().zip(heights(&scene)) {
                assert!(before - now <= bound + 1e-9, "{before} to {now}, but at most {bound}");
                worst = worst.max((before - now) / bound.max(1e-6));
            }
        }
    }
    worst
}
