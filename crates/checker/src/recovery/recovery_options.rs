//! Options of a recovery: the joints that may move, and the limits of the search.

use std::time::Instant;

use clearance_robot::{Joint, JointId, JointKind, RobotModel};

/// Limits of a search for a free state.
#[derive(Clone, Debug, PartialEq)]
pub struct RecoveryOptions {
    /// The joints that may move; `None` for all. Floating joints and passive joints of the SRDF never move, planar ones only if they are
    /// listed. A joint that mimics another one moves with it, within the limits of both.
    pub joints: Option<Vec<JointId>>,
    /// Joints that stay where they are, even if they are among `joints`.
    pub locked: Vec<JointId>,
    /// Largest distance of the free state from the given state: the Euclidean norm of the changes of all positions (rad, m).
    pub largest_distance: f64,
    /// The free state is at least this far (m) from all collisions, padding subtracted; 0 for a state that is just free.
    pub clearance: f64,
    /// The search ends after about this number of checked states.
    pub most_checks: u64,
    /// Time at which the search ends. The motion to a state that was found is still checked, which takes some 10 ms.
    pub deadline: Option<Instant>,
}

impl RecoveryOptions {
    /// Largest distance (rad, m) unless another one is given.
    pub const LARGEST_DISTANCE: f64 = 0.5;

    /// Clearance (m) unless another one is given: links of real robots are nearer to each other than a millimetre by design.
    pub const CLEARANCE: f64 = 0.0001;

    /// Number of checked states unless another one is given.
    pub const MOST_CHECKS: u64 = 30_000;

    /// The joints of a group of the SRDF may move.
    ///
    /// # Errors
    /// If the robot has no such group, or the group has no joint.
    pub fn of_group(robot: &RobotModel, name: &str) -> Result<Self, RecoveryError> {
        let groups = robot.srdf().map_or(&[][..], |srdf| &srdf.groups);
        let Some(group) = groups.iter().find(|group| group.name == name) else {
            let known = groups.iter().map(|group| group.name.clone()).collect();
            return Err(RecoveryError::UnknownGroup { name: name.to_owned(), known });
        };
        if group.joints.is_empty() {
            return Err(RecoveryError::EmptyGroup { name: name.to_owned() });
        }
        Ok(Self { joints: Some(group.joints.clone()), ..Self::default() })
    }

    /// By position: whether it may move.
    pub(super) fn movable(&self, robot: &RobotModel) -> Vec<bool> {
        let mut movable = vec![false; robot.position_names().len()];
        let mut set = |joint: JointId, value: bool| {
            let driver = robot.joint(joint).mimic.map_or(joint, |mimic| mimic.joint);
            if let Some(first) = robot.first_position(driver) {
                let count = robot.joint(driver).kind.position_suffixes().len();
                movable[first..first + count].fill(value);
            }
        };
        let is_planar = |joint: &JointId| matches!(robot.joint(*joint).kind, JointKind::Planar(_));
        match &self.joints {
            Some(joints) => joints.iter().for_each(|joint| set(*joint, true)),
            None => robot.joint_ids().filter(|joint| !is_planar(joint)).for_each(|joint| set(joint, true)),
        }
        // a passive joint that mimics another one follows it
        let rests = |joint: &JointId| {
            let Joint { kind, passive, mimic, .. } = robot.joint(*joint);
            *kind == JointKind::Floating || (*passive && mimic.is_none())
        };
        let resting = robot.joint_ids().filter(rests).chain(self.locked.iter().copied());
        resting.for_each(|joint| set(joint, false));
        movable
    }

    pub(super) fn validate(&self, robot: &RobotModel) -> Result<(), RecoveryError> {
        for (option, value) in [("largest_distance", self.largest_distance), ("clearance", self.clearance)] {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(RecoveryError::OutOfRange { option, value });
            }
        }
        let count = robot.joints().len();
        let all = self.joints.iter().flatten().chain(&self.locked);
        match all.map(|joint| joint.index()).find(|index| *index >= count) {
            Some(index) => Err(RecoveryError::UnknownJoint { index, count }),
            None => Ok(()),
        }
    }
}

impl Default for RecoveryOptions {
    fn default() -> Self {
        Self {
            joints: None,
            locked: Vec::new(),
            largest_distance: Self::LARGEST_DISTANCE,
            clearance: Self::CLEARANCE,
            most_checks: Self::MOST_CHECKS,
            deadline: None,
        }
    }
}

/// Options that do not fit the robot.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RecoveryError {
    /// A length is negative or not finite.
    #[error("{option} must be a finite number, zero or more: {value}")]
    OutOfRange {
        /// Name of the option.
        option: &'static str,
        /// Its value (rad, m).
        value: f64,
    },
    /// A joint of another robot.
    #[error("joint number {index} is not one of the robot's {count} joints")]
    UnknownJoint {
        /// Number of the joint.
        index: usize,
        /// Number of joints of the robot.
        count: usize,
    },
    /// The SRDF has no such group.
    #[error("the robot has no group '{name}'; {}", known_groups(known))]
    UnknownGroup {
        /// The given name.
        name: String,
        /// The groups of the robot.
        known: Vec<String>,
    },
    /// No joint of the group is in the URDF.
    #[error("group '{name}' has no joint of the robot's URDF")]
    EmptyGroup {
        /// Name of the group.
        name: String,
    },
}

fn known_groups(known: &[String]) -> String {
    if known.is_empty() {
        return "its SRDF has none".to_owned();
    }
    format!("its SRDF has {}", clearance_robot::quoted_list(known))
}
