//! Random configurations.

use std::f64::consts::PI;

use super::{Configuration, JointKind, RobotModel};

impl RobotModel {
    /// A configuration that is uniform over the joint limits. Joints without limits use half a turn or half a metre to either side;
    /// planar and floating joints keep their default positions.
    #[must_use]
    pub fn random_configuration(&self, random: &mut fastrand::Rng) -> Configuration {
        let mut positions = self.default_configuration().positions().to_vec();
        for id in self.joint_ids() {
            let joint = self.joint(id);
            let Some(first) = self.first_position(id) else { continue };
            let (low, high) = match (&joint.kind, joint.limits) {
                (JointKind::Planar(_) | JointKind::Floating, _) => continue,
                (JointKind::Continuous(_), _) | (JointKind::Revolute(_), None) => (-PI, PI),
                (_, None) => (-0.5, 0.5),
                (_, Some(limits)) => (limits.lower, limits.upper),
            };
            positions[first] = low + (high - low) * random.f64();
        }
        // if a mimic joint exceeds the largest allowed position, the robot keeps its default configuration
        self.configuration(&positions).unwrap_or_else(|_| self.default_configuration())
    }
}
