//! Data types of the monitor's input: a received joint state, and the identity of its publisher.

use super::Time;

/// Publisher of a message: unique for each publisher.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SourceId(pub [u8; 16]);

/// A `sensor_msgs/JointState` as it was received, not validated.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointStateInput {
    /// Publisher of the message.
    pub source: SourceId,
    /// Time of the measurement according to the publisher; zero when it is not given.
    pub stamp: Time,
    /// Names of the joints.
    pub names: Vec<String>,
    /// Positions (rad, m); a valid message has one for each name.
    pub positions: Vec<f64>,
    /// Velocities (rad/s, m/s), one for each name; empty when not given.
    pub velocities: Vec<f64>,
}
