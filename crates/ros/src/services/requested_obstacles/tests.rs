//! Tests of motion requests with moving obstacles, for the two-link robot at rest. Its tip is a ball of 0.1 m at
//! (2, 0, 0). The cart, a ball of 0.1 m, is 0.8 m beside it.

use std::sync::Arc;
use std::time::Duration;

use clearance_checker::CollisionChecker;
use clearance_geometry::math::Pose as ScenePose;
use clearance_geometry::{Primitive, Shape};
use clearance_monitor::{Evaluation, JointStateInput, Monitor, MonitorSettings, Now, Revision, Time};
use clearance_motion::ContinuousDirection;
use clearance_robot::{MeshFiles, RobotModel};
use clearance_scene::{Obstacle, Settings};
use ros2_interfaces_jazzy_serde::builtin_interfaces::msg::Duration as SpanMessage;
use ros2_interfaces_jazzy_serde::geometry_msgs::msg::{Point, Pose, Quaternion, Twist, Vector3};
use ros2_interfaces_jazzy_serde::trajectory_msgs::msg::{JointTrajectory, JointTrajectoryPoint};

use super::*;
use crate::messages::clearance_srvs::{
    CheckMotionRequest, CheckTrajectoryRequest, CheckTrajectoryResponse, MotionFindings,
};
use crate::services::motion_requests::{evaluate_motion, evaluate_trajectory};

const URDF: &str = include_str!("../../../../../urdf/two_link/two_link.urdf");

fn evaluation() -> Evaluation {
    let robot = RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap();
    let mut world = World::default();
    let ball = || Shape::Primitive(Primitive::Sphere { radius: 0.1 });
    world.add(Obstacle::of_shape("cart", ScenePose::translation(2.0, 1.0, 0.0), ball())).unwrap();
    world.add(Obstacle::of_shape("lamp", ScenePose::translation(2.0, -3.0, 0.0), ball())).unwrap();
    let checker = CollisionChecker::new(Arc::new(robot), &world, Settings::default()).unwrap();
    let mut monitor = Monitor::new(MonitorSettings::default(), || Duration::ZERO);
    monitor.set_checker(Arc::new(Revision::new(checker, 1, 1)));
    let now = Now { ros: Some(Time::from_nanoseconds(5)), steady: Duration::ZERO };
    let names = ["joint1", "joint2"].map(str::to_owned).to_vec();
    monitor
        .on_joint_state(JointStateInput { names, positions: vec![0.0; 2], ..JointStateInput::default() }, now)
}

/// The robot rests for so many seconds.
fn rest(duration: f64, terms: MotionTerms) -> CheckTrajectoryResponse {
    let joint_names = vec!["joint1".to_owned()];
    let request = CheckMotionRequest { joint_names, start: vec![0.0], goal: vec![0.0], terms, duration };
    evaluate_motion(&request, ContinuousDirection::AsGiven, Some(&evaluation()), &mut None).response
}

/// The same as a trajectory with points at these times.
fn rest_at(times: &[i32], terms: MotionTerms) -> CheckTrajectoryResponse {
    let point = |&sec| JointTrajectoryPoint {
        positions: vec![0.0],
        time_from_start: SpanMessage { sec, nanosec: 0 },
        ..JointTrajectoryPoint::default()
    };
    let (joint_names, points) = (vec!["joint1".to_owned()], times.iter().map(point).collect());
    let trajectory = JointTrajectory { joint_names, points, ..JointTrajectory::default() };
    let request = CheckTrajectoryRequest { trajectory, terms };
    evaluate_trajectory(&request, None, Some(&evaluation()), &mut None).response
}

fn limit(name: &str, speed: f64, acceleration: f64) -> ObstacleLimit {
    ObstacleLimit { name: name.to_owned(), speed, acceleration }
}

fn limits(obstacle_limits: Vec<ObstacleLimit>, obstacle_latency: f64) -> MotionTerms {
    MotionTerms { obstacle_limits, obstacle_latency, ..MotionTerms::default() }
}

/// The cart moves along y at this speed (m/s).
fn along_y(speed: f64) -> MovingObstacle {
    let linear = Vector3 { x: 0.0, y: speed, z: 0.0 };
    let twist = Twist { linear, ..Twist::default() };
    MovingObstacle { name: "cart".to_owned(), twist, ..MovingObstacle::default() }
}

/// The cart is displaced by this much along y (m) at these times (s).
fn through(places: &[(f64, f64)]) -> MovingObstacle {
    let pose = |y| Pose {
        position: Point { x: 0.0, y, z: 0.0 },
        orientation: Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 },
    };
    let (times, poses) = places.iter().map(|&(time, y)| (time, pose(y))).unzip();
    MovingObstacle { name: "cart".to_owned(), times, poses, ..MovingObstacle::default() }
}

fn moving(moving_obstacles: Vec<MovingObstacle>) -> MotionTerms {
    MotionTerms { moving_obstacles, ..MotionTerms::default() }
}

#[test]
fn a_motion_is_free_for_every_motion_of_obstacles_within_their_limits() {
    for (duration, terms, is_free) in [
        (1.0, limits(vec![limit("", 0.5, 0.0)], 0.0), true),
        (2.0, limits(vec![limit("", 0.5, 0.0)], 0.0), false),
        (1.0, limits(vec![limit("", 0.5, 0.0)], 0.7), false),
        (1.0, limits(vec![limit("cart", 0.5, 0.8)], 0.0), false),
        (1.0, limits(vec![limit("", 5.0, 0.0), limit("cart", 0.5, 0.0), limit("lamp", 0.0, 0.0)], 0.0), true),
        (1.0, limits(vec![limit("lamp", 2.0, 0.0)], 0.0), true),
        (1.0, limits(vec![limit("lamp", 3.0, 0.0)], 0.0), false),
    ] {
        let motion = rest(duration, terms.clone()).motion;
        if is_free {
            assert_eq!(motion.verdict, MotionFindings::FREE, "{terms:?}: {motion:?}");
            continue;
        }
        assert_eq!((motion.verdict, motion.reason_code.as_str()), (MotionFindings::UNDECIDED, "tube"));
        let end = rest_at(&[0, 1], terms);
        assert!(duration > 1.0 || end.motion.t_free == motion.t_free, "{end:?}");
    }
}

#[test]
fn a_known_motion_of_an_obstacle_decides_whether_and_when_it_touches() {
    let contact = rest(2.0, moving(vec![along_y(-1.0)])).motion;
    assert_eq!(contact.verdict, MotionFindings::CONTACT);
    assert!((contact.t_contact - 0.4).abs() < 1e-3, "0.8 s of 2 s: {}", contact.t_contact);
    assert_eq!(rest(2.0, moving(vec![along_y(0.5)])).motion.verdict, MotionFindings::FREE);
    // limits count in addition
    let mut both = moving(vec![along_y(-0.5)]);
    assert_eq!(rest(1.0, both.clone()).motion.verdict, MotionFindings::FREE);
    both.obstacle_limits = vec![limit("cart", 0.4, 0.0)];
    assert_eq!(rest(1.0, both).motion.reason_code, "tube");
}

/// The poses of the obstacle split segments; responses are about those of the request.
#[test]
fn fractions_and_segments_are_those_of_the_request() {
    let cart = || moving(vec![through(&[(0.0, 0.0), (1.0, 0.1), (3.0, 0.1), (4.0, -0.9)])]);
    let one = rest_at(&[0, 4], cart());
    assert_eq!((one.motion.verdict, one.segment), (MotionFindings::CONTACT, 0));
    assert!(
        (one.motion.t_contact - 3.9 / 4.0).abs() < 1e-3 && (one.time_contact - 3.9).abs() < 1e-3,
        "{one:?}"
    );
    let two = rest_at(&[0, 2, 4], cart());
    assert_eq!(two.segment, 1);
    assert!((two.motion.t_contact - 0.95).abs() < 1e-3 && (two.time_contact - 3.9).abs() < 1e-3, "{two:?}");
    let distances = MotionTerms { with_clearance: true, event_distance: 0.5, ..cart() };
    let along = rest_at(&[0, 2, 4], distances).distances;
    assert_eq!((along.event.segment, along.world_clearance.segment), (1, 1));
    assert!((along.event.t_reached - 0.7).abs() < 1e-2, "0.9 m - 0.4 m at 3.4 s: {:?}", along.event);
    assert!((along.event.time_reached - 3.4).abs() < 1e-2 && along.world_clearance.upper == 0.0);
}

#[test]
fn least_distances_count_with_the_limits() {
    let terms = MotionTerms { with_clearance: true, ..limits(vec![limit("", 0.5, 0.0)], 0.0) };
    let along = rest(1.0, terms).distances.world_clearance;
    assert!(along.lower <= 0.3 + 1e-9 && along.lower > 0.29, "{along:?}");
}

#[test]
fn requests_that_do_not_fit_are_rejected_by_name() {
    let quarter = MovingObstacle { times: vec![0.0], ..through(&[(0.0, 0.0), (1.0, 0.1)]) };
    let both = MovingObstacle { twist: along_y(1.0).twist, ..through(&[(0.0, 0.0), (1.0, 0.1)]) };
    let other = MovingObstacle { name: "person".to_owned(), ..along_y(1.0) };
    for (duration, terms, named) in [
        (0.0, limits(vec![limit("", 0.5, 0.0)], 0.0), "give the motion a duration"),
        (0.0, moving(vec![along_y(1.0)]), "give the motion a duration"),
        (1.0, moving(vec![along_y(0.0)]), "linear"),
        (1.0, limits(vec![], 0.5), "there are none"),
        (100.0, limits(vec![limit("cart", 1e308, 0.0)], 0.0), "larger than any number"),
        (1.0, limits(vec![limit("car", 0.5, 0.0)], 0.0), "'car'"),
        (1.0, limits(vec![limit("cart", -0.5, 0.0)], 0.0), "the speed limit of obstacle 'cart' is -0.5"),
        (
            1.0,
            limits(vec![limit("cart", 0.5, f64::NAN)], 0.0),
            "the acceleration limit of obstacle 'cart' is NaN",
        ),
        (
            1.0,
            limits(vec![limit("", 0.5, 0.0), limit("", 0.6, 0.0)], 0.0),
            "two limits of all other obstacles",
        ),
        (1.0, limits(vec![], -1.0), "obstacle_latency is -1"),
        (-1.0, limits(vec![], 0.0), "duration is -1"),
        (1.0, moving(vec![other]), "'person'"),
        (1.0, moving(vec![along_y(1.0), along_y(1.0)]), "'cart' occurs twice"),
        (1.0, moving(vec![along_y(f64::INFINITY)]), "linear"),
        (1.0, moving(vec![quarter]), "2 poses need as many times, but there are 1"),
        (1.0, moving(vec![both]), "but not both"),
        (2.0, moving(vec![through(&[(0.0, 0.0), (1.0, 0.1)])]), "the motion lasts from 0 to 2"),
        (1.0, moving(vec![through(&[(0.0, 0.0), (0.0, 0.1)])]), "pose 1"),
    ] {
        let motion = rest(duration, terms).motion;
        assert_eq!((motion.verdict, motion.reason_code.as_str()), (MotionFindings::ERROR, "bad_request"));
        assert!(motion.message.contains(named), "{}", motion.message);
    }
}
