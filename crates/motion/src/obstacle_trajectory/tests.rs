//! Tests of obstacle trajectories: obstacles move by their twist or through their poses in all parts of a trajectory.

use clearance_geometry::math::{Rotation, Vector};
use clearance_geometry::{Primitive, Shape};
use clearance_robot::{MeshFiles, RobotModel};
use clearance_scene::Obstacle;

use super::*;
use crate::{MotionSegment, TrajectoryPoint};

fn pose(xyz: [f64; 3], turn: [f64; 3]) -> Pose {
    Pose::from_parts(Vector::from(xyz).into(), Rotation::from_scaled_axis(Vector::from(turn)))
}

fn same(a: &Pose, b: &Pose) -> bool {
    (a.translation.vector - b.translation.vector).norm() < 1e-9 && a.rotation.angle_to(&b.rotation) < 1e-7
}

fn robot() -> RobotModel {
    let urdf = include_str!("../../../../urdf/two_link/two_link.urdf");
    RobotModel::from_urdf(urdf, &MeshFiles::default()).unwrap()
}

fn world() -> World {
    let mut world = World::default();
    for name in ["a", "b"] {
        let shape = Shape::Primitive(Primitive::sphere(0.1).unwrap());
        world.add(Obstacle::of_shape(name, Pose::translation(9.0, 0.0, 0.0), shape)).unwrap();
    }
    world
}

/// Linear, cubic and linear segments from 0.5 s to 4 s; optionally without times.
fn trajectory(timed: bool) -> Trajectory {
    let point = |q: [f64; 2], v: Option<[f64; 2]>, time: f64| TrajectoryPoint {
        positions: q.to_vec(),
        velocities: v.map_or_else(Vec::new, |v| v.to_vec()),
        accelerations: Vec::new(),
        time_from_start: if timed { time } else { 0.0 },
    };
    let bent = timed.then_some([0.5, -2.0]);
    let points = [
        point([0.0, 0.0], None, 0.5),
        point([1.0, 0.5], bent, 1.5),
        point([0.3, 1.0], bent, 3.0),
        point([0.0, 0.0], None, 4.0),
    ];
    let (robot, joints) = (robot(), ["joint1", "joint2"].map(str::to_owned));
    Trajectory::from_points(&robot, &joints, &points, &robot.default_configuration()).unwrap()
}

/// For every part: times, robot positions and displacements of obstacles, at fractions of it.
fn samples(way: &Trajectory) -> impl Iterator<Item = (f64, usize, f64)> + '_ {
    (0..way.segments().len()).flat_map(move |segment| {
        [0.0, 0.1, 0.5, 0.9, 1.0].map(|t| (way.time(segment, t).unwrap(), segment, t))
    })
}

#[test]
fn a_twist_goes_on_from_segment_to_segment() {
    let (centre, linear, angular) = (Point::new(9.0, 0.0, 0.0), [0.1, -0.5, 0.2], [0.0, 3.0, 4.0]);
    let mover = ObstacleTrajectory::even("a", centre, linear, angular);
    let way = trajectory(true).with_obstacles(&world(), &[mover]).unwrap();
    assert_eq!(way.segments().len(), 3);
    for (time, segment, t) in samples(&way) {
        let there = pose((centre.coords + Vector::from(linear) * time).into(), angular.map(|w| w * time));
        let expected = there * pose(centre.coords.into(), [0.0; 3]).inverse();
        assert!(same(&way.segments()[segment].obstacles()[0].displacement(t), &expected), "{time} s");
    }
    assert!(Trajectory::of_segments(way.segments().to_vec()).is_ok(), "robot and obstacle are joined");
}

#[test]
fn poses_are_passed_through_and_the_robot_moves_as_before() {
    let stops = [
        (0.25, pose([9.0, 0.0, 0.0], [0.0, 0.0, 1.0])),
        (1.0, pose([8.0, 1.0, 0.0], [0.0, 2.0, 0.0])),
        (1.5, pose([8.0, 2.0, 0.0], [0.0, 2.0, 0.0])),
        (2.0, pose([7.0, 2.0, 3.0], [1.0, 0.0, -1.0])),
        (2.75, pose([7.0, 2.0, 3.0], [0.0, 0.0, -1.0])),
        (5.0, pose([0.0; 3], [0.0; 3])),
    ];
    let mover = ObstacleTrajectory::through("b", &stops).unwrap();
    let even = ObstacleTrajectory::even("a", Point::origin(), [0.1; 3], [0.2; 3]);
    let plain = trajectory(true);
    let way = plain.clone().with_obstacles(&world(), &[even, mover]).unwrap();
    assert_eq!(way.segments().len(), 6, "cut at 1, 2 and 2.75 s; at 1.5 s a segment ends anyway");
    for (time, segment, t) in samples(&way) {
        let motion = &way.segments()[segment];
        let next = stops.iter().position(|(end, _)| *end >= time).unwrap();
        let [(begin, from), (end, to)] = [stops[next - 1], stops[next]];
        let s = (time - begin) / (end - begin);
        let shift = from.translation.vector.lerp(&to.translation.vector, s);
        let expected =
            Pose::from_parts(shift.into(), from.rotation.slerp(&to.rotation, s)) * stops[0].1.inverse();
        assert!(same(&motion.obstacles()[1].displacement(t), &expected), "{time} s");
        let (was, fraction) = way.origin(segment, t);
        assert!((plain.time(was, fraction).unwrap() - time).abs() < 1e-12);
        let (now, before) = (motion.at(t), plain.segments()[was].at(fraction));
        let off = now.positions().iter().zip(before.positions()).map(|(a, b)| (a - b).abs());
        assert!(off.fold(0.0, f64::max) < 1e-12, "{time} s");
    }
    assert!(Trajectory::of_segments(way.segments().to_vec()).is_ok());
    let again = [ObstacleTrajectory::even("a", Point::origin(), [0.0; 3], [0.0; 3])];
    assert!(way.with_obstacles(&world(), &again).is_err(), "it moves already");
}

#[test]
fn a_way_without_times_lasts_from_0_to_1() {
    let way = Trajectory::of_segments(vec![trajectory(false).segments()[0].clone()]).unwrap();
    let stops = [0.0, 0.25, 1.0].map(|x| (x, pose([9.0 + x, 0.0, 0.0], [0.0; 3])));
    let mover = ObstacleTrajectory::through("a", &stops).unwrap();
    let cut = way.with_obstacles(&world(), &[mover]).unwrap();
    assert_eq!((cut.segments().len(), cut.time(0, 0.5)), (2, None));
    assert_eq!(
        (cut.origin(0, 1.0), cut.origin(1, 0.0), cut.origin(1, 1.0)),
        ((0, 0.25), (0, 0.25), (0, 1.0))
    );
    let end = cut.segments()[1].obstacles()[0].displacement(1.0);
    assert!(same(&end, &Pose::translation(1.0, 0.0, 0.0)));
}

#[test]
fn floating_joints_turn_on_through_cuts() {
    let urdf = "<robot name='r'><link name='root'/><link name='body'/><joint name='f' type='floating'>
        <parent link='root'/><child link='body'/></joint></robot>";
    let robot = RobotModel::from_urdf(urdf, &MeshFiles::default()).unwrap();
    let at = |q: [f64; 7]| robot.configuration(&q).unwrap();
    let (from, to) = (at([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]), at([1.0, 2.0, 3.0, 0.1, 0.9, -0.3, 0.3]));
    let whole = MotionSegment::straight(&robot, &from, &to);
    let part = whole.part([0.25, 0.75]);
    for t in [0.0, 0.3, 1.0] {
        let (a, b) = (part.at(t), whole.at(0.25 + 0.5 * t));
        let off = a.positions().iter().zip(b.positions()).map(|(a, b)| (a - b).abs());
        assert!(off.fold(0.0, f64::max) < 1e-12);
    }
}

#[test]
fn what_is_no_way_is_rejected() {
    let still = |times: &[f64]| {
        let poses: Vec<_> = times.iter().map(|t| (*t, Pose::identity())).collect();
        ObstacleTrajectory::through("a", &poses)
    };
    assert_eq!(still(&[0.0]), Err(PosesError::TooFew(1)));
    for times in [[0.0, 1.0, 1.0], [0.0, 2.0, 1.0], [0.0, 1.0, f64::NAN], [0.0, 1.0, f64::INFINITY]] {
        assert!(matches!(still(&times), Err(PosesError::Time { pose: 2, .. })), "{times:?}");
    }
    assert!(matches!(still(&[-1.0, 1.0]), Err(PosesError::Time { pose: 0, .. })));
    let half = [(0.0, Pose::identity()), (1.0, pose([0.0; 3], [0.0, std::f64::consts::PI, 0.0]))];
    assert_eq!(ObstacleTrajectory::through("a", &half), Err(PosesError::HalfTurn(1)));

    let with = |way: Trajectory, mover: ObstacleTrajectory| way.with_obstacles(&world(), &[mover]);
    for times in [[0.6, 9.0], [0.0, 3.9]] {
        let refused = with(trajectory(true), still(&times).unwrap());
        assert!(matches!(refused, Err(TrajectoryError::ObstacleTimes { .. })), "{times:?}");
    }
    assert_eq!(with(trajectory(false), still(&[0.0, 1.0]).unwrap()), Err(TrajectoryError::NoClock));
    let endless = ObstacleTrajectory::even("a", Point::origin(), [1e8; 3], [0.0; 3]);
    assert!(matches!(with(trajectory(true), endless), Err(TrajectoryError::Segment { segment: 1, .. })));

    // from segment to segment an obstacle must not jump back to its pose in the world
    let even = ObstacleTrajectory::even("a", Point::origin(), [1.0; 3], [0.0; 3]);
    let mut jumping = with(trajectory(true), even).unwrap().segments().to_vec();
    jumping[1] = jumping[1].clone().with_obstacles(&world(), Vec::new()).unwrap();
    let refused = Trajectory::of_segments(jumping);
    assert!(matches!(refused, Err(TrajectoryError::ObstacleJump { segment: 1, .. })), "{refused:?}");
}
