//! Joints beyond their limits.

use super::{Configuration, JointId, RobotModel};

/// How far (rad, m) a joint may be beyond its limits without a word: encoders are noisy and brakes give.
const SLACK: f64 = 1e-3;

/// A joint that is where it should not get to. Collisions are checked all the same: what a robot does is no matter of limits.
#[derive(Clone, Debug, PartialEq)]
pub struct OutsideLimits {
    pub joint: String,
    /// Where it is (rad, m).
    pub position: f64,
    pub lower: f64,
    pub upper: f64,
    /// Whether the number would do if it were degrees.
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
    /// The joints that are beyond their limits by more than noise, mimic joints included, where `positions` has one for each of
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

    /// How a position of a joint is beyond its limits by more than noise, if it is. Joints with several positions have none.
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

    /// A word about states, or about ways given by some of theirs, in which joints are beyond their limits: the first of them, and how
    /// many others there are. `what` is what they are called.
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
