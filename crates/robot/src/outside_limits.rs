//! Detects joints beyond their limits.

use super::{Configuration, JointId, RobotModel};

/// Tolerance (rad, m) beyond joint limits that causes no warning: encoders are noisy and brakes yield.
const SLACK: f64 = 1e-3;

/// A joint beyond its limits. Collisions are checked nevertheless: limits do not affect the result.
#[derive(Clone, Debug, PartialEq)]
pub struct OutsideLimits {
    /// Name of the position.
    pub joint: String,
    /// Its position (rad, m).
    pub position: f64,
    /// Lower limit (rad, m).
    pub lower: f64,
    /// Upper limit (rad, m).
    pub upper: f64,
    /// True if the value would be within the limits if it were in degrees.
    pub fits_in_degrees: bool,
}

impl std::fmt::Display for OutsideLimits {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { joint, position, lower, upper, fits_in_degrees } = self;
        let hint = if *fits_in_degrees { " rad: is that degrees?" } else { "" };
        write!(f, "joint '{joint}' is at {position}, outside its limits [{lower}, {upper}]{hint}")
    }
}

impl RobotModel {
    /// The joints that exceed their limits by more than noise, mimic joints included; `positions` has one value for each of
    /// [`Self::position_names`]. Joints with several positions have no limits of their own.
    pub fn outside_limits<'a>(&'a self, positions: &'a [f64]) -> impl Iterator<Item = OutsideLimits> + 'a {
        self.joint_ids().filter_map(|id| {
            let position = match self.joint(id).mimic {
                Some(mimic) => {
                    mimic.multiplier * positions.get(self.first_position(mimic.joint)?)? + mimic.offset
                }
                None => *positions.get(self.first_position(id)?)?,
            };
            self.outside_limit(id, position)
        })
    }

    /// The excess of a joint position over its limits, if it is more than noise. Joints with several positions have none.
    pub(super) fn outside_limit(&self, id: JointId, position: f64) -> Option<OutsideLimits> {
        let joint = self.joint(id);
        let limits = joint.limits.filter(|_| joint.kind.position_suffixes().len() == 1)?;
        let is_inside = |q: f64| (limits.lower - SLACK..=limits.upper + SLACK).contains(&q);
        (!is_inside(position)).then(|| OutsideLimits {
            joint: joint.name.clone(),
            position,
            lower: limits.lower,
            upper: limits.upper,
            fits_in_degrees: joint.kind.turns() && is_inside(position.to_radians()),
        })
    }

    /// A remark on states, or on paths given by some of their states, in which joints are beyond their limits: the first such joint, and
    /// the number of others. `what` names the states in the text.
    pub fn limits_note<'q>(
        &self,
        what: &str,
        all: impl IntoIterator<Item = impl IntoIterator<Item = &'q Configuration>>,
    ) -> Option<String> {
        let mut count = 0;
        let mut outside = Vec::new();
        for states in all {
            let of_one = |q: &Configuration| self.outside_limits(q.positions()).next();
            outside.extend(states.into_iter().find_map(of_one).map(|joint| (count, joint)));
            count += 1;
        }
        let (number, joint) = outside.first()?;
        let which = if count > 1 { format!("{what} {number}: ") } else { String::new() };
        let others = match outside.len() - 1 {
            0 => String::new(),
            1 => format!(", and 1 more {what} is outside"),
            others => format!(", and {others} more {what}s are outside"),
        };
        Some(format!("{which}{joint}{others} (checked all the same)"))
    }
}

#[cfg(test)]
mod tests;
