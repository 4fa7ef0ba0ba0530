//! What the monitor hears.

use super::Time;

/// Who sent a message: unique for each publisher.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SourceId(pub [u8; 16]);

/// A `sensor_msgs/JointState` as it came, unchecked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointStateInput {
    pub source: SourceId,
    /// When the publisher says the positions were measured; zero when it does not say.
    pub stamp: Time,
    pub names: Vec<String>,
    /// Positions (rad, m), one for each name if the message is right.
    pub positions: Vec<f64>,
    /// Velocities (rad/s, m/s), one for each name; empty when they are not given.
    pub velocities: Vec<f64>,
}
