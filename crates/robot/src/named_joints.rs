//! Conversion of values given by joint name to values of the robot's positions. A value of a mimic joint moves the joint that it mimics
//! (its leader), or must agree with the leader's value.

use std::collections::{HashMap, HashSet};

use clearance_geometry::math::Extremes;

use super::configuration_error::MimicContradiction;
use super::joint::{JointKind, Mimic};
use super::name_length::check_name_length;
use super::{Configuration, ConfigurationError, JointId, RobotModel};

/// Tolerance (rad, m) for a mimic joint's value relative to its leader's; allows for rounding in files and messages.
pub const MIMIC_TOLERANCE: f64 = 1e-6;

/// Joint names of one robot, resolved once for any number of rows of values.
#[derive(Clone, Debug)]
pub struct NamedJoints<'r> {
    robot: &'r RobotModel,
    count: usize,
    /// By position: the source of its value.
    sources: Vec<Option<Source>>,
    followers: Vec<Follower>,
}

/// Source of a position's value.
#[derive(Clone, Copy, Debug)]
enum Source {
    /// The value with this index.
    Value(usize),
    /// The named mimic joint with this index.
    Follower(usize),
}

/// A named mimic joint.
#[derive(Clone, Copy, Debug)]
struct Follower {
    joint: JointId,
    mimic: Mimic,
    /// The index of its value.
    value: usize,
    /// The position of its leader; none if the leader is fixed, at 0.
    position: Option<usize>,
}

/// The value of a leader, and the value of its mimic joint that follows from it.
#[derive(Clone, Copy, Debug)]
struct LeaderValue {
    of_leader: f64,
    expected: f64,
}

impl RobotModel {
    /// Resolves joint names.
    ///
    /// # Errors
    /// If a name is unknown, fixed or given twice.
    pub fn named_joints<'n>(
        &self,
        names: impl IntoIterator<Item = &'n str>,
    ) -> Result<NamedJoints<'_>, ConfigurationError> {
        let index: HashMap<&str, usize> =
            (self.position_names().iter()).enumerate().map(|(i, n)| (n.as_str(), i)).collect();
        let mut named = NamedJoints {
            robot: self,
            count: 0,
            sources: vec![None; self.position_names().len()],
            followers: Vec::new(),
        };
        let mut seen = HashSet::new();
        for (value, name) in names.into_iter().enumerate() {
            if !seen.insert(name) {
                return Err(ConfigurationError::Duplicate { joint: name.to_owned() });
            }
            match index.get(name) {
                Some(&position) => named.sources[position] = Some(Source::Value(value)),
                None => named.followers.push(self.follower(name, value)?),
            }
            named.count = value + 1;
        }
        named.find_leaders();
        Ok(named)
    }

    /// The mimic joint with a name that is not a free position.
    fn follower(&self, name: &str, value: usize) -> Result<Follower, ConfigurationError> {
        check_name_length(name).map_err(ConfigurationError::LongName)?;
        let joint = self.joint_by_name(name).ok_or_else(|| ConfigurationError::UnknownJoint {
            hint: format!("; it has {}", self.position_names().join(", ")),
            joint: name.to_owned(),
        })?;
        let (kind, mimic) = (&self.joint(joint).kind, self.joint(joint).mimic);
        if let Some(mimic) = mimic {
            return Ok(Follower { joint, mimic, value, position: self.first_position(mimic.joint) });
        }
        let joint = name.to_owned();
        if *kind == JointKind::Fixed {
            return Err(ConfigurationError::Fixed { joint });
        }
        let names = kind.position_suffixes().iter().map(|s| format!("'{joint}{s}'"));
        let hint = format!(", but it has {}", names.collect::<Vec<_>>().join(", "));
        Err(ConfigurationError::UnknownJoint { hint, joint })
    }
}

impl NamedJoints<'_> {
    /// Leaders that are not named are moved by their named mimic joints. Of several, the one with the largest multiplier determines the
    /// leader most accurately; the others must agree.
    fn find_leaders(&mut self) {
        for (i, follower) in self.followers.iter().enumerate() {
            let Some(position) = follower.position else { continue };
            let source = &mut self.sources[position];
            let better = match *source {
                Some(Source::Value(_)) => false,
                Some(Source::Follower(other)) => {
                    follower.mimic.multiplier.abs() > self.followers[other].mimic.multiplier.abs()
                }
                None => follower.mimic.multiplier != 0.0,
            };
            if better {
                *source = Some(Source::Follower(i));
            }
        }
    }

    /// True if the names determine this position.
    #[must_use]
    pub fn decides(&self, position: usize) -> bool {
        self.sources[position].is_some()
    }

    /// The configuration with these positions (rad, m), one for each name; other joints keep their positions of `rest`.
    ///
    /// # Errors
    /// If a mimic joint disagrees with its leader, and as for [`RobotModel::configuration`].
    pub fn configuration(
        &self,
        rest: &Configuration,
        values: &[f64],
    ) -> Result<Configuration, ConfigurationError> {
        self.check_count(values)?;
        for follower in &self.followers {
            let value = values[follower.value];
            if !value.is_finite() {
                return Err(ConfigurationError::NotFinite { joint: self.name(follower), value });
            }
        }
        let mut positions = rest.positions().to_vec();
        for (position, source) in positions.iter_mut().zip(&self.sources) {
            match *source {
                None => {}
                Some(Source::Value(i)) => *position = values[i],
                Some(Source::Follower(i)) => {
                    let Follower { mimic, value, .. } = self.followers[i];
                    *position = (values[value] - mimic.offset) / mimic.multiplier;
                }
            }
        }
        let q = self.robot.configuration(&positions)?;
        for follower in &self.followers {
            let of_leader = follower.position.map_or(0.0, |position| q.positions()[position]);
            let expected = follower.mimic.multiplier * of_leader + follower.mimic.offset;
            self.check_agreement("position", follower, values, LeaderValue { of_leader, expected }, 1.0)?;
        }
        Ok(q)
    }

    /// Velocities or accelerations of the positions that the names determine, where `what` is `velocity` or `acceleration`. `scale` (s,
    /// s²) converts a difference to a distance: for mimic joints this distance may be at most [`MIMIC_TOLERANCE`].
    ///
    /// # Errors
    /// If the value of a mimic joint disagrees with its leader's, or numbers are not finite.
    pub fn rates(
        &self,
        what: &'static str,
        values: &[f64],
        scale: f64,
    ) -> Result<Vec<Option<f64>>, ConfigurationError> {
        self.check_count(values)?;
        let rate = |source: &Option<Source>| match *source {
            None => None,
            Some(Source::Value(i)) => Some(values[i]),
            Some(Source::Follower(i)) => {
                let Follower { mimic, value, .. } = self.followers[i];
                Some(values[value] / mimic.multiplier)
            }
        };
        let rates: Vec<Option<f64>> = self.sources.iter().map(rate).collect();
        for follower in &self.followers {
            let of_leader = follower.position.and_then(|position| rates[position]).unwrap_or(0.0);
            let expected = follower.mimic.multiplier * of_leader;
            self.check_agreement(what, follower, values, LeaderValue { of_leader, expected }, scale)?;
        }
        Ok(rates)
    }

    /// Tolerances (rad, m) of all positions, zero for positions that the names do not determine. A mimic joint's tolerance applies to its
    /// leader. If a position gets several, the largest applies, which includes the others.
    ///
    /// # Errors
    /// If a tolerance is negative or not finite, or belongs to a mimic joint that never moves.
    pub fn tolerances(&self, values: &[f64]) -> Result<Vec<f64>, ConfigurationError> {
        self.check_count(values)?;
        let mut tolerances = vec![0.0; self.sources.len()];
        let check = |joint: String, value: f64| {
            let sound = value.is_finite() && value >= 0.0;
            if sound { Ok(()) } else { Err(ConfigurationError::Tolerance { joint, value }) }
        };
        for (i, source) in self.sources.iter().enumerate() {
            if let Some(Source::Value(value)) = *source {
                check(self.robot.position_names()[i].clone(), values[value])?;
                tolerances[i] = values[value];
            }
        }
        for follower in &self.followers {
            let (value, joint) = (values[follower.value], self.name(follower));
            check(joint.clone(), value)?;
            if value == 0.0 {
                continue;
            }
            let moving = follower.position.filter(|_| follower.mimic.multiplier != 0.0);
            let position = moving.ok_or(ConfigurationError::ToleranceOfStanding { joint, value })?;
            let multiplier = follower.mimic.multiplier.abs();
            let mut of_leader = value / multiplier;
            // rounding must not make it smaller
            if of_leader * multiplier < value {
                of_leader = of_leader.next_up();
            }
            tolerances[position] = tolerances[position].greater(of_leader);
        }
        Ok(tolerances)
    }

    fn check_count(&self, values: &[f64]) -> Result<(), ConfigurationError> {
        let (given, expected) = (values.len(), self.count);
        if given == expected { Ok(()) } else { Err(ConfigurationError::WrongCount { given, expected }) }
    }

    /// Rejects the value of a mimic joint that disagrees with its leader.
    fn check_agreement(
        &self,
        what: &'static str,
        follower: &Follower,
        values: &[f64],
        LeaderValue { of_leader, expected }: LeaderValue,
        scale: f64,
    ) -> Result<(), ConfigurationError> {
        let given = values[follower.value];
        // an overflowed value agrees with nothing
        if (given - expected).abs() * scale <= MIMIC_TOLERANCE {
            return Ok(());
        }
        let from = match follower.position.and_then(|position| self.sources[position]) {
            Some(Source::Follower(i)) => {
                let other = &self.followers[i];
                (other.joint != follower.joint).then(|| (self.name(other), values[other.value]))
            }
            _ => None,
        };
        let leader = self.robot.joint(follower.mimic.joint).name.clone();
        let joint = self.name(follower);
        let contradiction = MimicContradiction { joint, what, given, leader, of_leader, expected, from };
        Err(ConfigurationError::Mimic(Box::new(contradiction)))
    }

    fn name(&self, follower: &Follower) -> String {
        self.robot.joint(follower.joint).name.clone()
    }
}

#[cfg(test)]
mod tests;
