//! Conversion of joint state messages to inputs of the monitor.

use clearance_monitor::{JointStateInput, SourceId};
use ros2_interfaces_jazzy_serde::sensor_msgs::msg::JointState;

use crate::messages::time_and_geometry::time_of;

/// Input of the monitor for a message of this publisher.
#[must_use]
pub fn joint_state_input(message: JointState, source: SourceId) -> JointStateInput {
    JointStateInput {
        source,
        stamp: time_of(&message.header.stamp),
        names: message.name,
        positions: message.position,
        velocities: message.velocity,
    }
}
