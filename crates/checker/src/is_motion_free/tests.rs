//! Tests of `is_motion_free` and its siblings: agreement with the full motion check, work, and moving obstacles.

use std::sync::Arc;

use clearance_geometry::math::{Pose, Rotation};
use clearance_geometry::testing::Random;
use clearance_motion::{MotionSegment, MovingObstacle};
use clearance_proximity::Work;
use clearance_robot::{Configuration, RobotModel};
use clearance_scene::World;

use crate::random_scenes::{checker, curved_motion, state, with_uncertainty};
use crate::{CollisionChecker, MotionOptions, MotionOrder, Workspace};

/// Limit of evaluations: enough for all but motions that stay undecided.
const BUDGET: u64 = 5000;

/// A straight motion from a state, mostly short.
fn motion_from(from: &Configuration, robot: &RobotModel, random: &mut Random) -> MotionSegment {
    let length = [0.0, 0.01, 0.1, 0.1, 0.5, 0.5, 0.5, 3.0, 3.0, 3e4][random.below(10)];
    let to: Vec<f64> = from.positions().iter().map(|q| q + random.within(length)).collect();
    MotionSegment::straight(robot, from, &robot.configuration(&to).unwrap())
}

/// Any motion of the robot: straight or not, with a tracking tolerance, with a moving obstacle.
fn motion(robot: &RobotModel, world: &World, random: &mut Random) -> MotionSegment {
    let from = state(robot, random);
    let mut motion = motion_from(&from, robot, random);
    if random.below(5) == 0 {
        motion = curved_motion(robot, &from, random);
    }
    if random.below(5) == 0 {
        let tube = from.positions().iter().map(|_| random.within(0.01).abs()).collect();
        motion = motion.with_tube(robot, tube).unwrap();
    }
    if let Some(obstacle) = world.obstacles().next().filter(|_| random.below(5) == 0) {
        let [linear, angular] = [(); 2].map(|()| random.vector(0.4).into());
        let name = obstacle.name.clone();
        motion = motion
            .with_obstacles(
                world,
                vec![MovingObstacle { name, linear, angular, centre: [0.0; 3], start: None }],
            )
            .unwrap();
    }
    if random.below(5) == 0 {
        motion = with_uncertainty(motion, random);
    }
    motion
}

fn options(random: &mut Random) -> MotionOptions {
    let standard = MotionOptions::default();
    MotionOptions {
        tolerance: [standard.tolerance, standard.tolerance, 0.0, 0.05][random.below(4)],
        budget: [BUDGET, 1000, 10, 0][random.below(4)],
        order: [MotionOrder::Earliest, MotionOrder::Any][random.below(2)],
        ..standard
    }
}

/// True if no sample of a motion that nothing else moves collides.
fn are_samples_free(checker: &CollisionChecker, motion: &MotionSegment, workspace: &mut Workspace) -> bool {
    !motion.obstacles().is_empty()
        || (0..=200).all(|i| checker.is_free(&motion.at(f64::from(i) / 200.0), workspace))
}

#[test]
fn a_motion_is_free_exactly_if_the_check_finds_it_free() {
    let mut random = Random::new(5);
    let mut counts = [0; 2];
    for _ in 0..200 {
        let checker = checker(&mut random);
        let [mut used, mut other, mut portable] =
            [checker.workspace(), checker.workspace(), checker.portable_workspace()];
        for _ in 0..20 {
            let motion = motion(checker.robot(), checker.world(), &mut random);
            let options = options(&mut random);
            let earliest = MotionOptions { order: MotionOrder::Earliest, ..options.clone() };
            let report = checker.check_motion_with(&motion, &earliest, &mut other);
            let is_free = checker.is_motion_free_with(&motion, &options, &mut used);
            assert_eq!(is_free, report.is_free(), "{motion:?} {options:?} {report:?}");
            assert_eq!(is_free, checker.is_motion_free_with(&motion, &options, &mut portable));
            assert_eq!(is_free, checker.is_motion_free_with(&motion, &options, &mut checker.workspace()));
            assert!(!is_free || are_samples_free(&checker, &motion, &mut other), "{motion:?}");
            counts[usize::from(is_free)] += 1;
        }
    }
    assert!(counts.iter().all(|count| *count > 500), "{counts:?}");
}

#[test]
fn a_motion_of_another_robot_or_after_the_deadline_is_not_free() {
    let mut random = Random::new(8);
    let checkers: Vec<CollisionChecker> = (0..100).map(|_| checker(&mut random)).collect();
    let with_joints =
        |count| checkers.iter().find(|checker| checker.robot().position_names().len() == count).unwrap();
    let [one, other] = [2, 3].map(with_joints);
    let rest = other.robot().default_configuration();
    assert!(!one.is_motion_free(&rest, &rest, &mut one.workspace()));
    let over = MotionOptions { deadline: Some(std::time::Instant::now()), ..MotionOptions::default() };
    let motion = MotionSegment::straight(other.robot(), &rest, &rest);
    assert_eq!(other.are_motions_free(std::slice::from_ref(&motion), &over), [false]);
}

#[test]
fn threads_and_earlier_motions_change_no_result() {
    let mut random = Random::new(6);
    for _ in 0..10 {
        let checker = checker(&mut random);
        let motions: Vec<_> =
            (0..200).map(|_| motion(checker.robot(), checker.world(), &mut random)).collect();
        let options = MotionOptions { budget: BUDGET, ..MotionOptions::default() };
        let single = |motion| checker.is_motion_free_with(motion, &options, &mut checker.workspace());
        let expected: Vec<bool> = motions.iter().map(single).collect();
        for threads in [1, 2, 5] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            assert_eq!(pool.install(|| checker.are_motions_free(&motions, &options)), expected);
        }
        let mut free = vec![false; motions.len()];
        checker.are_motions_free_with(&motions, &options, &mut checker.workspace(), &mut free);
        assert_eq!(free, expected);
    }
}

/// Work of the check of some motions in both orders, and of the test whether they are free.
#[derive(Debug, Default)]
struct Works {
    earliest: Work,
    any: Work,
    free: Work,
}

fn works(checker: &CollisionChecker, motions: &[MotionSegment]) -> Works {
    let mut works = Works::default();
    let mut workspaces = [checker.workspace(), checker.workspace()];
    for motion in motions {
        let mut in_order = |order| {
            let options = MotionOptions { order, budget: BUDGET, ..MotionOptions::default() };
            checker.check_motion_with(motion, &options, &mut workspaces[0]).work
        };
        works.earliest += in_order(MotionOrder::Earliest);
        works.any += in_order(MotionOrder::Any);
        let options = MotionOptions { budget: BUDGET, ..MotionOptions::default() };
        let _ = checker.is_motion_free_with(motion, &options, &mut workspaces[1]);
        works.free += workspaces[1].work();
    }
    works
}

/// Free motions take the work of the earliest contact, colliding ones no more than that of any contact.
#[test]
fn the_work_is_that_of_the_cheaper_order() {
    let mut random = Random::new(7);
    let mut sums = [Works::default(), Works::default()];
    for _ in 0..60 {
        let checker = checker(&mut random);
        let mut workspace = checker.workspace();
        let mut motions = [Vec::new(), Vec::new()];
        for _ in 0..60 {
            let from = state(checker.robot(), &mut random);
            if checker.is_free(&from, &mut workspace) {
                let motion = motion_from(&from, checker.robot(), &mut random);
                let options = MotionOptions { budget: BUDGET, ..MotionOptions::default() };
                let is_free = checker.is_motion_free_with(&motion, &options, &mut workspace);
                motions[usize::from(is_free)].push(motion);
            }
        }
        for (sum, motions) in sums.iter_mut().zip(&motions) {
            let works = works(&checker, motions);
            sum.earliest += works.earliest;
            sum.any += works.any;
            sum.free += works.free;
        }
    }
    let tests = |work: &Work| work.volume_tests + work.primitive_tests;
    let [colliding, free] = &sums;
    assert!(10 * tests(&free.free) <= 11 * tests(&free.earliest), "{free:?}");
    assert!(tests(&colliding.free) <= tests(&colliding.any), "{colliding:?}");
    let primitives = |work: &Work| work.primitive_tests;
    assert!(2 * primitives(&colliding.free) <= primitives(&colliding.earliest), "{colliding:?}");
}

/// Obstacles of free motions are placed where their limits allow: away by as much as possible, in random directions.
#[test]
fn obstacles_within_their_limits_touch_nothing_on_free_motions() {
    let mut random = Random::new(91);
    let (mut placed, mut touched) = (0, 0);
    while placed < 3000 {
        let checker = checker(&mut random);
        let from = state(checker.robot(), &mut random);
        let motion = with_uncertainty(motion_from(&from, checker.robot(), &mut random), &mut random);
        let Some(uncertainty) = motion.uncertainty() else { continue };
        let options = MotionOptions { budget: BUDGET, ..MotionOptions::default() };
        let is_free = checker.is_motion_free_with(&motion, &options, &mut checker.workspace());
        for _ in 0..5 {
            let t = random.within(0.5) + 0.5;
            let mut world = checker.world().clone();
            for obstacle in checker.world().obstacles() {
                let way = random.direction().into_inner() * uncertainty.of(&obstacle.name, t);
                let deviation = Pose::from_parts(way.into(), Rotation::identity());
                world.move_to(&obstacle.name, deviation * obstacle.pose_ro).unwrap();
            }
            let settings = checker.settings().clone();
            let elsewhere = CollisionChecker::new(Arc::clone(checker.robot()), &world, settings).unwrap();
            let is_apart = elsewhere.is_free(&motion.at(t), &mut elsewhere.workspace());
            assert!(is_apart || !is_free, "{motion:?} at {t}");
            placed += u32::from(is_free);
            touched += u32::from(!is_free && !is_apart);
        }
    }
    assert!(touched > 100, "{touched}");
}
