//! Tests of the collision checker: hand-computed results, padding, agreement of queries, reasons of skipped pairs.

use clearance::checker::{CollisionChecker, Question};
use clearance::geometry::math::Pose;
use clearance::geometry::{Primitive, Shape};
use clearance::robot::RobotModel;
use clearance::scene::{Obstacle, World};
use clearance::scene::{Settings, SkipReason};
use std::path::Path;
use std::sync::Arc;

fn load(urdf: &str, srdf: Option<&str>) -> Arc<RobotModel> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let srdf = srdf.map(|s| root.join(s));
    Arc::new(RobotModel::load(&root.join(urdf), srdf.as_deref(), &[]).unwrap())
}

fn two_link() -> Arc<RobotModel> {
    load("urdf/two_link/two_link.urdf", None)
}

fn ball(name: &str, x: f64, z: f64, radius: f64) -> Obstacle {
    let ball = Shape::Primitive(Primitive::sphere(radius).unwrap());
    Obstacle::of_shape(name, Pose::translation(x, 0.0, z), ball)
}

/// The table that the robot's own file gives, worked out by hand.
#[test]
fn two_link_agrees_with_its_table() {
    let robot = two_link();
    let checker = CollisionChecker::new(robot.clone(), &World::default(), Settings::default()).unwrap();
    let mut workspace = checker.workspace();
    let pi = std::f64::consts::PI;
    for (joint1, joint2, distance) in [(0.0, 0.0, 0.7), (0.0, 5.0 * pi / 6.0, 0.2), (0.0, pi, 0.0)] {
        let q = robot.configuration(&[joint1, joint2]).unwrap();
        let limit = f64::INFINITY;
        let nearest = checker.check(&q, Question::Distance { limit }, &mut workspace).nearest.unwrap();
        assert!((nearest.distance - distance).abs() < 1e-12, "{joint2}: {}", nearest.distance);
        assert_eq!(checker.is_free(&q, &mut workspace), distance > 0.0);
    }
}

#[test]
fn padding_counts_against_the_world_and_if_asked_between_links() {
    let robot = two_link();
    let mut world = World::default();
    world.add(ball("ball", 5.0, 0.0, 1.0)).unwrap();
    let q = robot.default_configuration();
    let ask = |settings: Settings| {
        let checker = CollisionChecker::new(robot.clone(), &world, settings).unwrap();
        let limit = f64::INFINITY;
        checker.check(&q, Question::PairDistances { limit }, &mut checker.workspace())
    };
    let bare = ask(Settings::default());
    let padded = ask(Settings { padding: 0.1, ..Settings::default() });
    let both = ask(Settings { padding: 0.1, pad_self: true, ..Settings::default() });
    for (i, pair) in bare.pair_distances.iter().enumerate() {
        let of_links = matches!(pair.b, clearance::scene::BodyId::Link(_));
        let taken = pair.distance - padded.pair_distances[i].distance;
        assert!((taken - if of_links { 0.0 } else { 0.1 }).abs() < 1e-12);
        let taken = pair.distance - both.pair_distances[i].distance;
        assert!((taken - if of_links { 0.2 } else { 0.1 }).abs() < 1e-12);
    }
    let mut settings = Settings::default();
    settings.link_padding.insert("nose".to_owned(), 0.1);
    let error = CollisionChecker::new(robot.clone(), &world, settings).unwrap_err();
    assert!(error.to_string().contains("nose"));
}

/// Every question tells the same truth about the same state.
#[test]
fn questions_agree_with_each_other() {
    let robot = load("urdf/demo_arm/demo_arm.urdf", Some("urdf/demo_arm/demo_arm.srdf"));
    let mut world = World::default();
    world.add(ball("ball", 0.5, 0.4, 0.2)).unwrap();
    let checker = CollisionChecker::new(robot.clone(), &world, Settings::default()).unwrap();
    let mut workspace = checker.workspace();
    let mut random = crate::random::Random::new(7);
    let (mut free, mut hit) = (0, 0);
    for _ in 0..60 {
        let positions: Vec<f64> = (robot.joint_ids())
            .filter(|j| robot.first_position(*j).is_some())
            .map(|j| robot.joint(j).limits.map_or(0.0, |l| random.within(l.lower, l.upper)))
            .collect();
        let q = robot.configuration(&positions).unwrap();
        let is_free = checker.is_free(&q, &mut workspace);
        let mut ask = |question| checker.check(&q, question, &mut workspace);
        let first = ask(Question::Free);
        let pairs = ask(Question::Pairs);
        let least = ask(Question::Distance { limit: f64::INFINITY });
        let all = ask(Question::PairDistances { limit: f64::INFINITY });
        let survey = ask(Question::Survey { influence_distance: 0.05, limit: 0.3 });
        for report in [&first, &pairs, &least, &all, &survey] {
            assert_eq!(report.is_free(), is_free);
            assert_eq!(report.self_collision, pairs.self_collision);
            assert_eq!(report.world_collision, pairs.world_collision);
        }
        assert_eq!(all.colliding_pairs, pairs.colliding_pairs);
        assert_eq!(survey.colliding_pairs, pairs.colliding_pairs);
        assert_eq!(all.pair_distances.len(), checker.pairs().len());
        let nearest = least.nearest.unwrap();
        assert!((nearest.distance - all.nearest.unwrap().distance).abs() < 1e-12);
        assert_eq!(nearest.distance == 0.0, !is_free);
        let within = all.pair_distances.iter().filter(|p| p.distance <= 0.05);
        assert_eq!(survey.pair_distances.len(), within.count());
        assert_eq!(survey.nearest.is_some(), nearest.distance <= 0.3);
        if is_free { free += 1 } else { hit += 1 }
    }
    assert!(free > 5 && hit > 5, "{free} {hit}");
}

#[test]
fn why_pairs_are_skipped_is_counted() {
    let checker = CollisionChecker::new(two_link(), &World::default(), Settings::default()).unwrap();
    let skipped: Vec<_> = checker.pairs().skipped().collect();
    assert_eq!(skipped, [(SkipReason::Adjacent, 2)]);
    assert_eq!(checker.pairs().len(), 1);
}
