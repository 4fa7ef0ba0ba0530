//! From names and numbers to a configuration, or why not.

use std::collections::HashMap;

use super::status::{quoted, quoted_list};
use super::{JointStateInput, Reason};
use crate::constants::LARGEST_COORDINATE;
use crate::robot::{Configuration, JointId, RobotModel};

/// How far (rad, m) a joint may be beyond its limits without a word: encoders are noisy and brakes give.
const LIMIT_SLACK: f64 = 1e-3;

/// What a name in a joint state stands for.
#[derive(Clone, Copy, Debug)]
enum Slot {
    /// The number with this index in a configuration.
    Position(usize),
    /// A joint whose position follows from others.
    Follows,
}

/// Reads joint states for one robot.
#[derive(Clone, Debug)]
pub(super) struct Tracker {
    slots: HashMap<String, Slot>,
    /// By position: the joint and its limits, where it has some.
    limits: Vec<Option<(JointId, f64, f64)>>,
}

/// A configuration, and what was odd about its message.
#[derive(Clone, Debug)]
pub(super) struct Reading {
    pub configuration: Configuration,
    /// One for each position, if all are given and finite.
    pub velocities: Option<Vec<f64>>,
    pub warnings: Vec<String>,
}

impl Tracker {
    pub fn new(robot: &RobotModel) -> Self {
        let mut slots: HashMap<String, Slot> =
            (robot.joints().iter()).map(|joint| (joint.name.clone(), Slot::Follows)).collect();
        for (index, name) in robot.position_names().iter().enumerate() {
            slots.insert(name.clone(), Slot::Position(index));
        }
        let mut limits = vec![None; robot.position_names().len()];
        for id in robot.joint_ids() {
            let joint = robot.joint(id);
            // joints with several positions have no limits of their own
            let single = joint.kind.position_suffixes().len() == 1;
            if let (true, Some(index), Some(l)) = (single, robot.first_position(id), joint.limits) {
                limits[index] = Some((id, l.lower, l.upper));
            }
        }
        Self { slots, limits }
    }

    pub fn read(&self, robot: &RobotModel, input: &JointStateInput) -> Result<Reading, Reason> {
        if input.names.len() != input.positions.len() {
            return Err(Reason::Malformed(format!(
                "it has {} names and {} positions",
                input.names.len(),
                input.positions.len()
            )));
        }
        let mut positions = vec![None; self.limits.len()];
        let mut unknown = Vec::new();
        for (name, &value) in input.names.iter().zip(&input.positions) {
            match self.slots.get(name) {
                Some(Slot::Position(index)) => fill(&mut positions[*index], name, value)?,
                Some(Slot::Follows) => {}
                None => unknown.push(name.clone()),
            }
        }
        let configuration = complete(robot, &positions)?;
        let mut warnings = self.limit_warnings(robot, &configuration);
        if !unknown.is_empty() {
            warnings.push(format!("the robot has no joint {}", quoted_list(&unknown)));
        }
        Ok(Reading { configuration, velocities: self.velocities(input), warnings })
    }

    /// Velocities of all positions; those of other joints count for nothing.
    fn velocities(&self, input: &JointStateInput) -> Option<Vec<f64>> {
        if input.velocities.len() != input.names.len() {
            return None;
        }
        let mut velocities = vec![0.0; self.limits.len()];
        for (name, &value) in input.names.iter().zip(&input.velocities) {
            if let Some(Slot::Position(index)) = self.slots.get(name) {
                velocities[*index] = value;
            }
        }
        velocities.iter().all(|v| v.is_finite()).then_some(velocities)
    }

    fn limit_warnings(&self, robot: &RobotModel, configuration: &Configuration) -> Vec<String> {
        (self.limits.iter().zip(configuration.positions()))
            .filter_map(|(limits, &value)| {
                let (joint, lower, upper) = (*limits)?;
                let inside = (lower - LIMIT_SLACK..=upper + LIMIT_SLACK).contains(&value);
                (!inside).then(|| {
                    let name = &robot.joint(joint).name;
                    format!("joint '{name}' is at {value}, outside its limits [{lower}, {upper}]")
                })
            })
            .collect()
    }
}

fn fill(slot: &mut Option<f64>, name: &str, value: f64) -> Result<(), Reason> {
    if slot.is_some() {
        return Err(Reason::Malformed(format!("joint {} stands in it twice", quoted(name))));
    }
    if !value.is_finite() {
        return Err(Reason::NonFinite { joint: name.to_owned(), value });
    }
    if value.abs() > LARGEST_COORDINATE {
        return Err(Reason::Malformed(format!("joint {} is at {value:e}", quoted(name))));
    }
    *slot = Some(value);
    Ok(())
}

fn complete(robot: &RobotModel, positions: &[Option<f64>]) -> Result<Configuration, Reason> {
    let missing: Vec<String> = (robot.position_names().iter().zip(positions))
        .filter(|(_, position)| position.is_none())
        .map(|(name, _)| name.clone())
        .collect();
    if !missing.is_empty() {
        return Err(Reason::Partial { missing });
    }
    let positions: Vec<f64> = positions.iter().copied().flatten().collect();
    (robot.configuration(&positions)).map_err(|error| Reason::Malformed(error.to_string()))
}
