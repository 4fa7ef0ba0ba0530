//! Tests of speed and separation monitoring in the monitor, with a person near the robot.

use clearance_geometry::math::Pose;
use clearance_geometry::{Primitive, Shape};
use clearance_scene::{BodyId, Obstacle, ObstacleShape};

use super::*;

const MONITORED: SeparationSettings = SeparationSettings {
    human_speed: 1.6,
    robot_speed: 1.0,
    reaction_time: 0.1,
    deceleration: 2.0,
    acceleration: 4.0,
    margin: 0.1,
};

/// A ball of 0.1 m at this height (m) above the base, and at this distance (m) in front of it.
fn ball(name: &str, x: f64, z: f64) -> Obstacle {
    Obstacle::of_shape(name, Pose::translation(x, 0.0, z), Shape::Primitive(Primitive::sphere(0.1).unwrap()))
}

fn beside(obstacles: Vec<Obstacle>, separation: impl Into<SeparationRules>, release_count: u32) -> Monitor {
    let mut world = World::default();
    for obstacle in obstacles {
        world.add(obstacle).unwrap();
    }
    let robot = RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap();
    let checker = CollisionChecker::new(Arc::new(robot), &world, Settings::default()).unwrap();
    let mut monitor = Monitor::new(MonitorSettings::default(), stopwatch);
    monitor.set_checker(Arc::new(Revision::new(checker, 1, 0)));
    let speed =
        SpeedSettings { release_count, separation: Some(separation.into()), ..SpeedSettings::default() };
    monitor.set_settings(MonitorSettings { speed, distance_limit: 5.0, ..MonitorSettings::default() });
    monitor
}

/// The tip of the stretched robot is 0.8 m from the person.
fn person() -> Vec<Obstacle> {
    vec![ball("person", 3.0, 0.0)]
}

/// The elbow is bent by this angle (rad), so that its velocity moves the tip towards the person or away.
const BENT: [f64; 2] = [0.0, 0.6];

fn evaluation(monitor: &mut Monitor, seconds: f64, positions: [f64; 2], velocities: &[f64]) -> Evaluation {
    monitor.on_joint_state(moving(seconds, positions, velocities), at(seconds))
}

#[test]
fn a_robot_at_rest_near_a_person_gets_the_share_of_its_largest_speed() {
    let mut monitor = beside(person(), MONITORED, 1);
    let evaluation = evaluation(&mut monitor, 0.0, FREE, &[0.0, 0.0]);
    let separation = evaluation.separation.unwrap();
    assert!((separation.distance - 0.8).abs() < 1e-9);
    let allowed = (1.6f64.powi(2) + 4.0 * 0.7).sqrt() - 1.6 - 0.2;
    assert!((separation.allowed_speed - allowed).abs() < 1e-9);
    assert!((evaluation.speed_scale - allowed).abs() < 1e-9, "{}", evaluation.speed_scale);
    assert!((separation.protective_distance - 0.26).abs() < 1e-9);
    assert!(separation.approach_speed.unwrap().abs() < 1e-9);
    let (a, b) = separation.bodies.unwrap();
    let checker = &evaluation.revision.as_ref().unwrap().checker;
    assert_eq!([checker.body_name(a), checker.body_name(b)], ["ball", "person"]);
    assert!(matches!(b, BodyId::Obstacle(_)));
    // pairs of the range are not all listed in the report
    assert!(evaluation.checked_state.unwrap().report.pair_distances.is_empty());
}

#[test]
fn what_moves_towards_the_person_is_slowed_and_what_moves_away_is_not() {
    let speed = |velocity: f64| {
        let mut monitor = beside(person(), MONITORED, 1);
        let evaluation = evaluation(&mut monitor, 0.0, BENT, &[0.0, velocity]);
        (evaluation.speed_scale, evaluation.separation.unwrap().approach_speed.unwrap())
    };
    let (at_rest, _) = speed(0.0);
    assert!((0.1..0.95).contains(&at_rest), "{at_rest}");
    let (towards, rate) = speed(-0.5);
    assert!(rate > 0.1 && (towards - at_rest).abs() < 1e-12, "{towards} at {rate} m/s");
    let (fast, rate) = speed(-3.0);
    assert!(rate > 1.0 && (fast - at_rest / rate).abs() < 1e-9, "{fast} at {rate} m/s");
    let (away, rate) = speed(0.5);
    assert!(rate < -0.1 && away == 1.0, "{away} at {rate} m/s");
}

/// The tip approaches faster than commands of the settings may move it.
#[test]
fn the_scale_of_a_fast_robot_rises_without_a_jump() {
    let scale = |x: f64| {
        let mut monitor = beside(vec![ball("person", x, 0.0)], MONITORED, 1);
        evaluation(&mut monitor, 0.0, BENT, &[0.0, -4.0]).speed_scale
    };
    let scales: Vec<f64> = (0..120).map(|i| scale(3.0 + 0.02 * f64::from(i))).collect();
    assert!(scales[0] < 0.3 && scales[119] > 0.7, "{scales:?}");
    let largest_step = scales.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    assert!(largest_step < 0.03 && scales.is_sorted(), "{largest_step}");
}

/// Two persons that one sensor reports as one obstacle: the tip leaves the nearer one towards the other.
#[test]
fn what_leaves_one_part_of_an_obstacle_is_slowed_before_another() {
    let at_place = |x: f64, y: f64| ObstacleShape {
        pose_os: Pose::translation(x, y, 0.0),
        shape: Shape::Primitive(Primitive::sphere(0.1).unwrap()),
    };
    let share = |shapes: Vec<ObstacleShape>| {
        let mut monitor = beside(vec![Obstacle::new("persons", shapes)], MONITORED, 1);
        let evaluation = evaluation(&mut monitor, 0.0, BENT, &[0.0, 0.5]);
        (evaluation.speed_scale, evaluation.separation.unwrap())
    };
    let (alone, separation) = share(vec![at_place(3.0, 0.0)]);
    assert!(alone == 1.0 && separation.approach_speed.unwrap() < -0.1);
    let (beside_another, separation) = share(vec![at_place(3.0, 0.0), at_place(1.8, 2.0)]);
    assert!(separation.approach_speed.unwrap() < -0.1, "the nearer one is left");
    assert_eq!(beside_another, separation.allowed_speed);
}

/// Without velocities, the first state has no rate; the second one has that of the difference, which is no bound.
#[test]
fn an_unknown_rate_counts_as_the_largest_one() {
    let mut monitor = beside(person(), MONITORED, 1);
    let first = monitor.on_joint_state(state(0.0, BENT), at(0.0));
    let separation = first.separation.unwrap();
    assert_eq!(separation.approach_speed, None);
    assert_eq!(separation.protective_distance, MONITORED.protective_distance(MONITORED.robot_speed));
    assert!((first.speed_scale - separation.allowed_speed).abs() < 1e-12);
    let away = monitor.on_joint_state(state(0.1, [0.0, 0.7]), at(0.1));
    assert!(away.separation.unwrap().approach_speed.unwrap() < -0.1);
    assert_eq!(away.speed_scale, away.separation.unwrap().allowed_speed);
}

#[test]
fn resting_obstacles_and_fixed_links_follow_the_distances() {
    let table = || vec![ball("table_7", 3.0, 0.0)];
    let resting = || SeparationRules {
        resting_obstacles: vec!["table_*".to_owned()],
        ..SeparationRules::of_all(MONITORED)
    };
    let evaluation_of = |obstacles, separation: SeparationRules| {
        evaluation(&mut beside(obstacles, separation, 1), 0.0, FREE, &[0.0, 0.0])
    };
    assert!(evaluation_of(table(), MONITORED.into()).speed_scale < 0.6);
    let rests = evaluation_of(table(), resting());
    assert_eq!((rests.speed_scale, rests.separation.unwrap().bodies), (1.0, None));
    assert_eq!(rests.separation.unwrap().distance, f64::INFINITY);
    // the slow-down distance counts for the table
    let mut monitor = beside(table(), resting(), 1);
    let world = SpeedDistances { slowdown: 1.0, stop: 0.6 };
    let speed =
        SpeedSettings { world, release_count: 1, separation: Some(resting()), ..SpeedSettings::default() };
    monitor.set_settings(MonitorSettings { speed, ..MonitorSettings::default() });
    assert!((evaluation(&mut monitor, 0.0, FREE, &[0.0, 0.0]).speed_scale - 0.5).abs() < 1e-9);

    // the base does not move, and the nearest moving link is out of range
    let beside_base = evaluation_of(vec![ball("person", -0.35, 0.0)], MONITORED.into());
    assert_eq!((beside_base.speed_scale, beside_base.separation.unwrap().bodies), (1.0, None));
    assert!(beside_base.checked_state.unwrap().report.nearest_world.unwrap().distance < 0.1);
}

/// A cart that is slower than a person leaves the robot faster.
#[test]
fn an_obstacle_may_have_a_speed_of_its_own() {
    let rules = |speed| SeparationRules {
        obstacle_speeds: vec![("cart".to_owned(), speed)],
        ..SeparationRules::of_all(MONITORED)
    };
    let share = |name: &str, speed: f64| {
        let mut monitor = beside(vec![ball(name, 3.0, 0.0)], rules(speed), 1);
        evaluation(&mut monitor, 0.0, FREE, &[0.0, 0.0]).speed_scale
    };
    let allowed = |speed: f64| (speed * speed + 4.0 * 0.7).sqrt() - speed - 0.2;
    assert!((share("cart", 1.0) - allowed(1.0)).abs() < 1e-9);
    assert!((share("person", 0.5) - allowed(1.6)).abs() < 1e-9);
    assert!((share("cart", 3.0) - allowed(3.0)).abs() < 1e-9);
}

#[test]
fn what_is_not_free_stops_and_the_counts_delay_a_rise() {
    let mut monitor = beside(person(), MONITORED, 2);
    let share = evaluation(&mut beside(person(), MONITORED, 1), 0.0, FREE, &[0.0, 0.0]).speed_scale;
    let mut next = |seconds, positions, velocities: &[f64]| {
        let evaluation = evaluation(&mut monitor, seconds, positions, velocities);
        (evaluation.speed_scale, evaluation.separation.is_some())
    };
    assert_eq!(next(0.0, FREE, &[0.0; 2]), (0.0, true));
    assert_eq!(next(0.1, FREE, &[0.0; 2]), (share, true));
    assert_eq!(next(0.2, COLLIDING, &[0.0; 2]), (0.0, false));
    assert_eq!(next(0.3, FREE, &[0.0; 2]), (0.0, true));
    assert_eq!(next(0.4, FREE, &[0.0; 2]), (share, true));
    assert_eq!(next(0.5, [0.0, f64::NAN], &[0.0; 2]), (0.0, false));
    let stale = monitor.on_heartbeat(at(2.0));
    assert_eq!((stale.speed_scale, stale.separation), (0.0, None));
    let off = super::monitor().on_joint_state(state(0.0, FREE), at(0.0));
    assert_eq!(off.separation, None);
}

/// Pairs between links keep the rule of the distances.
#[test]
fn links_keep_their_distances() {
    let own = SpeedDistances { slowdown: 0.5, stop: 0.1 };
    let scale = |separation| {
        let mut monitor = monitor();
        let speed = SpeedSettings { own, release_count: 1, separation, ..SpeedSettings::default() };
        monitor.set_settings(MonitorSettings { speed, ..MonitorSettings::default() });
        evaluation(&mut monitor, 0.0, [0.0, 2.6], &[0.0, 0.3]).speed_scale
    };
    assert!((0.01..0.99).contains(&scale(None)));
    assert_eq!(scale(Some(MONITORED.into())), scale(None));
}
