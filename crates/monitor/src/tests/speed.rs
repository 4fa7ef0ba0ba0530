//! Tests of the speed scale.

use clearance_geometry::math::Pose;
use clearance_geometry::{Primitive, Shape};
use clearance_motion::{ObstacleLimits, SpeedLimit};
use clearance_scene::{Obstacle, ObstacleShape};
use proptest::prelude::*;

use super::*;

const SPEED: SpeedSettings = SpeedSettings {
    own: SpeedDistances { slowdown: 0.5, stop: 0.1 },
    world: SpeedDistances { slowdown: 0.0, stop: 0.0 },
    reaction_time: 0.1,
    trigger_count: 1,
    release_count: 1,
    separation: None,
};

/// A monitor with a speed scale; joint states are stale after half a second.
fn governed(speed: SpeedSettings) -> Monitor {
    let mut monitor = monitor();
    monitor.set_settings(MonitorSettings { speed, ..MonitorSettings::default() });
    monitor
}

/// The distance for an elbow position.
fn distance_at(elbow: f64) -> f64 {
    governed(SPEED).on_joint_state(state(0.0, [0.0, elbow]), at(0.0)).distance()
}

#[test]
fn the_speed_is_that_of_the_distance_and_the_way_to_it() {
    let (near, distance) = ([0.0, 2.6], distance_at(2.6));
    assert!((0.1..0.5).contains(&distance), "{distance}");
    let share = |velocities: &[f64]| {
        governed(SPEED).on_joint_state(moving(0.0, near, velocities), at(0.0)).speed_scale
    };
    let at_rest = (distance - 0.1) / 0.4;
    assert!((share(&[0.0, 0.0]) - at_rest).abs() < 1e-9);
    assert_eq!(share(&[]), share(&[0.0, 0.0]), "where nothing is known of velocities, the distance counts");
    // the ball is above the base, slightly to the right: the shoulder moves it up or down
    assert_eq!(share(&[1.0, 0.0]), 1.0);
    assert!(share(&[-1.0, 0.0]) < at_rest);
    assert!(share(&[0.0, 0.3]) < at_rest);
    assert_eq!(share(&[0.0, 3.0]), 0.0);
    assert_eq!(share(&[0.0, -0.3]), 1.0);
    assert_eq!(governed(SPEED).on_joint_state(state(0.0, FREE), at(0.0)).speed_scale, 1.0);
}

/// A ball of 10 cm that is this far (m) from the robot's outstretched one.
fn beside_a_ball(gap: f64) -> Arc<Revision> {
    let mut world = World::default();
    let ball = Shape::Primitive(Primitive::Sphere { radius: 0.1 });
    world.add(Obstacle::of_shape("cart", Pose::translation(2.2 + gap, 0.0, 0.0), ball)).unwrap();
    let robot = RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap();
    let checker = CollisionChecker::new(Arc::new(robot), &world, Settings::default()).unwrap();
    Arc::new(Revision::new(checker, 1, 1))
}

#[test]
fn an_obstacle_that_may_move_counts_as_nearer() {
    let world = SpeedDistances { slowdown: 0.5, stop: 0.1 };
    let limit = |speed, acceleration| SpeedLimit { speed, acceleration };
    let cart = |of| [("cart".to_owned(), of)].into();
    let share = |gap: f64, limits: ObstacleLimits| {
        let mut monitor = Monitor::new(MonitorSettings::default(), stopwatch);
        monitor.set_checker(beside_a_ball(gap));
        monitor.set_settings(MonitorSettings {
            speed: SpeedSettings { world, ..SPEED },
            obstacle_limits: Arc::new(limits),
            obstacle_latency: 0.1,
            ..MonitorSettings::default()
        });
        monitor.on_joint_state(moving(0.0, FREE, &[0.0, 0.0]), at(0.0)).speed_scale
    };
    let all = |default| ObstacleLimits { default, ..ObstacleLimits::default() };
    // within 0.2 s: 1 m/s · 0.2 s + 2 m/s² · (0.2 s)² / 2 = 0.24 m
    let named = ObstacleLimits { default: limit(5.0, 0.0), by_name: cart(limit(1.0, 2.0)) };
    for (gap, limits, expected) in [
        (0.4, all(limit(0.0, 0.0)), 0.75),
        (0.4, all(limit(1.0, 2.0)), 0.15),
        (0.4, named.clone(), 0.15),
        (0.6, all(limit(0.0, 0.0)), 1.0),
        (0.6, named.clone(), 0.65),
        (0.8, named, 1.0),
        (0.3, all(limit(1.6, 0.0)), 0.0),
    ] {
        let found = share(gap, limits);
        assert!((found - expected).abs() < 1e-9, "{gap} m: {found}, not {expected}");
    }
}

/// A wrong name is reported whatever the limits are used for: here neither a look-ahead nor slowing down is on.
#[test]
fn limits_of_obstacles_that_do_not_exist_are_a_warning() {
    let mut monitor = governed(SpeedSettings::default());
    monitor.set_checker(beside_a_ball(0.4));
    let limit = SpeedLimit { speed: 1.0, acceleration: 2.0 };
    let mut warnings = |names: &[&str]| {
        let by_name = names.iter().map(|name| ((*name).to_owned(), limit)).collect();
        let limits = ObstacleLimits { by_name, ..ObstacleLimits::default() };
        monitor.set_settings(MonitorSettings {
            obstacle_limits: Arc::new(limits),
            ..MonitorSettings::default()
        });
        monitor.on_joint_state(moving(0.0, FREE, &[0.0, 0.0]), at(0.0)).warnings.to_vec()
    };
    assert_eq!(warnings(&["cart"]), [""; 0]);
    assert_eq!(warnings(&["cart", "card"]), ["obstacle_limits: the world has no obstacle 'card'"]);
}

/// A robot that moves away from an obstacle is not slowed down, also if the obstacle may follow.
#[test]
fn moving_away_from_what_may_follow_is_not_slowed() {
    let mut monitor = Monitor::new(MonitorSettings::default(), stopwatch);
    monitor.set_checker(beside_a_ball(0.4));
    let world = SpeedDistances { slowdown: 0.5, stop: 0.1 };
    let default = SpeedLimit { speed: 10.0, acceleration: 0.0 };
    monitor.set_settings(MonitorSettings {
        speed: SpeedSettings { world, ..SPEED },
        obstacle_limits: Arc::new(ObstacleLimits { default, ..ObstacleLimits::default() }),
        ..MonitorSettings::default()
    });
    let mut share =
        |seconds, elbow: f64| monitor.on_joint_state(moving(seconds, [0.0, 0.4], &[0.0, elbow]), at(seconds));
    assert_eq!(share(0.0, 1.0).speed_scale, 1.0);
    assert_eq!(share(0.1, -1.0).speed_scale, 0.0);
}

/// Where the robot is slowed down, distances are exact: points that are only nearly the nearest ones have other
/// approach rates.
#[test]
fn tolerances_leave_the_speed_as_it_is() {
    let mut exact = governed(SPEED);
    let settings = MonitorSettings {
        speed: SPEED,
        influence_distance: 1.0,
        distance_absolute_tolerance: 0.3,
        distance_relative_tolerance: 0.5,
        ..MonitorSettings::default()
    };
    let [mut tolerant, mut until] = [(); 2].map(|()| governed(SPEED));
    tolerant.set_settings(settings.clone());
    until.set_settings(MonitorSettings { check_deadline: 10.0, ..settings });
    let mut slowed = 0;
    for i in 0..100 {
        let seconds = f64::from(i) * 0.01;
        let (positions, velocities) = ([0.2 * (9.0 * seconds).sin(), 2.2 + 0.9 * seconds], [0.3, 0.9]);
        let [exact, tolerant, until] = [&mut exact, &mut tolerant, &mut until].map(|monitor| {
            monitor.on_joint_state(moving(seconds, positions, &velocities), at(seconds)).speed_scale
        });
        assert_eq!([exact, exact], [tolerant, until], "after {seconds} s");
        slowed += u32::from(exact < 1.0);
    }
    assert!(slowed > 30, "{slowed} states were slowed down");
}

#[test]
fn without_velocities_the_last_state_gives_the_direction() {
    let mut monitor = governed(SPEED);
    let speeds: Vec<f64> = [(0.0, 2.6), (0.1, 2.61), (0.2, 2.6), (0.3, 2.6)]
        .map(|(t, elbow)| monitor.on_joint_state(state(t, [0.0, elbow]), at(t)).speed_scale)
        .into();
    let [resting, folding, opening, held] = speeds[..] else { panic!() };
    let by_velocity = |elbow, velocity| {
        governed(SPEED).on_joint_state(moving(0.0, [0.0, elbow], &[0.0, velocity]), at(0.0)).speed_scale
    };
    assert_eq!((resting, opening, held), (by_velocity(2.6, 0.0), 1.0, resting));
    assert!((folding - by_velocity(2.61, 0.1)).abs() < 1e-3, "{folding}");
}

/// Two drivers, one of them without velocities: their messages alternate.
#[test]
fn drivers_without_velocities_hide_none_of_others() {
    let arm = |seconds: f64, elbow: f64, velocity: f64| JointStateInput {
        velocities: vec![velocity],
        ..input(seconds, &[("elbow", elbow)])
    };
    let turntable =
        |seconds: f64| JointStateInput { source: SourceId([2; 16]), ..input(seconds, &[("shoulder", 0.0)]) };
    for (velocity, velocities_told) in [(0.2, true), (-0.2, true), (0.2, false), (-0.2, false)] {
        let speed = SpeedSettings { trigger_count: 3, release_count: 3, ..SPEED };
        let mut monitor = governed(speed);
        let mut scales = Vec::new();
        for i in 0..20 {
            let (seconds, elbow) = (0.02 * f64::from(i), 2.6 + velocity * 0.02 * f64::from(i));
            let told = arm(seconds, elbow, velocity);
            let told = JointStateInput {
                velocities: if velocities_told { told.velocities.clone() } else { vec![] },
                ..told
            };
            monitor.on_joint_state(told, at(seconds));
            let evaluation = monitor.on_joint_state(turntable(seconds + 0.01), at(seconds + 0.01));
            scales.push((evaluation.speed_scale, elbow));
        }
        for (scale, elbow) in &scales[8..] {
            // the share lags by the trigger and release counts
            let wanted =
                governed(SPEED).on_joint_state(moving(0.0, [0.0, *elbow], &[0.0, velocity]), at(0.0));
            assert!((scale - wanted.speed_scale).abs() < 0.05, "{velocity} at {elbow}: {scale}, {wanted:?}");
        }
    }
}

/// The slow-down distance is 0.5 m; a pair that is farther away is within it before the reaction time is over.
#[test]
fn what_comes_fast_is_slowed_down_from_beyond_also_without_velocities() {
    let mut monitor = governed(SPEED);
    let (rate, period) = (2.0, 0.01);
    let at_elbow = |i: i32| 2.1 + rate * period * f64::from(i);
    assert!(distance_at(at_elbow(5)) > 0.5);
    let mut from_beyond = 0;
    for i in 0..6 {
        let (elbow, seconds) = (at_elbow(i), period * f64::from(i));
        let told = monitor.on_joint_state(state(seconds, [0.0, elbow]), at(seconds)).speed_scale;
        let wanted =
            governed(SPEED).on_joint_state(moving(0.0, [0.0, elbow], &[0.0, rate]), at(0.0)).speed_scale;
        if i > 0 {
            assert!((told - wanted).abs() < 0.05, "{told} at {elbow}, and {wanted} with velocities");
            from_beyond += u32::from(told < 0.95);
        }
    }
    assert!(from_beyond > 0);
}

#[test]
fn what_is_not_free_has_no_speed() {
    let mut monitor = governed(SpeedSettings { release_count: 2, ..SpeedSettings::default() });
    let mut speed = |input, seconds| monitor.on_joint_state(input, at(seconds)).speed_scale;
    assert_eq!([speed(state(0.0, FREE), 0.0), speed(state(0.1, FREE), 0.1)], [0.0, 1.0]);
    assert_eq!(speed(state(0.2, COLLIDING), 0.2), 0.0);
    assert_eq!([speed(state(0.3, FREE), 0.3), speed(state(0.4, FREE), 0.4)], [0.0, 1.0]);
    assert_eq!(speed(state(0.5, [0.0, f64::NAN]), 0.5), 0.0);
    assert_eq!([speed(state(0.6, FREE), 0.6), speed(state(0.7, FREE), 0.7)], [0.0, 1.0]);
    // a heartbeat does not count as a state; a stale state stops the robot
    assert_eq!(monitor.on_heartbeat(at(1.0)).speed_scale, 1.0);
    assert_eq!(monitor.on_heartbeat(at(1.3)).speed_scale, 0.0);
    assert_eq!(monitor.on_joint_state(state(1.4, FREE), at(1.4)).speed_scale, 0.0);
    // a change of the world does not count as one of the states in a row
    monitor.on_joint_state(state(1.5, FREE), at(1.5));
    monitor.set_checker(revision(2));
    assert_eq!(monitor.on_joint_state(state(1.6, FREE), at(1.6)).speed_scale, 1.0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn the_speed_is_that_of_the_change_of_the_distance(elbow in 2.4..2.8f64, velocity in -2.0..2.0f64) {
        const STEP: f64 = 1e-4;
        let distance = distance_at(elbow);
        let rate = (distance_at(elbow - STEP * velocity) - distance_at(elbow + STEP * velocity)) / (2.0 * STEP);
        prop_assume!(rate.abs() > 0.01 && distance > 0.0 && distance < 0.5);
        let evaluation = governed(SPEED).on_joint_state(moving(0.0, [0.0, elbow], &[0.0, velocity]), at(0.0));
        let expected = if rate < 0.0 { 1.0 } else { ((distance - 0.1 * rate - 0.1) / 0.4).clamp(0.0, 1.0) };
        prop_assert!((evaluation.speed_scale - expected).abs() < 1e-3, "{} but {expected}", evaluation.speed_scale);
    }
}

/// A bar of 2 m that turns about its middle (or, with `middle` 1, about one end), beside a wall at x = 1.1.
fn beside_a_wall(middle: f64) -> Arc<Revision> {
    let urdf = format!(
        "<robot name='saw'><link name='base'/><link name='bar'><collision><origin xyz='0 {middle} 0'/>
        <geometry><box size='0.02 2 0.02'/></geometry></collision></link>
        <joint name='turn' type='revolute'><parent link='base'/><child link='bar'/><origin xyz='0.99 0 0'/><axis xyz='0 0 1'/>
        <limit lower='-9' upper='9' effort='1' velocity='9'/></joint></robot>"
    );
    let mut world = World::default();
    let wall = Shape::Primitive(Primitive::Box { half_extents: [0.5, 5.0, 5.0] });
    world.add(Obstacle::of_shape("wall", Pose::translation(1.6, 0.0, 0.0), wall)).unwrap();
    let robot = RobotModel::from_urdf(&urdf, &MeshFiles::default()).unwrap();
    let checker = CollisionChecker::new(Arc::new(robot), &world, Settings::default()).unwrap();
    Arc::new(Revision::new(checker, 1, 1))
}

#[test]
fn a_part_that_is_not_the_nearest_one_may_come_first() {
    let share = |middle, angle, rate| {
        let world = SpeedDistances { slowdown: 0.6, stop: 0.01 };
        let mut monitor = governed(SpeedSettings { world, ..SPEED });
        monitor.set_checker(beside_a_wall(middle));
        let input = JointStateInput {
            names: vec!["turn".to_owned()],
            positions: vec![angle],
            velocities: vec![rate],
            ..state(0.0, FREE)
        };
        monitor.on_joint_state(input, at(0.0)).speed_scale
    };
    let at_rest = share(0.0, 0.01, 0.0);
    assert!(at_rest > 0.1, "{at_rest}");
    // the nearest end leaves, and the other one comes: by 1 cm, and into the wall
    assert!(share(0.0, 0.01, 0.2) < 0.99 * at_rest);
    assert_eq!(share(0.0, 0.01, 5.0), 0.0);
    // about the nearest end, which stays where it is
    let at_rest = share(1.0, 0.02, 0.0);
    assert_eq!(share(1.0, 0.02, -5.0), 0.0);
    assert!(share(1.0, 0.02, 5.0) > 0.9 * at_rest, "the rest of it leaves");
}

/// A ball of 10 cm that slides along x between two others, 10 cm away behind it and 11 cm ahead.
fn between_two_balls(are_one: bool) -> Arc<Revision> {
    let urdf = "<robot name='slider'><link name='base'/><link name='ball'><collision>
        <geometry><sphere radius='0.1'/></geometry></collision></link>
        <joint name='slide' type='prismatic'><parent link='base'/><child link='ball'/><axis xyz='1 0 0'/>
        <limit lower='-9' upper='9' effort='1' velocity='9'/></joint></robot>";
    let ball = || Shape::Primitive(Primitive::Sphere { radius: 0.1 });
    let poses = [-0.3, 0.31].map(|x| Pose::translation(x, 0.0, 0.0));
    let mut world = World::default();
    if are_one {
        let shapes = poses.map(|pose_os| ObstacleShape { pose_os, shape: ball() });
        let one = Obstacle::of_shape("both", Pose::identity(), ball());
        world.add(Obstacle { shapes: shapes.into(), ..one }).unwrap();
    } else {
        for (name, pose) in ["behind", "ahead"].into_iter().zip(poses) {
            world.add(Obstacle::of_shape(name, pose, ball())).unwrap();
        }
    }
    let robot = RobotModel::from_urdf(urdf, &MeshFiles::default()).unwrap();
    let checker = CollisionChecker::new(Arc::new(robot), &world, Settings::default()).unwrap();
    Arc::new(Revision::new(checker, 1, 1))
}

#[test]
fn another_part_of_the_same_obstacle_counts_as_another_obstacle() {
    let shares = |are_one: bool, rate: f64, has_velocity: bool| {
        let world = SpeedDistances { slowdown: 0.5, stop: 0.01 };
        let mut monitor = governed(SpeedSettings { world, ..SPEED });
        monitor.set_checker(between_two_balls(are_one));
        let mut last = f64::NAN;
        for step in [-1.0, 0.0] {
            let seconds = 0.01 + 0.01 * step;
            let input = JointStateInput {
                names: vec!["slide".to_owned()],
                positions: vec![rate * 0.01 * step],
                velocities: if has_velocity { vec![rate] } else { vec![] },
                ..state(seconds, FREE)
            };
            last = monitor.on_joint_state(input, at(seconds)).speed_scale;
        }
        last
    };
    for has_velocity in [true, false] {
        for rate in [0.0, 0.2, 0.5, 5.0, -0.2, -5.0] {
            let [one, two] = [true, false].map(|are_one| shares(are_one, rate, has_velocity));
            assert!((one - two).abs() < 1e-6, "{rate} m/s: {one} as one obstacle, {two} as two");
        }
        assert_eq!(shares(true, 5.0, has_velocity), 0.0);
    }
}

/// A driver that does not know one velocity, as that of a joint that stands.
#[test]
fn an_unknown_velocity_does_not_hide_what_comes_from_beyond() {
    let share = |velocities: [f64; 2]| {
        let mut monitor = governed(SPEED);
        let (rate, period) = (2.0, 0.01);
        let mut last = f64::NAN;
        for i in 0..5 {
            let elbow = 2.1 + rate * period * f64::from(i);
            assert!(distance_at(elbow) > 0.5);
            let seconds = period * f64::from(i);
            last =
                monitor.on_joint_state(moving(seconds, [0.0, elbow], &velocities), at(seconds)).speed_scale;
        }
        last
    };
    let (known, unknown) = (share([0.0, 2.0]), share([f64::NAN, 2.0]));
    assert!(known < 0.95 && (known - unknown).abs() < 0.02, "{known} {unknown}");
}
