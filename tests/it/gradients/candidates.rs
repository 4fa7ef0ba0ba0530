//! Tests of gradients of pairs with several witness pairs, against one-sided directional derivatives.

use std::sync::Arc;

use clearance::checker::{Clearance, ClearanceOptions, CollisionChecker, WitnessCount};
use clearance::geometry::math::Pose;
use clearance::geometry::{Primitive, Shape};
use clearance::proximity::TieTolerance;
use clearance::robot::{MeshFiles, RobotModel};
use clearance::scene::{Obstacle, ObstacleShape, Settings, World};

use super::differences::exact;
use super::random_robot::random_box_mesh;
use crate::random::Random;

/// Step (rad, m) of differences: the noise of distances, 1e-10 m, allows no shorter ones.
const STEP: f64 = 2e-5;

/// A hand that three prismatic joints and three revolute ones move, with a mimic joint for one of them.
fn hand(geometry: &str) -> Arc<RobotModel> {
    let joint = |i: usize, kind: &str, axis: &str, more: &str| {
        format!(
            "<link name='l{}'>{}</link><joint name='j{}' type='{kind}'><parent link='l{i}'/><child link='l{}'/>
             <axis xyz='{axis}'/><limit lower='-9' upper='9' effort='1' velocity='1'/>{more}</joint>",
            i + 1,
            if i == 5 { format!("<collision><geometry>{geometry}</geometry></collision>") } else { String::new() },
            i + 1,
            i + 1,
        )
    };
    let mimic = "<mimic joint='j4' multiplier='0.5'/>";
    let urdf: String = [
        joint(0, "prismatic", "1 0 0", ""),
        joint(1, "prismatic", "0 1 0", ""),
        joint(2, "prismatic", "0 0 1", ""),
        joint(3, "revolute", "1 0 0", ""),
        joint(4, "revolute", "0 1 0", mimic),
        joint(5, "revolute", "0 0 1", ""),
    ]
    .concat();
    let urdf = format!("<robot name='hand'><link name='l0'/>{urdf}</robot>");
    Arc::new(RobotModel::from_urdf(&urdf, &MeshFiles::default()).unwrap())
}

const BOX: &str = "<box size='0.2 0.2 0.2'/>";
const BALL: &str = "<sphere radius='0.1'/>";
const ROD: &str = "<capsule radius='0.05' length='0.3'/>";

fn cuboid(half: [f64; 3]) -> Shape {
    Shape::Primitive(Primitive::cuboid(half.map(|h| 2.0 * h)).unwrap())
}

/// Two posts, left and right.
fn posts() -> Vec<ObstacleShape> {
    [-0.25, 0.25]
        .map(|x| ObstacleShape { pose_os: Pose::translation(x, 0.0, 0.0), shape: cuboid([0.05, 0.1, 1.0]) })
        .into()
}

fn one(shape: Shape) -> Vec<ObstacleShape> {
    vec![ObstacleShape { pose_os: Pose::identity(), shape }]
}

struct Case {
    name: &'static str,
    hand: &'static str,
    obstacle: Vec<ObstacleShape>,
    /// Positions of the free joints: x, y, z, roll (pitch follows with half of it), yaw.
    at: [f64; 5],
    overlaps: bool,
}

fn cases() -> Vec<Case> {
    let wall = || cuboid([0.1, 0.5, 0.5]);
    let mesh = || Shape::Mesh(random_box_mesh([0.1, 0.5, 0.5]).into());
    let case = |name, hand, obstacle, at, overlaps| Case { name, hand, obstacle, at, overlaps };
    vec![
        case("face to face", BOX, one(wall()), [0.3, 0.1, 0.0, 0.0, 0.0], false),
        case("face to face of a mesh", BOX, one(mesh()), [0.3, 0.1, 0.0, 0.0, 0.0], false),
        case("edge above a face", BOX, one(wall()), [0.3, 0.1, 0.0, 0.0, std::f64::consts::FRAC_PI_4], false),
        case("ball between posts", BALL, posts(), [0.0, 0.0, 0.3, 0.1, 0.2], false),
        case("rod along a wall", ROD, one(wall()), [0.3, 0.1, 0.3, 0.0, 0.3], false),
        case("box in a wall", BOX, one(wall()), [0.15, 0.1, 0.0, 0.0, 0.0], true),
        case("box in a mesh", BOX, one(mesh()), [0.15, 0.1, 0.0, 0.0, 0.0], true),
        case("ball in the middle of a wall", BALL, one(wall()), [0.0, 0.1, 0.0, 0.4, 0.0], true),
    ]
}

impl Case {
    fn checker(&self) -> CollisionChecker {
        let mut world = World::default();
        world.add(Obstacle::new("o", self.obstacle.clone())).unwrap();
        CollisionChecker::new(hand(self.hand), &world, Settings::default()).unwrap()
    }
}

fn query(checker: &CollisionChecker, positions: &[f64]) -> Clearance {
    let q = checker.robot().configuration(positions).unwrap();
    let options = ClearanceOptions { most_candidates: 100, ..ClearanceOptions::new(1.0) };
    checker.clearance_with(&q, &options, &mut checker.workspace())
}

#[test]
fn candidates_give_directional_derivatives() {
    let mut random = Random::new(8);
    for case in cases() {
        let checker = case.checker();
        let found = query(&checker, &case.at);
        let [pair] = &found.pairs[..] else { panic!("{}: {found:?}", case.name) };
        assert_eq!(pair.witnesses, WitnessCount::Several, "{}: {found:?}", case.name);
        assert!(pair.has_all_candidates && found.candidates.len() > 1, "{}: {found:?}", case.name);
        assert_eq!(pair.distance < 0.0, case.overlaps, "{}: {found:?}", case.name);
        for _ in 0..20 {
            let velocities: Vec<f64> = (0..found.columns).map(|_| random.within(-1.0, 1.0)).collect();
            let derivative = found.directional_derivative(0, &velocities).expect("all candidates are listed");
            let at = |step: f64| {
                let moved: Vec<f64> = case.at.iter().zip(&velocities).map(|(q, v)| q + step * v).collect();
                exact(&query(&checker, &moved).pairs[0])
            };
            let start = exact(pair);
            let [near, far] = [STEP, 2.0 * STEP].map(|step| (at(step) - start) / step);
            let difference = 2.0 * near - far;
            assert!((derivative - difference).abs() < 5e-5, "{}: {derivative} {difference}", case.name);
            let kink = found.candidates_of(0).any(|(_, row)| row != found.row(0));
            assert!(kink, "{}: all candidates have one row", case.name);
        }
    }
}

/// Without the option nothing is listed; a smaller tolerance than the difference of two distances makes the nearest one the only one.
#[test]
fn the_tolerance_decides_what_is_equally_near() {
    let case = &cases()[3];
    let checker = case.checker();
    let with = |offset: f64, absolute: f64| {
        let mut at = case.at;
        at[0] = offset;
        let q = checker.robot().configuration(&at).unwrap();
        let tie_tolerance = TieTolerance { relative: 0.0, absolute };
        let options = ClearanceOptions { tie_tolerance, most_candidates: 10, ..ClearanceOptions::new(1.0) };
        let found = checker.clearance_with(&q, &options, &mut checker.workspace());
        (found.pairs[0].witnesses, found.candidates.len())
    };
    assert_eq!(with(0.0, 1e-9), (WitnessCount::Several, 2));
    // the distances differ by twice the offset
    assert_eq!(with(1e-4, 1.9e-4), (WitnessCount::One, 0));
    assert_eq!(with(1e-4, 2.1e-4), (WitnessCount::Several, 2));
    let found =
        checker.clearance(&checker.robot().configuration(&case.at).unwrap(), 1.0, &mut checker.workspace());
    assert!(found.candidates.is_empty() && !found.pairs[0].has_all_candidates);
    assert_eq!(found.directional_derivative(0, &[1.0, 0.0, 0.0, 0.0, 0.0]), None);
}
