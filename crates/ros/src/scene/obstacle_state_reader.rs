//! Conversion of `clearance_msgs/ObstacleStates` to a scene update.

use clearance_geometry::math::Vector;
use clearance_monitor::{Now, Time};
use clearance_scene::{ObstacleState, ObstacleStates, SceneRejection};
use ros2_interfaces_jazzy_serde::geometry_msgs::msg::Vector3;

use crate::messages::clearance_msgs::{
    ObstacleState as StateMessage, ObstacleStates as ObstacleStatesMessage,
};
use crate::messages::time_and_geometry::time_of;
use crate::scene::scene_message_reader::Converted;
use crate::scene::transform_messages::pose;

/// Largest time (s) by which a stamp may be in the future.
const LARGEST_LEAD: f64 = 0.1;

/// Largest speed (m/s, rad/s); a faster one is a mistake.
const LARGEST_SPEED: f64 = 1000.0;

/// Converts a message that was received at `received_at`. Obstacles with invalid numbers are rejected; with a stamp in
/// the future, all are.
#[must_use]
pub fn obstacle_states(message: &ObstacleStatesMessage, received_at: Now) -> Converted<ObstacleStates> {
    let now = received_at.ros.unwrap_or_default();
    let stamp = match time_of(&message.header.stamp) {
        Time::ZERO => now,
        stamp => stamp,
    };
    let lead = received_at.ros.map_or(0.0, |now| stamp.seconds_since(now));
    let frame = &message.header.frame_id;
    let (mut states, mut rejections) = (Vec::new(), Vec::new());
    for state in &message.obstacles {
        let read = if lead > LARGEST_LEAD {
            Err(format!("header.stamp is {lead:.3} s in the future: synchronise the clocks"))
        } else {
            obstacle_state(state, frame)
        };
        match read {
            Ok(state) => states.push(state),
            Err(why) => rejections.push(SceneRejection::of(&state.name, why).of_pose()),
        }
    }
    Converted { change: ObstacleStates { stamp, received: received_at.steady, states }, rejections }
}

fn obstacle_state(
    StateMessage { name, pose: placed, twist }: &StateMessage,
    frame: &str,
) -> Result<ObstacleState, String> {
    Ok(ObstacleState {
        id: name.clone(),
        frame: frame.to_owned(),
        pose_fo: pose(placed, "pose")?,
        linear_f: velocity(&twist.linear, "twist.linear")?,
        angular_f: velocity(&twist.angular, "twist.angular")?,
    })
}

fn velocity(Vector3 { x, y, z }: &Vector3, field: &str) -> Result<Vector, String> {
    let velocity = Vector::new(*x, *y, *z);
    let is_valid = velocity.iter().all(|v| v.abs() <= LARGEST_SPEED);
    is_valid.then_some(velocity).ok_or_else(|| {
        format!("{field}: ({x}, {y}, {z}) must be finite, and at most {LARGEST_SPEED} in each direction")
    })
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use ros2_interfaces_jazzy_serde::geometry_msgs::msg::{Pose as PoseMessage, Quaternion, Twist};

    use super::*;
    use crate::messages::time_and_geometry::stamp_message;

    fn message(name: &str, milliseconds: i64) -> ObstacleStatesMessage {
        let mut message = ObstacleStatesMessage::default();
        message.header.stamp = stamp_message(Time::from_nanoseconds(1_000_000 * milliseconds));
        let pose = PoseMessage {
            orientation: Quaternion { w: 1.0, ..Quaternion::default() },
            ..PoseMessage::default()
        };
        let twist = Twist { linear: Vector3 { x: 0.5, y: 0.0, z: 0.0 }, ..Twist::default() };
        message.obstacles.push(StateMessage { name: name.to_owned(), pose, twist });
        message
    }

    fn now() -> Now {
        Now { ros: Some(Time::from_nanoseconds(10_000_000_000)), steady: Duration::from_secs(3) }
    }

    #[test]
    fn a_message_without_a_stamp_is_of_the_time_of_its_reception() {
        for (given, stamp) in [(0, 10.0), (9500, 9.5), (10_090, 10.09)] {
            let Converted { change, rejections } = obstacle_states(&message("a", given), now());
            assert!(rejections.is_empty() && change.states.len() == 1, "{rejections:?}");
            assert!((change.stamp.seconds_since(Time::ZERO) - stamp).abs() < 1e-9);
            assert_eq!(change.received, Duration::from_secs(3));
            assert_eq!(change.states[0].linear_f, Vector::new(0.5, 0.0, 0.0));
        }
    }

    #[test]
    fn broken_states_are_rejected_by_name() {
        type Break = fn(&mut ObstacleStatesMessage);
        let table: [(Break, &str); 5] = [
            (|m| m.header.stamp.sec = 11, "header.stamp is 1.000 s in the future"),
            (|m| m.obstacles[0].pose.position.x = f64::NAN, "pose"),
            (|m| m.obstacles[0].twist.linear.y = f64::INFINITY, "twist.linear"),
            (|m| m.obstacles[0].twist.angular.z = f64::NAN, "twist.angular"),
            (|m| m.obstacles[0].twist.angular.z = 1e30, "twist.angular"),
        ];
        for (damage, named) in table {
            let mut broken = message("a", 0);
            broken.obstacles.extend(message("b", 0).obstacles);
            damage(&mut broken);
            let Converted { change, rejections } = obstacle_states(&broken, now());
            assert!(rejections[0].to_string().starts_with(&format!("object 'a': {named}")), "{rejections:?}");
            assert_eq!(change.states.len() + rejections.len(), 2);
        }
    }
}
