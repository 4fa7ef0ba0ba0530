//! Joint groups of the SRDF as sub-vectors of a configuration, with which planners of one arm work.

use std::collections::BTreeSet;

use clearance_geometry::constants::LARGEST_COORDINATE;
use clearance_geometry::math::Extremes;

use super::configuration::unit_quaternion;
use super::quoted_names::quoted_list;
use super::{Configuration, ConfigurationError, JointId, JointKind, RobotModel};

/// Positions of the joints of one group, in the order of the URDF. Reads and writes them in a configuration of the whole
/// robot, without allocation; all other positions stay.
///
/// Fixed joints have no position. A mimic joint in the group stands for its leader, whose position is in the group then;
/// it follows its leader always.
#[derive(Clone, Debug, PartialEq)]
pub struct JointGroup {
    name: String,
    joint_names: Vec<String>,
    /// By position of the group: its index in a configuration.
    positions: Vec<usize>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    /// By position of the group: the largest value with which its mimic joints can be computed.
    farthest: Vec<f64>,
    /// First index of each quaternion.
    quaternions: Vec<usize>,
    /// Number of positions of the robot.
    robot_positions: usize,
}

/// The robot has no such group.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the robot has no group '{name}'; {}", known_names("SRDF", known))]
pub struct UnknownGroup {
    /// The name that was given.
    pub name: String,
    /// Names of the groups of the SRDF.
    pub known: Vec<String>,
}

/// The names that there are, as part of an error message.
pub(super) fn known_names(holder: &str, known: &[String]) -> String {
    if known.is_empty() {
        format!("its {holder} has none")
    } else {
        format!("its {holder} has {}", quoted_list(known))
    }
}

impl RobotModel {
    /// The group of the SRDF with this name; chains and subgroups are resolved.
    ///
    /// # Errors
    /// If there is no such group, or no SRDF.
    pub fn joint_group(&self, name: &str) -> Result<JointGroup, UnknownGroup> {
        let groups = self.srdf().map_or(&[][..], |srdf| &srdf.groups);
        let group = groups.iter().find(|group| group.name == name).ok_or_else(|| UnknownGroup {
            name: name.to_owned(),
            known: groups.iter().map(|group| group.name.clone()).collect(),
        })?;
        Ok(JointGroup::of_joints(self, name, &group.joints))
    }

    /// All joints as one group, with the robot's name.
    #[must_use]
    pub fn all_joints(&self) -> JointGroup {
        JointGroup::of_joints(self, self.name(), &self.joint_ids().collect::<Vec<_>>())
    }
}

impl JointGroup {
    /// A group of these joints, whether the SRDF has it or not.
    ///
    /// # Panics
    /// If a joint is not one of the robot's.
    #[must_use]
    pub fn of_joints(robot: &RobotModel, name: &str, joints: &[JointId]) -> Self {
        let mut group = Self {
            name: name.to_owned(),
            joint_names: Vec::new(),
            positions: Vec::new(),
            lower: Vec::new(),
            upper: Vec::new(),
            farthest: Vec::new(),
            quaternions: Vec::new(),
            robot_positions: robot.position_names().len(),
        };
        let ranges = robot.position_ranges();
        let leader = |&id: &JointId| robot.joint(id).mimic.map_or(id, |mimic| mimic.joint);
        let leaders: BTreeSet<JointId> = joints.iter().map(leader).collect();
        for id in leaders {
            let Some(first) = robot.first_position(id) else { continue };
            let joint = robot.joint(id);
            if joint.kind == JointKind::Floating {
                group.quaternions.push(group.positions.len() + 3);
            }
            for offset in 0..joint.kind.position_suffixes().len() {
                group.joint_names.push(robot.position_names()[first + offset].clone());
                group.positions.push(first + offset);
                let [lower, upper] = ranges[first + offset];
                group.lower.push(lower);
                group.upper.push(upper);
                group.farthest.push(farthest(robot, id));
            }
        }
        group
    }

    /// Name of the group.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Names of the positions, as in [`RobotModel::position_names`].
    #[must_use]
    pub fn joint_names(&self) -> &[String] {
        &self.joint_names
    }

    /// Number of positions.
    #[must_use]
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// True if the group has no joint that moves by itself.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Lower limits (rad, m), also of the joints that mimic these; negative infinity where there is none. See
    /// [`RobotModel::position_ranges`].
    #[must_use]
    pub fn lower(&self) -> &[f64] {
        &self.lower
    }

    /// Upper limits (rad, m), also of the joints that mimic these; infinity where there is none.
    #[must_use]
    pub fn upper(&self) -> &[f64] {
        &self.upper
    }

    /// Index of each position in [`Configuration::positions`].
    #[must_use]
    pub fn positions(&self) -> &[usize] {
        &self.positions
    }

    /// Moves the joints of the group in `q` to these positions (rad, m); quaternions are normalised. Limits are not
    /// checked.
    ///
    /// # Errors
    /// If the number of positions is wrong, if one is not finite or too large, if a quaternion has not length 1, or if
    /// `q` is of a robot with another number of positions. Then `q` does not change.
    pub fn set(&self, q: &mut Configuration, positions: &[f64]) -> Result<(), ConfigurationError> {
        self.check(q, positions)?;
        for (&index, &value) in self.positions.iter().zip(positions) {
            q.positions_mut()[index] = value;
        }
        for &first in &self.quaternions {
            let quaternion: [f64; 4] = std::array::from_fn(|i| positions[first + i]);
            if let Ok(unit) = unit_quaternion(quaternion) {
                (0..4).for_each(|i| q.positions_mut()[self.positions[first + i]] = unit[i]);
            }
        }
        Ok(())
    }

    fn check(&self, q: &Configuration, positions: &[f64]) -> Result<(), ConfigurationError> {
        let counts = [(positions.len(), self.len()), (q.positions().len(), self.robot_positions)];
        if let Some((given, expected)) = counts.into_iter().find(|(given, expected)| given != expected) {
            let names = self.joint_names.join(", ");
            return Err(ConfigurationError::WrongLength { given, expected, names });
        }
        for (i, &value) in positions.iter().enumerate() {
            let joint = || self.joint_names[i].clone();
            if !value.is_finite() {
                return Err(ConfigurationError::NotFinite { joint: joint(), value });
            }
            if value.abs() > self.farthest[i] {
                return Err(ConfigurationError::TooFar { joint: joint(), value });
            }
        }
        for &first in &self.quaternions {
            let quaternion = std::array::from_fn(|i| positions[first + i]);
            unit_quaternion(quaternion).map_err(|length| {
                let joint = self.joint_names[first].trim_end_matches("/rot_x").to_owned();
                ConfigurationError::NotAQuaternion { joint, length }
            })?;
        }
        Ok(())
    }

    /// Writes the positions (rad, m) of the group in `q` to `positions`.
    ///
    /// # Panics
    /// If `positions` is not as long as the group, or `q` is of a robot with fewer positions.
    pub fn get(&self, q: &Configuration, positions: &mut [f64]) {
        assert_eq!(positions.len(), self.len(), "a number for every position of the group");
        for (value, &index) in positions.iter_mut().zip(&self.positions) {
            *value = q.positions()[index];
        }
    }
}

/// The largest position of a joint with which it and its mimic joints can be computed.
fn farthest(robot: &RobotModel, leader: JointId) -> f64 {
    let of_follower =
        robot.mimicking_joints().filter(|(_, mimic)| mimic.joint == leader).map(|(_, mimic)| {
            let room = (LARGEST_COORDINATE - mimic.offset.abs()).greater(0.0);
            if mimic.multiplier == 0.0 { f64::INFINITY } else { room / mimic.multiplier.abs() }
        });
    of_follower.fold(LARGEST_COORDINATE, f64::lesser)
}

#[cfg(test)]
mod tests;
