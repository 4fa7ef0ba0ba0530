//! Tests of the separation test: bodies are proven apart up to their distance, and not beyond.

use clearance_checker::{CollisionChecker, Question};
use clearance_geometry::Shape;
use clearance_geometry::math::{MatrixPose, Point, Pose, Vector};
use clearance_geometry::testing::Random;
use clearance_robot::{MeshFiles, RobotModel};
use clearance_scene::Settings;
use clearance_scene::{Obstacle, ObstacleShape, World};
use std::sync::Arc;

use super::scenes::{grains, mesh, plane, point_of, primitive};
use crate::body::Body;
use crate::element::{Element, gap};
use crate::separation_test::SeparationTest;

fn proven(a: &Body, b: &Body, pose_ab: &Pose, target: f64) -> bool {
    SeparationTest::new(a, b, MatrixPose::from(pose_ab), target).prove()
}

fn shapes(random: &mut Random, extent: f64) -> Vec<(Pose, Shape)> {
    (0..=random.below(3))
        .map(|_| {
            let shape = match random.below(3) {
                0 => mesh(random, extent),
                1 => primitive(random, extent),
                _ => grains(random, extent),
            };
            (random.pose(extent), shape)
        })
        .collect()
}

fn body(shapes: &[(Pose, Shape)]) -> Body {
    Body::new(&shapes.iter().map(|(pose, shape)| (*pose, shape)).collect::<Vec<_>>(), false)
}

#[test]
fn supports_are_reached_and_never_passed() {
    let mut random = Random::new(72);
    for _ in 0..2000 {
        let shapes = shapes(&mut random, 0.3);
        let body = body(&shapes);
        for element in body.elements() {
            let n = random.direction();
            let top = element.support(&n);
            let reached = n.dot(&element.extreme(&n).coords) + element.ball();
            assert!((top - reached).abs() < 1e-12);
            for _ in 0..5 {
                assert!(n.dot(&point_of(&mut random, element).coords) <= top + 1e-12);
            }
            let [low, high] = element.bounds();
            let centre = Point::from(random.vector(1.0));
            let far = |p: &Point| nalgebra::distance(p, &centre);
            let p = point_of(&mut random, element);
            assert!(body.greatest(1.0, far) >= far(&p) - 1e-12);
            assert!((0..3).all(|i| low[i] - 1e-12 <= p[i] && p[i] <= high[i] + 1e-12));
        }
    }
}

/// Pairs at poses, against the engine that makes certificates: an obstacle against the one link of a robot.
#[test]
fn proven_up_to_the_distance_that_the_engine_finds() {
    let robot = "<robot name='ball'><link name='l'><collision><geometry><sphere radius='0.1'/></geometry></collision>\
                 </link></robot>";
    let robot = Arc::new(RobotModel::from_urdf(robot, &MeshFiles::default()).unwrap());
    let ball = (Pose::identity(), robot.links()[0].collisions[0].shape.clone());
    let mut random = Random::new(73);
    for _ in 0..1000 {
        let mut shapes = shapes(&mut random, 0.2);
        match random.below(4) {
            0 => shapes.push((random.pose(0.3), plane(&mut random, 0.3))),
            1 => shapes = vec![(random.pose(0.3), plane(&mut random, 0.5))],
            _ => {}
        }
        let pose = Pose::from_parts((random.direction().into_inner() * 0.5).into(), random.rotation());
        let mut world = World::default();
        let placed = shapes.iter().map(|(p, shape)| ObstacleShape { pose_os: *p, shape: shape.clone() });
        world.add(Obstacle { pose_ro: pose, ..Obstacle::new("o", placed.collect::<Vec<_>>()) }).unwrap();
        let checker = CollisionChecker::new(robot.clone(), &world, Settings::default()).unwrap();
        let question = Question::Distance { limit: f64::INFINITY };
        let report = checker.check(&robot.default_configuration(), question, &mut checker.workspace());
        let distance = report.nearest.unwrap().distance;
        let (a, b) = (body(std::slice::from_ref(&ball)), body(&shapes));
        assert!(!proven(&a, &b, &pose, distance + 2e-9), "{distance}");
        if distance > 1e-6 {
            assert!(proven(&a, &b, &pose, distance - 1e-9), "{distance} {shapes:?} {pose}");
            assert!(proven(&b, &a, &pose.inverse(), distance - 1e-9), "{distance}");
        }
    }
}

/// How far two elements are apart, by steps of a method that needs no directions (alternating projections cannot be used on round
/// things): the best of many sampled pairs of points is never nearer than what is proven.
#[test]
fn sampled_points_are_never_nearer() {
    let mut random = Random::new(74);
    let mut tight = 0;
    for _ in 0..1000 {
        let (s, t) = (shapes(&mut random, 0.2), shapes(&mut random, 0.2));
        let (a, b) = (body(&s), body(&t));
        let pose = Pose::from_parts((random.direction().into_inner() * 0.7).into(), random.rotation());
        let point = |random: &mut Random, body: &Body| {
            let elements = body.elements();
            let element = &elements[random.below(elements.len())];
            point_of(random, element)
        };
        let nearest = (0..100)
            .map(|_| nalgebra::distance(&point(&mut random, &a), &(pose * point(&mut random, &b))))
            .fold(f64::INFINITY, f64::min);
        assert!(!proven(&a, &b, &pose, nearest + 1e-9));
        tight += usize::from(proven(&a, &b, &pose, 0.6 * nearest));
    }
    assert!(tight > 500, "{tight}");
}

/// Each pair of elements is proven apart up to where some direction of very many does not do better.
#[test]
fn the_best_direction_is_found() {
    let mut random = Random::new(75);
    let mut apart = 0;
    for _ in 0..3000 {
        let (s, t) = (shapes(&mut random, 0.2), shapes(&mut random, 0.2));
        let (a, b) = (body(&s[..1]), body(&t[..1]));
        let (e, f): (&Element, &Element) = (
            &a.elements()[random.below(a.elements().len())],
            &b.elements()[random.below(b.elements().len())],
        );
        let scale = [1.0, 1e-3][random.below(2)];
        let pose = MatrixPose::from(&Pose::from_parts(random.vector(0.5).into(), random.rotation()));
        let mut n: Vector = random.direction().into_inner();
        let mut best = gap(e, f, &pose, &n);
        // climbs from a random direction: the gap is concave where it is positive
        let mut step = 1.0;
        while step > 1e-12 {
            let next = (n + random.vector(step)).normalize();
            let value = gap(e, f, &pose, &next);
            if value > best {
                (n, best) = (next, value);
                step *= 2.0;
            } else {
                step *= 0.9;
            }
        }
        if best > 1e-4 * scale {
            apart += 1;
            let found = crate::separating_direction::find(e, f, &pose, best - 1e-9);
            assert!(found.is_some(), "{best} {e:?} {f:?}");
        }
    }
    assert!(apart > 1000, "{apart}");
}
