//! Tests of signed distances: agreement with other queries, witness points and normals, limits, unknown depths.

use std::sync::Arc;

use clearance::Question;
use clearance::checker::{Clearance, ClearanceOptions, CollisionChecker, PairClearance, WitnessCount};
use clearance::geometry::math::{Pose, Vector};
use clearance::geometry::{Plane, PointCloud, Primitive, Shape};
use clearance::proximity::UnknownDepth;
use clearance::robot::{Configuration, MeshFiles, RobotModel};
use clearance::scene::{MeshModel, Obstacle, Settings, World};

use super::differences::{bodies, moved};
use super::random_robot::{Shapes, checker, checker_with, configuration};
use crate::random::Random;

/// Error (m) of a distance of curved primitives.
const DISTANCE_ERROR: f64 = 2e-10;

fn overlaps(pair: &PairClearance) -> bool {
    let [p, q] = pair.witness_points;
    pair.normal.is_none_or(|normal| normal.dot(&(q - p)) <= 0.0)
}

/// The same pairs and bits as queries of distances, and the same depths as contacts.
#[test]
fn distances_and_depths_are_those_of_other_queries() {
    let mut random = Random::new(4);
    let (mut apart, mut overlapping) = (0, 0);
    for _ in 0..60 {
        let checker = checker(&mut random, Shapes::All);
        let mut workspace = checker.workspace();
        for limit in [0.0, 0.1, f64::INFINITY] {
            let q = configuration(checker.robot(), &mut random);
            let found = checker.clearance(&q, limit, &mut workspace);
            let report = checker.check(&q, Question::PairDistances { limit }, &mut workspace);
            assert_eq!(found.pairs.len(), report.pair_distances.len());
            for (pair, other) in found.pairs.iter().zip(&report.pair_distances) {
                assert_eq!(bodies(pair), (other.a, other.b));
                assert_eq!(pair.distance.max(0.0).to_bits(), other.distance.to_bits());
                assert!(pair.lower <= pair.distance && pair.distance <= pair.upper);
                if pair.distance > 0.0 {
                    apart += 1;
                    let far =
                        |k: usize| nalgebra::distance(&pair.witness_points[k], &other.witness_points[k]);
                    // the points of curved primitives are refined
                    assert!(pair.witnesses == WitnessCount::Several || far(0).max(far(1)) < 1e-4, "{pair:?}");
                    continue;
                }
                overlapping += 1;
                let contact = checker.contact(&q, bodies(pair), &mut workspace).expect("the bodies touch");
                assert_eq!(contact.unknown, pair.unknown);
                assert_eq!(contact.normal.is_some(), pair.normal.is_some());
                let (depth, normal) = (contact.depth.unwrap(), contact.normal.unwrap());
                assert!((depth + pair.distance).abs() < DISTANCE_ERROR, "{pair:?} {contact:?}");
                assert!((contact.depth_lower + pair.upper).abs() < DISTANCE_ERROR, "{pair:?} {contact:?}");
                assert!((normal - pair.normal.unwrap()).norm() < 1e-3, "{pair:?} {contact:?}");
            }
        }
    }
    assert!(apart > 500 && overlapping > 100, "{apart} {overlapping}");
}

/// Given pairs have the same results, bit by bit, in the order in which they are given, also beyond the influence distance.
#[test]
fn given_pairs_have_the_results_of_all() {
    let mut random = Random::new(14);
    let mut compared = 0;
    for _ in 0..30 {
        let checker = checker(&mut random, Shapes::All);
        let mut workspace = checker.workspace();
        let q = configuration(checker.robot(), &mut random);
        let all = checker.clearance(&q, f64::INFINITY, &mut workspace);
        let given: Vec<_> = all.pairs.iter().rev().step_by(2).map(bodies).collect();
        let found = checker.clearance_of_pairs(&q, &given, None, &mut checker.workspace());
        assert_eq!(found.pairs.iter().map(bodies).collect::<Vec<_>>(), given);
        for (row, pair) in found.pairs.iter().enumerate() {
            let same = all.pairs.iter().position(|other| bodies(other) == bodies(pair)).unwrap();
            assert_eq!((pair, found.row(row)), (&all.pairs[same], all.row(same)));
            compared += 1;
        }
        let swapped: Vec<_> = given.iter().map(|(a, b)| (*b, *a)).collect();
        let none = checker.clearance_of_pairs(&q, &swapped, None, &mut workspace);
        assert_eq!((none.pairs.len(), none.gradient.len()), (0, 0), "these are no pairs of the list");
    }
    assert!(compared > 200, "{compared}");
}

/// Witness points of bodies that are apart have the distance, along the normal; those of a depth lie within it.
#[test]
fn points_and_normals_belong_to_the_distance() {
    let mut random = Random::new(5);
    for _ in 0..60 {
        let checker = checker(&mut random, Shapes::All);
        let q = configuration(checker.robot(), &mut random);
        for pair in checker.clearance(&q, 1.0, &mut checker.workspace()).pairs {
            let ([p, q], normal) = (pair.witness_points, pair.normal.expect("a normal is known"));
            assert!((normal.norm() - 1.0).abs() < 1e-12);
            if !overlaps(&pair) {
                let apart = nalgebra::distance(&p, &q);
                assert!(((q - p) - normal * apart).norm() < 1e-12);
                assert!(pair.distance <= apart + DISTANCE_ERROR && pair.lower == pair.upper);
            }
        }
    }
}

/// No signed distance changes by more than the motion of the bodies; bounds of depths that are not exact never contradict this.
#[test]
fn signed_distances_change_at_most_as_much_as_bodies_move() {
    let mut random = Random::new(6);
    let (mut compared, mut across) = (0, 0);
    for _ in 0..100 {
        let checker = checker_with(&mut random, Shapes::All, MeshModel::Solid);
        let mut workspace = checker.workspace();
        for _ in 0..4 {
            let start = configuration(checker.robot(), &mut random);
            let mut end = start.clone();
            let size = 10f64.powf(random.within(-4.0, -0.3));
            for column in 0..start.positions().len() {
                end = moved(checker.robot(), &end, column, random.within(-size, size));
            }
            let travel = checker.travel(start.positions(), end.positions());
            if !travel.is_finite() {
                continue;
            }
            let [before, after] = [start, end].map(|q| checker.clearance(&q, f64::INFINITY, &mut workspace));
            for (before, after) in before.pairs.iter().zip(&after.pairs) {
                assert_eq!(bodies(before), bodies(after));
                let allowed = travel + DISTANCE_ERROR + 1e-8;
                assert!(before.lower <= after.upper + allowed, "{before:?} {after:?} {travel}");
                assert!(after.lower <= before.upper + allowed, "{before:?} {after:?} {travel}");
                compared += 1;
                across += usize::from((before.distance > 0.0) != (after.distance > 0.0));
            }
        }
    }
    assert!(compared > 1000 && across > 5, "{compared} {across}");
}

/// Batches, threads and instruction sets change no bit.
#[test]
fn results_do_not_depend_on_threads_or_instructions() {
    let mut random = Random::new(7);
    for shapes in [Shapes::All, Shapes::Boxes] {
        let checker = checker(&mut random, shapes);
        let states: Vec<_> = (0..100).map(|_| configuration(checker.robot(), &mut random)).collect();
        let options = ClearanceOptions { most_candidates: 20, ..ClearanceOptions::new(0.3) };
        let mut portable = checker.portable_workspace();
        let single: Vec<Clearance> =
            states.iter().map(|q| checker.clearance_with(q, &options, &mut portable)).collect();
        for threads in [1, 2, 5] {
            let pool = rayon_pool(threads);
            let found = pool.install(|| checker.clearances_with(&states, &options));
            for (found, single) in found.iter().zip(&single) {
                assert_eq!(found, single);
            }
        }
        let mut reused = Clearance::default();
        let mut stream = checker.streaming_workspace();
        for (q, single) in states.iter().zip(&single) {
            checker.clearance_into(q, &options, &mut stream, &mut reused);
            assert_eq!(&reused, single);
            let flags = checker.clearance(q, 0.3, &mut stream);
            assert_eq!((&flags.pairs.len(), &flags.gradient), (&single.pairs.len(), &single.gradient));
            assert!(flags.candidates.is_empty());
            let counts =
                |found: &Clearance| found.pairs.iter().map(|pair| pair.witnesses).collect::<Vec<_>>();
            assert_eq!(counts(&flags), counts(single));
        }
    }
}

fn rayon_pool(threads: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap()
}

/// A ball that a joint moves along x, and an obstacle at the origin.
fn ball_and(obstacle: Shape) -> (CollisionChecker, Configuration) {
    let urdf = "<robot name='r'><link name='base'/>
        <link name='ball'><collision><geometry><sphere radius='0.1'/></geometry></collision></link>
        <joint name='x' type='prismatic'><parent link='base'/><child link='ball'/><axis xyz='1 0 0'/>
        <limit lower='-5' upper='5' effort='1' velocity='1'/></joint></robot>";
    let robot = Arc::new(RobotModel::from_urdf(urdf, &MeshFiles::default()).unwrap());
    let mut world = World::default();
    world.add(Obstacle::of_shape("o", Pose::identity(), obstacle)).unwrap();
    let checker = CollisionChecker::new(robot, &world, Settings::default()).unwrap();
    let q = checker.robot().configuration(&[0.25]).unwrap();
    (checker, q)
}

#[test]
fn the_influence_distance_selects_pairs() {
    let (checker, q) = ball_and(Shape::Primitive(Primitive::sphere(0.3).unwrap()));
    let mut workspace = checker.workspace();
    // the depth is 0.15
    for (influence, reported) in [(0.1, true), (0.0, true), (-0.1, true), (-0.2, false), (f64::NAN, true)] {
        let found = checker.clearance(&q, influence, &mut workspace);
        assert_eq!(found.pairs.len(), usize::from(reported), "{influence}");
        assert_eq!(found.gradient.len(), found.pairs.len());
    }
    let found = checker.clearance(&q, 0.0, &mut workspace);
    assert!(
        (found.pairs[0].distance + 0.15).abs() < 1e-8 && (found.row(0)[0] - 1.0).abs() < 1e-12,
        "{found:?}"
    );
}

/// Where no depth is known, there is no normal, and the bound says so.
#[test]
fn an_unknown_depth_has_no_row() {
    let plane = Plane::from_coefficients([1.0, 0.0, 0.0, 0.0]).unwrap();
    let (checker, _) = ball_and(Shape::Plane(plane));
    let mut world = World::default();
    world.add(Obstacle::of_shape("o", Pose::identity(), Shape::Plane(plane))).unwrap();
    let turned = Plane::from_coefficients([1.0, 1.0, 0.0, 0.0]).unwrap();
    let held = Obstacle::of_shape("held", Pose::identity(), Shape::Plane(turned));
    world.attach(clearance::AttachedObject::grasped(&held, "ball", &Pose::identity(), vec![])).unwrap();
    let checker = checker.with_world(&world, Settings::default(), None).unwrap();
    let q = checker.robot().configuration(&[1.0]).unwrap();
    let options = ClearanceOptions { most_candidates: 10, ..ClearanceOptions::new(0.0) };
    let found = checker.clearance_with(&q, &options, &mut checker.workspace());
    let pair = found.pairs.iter().find(|pair| pair.unknown == Some(UnknownDepth::Inseparable)).unwrap();
    assert_eq!((pair.lower, pair.distance, pair.normal), (f64::NEG_INFINITY, pair.upper, None));
    assert_eq!(pair.witnesses, WitnessCount::Unknown);
    assert!(found.gradient.iter().all(|entry| *entry == 0.0));
    assert_eq!(found.directional_derivative(0, &[1.0]), None);
}

/// A cloud is a set of balls: the deepest counts.
#[test]
fn clouds_have_signed_distances() {
    let cloud = PointCloud::new(vec![[0.0, 0.0, 0.0], [0.5, 0.0, 0.0]], 0.05).unwrap();
    let (checker, _) = ball_and(Shape::Points(cloud.into()));
    for (x, distance, slope) in
        [(-0.2, 0.05, -1.0), (-0.12, -0.03, -1.0), (0.7, 0.05, 1.0), (0.58, -0.07, 1.0)]
    {
        let q = checker.robot().configuration(&[x]).unwrap();
        let found = checker.clearance(&q, 0.1, &mut checker.workspace());
        assert!((found.pairs[0].distance - distance).abs() < 1e-8, "{x}: {found:?}");
        // the ball is the second body of the pair or the first
        assert!((found.row(0)[0] - slope).abs() < 1e-9, "{x}: {found:?}");
        assert!((found.pairs[0].normal.unwrap() - Vector::x() * -slope).norm() < 1e-9, "{x}: {found:?}");
    }
}
