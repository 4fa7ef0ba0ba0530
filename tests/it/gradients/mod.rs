//! Tests that gradients of signed distances equal difference quotients, for random and real robots.

mod candidates;
mod command;
mod differences;
mod laws;
mod random_robot;

use std::sync::Arc;

use clearance::checker::CollisionChecker;
use clearance::geometry::Shape;
use clearance::robot::RobotModel;
use clearance::scene::{Obstacle, Settings, World};

use crate::random::Random;
use crate::tally::{json, shared_folder};
use differences::{Compared, Comparison};
use random_robot::{Shapes, checker, configuration};

/// Least distance (m) that is compared: nearer bodies need shorter steps than the noise of their distances allows.
const APART: f64 = 0.03;

/// All kinds of joints and shapes.
#[test]
fn rows_equal_differences_for_random_robots() {
    let mut random = Random::new(1);
    let mut total = Comparison::default();
    for _ in 0..120 {
        let checker = checker(&mut random, Shapes::All);
        for _ in 0..2 {
            let q = configuration(checker.robot(), &mut random);
            total.add(&Comparison::of_state(
                &checker,
                &q,
                1.0,
                Compared::Apart(APART),
                &mut checker.workspace(),
            ));
        }
    }
    println!("{total:?}");
    assert!(total.pairs > 1000 && total.pairs > 20 * total.not_converged, "{total:?}");
    assert!(total.worst < 1e-6, "{total:?}");
}

#[test]
fn rows_of_exact_depths_equal_differences() {
    let mut random = Random::new(2);
    let mut total = Comparison::default();
    for _ in 0..200 {
        let checker = checker(&mut random, Shapes::Boxes);
        for _ in 0..3 {
            let q = configuration(checker.robot(), &mut random);
            total.add(&Comparison::of_state(
                &checker,
                &q,
                0.0,
                Compared::Overlapping,
                &mut checker.workspace(),
            ));
        }
    }
    println!("{total:?}");
    assert!(total.pairs > 100 && total.worst < 1e-6, "{total:?}");
}

/// Robots of other people, against themselves.
#[test]
fn rows_equal_differences_for_real_robots() {
    let Some(folder) = shared_folder("robots") else { return };
    for entry in json(&folder.join("robots.json")).as_array().unwrap() {
        let path = |key: &str| folder.join(entry[key].as_str().unwrap());
        let robot = RobotModel::load(&path("urdf"), Some(&path("srdf")), &[path("package_root")]).unwrap();
        let mut random = Random::new(3);
        let mut world = World::default();
        for i in 0..6 {
            let shape = Shape::Primitive(random.primitive());
            world.add(Obstacle::of_shape(format!("o{i}"), random.pose(1.5), shape)).unwrap();
        }
        let checker = CollisionChecker::new(Arc::new(robot), &world, Settings::default()).unwrap();
        let mut total = Comparison::default();
        for _ in 0..20 {
            if total.pairs > 30 {
                break;
            }
            let q = configuration(checker.robot(), &mut random);
            total.add(&Comparison::of_state(
                &checker,
                &q,
                0.2,
                Compared::Free(APART),
                &mut checker.workspace(),
            ));
        }
        println!("{}: {total:?}", entry["name"]);
        assert!(total.pairs > 0 && total.worst < 1e-6, "{}: {total:?}", entry["name"]);
    }
}
