//! Tests of swept volume markers of the two-link robot: shapes, colours, and parts that are left out.

use clearance_checker::MotionOptions;
use clearance_geometry::math::Point;
use clearance_motion::MotionSegment;
use clearance_robot::MeshFiles;
use clearance_scene::World;
use clearance_scene::{BodyId, Settings};
use std::sync::Arc;

use super::*;

const URDF: &str = include_str!("../../../../../urdf/two_link/two_link.urdf");

fn checker() -> CollisionChecker {
    let robot = RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap();
    CollisionChecker::new(Arc::new(robot), &World::default(), Settings::default()).unwrap()
}

/// Trajectory of straight motions of the second joint.
fn folding(checker: &CollisionChecker, stops: &[f64]) -> Trajectory {
    let at = |q2: f64| checker.robot().configuration(&[0.0, q2]).unwrap();
    let segments =
        stops.windows(2).map(|ends| MotionSegment::straight(checker.robot(), &at(ends[0]), &at(ends[1])));
    Trajectory::of_segments(segments.collect()).unwrap()
}

fn shown(checker: &CollisionChecker, way: &Trajectory, intervals: usize) -> Vec<Marker> {
    let mut workspace = checker.workspace();
    let report = checker.check_trajectory(way, &MotionOptions::default(), &mut workspace);
    swept_volume_markers(checker, way, &report, intervals, &mut workspace).unwrap().markers
}

/// Colours of a link's volumes, in order.
fn colours(markers: &[Marker], link: &str) -> Vec<[f32; 4]> {
    (markers.iter().filter(|m| m.ns == link && m.type_ == Marker::SPHERE_LIST))
        .map(|m| [m.color.r, m.color.g, m.color.b, m.color.a])
        .collect()
}

#[test]
fn markers_are_the_volumes() {
    let checker = checker();
    let way = folding(&checker, &[0.0, 1.0, 2.0]);
    let markers = shown(&checker, &way, 5);
    assert_eq!(markers[0].action, Marker::DELETEALL);
    let mut workspace = checker.workspace();
    let volumes: Vec<SweptVolume> =
        (way.segments().iter()).flat_map(|s| checker.swept_volumes(s, 5, &mut workspace)).collect();
    let balls: Vec<&Marker> = markers.iter().filter(|m| m.type_ == Marker::SPHERE_LIST).collect();
    assert_eq!(balls.len(), volumes.len());
    for (ball, volume) in balls.iter().zip(&volumes) {
        assert_eq!((ball.action, ball.header.frame_id.as_str()), (Marker::ADD, "base"));
        assert_eq!(ball.ns, checker.body_name(volume.body));
        assert_eq!(ball.points[0], point_message(&volume.a));
        assert_eq!(ball.scale, vector_message(&Vector::repeat(2.0 * volume.radius)));
        let cylinder = markers.iter().find(|m| m.ns == ball.ns && m.id == ball.id - 1);
        let cylinder = cylinder.filter(|m| m.type_ == Marker::CYLINDER);
        assert_eq!(cylinder.is_some(), volume.a != volume.b);
        let Some(cylinder) = cylinder else { continue };
        let (p, q) = (&cylinder.pose.position, &cylinder.pose.orientation);
        let pose = clearance_geometry::math::pose_from_xyz_quaternion([p.x, p.y, p.z], [q.x, q.y, q.z, q.w])
            .unwrap();
        let end = |z: f64| pose * Point::new(0.0, 0.0, z * cylinder.scale.z);
        assert!((end(0.5) - volume.b).norm() < 1e-12 && (end(-0.5) - volume.a).norm() < 1e-12);
        assert!((cylinder.scale.x - 2.0 * volume.radius).abs() < 1e-12);
    }
    let mut ids: Vec<_> = markers[1..].iter().map(|m| (&m.ns, m.id)).collect();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), markers.len() - 1);
}

#[test]
fn axes_in_any_direction_have_their_cylinder() {
    for axis in [[0.0, 0.0, 2.0], [0.0, 0.0, -2.0], [1.0, -2.0, 3.0], [1e-9, 0.0, -2.0]] {
        let b = Point::from(axis);
        let volume = SweptVolume {
            body: BodyId::Link(clearance_robot::LinkId(0)),
            t: [0.0, 1.0],
            a: Point::origin(),
            b,
            radius: 0.1,
        };
        let cylinder = capsule(&volume)[0].clone().unwrap();
        let q = cylinder.pose.orientation;
        let turn = Rotation::from_quaternion(nalgebra::Quaternion::new(q.w, q.x, q.y, q.z));
        assert!((turn * Vector::z() - b.coords.normalize()).norm() < 1e-9, "{axis:?}");
    }
    let volume = |b: Point| SweptVolume {
        body: BodyId::Link(clearance_robot::LinkId(0)),
        t: [0.0, 1.0],
        a: Point::origin(),
        b,
        radius: 0.1,
    };
    let [none, ball] = capsule(&volume(Point::origin()));
    assert!(none.is_none() && ball.unwrap().points.len() == 1);
}

#[test]
fn colours_say_what_is_known() {
    let checker = checker();
    let free = shown(&checker, &folding(&checker, &[0.0, 2.8]), 4);
    assert!(free[1..].iter().all(|m| m.color.g > m.color.r));
    // the contact is at 2.8369 rad, in the third quarter of the second segment
    let contact = shown(&checker, &folding(&checker, &[0.0, 2.5, 3.0, 3.1]), 4);
    let tip = [&[GREEN; 4][..], &[GREEN, GREEN, RED, GREY], &[GREY; 4]].concat();
    assert_eq!(colours(&contact, "tip"), tip);
    assert_eq!(colours(&contact, "upper"), [&[GREEN; 6][..], &[GREY; 6]].concat());
    assert_eq!(colours(&contact, "base"), tip);
}

#[test]
fn what_is_allowed_fits_into_a_message() {
    let robot = RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap();
    let most = most_intervals(&robot, 1);
    assert!((50..1000).contains(&most), "{most}");
    assert_eq!(most_intervals(&robot, 2), most / 2);
    assert_eq!(most_intervals(&robot, 1_000_000), 0);
    assert_eq!(most_intervals(&robot, usize::MAX), 0);
    // every marker of the link contains the name
    let long = URDF.replace("\"base\"", &format!("\"{}\"", "b".repeat(1000)));
    assert!(most_intervals(&RobotModel::from_urdf(&long, &MeshFiles::default()).unwrap(), 1) < most);
}
