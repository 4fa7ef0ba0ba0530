//! `~/swept_volume`: swept volumes of the links along a motion, for `RViz`.

use clearance_checker::{CollisionChecker, MotionVerdict, SweptVolume, TrajectoryReport, Workspace};
use clearance_geometry::math::{Pose, Rotation, Vector};
use clearance_motion::Trajectory;
use clearance_robot::RobotModel;
use ros2_interfaces_jazzy_serde::std_msgs::msg::{ColorRGBA, Header};
use ros2_interfaces_jazzy_serde::visualization_msgs::msg::{Marker, MarkerArray};

use crate::messages::time_and_geometry::{point_message, pose_message, vector_message};

/// Maximum size of one message (bytes): `RustDDS` loses messages of more than about 250 kB.
const LONGEST_MESSAGE: usize = 200_000;

/// Size of a marker without its names (bytes), rounded up: 230 and two points.
const MARKER_BYTES: usize = 288;

/// Maximum number of markers per capsule: a cylinder, and the spheres at its ends.
const MARKERS_OF_CAPSULE: usize = 2;

const GREEN: [f32; 4] = [0.1, 0.8, 0.2, 0.25];
const RED: [f32; 4] = [0.9, 0.1, 0.1, 0.5];
const YELLOW: [f32; 4] = [1.0, 0.8, 0.1, 0.4];
const GREY: [f32; 4] = [0.6, 0.6, 0.6, 0.25];

/// Maximum number of intervals per segment that fit into one message, for this number of segments.
#[must_use]
pub fn most_intervals(robot: &RobotModel, segments: usize) -> usize {
    let frame = robot.link(robot.root()).name.len();
    let with_geometry = robot.links().iter().filter(|link| !link.collisions.is_empty());
    let bytes: usize =
        with_geometry.map(|link| MARKERS_OF_CAPSULE * (MARKER_BYTES + frame + link.name.len())).sum();
    LONGEST_MESSAGE / bytes.saturating_mul(segments).max(1)
}

/// Message that deletes all markers.
#[must_use]
pub fn no_markers() -> MarkerArray {
    let pose = pose_message(&Pose::identity());
    MarkerArray { markers: vec![Marker { action: Marker::DELETEALL, pose, ..Marker::default() }] }
}

/// Swept volumes of all links for a number of intervals per segment, coloured by the result. Deletes the previous
/// markers first. `None` when the volumes exceed the range of numbers.
#[must_use]
pub fn swept_volume_markers(
    checker: &CollisionChecker,
    trajectory: &Trajectory,
    report: &TrajectoryReport,
    intervals: usize,
    workspace: &mut Workspace,
) -> Option<MarkerArray> {
    let robot = checker.robot();
    let frame = &robot.link(robot.root()).name;
    let mut shown = no_markers();
    for (segment, motion) in trajectory.segments().iter().enumerate() {
        for volume in checker.swept_volumes(motion, intervals, workspace) {
            let numbers = volume.a.iter().chain(volume.b.iter()).chain([&volume.radius]);
            if !numbers.into_iter().all(|x| x.is_finite()) {
                return None;
            }
            let first_id = shown.markers.len();
            let colour = colour(report, segment, &volume);
            shown.markers.extend(capsule(&volume).into_iter().flatten().zip(first_id..).map(
                |(marker, id)| Marker {
                    // the volumes move with the root link in `RViz`
                    header: Header { frame_id: frame.clone(), ..Header::default() },
                    ns: checker.body_name(volume.body).to_owned(),
                    id: i32::try_from(id).unwrap_or(i32::MAX),
                    action: Marker::ADD,
                    color: colour.clone(),
                    ..marker
                },
            ));
        }
    }
    Some(shown)
}

/// Colour for the result of a link on an interval of a segment.
fn colour(report: &TrajectoryReport, segment: usize, volume: &SweptVolume) -> ColorRGBA {
    let [from, to] = volume.t;
    // the position of a contact is known; an undecided part may be anywhere in its interval
    let (found, proven_until, [first, last], pair) = match report.verdict {
        MotionVerdict::Free => (GREEN, 1.0, [1.0; 2], None),
        MotionVerdict::Contact { t, pair, .. } => (RED, t[0], [t[1]; 2], Some(pair)),
        MotionVerdict::Undecided { t, pair, .. } => (YELLOW, t[0], t, pair),
    };
    let is_there = segment == report.segment;
    let is_of_pair = pair.is_some_and(|(a, b)| [a, b].contains(&volume.body));
    let [r, g, b, a] = if segment < report.segment || (is_there && to <= proven_until) {
        GREEN
    } else if is_there && is_of_pair && from <= last && first <= to {
        found
    } else {
        GREY
    };
    ColorRGBA { r, g, b, a }
}

/// Cylinder, and one marker with the spheres at its ends; only a sphere if both ends are equal.
fn capsule(volume: &SweptVolume) -> [Option<Marker>; MARKERS_OF_CAPSULE] {
    let axis = volume.b - volume.a;
    let diameter = 2.0 * volume.radius;
    let length = axis.norm();
    let cylinder = (length > 0.0).then(|| {
        let turn = Rotation::rotation_between(&Vector::z(), &axis);
        // the rotation is undefined only for a half turn
        let turn = turn.unwrap_or(Rotation::from_axis_angle(&Vector::x_axis(), std::f64::consts::PI));
        let middle = nalgebra::center(&volume.a, &volume.b);
        Marker {
            type_: Marker::CYLINDER,
            pose: pose_message(&Pose::from_parts(middle.coords.into(), turn)),
            scale: vector_message(&Vector::new(diameter, diameter, length)),
            ..Marker::default()
        }
    });
    let ends = if length > 0.0 { vec![volume.a, volume.b] } else { vec![volume.a] };
    let balls = Marker {
        type_: Marker::SPHERE_LIST,
        pose: pose_message(&Pose::identity()),
        scale: vector_message(&Vector::repeat(diameter)),
        points: ends.iter().map(point_message).collect(),
        ..Marker::default()
    };
    [cylinder, Some(balls)]
}

#[cfg(test)]
mod tests;
