//! Configurations: validated joint positions of a whole robot.

use clearance_geometry::constants::LARGEST_COORDINATE;

use super::joint::{Joint, JointKind};
use super::{ConfigurationError, JointId, RobotModel};

/// Finite positions of every free joint (rad, m), in the order of [`RobotModel::position_names`].
#[derive(Clone, Debug, PartialEq)]
pub struct Configuration(Vec<f64>);

impl Configuration {
    /// The positions (rad, m), in the order of [`RobotModel::position_names`].
    #[must_use]
    #[inline]
    pub fn positions(&self) -> &[f64] {
        &self.0
    }

    /// For positions that are validated by the caller.
    #[inline]
    pub(super) fn positions_mut(&mut self) -> &mut [f64] {
        &mut self.0
    }

    /// Positions interpolated between validated ones.
    #[inline]
    pub fn trusted(positions: Vec<f64>) -> Self {
        Self(positions)
    }
}

impl RobotModel {
    /// Checks `positions`, one for each of [`Self::position_names`].
    ///
    /// # Errors
    /// If there are too many or too few, if one is not finite, or if the quaternion of a floating joint is not a unit quaternion.
    #[inline]
    pub fn configuration(&self, positions: &[f64]) -> Result<Configuration, ConfigurationError> {
        let mut q = Configuration(Vec::with_capacity(self.position_names.len()));
        self.configuration_into(positions, &mut q)?;
        Ok(q)
    }

    /// As [`Self::configuration`], into an earlier configuration of this robot, whose memory is reused. If it fails, `q` must not be used.
    pub fn configuration_into(
        &self,
        positions: &[f64],
        q: &mut Configuration,
    ) -> Result<(), ConfigurationError> {
        if positions.len() != self.position_names.len() {
            return Err(ConfigurationError::WrongLength {
                given: positions.len(),
                expected: self.position_names.len(),
                names: self.position_names.join(", "),
            });
        }
        if let Some(i) = positions.iter().position(|value| !value.is_finite()) {
            return Err(ConfigurationError::NotFinite {
                joint: self.position_names[i].clone(),
                value: positions[i],
            });
        }
        q.0.clear();
        q.0.extend_from_slice(positions);
        self.normalise_quaternions(&mut q.0)?;
        self.check_reach(q)
    }

    /// Rejects positions, of mimic joints too, so large that kinematics would overflow.
    fn check_reach(&self, q: &Configuration) -> Result<(), ConfigurationError> {
        let near = -LARGEST_COORDINATE..=LARGEST_COORDINATE;
        let too_far = |joint: &String, value: f64| ConfigurationError::TooFar { joint: joint.clone(), value };
        let named = self.position_names.iter().zip(&q.0);
        // the position of a mimic joint may have overflowed to NaN, which counts as too large, too
        let following = (self.joint_ids().filter(|j| self.joint(*j).mimic.is_some()))
            .filter_map(|j| Some((&self.joint(j).name, self.joint_position(q, j)?)));
        let mut all = named.map(|(name, value)| (name, *value)).chain(following);
        all.find(|(_, value)| !near.contains(value)).map_or(Ok(()), |(name, value)| Err(too_far(name, value)))
    }

    /// By position: true if a full turn changes nothing, neither in this joint nor in its mimic joints.
    #[must_use]
    #[inline]
    pub fn whole_turns(&self) -> Vec<bool> {
        let mut turns = vec![false; self.position_names.len()];
        for id in self.joint_ids().filter(|id| self.moved_by_whole_turns(*id).is_none()) {
            let Some(first) = self.first_position(id) else { continue };
            if let Some(angle) = self.joint(id).kind.unlimited_angle() {
                turns[first + angle] = true;
            }
        }
        turns
    }

    /// A mimic joint of this one whose pose differs after a full turn of this one.
    #[must_use]
    #[inline]
    pub fn moved_by_whole_turns(&self, leader: JointId) -> Option<&Joint> {
        let comes_back = |joint: &Joint, multiplier: f64| {
            multiplier == 0.0 || (matches!(joint.kind, JointKind::Continuous(_)) && multiplier.fract() == 0.0)
        };
        (self.mimicking_joints())
            .find(|(joint, mimic)| mimic.joint == leader && !comes_back(joint, mimic.multiplier))
            .map(|(joint, _)| joint)
    }

    /// Every joint at zero, or at the middle of limits that exclude zero.
    #[must_use]
    #[inline]
    pub fn default_configuration(&self) -> Configuration {
        let mut positions = vec![0.0; self.position_names.len()];
        for joint in self.joint_ids() {
            let Some(first) = self.first_position(joint) else {
                continue;
            };
            match (&self.joint(joint).kind, self.joint(joint).limits) {
                (JointKind::Floating, _) => positions[first + 6] = 1.0,
                (_, Some(l)) if !(l.lower..=l.upper).contains(&0.0) => {
                    positions[first] = l.lower.midpoint(l.upper);
                }
                _ => {}
            }
        }
        Configuration(positions)
    }

    /// The default configuration with some joints set by name.
    ///
    /// A value of a mimic joint moves its leader, or must agree with the value of the leader.
    ///
    /// # Errors
    /// If a name is unknown, fixed or given twice, if a value of a mimic joint disagrees with its leader, and as for
    /// [`Self::configuration`].
    #[inline]
    pub fn configuration_from_names<'a>(
        &self,
        named: impl IntoIterator<Item = (&'a str, f64)>,
    ) -> Result<Configuration, ConfigurationError> {
        self.configuration_over(&self.default_configuration(), named)
    }

    /// As [`Self::configuration_from_names`], but joints that are not named keep their positions of `rest`.
    #[inline]
    pub fn configuration_over<'a>(
        &self,
        rest: &Configuration,
        named: impl IntoIterator<Item = (&'a str, f64)>,
    ) -> Result<Configuration, ConfigurationError> {
        let (names, values): (Vec<&str>, Vec<f64>) = named.into_iter().unzip();
        self.named_joints(names)?.configuration(rest, &values)
    }

    fn normalise_quaternions(&self, positions: &mut [f64]) -> Result<(), ConfigurationError> {
        for id in self.joint_ids() {
            let joint = self.joint(id);
            let (JointKind::Floating, Some(first)) = (&joint.kind, self.first_position(id)) else {
                continue;
            };
            let quaternion = &mut positions[first + 3..first + 7];
            let unit = unit_quaternion(std::array::from_fn(|i| quaternion[i]))
                .map_err(|length| ConfigurationError::NotAQuaternion { joint: joint.name.clone(), length })?;
            quaternion.copy_from_slice(&unit);
        }
        Ok(())
    }

    /// The position of a joint with one degree of freedom, mimics resolved: a joint that mimics a fixed joint stays at its offset. `None`
    /// for other joints.
    #[must_use]
    #[inline]
    pub fn joint_position(&self, q: &Configuration, joint: JointId) -> Option<f64> {
        match self.joint(joint).mimic {
            Some(m) if self.joint(m.joint).kind == JointKind::Fixed => Some(m.offset),
            Some(m) => Some(m.multiplier * self.joint_position(q, m.joint)? + m.offset),
            None if self.joint(joint).kind.position_suffixes().len() == 1 => {
                Some(q.0[self.first_position(joint)?])
            }
            None => None,
        }
    }
}

/// A quaternion of length 1, from one that has it within 1e-3; otherwise the length is the error.
pub(super) fn unit_quaternion(components: [f64; 4]) -> Result<[f64; 4], f64> {
    let length = components.iter().map(|c| c * c).sum::<f64>().sqrt();
    // NaN is no length
    if (length - 1.0).abs() <= 1e-3 { Ok(components.map(|c| c / length)) } else { Err(length) }
}
