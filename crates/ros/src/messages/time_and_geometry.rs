//! Conversion of times, points, vectors and poses to ROS messages, and of stamps back.

use clearance_geometry::math::{Point, Pose, Vector};
use clearance_monitor::Time;
use ros2_interfaces_jazzy_serde::builtin_interfaces::msg::Time as StampMessage;
use ros2_interfaces_jazzy_serde::geometry_msgs::msg::{
    Point as PointMessage, Pose as PoseMessage, Quaternion, Vector3,
};

const NANOSECONDS: i64 = 1_000_000_000;

/// Converts a time to a message stamp; times after the year 2038 are clamped.
#[must_use]
pub fn stamp_message(time: Time) -> StampMessage {
    let nanosecond = time.nanoseconds().rem_euclid(NANOSECONDS);
    let second = time.nanoseconds().div_euclid(NANOSECONDS);
    StampMessage {
        sec: i32::try_from(second).unwrap_or(if second < 0 { i32::MIN } else { i32::MAX }),
        nanosec: u32::try_from(nanosecond).unwrap_or_default(),
    }
}

/// Converts a message stamp to a time.
#[must_use]
pub fn time_of(stamp: &StampMessage) -> Time {
    Time::from_nanoseconds(i64::from(stamp.sec) * NANOSECONDS + i64::from(stamp.nanosec))
}

#[must_use]
pub fn point_message(point: &Point) -> PointMessage {
    PointMessage { x: point.x, y: point.y, z: point.z }
}

#[must_use]
pub fn vector_message(vector: &Vector) -> Vector3 {
    Vector3 { x: vector.x, y: vector.y, z: vector.z }
}

#[must_use]
pub fn pose_message(pose: &Pose) -> PoseMessage {
    let position = pose.translation.vector;
    let q = pose.rotation.quaternion();
    PoseMessage {
        position: PointMessage { x: position.x, y: position.y, z: position.z },
        orientation: Quaternion { x: q.i, y: q.j, z: q.k, w: q.w },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_go_both_ways() {
        for nanoseconds in [0, 1, -1, 1_500_000_000, -1_500_000_000, 1_700_000_000_123_456_789] {
            let time = Time::from_nanoseconds(nanoseconds);
            let message = stamp_message(time);
            assert!(i64::from(message.nanosec) < NANOSECONDS);
            assert_eq!(time_of(&message), time);
        }
        assert_eq!(stamp_message(Time::from_nanoseconds(i64::MAX)).sec, i32::MAX);
    }
}
