//! Obstacles that move at a velocity of their own.

use clearance_geometry::math::{Pose, Vector, pose_from_xyz_rpy};
use clearance_geometry::{Primitive, Shape};
use clearance_motion::{ObstacleLimits, SpeedLimit};
use clearance_scene::{Obstacle, ObstacleTwist};

use super::*;

/// Distance (m) from the robot's outstretched ball to the cart.
const GAP: f64 = 1.0;

/// A ball of 10 cm in front of the robot, and its velocity in the root frame at this time (s).
fn cart(pose_ro: Pose, linear: [f64; 3], angular: [f64; 3], seconds: f64) -> Arc<Revision> {
    let mut world = World::default();
    let ball = Shape::Primitive(Primitive::Sphere { radius: 0.1 });
    world.add(Obstacle::of_shape("cart", pose_ro, ball)).unwrap();
    let robot = RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap();
    let checker = CollisionChecker::new(Arc::new(robot), &world, Settings::default()).unwrap();
    let [linear_o, angular_o] = [linear, angular].map(|v| pose_ro.rotation.inverse() * Vector::from(v));
    let twist = ObstacleTwist {
        name: "cart".to_owned(),
        linear_o,
        angular_o,
        stamp: time(START + seconds),
        received: Duration::from_secs_f64(seconds),
    };
    let mut revision = Revision::new(checker, 1, 1);
    revision.obstacle_twists.push(twist);
    Arc::new(revision)
}

fn in_front() -> Pose {
    pose_from_xyz_rpy([2.2 + GAP, 0.0, 0.0], [0.3, -0.5, 2.0])
}

/// The evaluation of a robot at rest, one second after the start.
fn evaluated(revision: Arc<Revision>, settings: MonitorSettings) -> Evaluation {
    let mut monitor = Monitor::new(settings, stopwatch);
    monitor.set_checker(revision);
    let evaluation = monitor.on_joint_state(moving(1.0, FREE, &[0.0, 0.0]), at(1.0));
    assert_eq!(code(&evaluation), "FREE");
    evaluation
}

fn looking_ahead(limit: SpeedLimit) -> MonitorSettings {
    let obstacle_limits = Arc::new(ObstacleLimits { default: limit, ..ObstacleLimits::default() });
    // the joints do not accelerate
    let (look_ahead_horizon, look_ahead_acceleration) = (3.0, 0.0);
    MonitorSettings { look_ahead_horizon, look_ahead_acceleration, obstacle_limits, ..settings_of_lookout() }
}

fn time_to_contact(revision: Arc<Revision>, limit: SpeedLimit) -> f64 {
    evaluated(revision, looking_ahead(limit)).time_to_contact()
}

#[test]
fn the_time_to_contact_is_that_of_the_motion() {
    let rest = SpeedLimit::default();
    for (linear, first) in [
        ([-0.5, 0.0, 0.0], 2.0),
        ([-1.0, 0.0, 0.0], 1.0),
        ([0.5, 0.0, 0.0], f64::INFINITY),
        ([0.0, -0.5, 0.0], f64::INFINITY),
        ([-0.5, 0.5, 0.0], f64::INFINITY),
    ] {
        let found = time_to_contact(cart(in_front(), linear, [0.0; 3], 1.0), rest);
        assert!(found <= first && found > first.min(3.0) - 0.02, "{found} {first}");
    }
    // turning about its own centre changes nothing
    let found = time_to_contact(cart(in_front(), [-0.5, 0.0, 0.0], [1.0, -2.0, 3.0], 1.0), rest);
    assert!((1.9..=2.0).contains(&found), "{found}");
}

#[test]
fn the_stamp_of_the_pose_counts() {
    // the pose is 0.4 s older than the state, or 0.3 s newer
    for (seconds, first) in [(0.6, 1.6), (1.3, 2.3)] {
        let revision = cart(in_front(), [-0.5, 0.0, 0.0], [0.0; 3], seconds);
        let found = time_to_contact(revision, SpeedLimit::default());
        assert!(found <= first && found > first - 0.02, "{found} {first}");
    }
}

#[test]
fn an_acceleration_limit_allows_departures_and_a_speed_limit_none() {
    let linear = [-0.5, 0.0, 0.0];
    let with = |speed, acceleration, seconds| {
        let limit = SpeedLimit { speed, acceleration };
        time_to_contact(cart(in_front(), linear, [0.0; 3], seconds), limit)
    };
    assert_eq!(with(0.0, 0.0, 1.0), with(5.0, 0.0, 1.0));
    // 0.5 t + t² / 2 = 1
    let exact = (0.25_f64 + 2.0).sqrt() - 0.5;
    let found = with(0.0, 1.0, 1.0);
    assert!(found <= exact && found > exact - 0.02, "{found} {exact}");
    // it may have accelerated since its pose: 0.5 (t + 0.2) + (t + 0.2)² / 2 = 1
    let found = with(0.0, 1.0, 0.8);
    assert!(found <= exact - 0.2 && found > exact - 0.22, "{found} {exact}");
}

/// An obstacle at rest may start to move at any time since its pose; without an acceleration limit, its speed limit applies.
#[test]
fn limits_of_an_obstacle_at_rest_hold() {
    let with = |speed, acceleration| {
        let limit = SpeedLimit { speed, acceleration };
        time_to_contact(cart(in_front(), [0.0; 3], [0.0; 3], 0.8), limit)
    };
    assert!(with(0.0, 0.0) >= 3.0);
    for (found, exact) in [(with(0.5, 0.0), 2.0), (with(0.0, 2.0), 1.0 - 0.2)] {
        assert!(found <= exact && found > exact - 0.05, "{found} {exact}");
    }
}

/// The clock was set back by a minute since the last state.
#[test]
fn a_stamp_of_another_clock_says_nothing() {
    let revision = cart(in_front(), [-0.5, 0.0, 0.0], [0.0; 3], 61.0);
    let evaluation = evaluated(revision, looking_ahead(SpeedLimit::default()));
    assert!(evaluation.time_to_contact() <= 0.0);
    let why = "the last state of obstacle 'cart' has a later stamp";
    assert!(evaluation.warnings.iter().any(|found| found.contains(why)), "{:?}", evaluation.warnings);
}

#[test]
fn the_motion_is_reported() {
    let with =
        |linear| evaluated(cart(in_front(), linear, [0.0; 3], 1.0), looking_ahead(SpeedLimit::default()));
    assert!(with([0.5, 0.0, 0.0]).checked_state.unwrap().obstacles_may_move);
    assert!(!with([0.0; 3]).checked_state.unwrap().obstacles_may_move);
}

#[test]
fn the_speed_scale_counts_the_velocity_along_its_direction() {
    let world = SpeedDistances { slowdown: 1.5, stop: 0.5 };
    let still = SpeedDistances { slowdown: 0.0, stop: 0.0 };
    let share_at = |linear: [f64; 3], acceleration, seconds| {
        let speed = SpeedSettings {
            own: still,
            world,
            reaction_time: 0.2,
            trigger_count: 1,
            release_count: 1,
            separation: None,
        };
        let default = SpeedLimit { speed: 9.0, acceleration };
        let obstacle_limits = Arc::new(ObstacleLimits { default, ..ObstacleLimits::default() });
        let settings = MonitorSettings { speed, obstacle_limits, ..MonitorSettings::default() };
        evaluated(cart(in_front(), linear, [0.0; 3], seconds), settings).speed_scale
    };
    let share = |linear, acceleration| share_at(linear, acceleration, 1.0);
    // (1 m - 0.2 s · 0.5 m/s - 0.5 m) / 1 m
    assert!((share([-0.5, 0.0, 0.0], 0.0) - 0.4).abs() < 1e-6);
    assert!((share([-0.5, 3.0, 0.0], 0.0) - 0.4).abs() < 1e-3, "what passes by does not approach");
    // 2 m/s² · (0.2 s)² / 2
    assert!((share([-0.5, 0.0, 0.0], 2.0) - 0.36).abs() < 1e-6);
    assert!((share([0.5, 0.0, 0.0], 0.0) - 0.5).abs() < 1e-6, "what moves away counts where it is");
    // its pose is 0.4 s older than the state, or newer: 0.2 m
    for seconds in [0.6, 1.4] {
        assert!((share_at([-0.5, 0.0, 0.0], 0.0, seconds) - 0.2).abs() < 1e-6);
    }
    // from beyond the slow-down distance
    assert!((share([-4.0, 0.0, 0.0], 0.0)).abs() < 1e-6);
}

/// The motion from a state 0.2 s before, with the arm turned by an angle (rad), while the cart moves.
fn motion_since_previous(gap: f64, linear: [f64; 3], angle: f64) -> MotionSincePrevious {
    let settings = MonitorSettings { check_between_states: true, ..MonitorSettings::default() };
    let mut monitor = Monitor::new(settings, stopwatch);
    monitor.set_checker(cart(Pose::translation(2.2 + gap, 0.0, 0.0), linear, [0.0; 3], 1.0));
    monitor.on_joint_state(state(0.8, [angle, 0.0]), at(0.8));
    let evaluation = monitor.on_joint_state(state(1.0, FREE), at(1.0));
    assert_eq!(code(&evaluation), "FREE");
    evaluation.motion_since_previous
}

/// In 0.2 s, the cart has moved by up to 0.1 m.
#[test]
fn motions_beside_a_moving_obstacle_are_proven_with_its_motion() {
    let linear = [0.0, 0.5, 0.0];
    assert_eq!(motion_since_previous(0.15, linear, 0.01), MotionSincePrevious::ProvenFree);
    assert_eq!(motion_since_previous(0.05, [0.0; 3], 0.01), MotionSincePrevious::ProvenFree);
    let near = motion_since_previous(0.05, linear, 0.01);
    let MotionSincePrevious::NotProven { why, .. } = near else { panic!("{near:?}") };
    assert_eq!(why, GapReason::ObstacleMoves { name: "cart".to_owned() });
}

/// The motion through one of two balls of 1 cm: a cart that moves, and a post.
fn passes(passed: &str) -> MotionSincePrevious {
    let mut world = World::default();
    for (name, angle) in [("cart", 0.0), ("post", 1.5)] {
        let ball = Shape::Primitive(Primitive::Sphere { radius: 0.01 });
        let pose_ro = pose_from_xyz_rpy([2.0 * f64::cos(angle), 2.0 * f64::sin(angle), 0.0], [0.0; 3]);
        world.add(Obstacle::of_shape(name, pose_ro, ball)).unwrap();
    }
    let robot = RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap();
    let checker = CollisionChecker::new(Arc::new(robot), &world, Settings::default()).unwrap();
    let mut revision = Revision::new(checker, 1, 1);
    revision.obstacle_twists.push(ObstacleTwist {
        name: "cart".to_owned(),
        linear_o: Vector::new(0.0, 0.1, 0.0),
        angular_o: Vector::default(),
        stamp: time(START + 1.0),
        received: Duration::from_secs(1),
    });
    let settings = MonitorSettings { check_between_states: true, ..MonitorSettings::default() };
    let mut monitor = Monitor::new(settings, stopwatch);
    monitor.set_checker(Arc::new(revision));
    let middle = if passed == "cart" { 0.0 } else { 1.5 };
    monitor.on_joint_state(state(0.8, [middle - 0.2, 0.0]), at(0.8));
    monitor.on_joint_state(state(1.0, [middle + 0.2, 0.0]), at(1.0)).motion_since_previous
}

#[test]
fn what_stands_is_passed_through_and_what_moves_perhaps() {
    let MotionSincePrevious::PassedThrough(passage) = passes("post") else { panic!("{:?}", passes("post")) };
    assert!(passage.pair.is_some() && passage.t[0] > 0.2 && passage.t[1] < 0.8, "{passage:?}");
    let MotionSincePrevious::NotProven { why, .. } = passes("cart") else { panic!("{:?}", passes("cart")) };
    assert_eq!(why, GapReason::ObstacleMoves { name: "cart".to_owned() });
}
