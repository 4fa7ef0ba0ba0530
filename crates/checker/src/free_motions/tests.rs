//! Tests of free motions and the look-ahead: agreement with the full motion check, work, and moving obstacles.

use std::sync::Arc;

use clearance_geometry::math::{Pose, Rotation};
use clearance_geometry::testing::Random;
use clearance_motion::{MotionSegment, MovingObstacle, ObstacleLimits, ObstacleUncertainty, SpeedLimit};
use clearance_proximity::Work;
use clearance_robot::{Configuration, RobotModel};
use clearance_scene::World;

use crate::random_scenes::{checker, curved_motion, state};
use crate::{CollisionChecker, LookAheadState, MotionOptions, MotionOrder, Workspace};

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

/// Obstacles may move: all, or only one of them.
fn with_uncertainty(motion: MotionSegment, random: &mut Random) -> MotionSegment {
    let limit = |random: &mut Random| SpeedLimit {
        speed: [0.0, 0.01, 0.1][random.below(3)],
        acceleration: [0.0, 0.1][random.below(2)],
    };
    let default = if random.below(2) == 0 { SpeedLimit::default() } else { limit(random) };
    let limits = Arc::new(ObstacleLimits { default, by_name: [("o0".to_owned(), limit(random))].into() });
    let latency = [0.0, 0.1][random.below(2)];
    motion.with_uncertainty(ObstacleUncertainty::new(limits, [latency, latency + 1.0]).unwrap())
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

/// Known motions of about half of the obstacles, which have begun before.
fn motions_of_some(world: &World, random: &mut Random) -> Vec<MovingObstacle> {
    let mut motions = Vec::new();
    for obstacle in world.obstacles() {
        if random.below(2) == 0 {
            let mut vector = |size: f64| [0, 1, 2].map(|_| random.within(size));
            let (centre, linear, angular) = (vector(1.0), vector(0.5), vector(1.0));
            let name = obstacle.name.clone();
            let motion = MovingObstacle { name, centre, linear, angular, start: None };
            let begin = random.within(0.2);
            motions.push(motion.part([begin, begin + 1.0]));
        }
    }
    motions
}

/// Robot and obstacles accelerate at random within their limits; before the time of the look-ahead nothing touches. Returns
/// the number of motions that touched later, of at least so many that ended before.
fn touched_after_the_look_ahead(motions: u32, random: &mut Random) -> u32 {
    let (mut placed, mut touched) = (0, 0);
    while placed < motions {
        let checker = checker(random);
        let from = state(checker.robot(), random);
        let still = MotionSegment::straight(checker.robot(), &from, &from);
        let loose = with_uncertainty(still, random);
        let Some(text) = loose.text().obstacle_uncertainty else { continue };
        let limits = Arc::new(text.limits);
        let velocities: Vec<f64> = from.positions().iter().map(|_| random.within(1.0)).collect();
        let accelerations: Vec<f64> = from.positions().iter().map(|_| random.within(2.0).abs()).collect();
        let horizon = 1.0;
        let moving_obstacles = motions_of_some(checker.world(), random);
        let now = LookAheadState {
            q: &from,
            velocities: &velocities,
            accelerations: &accelerations,
            moving_obstacles: &moving_obstacles,
            obstacle_limits: Some(&limits),
            obstacle_latency: text.time[0],
            only_moving_obstacles: false,
        };
        let found = checker.look_ahead(now, horizon, &mut checker.workspace()).unwrap();
        for _ in 0..5 {
            let time = random.within(0.5) + 0.5;
            let uncertainty = |name: &str| limits.of(name).displacement(text.time[0] + time);
            let mut world = checker.world().clone();
            for obstacle in checker.world().obstacles() {
                let way = random.direction().into_inner() * uncertainty(&obstacle.name);
                let deviation = Pose::from_parts(way.into(), Rotation::identity());
                let known = moving_obstacles.iter().find(|mover| mover.name == obstacle.name);
                let moved = known.map_or_else(Pose::identity, |mover| mover.displacement(time / horizon));
                world.move_to(&obstacle.name, deviation * moved * obstacle.pose_ro).unwrap();
            }
            let later = (0..velocities.len()).map(|i| {
                let acceleration = [-1.0, 1.0, random.within(1.0)][random.below(3)] * accelerations[i];
                from.positions()[i] + velocities[i] * time + 0.5 * acceleration * time * time
            });
            let later: Vec<f64> = later.collect();
            let settings = checker.settings().clone();
            let elsewhere = CollisionChecker::new(Arc::clone(checker.robot()), &world, settings).unwrap();
            let later = checker.robot().configuration(&later).unwrap();
            let is_apart = elsewhere.is_free(&later, &mut elsewhere.workspace());
            assert!(is_apart || time >= found.free_for, "{found:?}, but a contact at {time}");
            placed += u32::from(time < found.free_for);
            touched += u32::from(!is_apart);
        }
    }
    touched
}

#[test]
fn nothing_touches_before_the_look_ahead_with_moving_obstacles() {
    let touched = touched_after_the_look_ahead(3000, &mut Random::new(92));
    assert!(touched > 100, "{touched}");
}

/// By hand: `cargo test --release -p clearance-checker -- --ignored --nocapture many_obstacle_motions`.
#[test]
#[ignore = "takes many minutes"]
fn many_obstacle_motions() {
    for thousands in 1..=1000 {
        let touched = touched_after_the_look_ahead(1000, &mut Random::new(92_000 + thousands));
        println!("{} motions: {touched} touched later", 1000 * thousands);
    }
}
