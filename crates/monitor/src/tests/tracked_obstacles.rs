//! Tests of tracked obstacles, which move at a published velocity: time to contact, speed scale, checks between states.

use clearance_geometry::math::{Pose, Vector, pose_from_xyz_rpy};
use clearance_geometry::{Primitive, Shape};
use clearance_motion::{ObstacleLimits, SpeedLimit};
use clearance_scene::{Obstacle, ObstacleShape, ObstacleTwist};
use std::sync::OnceLock;

use super::*;

/// Distance (m) from the robot's outstretched ball to the cart.
const GAP: f64 = 1.0;

/// A ball of 10 cm in front of the robot, and its velocity in the root frame at this time (s).
fn cart(pose_ro: Pose, linear: [f64; 3], angular: [f64; 3], seconds: f64) -> Arc<Revision> {
    let ball = Primitive::Sphere { radius: 0.1 };
    cart_of(ball, pose_ro, [linear, angular], seconds)
}

fn cart_of(shape: Primitive, pose_ro: Pose, velocity: [[f64; 3]; 2], seconds: f64) -> Arc<Revision> {
    let mut world = World::default();
    world.add(Obstacle::of_shape("cart", pose_ro, Shape::Primitive(shape))).unwrap();
    let checker = CollisionChecker::new(robot(), &world, Settings::default()).unwrap();
    let [linear_o, angular_o] = velocity.map(|v| pose_ro.rotation.inverse() * Vector::from(v));
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

/// One model for all worlds.
fn robot() -> Arc<RobotModel> {
    static ROBOT: OnceLock<Arc<RobotModel>> = OnceLock::new();
    let read = || Arc::new(RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap());
    Arc::clone(ROBOT.get_or_init(read))
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

/// It reached the robot 0.2 s after its pose, and goes on in the model, through the robot and beyond.
#[test]
fn an_obstacle_that_should_have_touched_by_now_has_no_time_left() {
    let limit = SpeedLimit::default();
    for (age, is_left) in [(0.1, true), (0.19, true), (0.21, false), (0.3, false), (0.7, false)] {
        let found = time_to_contact(cart(in_front(), [-5.0, 0.0, 0.0], [0.0; 3], 1.0 - age), limit);
        assert_eq!(found > 0.0, is_left, "{found} s left after {age} s");
    }
    // beside the robot it goes on
    let beside = Pose::translation(2.2 + GAP, 0.5, 0.0);
    assert!(time_to_contact(cart(beside, [-5.0, 0.0, 0.0], [0.0; 3], 0.9), limit) > 0.0);
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

/// The motion from a state 0.2 s before, with the arm turned by an angle (rad).
fn motion_beside(worlds: [Arc<Revision>; 2], settings: MonitorSettings, angle: f64) -> MotionSincePrevious {
    let settings = MonitorSettings { check_between_states: true, ..settings };
    let mut monitor = Monitor::new(settings, stopwatch);
    let [before, now] = worlds;
    monitor.set_checker(before);
    monitor.on_joint_state(state(0.8, [angle, 0.0]), at(0.8));
    monitor.set_checker(now);
    let evaluation = monitor.on_joint_state(state(1.0, FREE), at(1.0));
    assert_eq!(code(&evaluation), "FREE");
    evaluation.motion_since_previous
}

/// A cart at this distance (m) from the ball.
fn cart_at(gap: f64, linear: [f64; 3], seconds: f64) -> Arc<Revision> {
    cart(Pose::translation(2.2 + gap, 0.0, 0.0), linear, [0.0; 3], seconds)
}

fn assert_may_have_moved(motion: &MotionSincePrevious) {
    let MotionSincePrevious::NotProven { why, .. } = motion else { panic!("{motion:?}") };
    assert_eq!(*why, GapReason::ObstacleMoves { name: "cart".to_owned() });
}

/// In 0.2 s, the cart has moved by up to 0.1 m.
#[test]
fn motions_beside_a_moving_obstacle_are_proven_with_its_motion() {
    let beside = |gap, linear| {
        let world = cart_at(gap, linear, 1.0);
        motion_beside([Arc::clone(&world), world], MonitorSettings::default(), 0.01)
    };
    let linear = [0.0, 0.5, 0.0];
    assert_eq!(beside(0.15, linear), MotionSincePrevious::ProvenFree);
    assert_eq!(beside(0.05, [0.0; 3]), MotionSincePrevious::ProvenFree);
    assert_may_have_moved(&beside(0.05, linear));
}

/// It rests now, and was on its way to where it is at the state before.
#[test]
fn the_velocity_at_the_start_of_the_motion_counts() {
    let [before, now] = [cart_at(0.15, [-0.5, 0.0, 0.0], 0.8), cart_at(0.05, [0.0; 3], 1.0)];
    let motion = motion_beside([before, now], MonitorSettings::default(), 0.01);
    assert_may_have_moved(&motion);
    let [before, now] = [cart_at(0.25, [-0.5, 0.0, 0.0], 0.8), cart_at(0.15, [0.0; 3], 1.0)];
    let motion = motion_beside([before, now], MonitorSettings::default(), 0.01);
    assert_eq!(motion, MotionSincePrevious::ProvenFree);
}

/// Up to ½ · 2 · 0.2² = 0.04 m from rest; with a pose that is 0.1 s old, 0.09 m.
#[test]
fn an_obstacle_at_rest_may_have_accelerated() {
    let limit = SpeedLimit { speed: 0.0, acceleration: 2.0 };
    let beside = |gap, seconds| {
        let obstacle_limits = Arc::new(ObstacleLimits { default: limit, ..ObstacleLimits::default() });
        let settings = MonitorSettings { obstacle_limits, ..MonitorSettings::default() };
        let world = cart_at(gap, [0.0; 3], seconds);
        motion_beside([Arc::clone(&world), world], settings, 0.001)
    };
    assert_eq!(beside(0.06, 1.0), MotionSincePrevious::ProvenFree);
    assert_may_have_moved(&beside(0.03, 1.0));
    assert_may_have_moved(&beside(0.06, 0.9));
}

/// Limits of obstacles that nobody tracks: 0.5 m/s for 0.2 s, and the latency.
#[test]
fn limits_of_obstacles_count_between_states() {
    let beside = |gap: f64, obstacle_latency, name: &str| {
        let mut world = World::default();
        let ball = Shape::Primitive(Primitive::Sphere { radius: 0.1 });
        world.add(Obstacle::of_shape("cart", Pose::translation(2.2 + gap, 0.0, 0.0), ball)).unwrap();
        let checker = CollisionChecker::new(robot(), &world, Settings::default()).unwrap();
        let world = Arc::new(Revision::new(checker, 1, 1));
        let limit = (Some(name.to_owned()), SpeedLimit { speed: 0.5, acceleration: 0.0 });
        let obstacle_limits = Arc::new(ObstacleLimits::from_list([limit]).unwrap());
        let settings = MonitorSettings { obstacle_limits, obstacle_latency, ..MonitorSettings::default() };
        motion_beside([Arc::clone(&world), world], settings, 0.001)
    };
    assert_eq!(beside(0.12, 0.0, "cart"), MotionSincePrevious::ProvenFree);
    assert_may_have_moved(&beside(0.12, 0.1, "cart"));
    assert_may_have_moved(&beside(0.08, 0.0, "cart"));
    assert_eq!(beside(0.08, 0.1, "other"), MotionSincePrevious::ProvenFree);
}

/// The shoulder is 0.2 s newer than the elbow, at whose time the cart was seen.
#[test]
fn the_times_of_the_joints_count() {
    let beside = |gap, elbow: f64| {
        let world = SpeedDistances { slowdown: 0.5, stop: 0.1 };
        let speed = SpeedSettings { world, reaction_time: 0.0, release_count: 1, ..SpeedSettings::default() };
        let settings = MonitorSettings { check_between_states: true, speed, ..MonitorSettings::default() };
        let mut monitor = Monitor::new(settings, stopwatch);
        monitor.set_checker(cart_at(gap, [0.5, 0.0, 0.0], elbow));
        let send = |monitor: &mut Monitor, source, joint: &str, seconds: f64, shown: f64| {
            let input = JointStateInput {
                source: SourceId([source; 16]),
                velocities: vec![0.0],
                ..input(seconds, &[(joint, 0.0)])
            };
            monitor.on_joint_state(input, at(shown))
        };
        send(&mut monitor, 1, "elbow", elbow, elbow);
        send(&mut monitor, 2, "shoulder", 1.19, 1.19);
        let evaluation = send(&mut monitor, 2, "shoulder", 1.2, 1.2);
        assert_eq!(code(&evaluation), "FREE");
        (evaluation.speed_scale, evaluation.motion_since_previous)
    };
    // a distance of 0.3 m less 0.01 m, for a first state that is 0.01 s older than the cart's
    let (share, motion) = beside(0.3, 1.2);
    assert!((share - 0.475).abs() < 1e-9 && motion == MotionSincePrevious::ProvenFree, "{share} {motion:?}");
    // less 0.1 m
    let (share, motion) = beside(0.3, 1.0);
    assert!((share - 0.25).abs() < 1e-9 && motion == MotionSincePrevious::ProvenFree, "{share} {motion:?}");
    assert_may_have_moved(&beside(0.08, 1.0).1);
}

/// Two posts as one obstacle: one is 0.3 m ahead of the ball, the other one 0.5 m beside it and comes sideways.
#[test]
fn a_part_that_is_not_the_nearest_one_may_come_nearer() {
    let ball = || Shape::Primitive(Primitive::Sphere { radius: 0.1 });
    let at = |x, y| ObstacleShape { pose_os: Pose::translation(x, y, 0.0), shape: ball() };
    let share = |shapes: Vec<ObstacleShape>| {
        let mut world = World::default();
        let shapes = shapes.into();
        world.add(Obstacle { shapes, ..Obstacle::of_shape("cart", Pose::identity(), ball()) }).unwrap();
        let checker = CollisionChecker::new(robot(), &world, Settings::default()).unwrap();
        let mut revision = Revision::new(checker, 1, 1);
        revision.obstacle_twists.push(ObstacleTwist {
            name: "cart".to_owned(),
            linear_o: Vector::new(0.0, -1.0, 0.0),
            angular_o: Vector::default(),
            stamp: time(START + 1.0),
            received: Duration::from_secs(1),
        });
        let world = SpeedDistances { slowdown: 0.25, stop: 0.1 };
        let speed = SpeedSettings { world, reaction_time: 0.5, release_count: 1, ..SpeedSettings::default() };
        evaluated(Arc::new(revision), MonitorSettings { speed, ..MonitorSettings::default() }).speed_scale
    };
    assert_eq!(share(vec![at(2.5, 0.0), at(2.0, 0.7)]), 0.0);
    assert_eq!(share(vec![at(2.5, 0.0)]), 1.0);
}

/// A door whose hinge is 1 m beside the ball, and which is far from it.
#[test]
fn a_door_comes_round_in_the_reaction_time() {
    let door = Shape::Primitive(Primitive::cuboid([0.02, 2.0, 1.0]).unwrap());
    let mut world = World::default();
    let shapes =
        vec![ObstacleShape { pose_os: Pose::translation(0.0, 1.0, 0.0), shape: door.clone() }].into();
    let hinge = Pose::translation(3.0, -0.2, 0.0);
    world.add(Obstacle { shapes, ..Obstacle::of_shape("door", hinge, door) }).unwrap();
    let checker = CollisionChecker::new(robot(), &world, Settings::default()).unwrap();
    let mut revision = Revision::new(checker, 1, 1);
    revision.obstacle_twists.push(ObstacleTwist {
        name: "door".to_owned(),
        linear_o: Vector::default(),
        angular_o: Vector::new(0.0, 0.0, 3.0),
        stamp: time(START + 1.0),
        received: Duration::from_secs(1),
    });
    let speed = SpeedSettings {
        world: SpeedDistances { slowdown: 0.25, stop: 0.1 },
        reaction_time: 1.0,
        release_count: 1,
        ..SpeedSettings::default()
    };
    let settings = MonitorSettings { speed, ..MonitorSettings::default() };
    assert_eq!(evaluated(Arc::new(revision), settings).speed_scale, 0.0);
}

/// A point at 0.5 m from the centre, once around between the pose and the state.
/// The end of a bar that turns comes nearer within the reaction time.
#[test]
fn a_long_obstacle_that_turns_is_slowed_for_at_any_distance() {
    let bar = Primitive::cuboid([0.1, 4.0, 0.1]).unwrap();
    let speed = SpeedSettings {
        world: SpeedDistances { slowdown: 0.3, stop: 0.1 },
        reaction_time: 1.0,
        release_count: 1,
        trigger_count: 1,
        ..SpeedSettings::default()
    };
    for gap in [0.5, 1.2, 1.4, 1.6, 1.8] {
        let scale = |angular: f64| {
            let pose = Pose::translation(2.2 + 0.05 + gap, 0.0, 0.0);
            let revision = cart_of(bar, pose, [[0.0; 3], [0.0, 0.0, angular]], 1.0);
            let settings = MonitorSettings { speed: speed.clone(), ..MonitorSettings::default() };
            evaluated(revision, settings).speed_scale
        };
        assert_eq!([scale(0.0), scale(1.5)], [1.0, 0.0], "{gap}");
    }
}

#[test]
fn a_whole_turn_is_no_rest() {
    let world = SpeedDistances { slowdown: 3.0, stop: 0.5 };
    let speed = SpeedSettings { world, reaction_time: 0.0, release_count: 1, ..SpeedSettings::default() };
    let settings = MonitorSettings { distance_limit: 10.0, speed, ..MonitorSettings::default() };
    let share = |age: f64| {
        let revision = cart(in_front(), [0.0; 3], [0.0, 0.0, std::f64::consts::TAU / 0.5], 1.0 - age);
        evaluated(revision, settings.clone()).speed_scale
    };
    assert!((share(0.0) - (GAP - 0.5) / 2.5).abs() < 1e-6);
    assert!((share(0.5) - (GAP - 0.2 - 0.5) / 2.5).abs() < 1e-6, "twice the radius of 0.1 m: {}", share(0.5));
}

/// Speed and separation monitoring: a cart at 3 m/s, which is declared to rest, or a person to be at 1.6 m/s.
#[test]
fn a_measured_speed_counts_for_the_separation() {
    let usual = SeparationSettings {
        human_speed: 1.6,
        robot_speed: 1.0,
        reaction_time: 0.1,
        deceleration: 5.0,
        acceleration: 0.0,
        margin: 0.1,
    };
    let share_of = |resting: &[&str], revision: Arc<Revision>| {
        let resting_obstacles = resting.iter().map(|name| (*name).to_owned()).collect();
        let rules = SeparationRules { resting_obstacles, ..SeparationRules::of_all(usual) };
        let speed = SpeedSettings { separation: Some(rules), release_count: 1, ..SpeedSettings::default() };
        let settings = MonitorSettings { speed, ..MonitorSettings::default() };
        evaluated(revision, settings).speed_scale
    };
    let share = |resting: &[&str], linear| share_of(resting, cart(in_front(), linear, [0.0; 3], 1.0));
    let with_speed = |human_speed| SeparationSettings { human_speed, ..usual }.allowed_speed(GAP).min(1.0);
    assert!(with_speed(3.0) < with_speed(1.6));
    let fast = [-3.0, 0.0, 0.0];
    for (resting, linear, expected) in [
        (&[][..], [0.0; 3], with_speed(1.6)),
        (&[], [0.5, 0.0, 0.0], with_speed(1.6)),
        (&[], fast, with_speed(3.0)),
        (&["cart"], fast, with_speed(3.0)),
        (&["cart"], [0.0; 3], 1.0),
    ] {
        let found = share(resting, linear);
        assert!((found - expected).abs() < 1e-9, "{resting:?} {linear:?}: {found}, not {expected}");
    }
    // its pose is 0.2 s old
    let found = share_of(&[], cart(in_front(), fast, [0.0; 3], 0.8));
    let expected = SeparationSettings { human_speed: 3.0, margin: 0.1 + 0.6, ..usual }.allowed_speed(GAP);
    assert!((found - expected).abs() < 1e-6, "{found}, not {expected}");
    // its points turn about a centre 10 cm away, the nearest ones too
    let found = share_of(&[], cart(in_front(), [0.0; 3], [0.0, 0.0, 30.0], 1.0));
    assert!((found - with_speed(3.0)).abs() < 1e-6, "{found}, not {}", with_speed(3.0));
}

/// The motion through one of two balls of 1 cm: a cart that moves, and a post.
fn passes(passed: &str) -> MotionSincePrevious {
    let mut world = World::default();
    for (name, angle) in [("cart", 0.0), ("post", 1.5)] {
        let ball = Shape::Primitive(Primitive::Sphere { radius: 0.01 });
        let pose_ro = pose_from_xyz_rpy([2.0 * f64::cos(angle), 2.0 * f64::sin(angle), 0.0], [0.0; 3]);
        world.add(Obstacle::of_shape(name, pose_ro, ball)).unwrap();
    }
    let checker = CollisionChecker::new(robot(), &world, Settings::default()).unwrap();
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
