//! Motion segment: positions as polynomials of t in [0, 1], with tolerances, moving obstacles and their uncertainty.

use clearance_geometry::constants::LARGEST_COORDINATE;
use clearance_geometry::math::{Extremes, Rotation, UnitVector, Vector};
use clearance_robot::{Configuration, Deviation, JointKind, RobotModel};
use clearance_scene::World;
use serde::{Deserialize, Serialize};

use super::obstacle_uncertainty::{ObstacleUncertainty, UncertaintyText};
use super::{MovingObstacle, SegmentError};

/// Coefficients of a polynomial of degree five, the constant first.
pub type Polynomial = [f64; 6];

/// Motion of all positions of a robot while t goes from 0 to 1. Each position is a polynomial of degree at most five, but floating joints
/// rotate at constant speed, by the shortest path.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionSegment {
    positions: Vec<Polynomial>,
    /// Given positions at t = 1; empty for polynomials, whose ends are computed sums.
    goal: Vec<f64>,
    /// Index of the first component of each quaternion.
    quaternions: Vec<usize>,
    turns: Vec<Turn>,
    obstacles: Vec<MovingObstacle>,
    /// Tolerance (rad, m) of each position along the motion; empty if it is followed exactly.
    tube: Vec<f64>,
    /// Growth of each position's deviation (rad, m, per unit of t²); empty if there is none.
    spread: Vec<f64>,
    /// Unknown motion of obstacles, if they may move.
    uncertainty: Option<ObstacleUncertainty>,
    is_straight: bool,
    /// Upper bound (rad, m) on all positions, and on the values they are computed from.
    size: f64,
}

/// The rotation of a floating joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Turn {
    /// Index of the first component of its quaternion.
    pub first: usize,
    pub from: Rotation,
    /// Rotation axis, in the frame of the joint.
    pub axis: UnitVector,
    pub angle: f64,
}

/// File format of a segment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SegmentText {
    /// Positions at t = 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<Vec<f64>>,
    /// Positions at t = 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to: Option<Vec<f64>>,
    /// Alternatively, a polynomial for each position, the constant first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub polynomials: Option<Vec<[f64; 6]>>,
    /// Motion of obstacles, by name; others keep their poses.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub obstacles: Vec<MovingObstacle>,
    /// Tolerance (rad, m) of each position; empty without tolerances.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tube: Vec<f64>,
    /// Unknown motion of obstacles; none if they stand, or move exactly as in `obstacles`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub obstacle_uncertainty: Option<UncertaintyText>,
}

impl MotionSegment {
    /// The straight line in joint space from one configuration of `robot` to another.
    #[must_use]
    pub fn straight(robot: &RobotModel, from: &Configuration, to: &Configuration) -> Self {
        let (from, to) = (from.positions(), to.positions());
        let segment = Self::new(robot, line(from, to));
        let turns = Turn::all(&segment.quaternions, from, to);
        Self { goal: to.to_vec(), turns, ..segment }
    }

    fn new(robot: &RobotModel, positions: Vec<Polynomial>) -> Self {
        let is_straight = positions.iter().all(|p| p[2..].iter().all(|c| *c == 0.0));
        let most = |p: &Polynomial| p.iter().map(|c| c.abs()).sum::<f64>();
        let following = robot.mimicking_joints().filter_map(|(_, mimic)| {
            let p = &positions[robot.first_position(mimic.joint)?];
            Some(mimic.multiplier.abs() * most(p) + mimic.offset.abs())
        });
        let size = positions.iter().map(most).chain(following).fold(0.0, f64::greater);
        let quaternions = floating(robot).map(|(_, first)| first + 3).collect();
        let (goal, turns, obstacles) = (Vec::new(), Vec::new(), Vec::new());
        let (tube, spread, uncertainty) = (Vec::new(), Vec::new(), None);
        Self { positions, goal, quaternions, turns, obstacles, tube, spread, uncertainty, is_straight, size }
    }

    /// A polynomial for each of the robot's positions.
    pub fn polynomial(robot: &RobotModel, mut positions: Vec<[f64; 6]>) -> Result<Self, SegmentError> {
        let expected = robot.position_names().len();
        if positions.len() != expected {
            return Err(SegmentError::WrongLength { given: positions.len(), expected });
        }
        for (name, numbers) in robot.position_names().iter().zip(&positions) {
            let most: f64 = numbers.iter().map(|c| c.abs()).sum();
            if !most.is_finite() {
                return Err(SegmentError::NotFinite(name.clone()));
            }
            if most > LARGEST_COORDINATE {
                return Err(SegmentError::TooLarge { joint: name.clone(), size: most });
            }
        }
        for (name, first) in floating(robot) {
            let stands = |p: &Polynomial| p[1..].iter().all(|c| *c == 0.0);
            if !positions[first..first + 7].iter().all(stands) {
                return Err(SegmentError::FloatingPolynomial(name.to_owned()));
            }
        }
        // this normalises quaternions
        let start: Vec<f64> = positions.iter().map(|p| p[0]).collect();
        let start = robot.configuration(&start)?;
        positions.iter_mut().zip(start.positions()).for_each(|(p, q)| p[0] = *q);
        let segment = Self::new(robot, positions);
        if segment.size > LARGEST_COORDINATE {
            return Err(SegmentError::TooFar(segment.size));
        }
        Ok(segment)
    }

    /// Adds moving obstacles of `world`, with the same t.
    pub fn with_obstacles(self, world: &World, obstacles: Vec<MovingObstacle>) -> Result<Self, SegmentError> {
        for (i, mover) in obstacles.iter().enumerate() {
            if world.id(&mover.name).is_none() {
                return Err(SegmentError::UnknownObstacle(mover.name.clone()));
            }
            if obstacles[..i].iter().any(|other| other.name == mover.name) {
                return Err(SegmentError::ObstacleTwice(mover.name.clone()));
            }
        }
        self.with_movers(obstacles)
    }

    /// As [`Self::with_obstacles`], without a check that these obstacles exist.
    pub fn with_movers(mut self, obstacles: Vec<MovingObstacle>) -> Result<Self, SegmentError> {
        if let Some(bad) = obstacles.iter().find(|o| !o.is_sound()) {
            return Err(SegmentError::Obstacle(bad.name.clone()));
        }
        let largest = obstacles.iter().map(MovingObstacle::size);
        self.size = largest.fold(self.size, f64::greater);
        self.obstacles = obstacles;
        Ok(self)
    }

    /// Adds the moving obstacles of another segment, and what is not known about them unless limits are given.
    #[must_use]
    pub fn with_obstacles_of(self, other: &Self) -> Self {
        let size = other.obstacles.iter().map(MovingObstacle::size).fold(self.size, f64::greater);
        let uncertainty = self.uncertainty.clone().or_else(|| other.uncertainty.clone());
        Self { size, obstacles: other.obstacles.clone(), uncertainty, ..self }
    }

    /// Obstacles may move as their limits allow, in addition to the motion of [`Self::obstacles`].
    #[must_use]
    pub fn with_uncertainty(self, uncertainty: ObstacleUncertainty) -> Self {
        Self { uncertainty: Some(uncertainty).filter(|uncertainty| !uncertainty.is_zero()), ..self }
    }

    /// Adds a tolerance (rad, m) for each of the robot's positions: the robot may be anywhere within it.
    pub fn with_tube(mut self, robot: &RobotModel, tube: Vec<f64>) -> Result<Self, SegmentError> {
        let expected = robot.position_names().len();
        if tube.len() != expected {
            return Err(SegmentError::WrongLength { given: tube.len(), expected });
        }
        for (joint, &value) in robot.position_names().iter().zip(&tube) {
            if !(value.is_finite() && value >= 0.0) {
                return Err(SegmentError::Tube { joint: joint.clone(), value });
            }
        }
        for (joint, first) in floating(robot) {
            if tube[first..first + 7].iter().any(|t| *t != 0.0) {
                return Err(SegmentError::FloatingTube(joint.to_owned()));
            }
        }
        self.tube = if tube.iter().all(|t| *t == 0.0) { Vec::new() } else { tube };
        Ok(self)
    }

    /// Adds accelerations (rad, m, per unit of t²) by which each of the positions may deviate from the motion.
    #[must_use]
    pub fn with_spread(self, spread: Vec<f64>) -> Self {
        Self { spread, ..self }
    }

    /// The part of the motion between two values of t, as a segment of its own.
    #[must_use]
    pub(super) fn part(&self, [from, to]: [f64; 2]) -> Self {
        if [from, to] == [0.0, 1.0] {
            return self.clone();
        }
        let obstacles = self.obstacles.iter().map(|mover| mover.part([from, to])).collect();
        let uncertainty = self.uncertainty.as_ref().map(|uncertainty| uncertainty.part([from, to]));
        if !self.goal.is_empty() {
            // both parts at a cut compute its positions by the same operations, so that they join exactly
            return Self {
                obstacles,
                uncertainty,
                ..self.between(self.at(from).positions(), self.at(to).positions())
            };
        }
        let part = |p: &Polynomial| {
            let (mut c, mut scale) = (taylor(p, from), 1.0);
            for c in &mut c {
                *c *= scale;
                scale *= to - from;
            }
            c
        };
        Self { positions: self.positions.iter().map(part).collect(), obstacles, uncertainty, ..self.clone() }
    }

    /// A straight motion of the same robot, with the same tolerances and obstacles, between two configurations no farther from zero than
    /// this segment's [`Self::size`].
    pub(super) fn between(&self, from: &[f64], to: &[f64]) -> Self {
        Self {
            positions: line(from, to),
            goal: to.to_vec(),
            turns: Turn::all(&self.quaternions, from, to),
            is_straight: true,
            ..self.clone()
        }
    }

    /// Adds the tolerances and obstacles of a gap at the start of this segment, next to a segment of this [`Self::size`].
    pub(super) fn into_gap(self, tube: Vec<f64>, obstacles: Vec<MovingObstacle>, beside: f64) -> Self {
        let tube = if tube.iter().all(|t| *t == 0.0) { Vec::new() } else { tube };
        let size = obstacles.iter().map(MovingObstacle::size).fold(self.size.greater(beside), f64::greater);
        let uncertainty = self.uncertainty.as_ref().map(|uncertainty| uncertainty.part([0.0, 0.0]));
        Self { tube, spread: Vec::new(), obstacles, uncertainty, size, ..self }
    }

    /// The same robot at rest at the start of this segment, without tolerances and moving obstacles.
    #[must_use]
    pub fn standing_at_start(&self) -> Self {
        let start: Vec<f64> = self.starts().collect();
        let uncertainty = self.uncertainty.as_ref().map(|uncertainty| uncertainty.part([0.0, 0.0]));
        Self { obstacles: Vec::new(), uncertainty, ..self.nominal().between(&start, &start) }
    }

    /// The same without tolerances and unknown motion of obstacles.
    #[must_use]
    pub fn nominal(&self) -> Self {
        Self { tube: Vec::new(), spread: Vec::new(), uncertainty: None, ..self.clone() }
    }

    /// True if the robot's possible deviation grows with t.
    #[must_use]
    pub fn widens(&self) -> bool {
        !self.spread.is_empty()
    }

    /// True if the robot or an obstacle may deviate from the motion.
    #[must_use]
    pub fn is_loose(&self) -> bool {
        !self.tube.is_empty() || !self.spread.is_empty() || self.uncertainty.is_some()
    }

    /// Limits of the unknown motion of obstacles; `None` if they stand, or move exactly as [`Self::obstacles`].
    #[must_use]
    pub fn uncertainty(&self) -> Option<&ObstacleUncertainty> {
        self.uncertainty.as_ref()
    }

    /// Upper bound (rad, m) on all positions, and on the values they are computed from.
    #[must_use]
    pub fn size(&self) -> f64 {
        self.size
    }

    /// Number of positions of a configuration.
    #[must_use]
    pub fn position_count(&self) -> usize {
        self.positions.len()
    }

    /// The obstacles that move in this segment.
    #[must_use]
    pub fn obstacles(&self) -> &[MovingObstacle] {
        &self.obstacles
    }

    /// Tolerance (rad, m) of each position; empty without tolerances.
    #[must_use]
    pub fn tube(&self) -> &[f64] {
        &self.tube
    }

    /// Index of the first component of each floating joint's quaternion.
    pub(super) fn quaternions(&self) -> &[usize] {
        &self.quaternions
    }

    /// The positions at t = 0, which are always exact.
    pub(super) fn starts(&self) -> impl Iterator<Item = f64> + '_ {
        self.positions.iter().map(|p| p[0])
    }

    /// A position at t = 1, with its rounding error; the error is zero where the end was given as a number.
    pub(super) fn end(&self, position: usize) -> [f64; 2] {
        if let Some(goal) = self.goal.get(position) {
            return [*goal, 0.0];
        }
        let p = &self.positions[position];
        if p[1..].iter().all(|c| *c == 0.0) {
            return [p[0], 0.0];
        }
        // a sum of six terms and the products of Horner's scheme: ten roundings
        let size: f64 = p.iter().map(|c| c.abs()).sum();
        [value(p, 1.0), 10.0 * f64::EPSILON * size]
    }

    /// Highest power of t in any position; 1 for a straight line, also without motion.
    #[must_use]
    pub fn degree(&self) -> usize {
        let of = |p: &Polynomial| p.iter().rposition(|c| *c != 0.0).unwrap_or(0);
        if self.goal.is_empty() { self.positions.iter().map(of).max().unwrap_or(0) } else { 1 }
    }

    /// True if every position changes at constant speed.
    #[must_use]
    pub fn is_straight(&self) -> bool {
        self.is_straight
    }

    /// The rotation of a floating joint whose positions begin at `first`: axis in the joint's frame, and angle (rad per unit of t).
    #[must_use]
    pub fn turn_of(&self, first: usize) -> Option<(UnitVector, f64)> {
        let turn = self.turns.iter().find(|turn| turn.first == first + 3)?;
        Some((turn.axis, turn.angle))
    }

    /// The maximum speed (per unit of t) of a position.
    #[must_use]
    pub fn top_speed(&self, position: usize) -> f64 {
        let p = &self.positions[position];
        if self.is_straight { p[1].abs() } else { largest_slope(p) }
    }

    /// The maximum absolute value of a position, tolerance included.
    #[must_use]
    pub fn range(&self, position: usize) -> f64 {
        let Deviation { most, tolerance, .. } = self.deviation(position, 0.5, 0.5);
        value(&self.positions[position], 0.5).abs() + most + tolerance
    }

    /// Writes the positions at t.
    ///
    /// # Panics
    /// If the length of `positions` differs from the robot's number of positions.
    pub fn positions_at(&self, t: f64, positions: &mut [f64]) {
        if t == 1.0 && !self.goal.is_empty() {
            positions.copy_from_slice(&self.goal);
            return;
        }
        for (position, p) in positions.iter_mut().zip(&self.positions) {
            *position = if self.is_straight { p[0] + t * p[1] } else { value(p, t) };
        }
        for turn in &self.turns {
            let at = (Rotation::from_axis_angle(&turn.axis, turn.angle * t) * turn.from).coords;
            positions[turn.first..turn.first + 4].copy_from_slice(at.as_slice());
        }
    }

    /// Where it begins and where it ends.
    #[must_use]
    pub fn ends(&self) -> [Configuration; 2] {
        [self.at(0.0), self.at(1.0)]
    }

    /// The configuration at t.
    #[must_use]
    pub fn at(&self, t: f64) -> Configuration {
        let mut positions = vec![0.0; self.positions.len()];
        self.positions_at(t, &mut positions);
        Configuration::trusted(positions)
    }

    /// Bound on the deviation of a position from its value at `middle` within `half_width` of it; not for quaternions.
    #[must_use]
    #[inline]
    pub fn deviation(&self, position: usize, middle: f64, half_width: f64) -> Deviation {
        let p = &self.positions[position];
        let latest = middle + half_width;
        let tolerance = self.tube.get(position).copied().unwrap_or(0.0)
            + self.spread.get(position).map_or(0.0, |a| 0.5 * a * latest * latest);
        if self.is_straight {
            return Deviation { velocity: p[1], most: half_width * p[1].abs(), curvature: 0.0, tolerance };
        }
        let c = taylor(p, middle);
        let curvature = (2..6).rev().fold(0.0, |sum, j| (sum + c[j].abs()) * half_width) * half_width;
        Deviation { velocity: c[1], most: half_width * c[1].abs() + curvature, curvature, tolerance }
    }

    /// As it stands in a file.
    #[must_use]
    pub fn text(&self) -> SegmentText {
        let by_ends = !self.goal.is_empty() || self.positions.is_empty();
        SegmentText {
            from: by_ends.then(|| self.starts().collect()),
            to: by_ends.then(|| self.goal.clone()),
            polynomials: (!by_ends).then(|| self.positions.clone()),
            obstacles: self.obstacles.clone(),
            tube: self.tube.clone(),
            obstacle_uncertainty: self.uncertainty.as_ref().map(ObstacleUncertainty::text),
        }
    }
}

/// Taylor coefficients at t, by repeated synthetic division.
#[inline]
fn taylor(p: &Polynomial, t: f64) -> Polynomial {
    let mut c = *p;
    for i in 0..6 {
        for j in (i..5).rev() {
            c[j] += t * c[j + 1];
        }
    }
    c
}

fn line(from: &[f64], to: &[f64]) -> Vec<Polynomial> {
    from.iter().zip(to).map(|(a, b)| [*a, b - a, 0.0, 0.0, 0.0, 0.0]).collect()
}

fn value(p: &Polynomial, t: f64) -> f64 {
    p.iter().rev().fold(0.0, |sum, c| sum * t + c)
}

/// C(i, k) / C(4, k): the contribution of each coefficient of a polynomial of degree four to its Bernstein coefficients.
const SHARES: [[f64; 5]; 5] = [
    [1.0, 0.0, 0.0, 0.0, 0.0],
    [1.0, 1.0 / 4.0, 0.0, 0.0, 0.0],
    [1.0, 2.0 / 4.0, 1.0 / 6.0, 0.0, 0.0],
    [1.0, 3.0 / 4.0, 3.0 / 6.0, 1.0 / 4.0, 0.0],
    [1.0, 1.0, 1.0, 1.0, 1.0],
];

/// Upper bound on the slope between 0 and 1: the derivative lies within the hull of its Bernstein coefficients.
fn largest_slope(p: &Polynomial) -> f64 {
    let derivative = [p[1], 2.0 * p[2], 3.0 * p[3], 4.0 * p[4], 5.0 * p[5]];
    let coefficient =
        |shares: &[f64; 5]| shares.iter().zip(&derivative).map(|(s, d)| s * d).sum::<f64>().abs();
    let size: f64 = derivative.iter().map(|d| d.abs()).sum();
    SHARES.iter().map(coefficient).fold(0.0, f64::greater) + 1e-14 * size
}

/// Names of floating joints and where their positions begin.
pub fn floating(robot: &RobotModel) -> impl Iterator<Item = (&str, usize)> {
    robot.joint_ids().filter_map(|id| {
        let joint = robot.joint(id);
        (joint.kind == JointKind::Floating).then_some(())?;
        Some((joint.name.as_str(), robot.first_position(id)?))
    })
}

impl Turn {
    fn all(quaternions: &[usize], from: &[f64], to: &[f64]) -> Vec<Self> {
        quaternions.iter().map(|first| Self::between(*first, from, to)).collect()
    }

    fn between(first: usize, from: &[f64], to: &[f64]) -> Self {
        let rotation = |q: &[f64]| {
            Rotation::from_quaternion(nalgebra::Quaternion::new(
                q[first + 3],
                q[first],
                q[first + 1],
                q[first + 2],
            ))
        };
        let (from, to) = (rotation(from), rotation(to));
        let turn = to * from.inverse();
        let axis = turn.axis().unwrap_or(Vector::z_axis());
        Self { first, from, axis, angle: turn.angle() }
    }
}

#[cfg(test)]
mod tests;
