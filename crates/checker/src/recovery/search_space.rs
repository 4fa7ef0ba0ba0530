//! Search space of a recovery: the positions that may change, and their ranges.

use std::f64::consts::PI;

use clearance_geometry::math::Extremes;
use clearance_robot::{Configuration, RobotModel};

/// The states that are within the limits of a search.
#[derive(Clone, Debug)]
pub struct SearchSpace<'r> {
    robot: &'r RobotModel,
    start: Vec<f64>,
    /// The positions that change.
    movable: Vec<Range>,
}

/// Range of a position: within the limits of its joint and of all that mimic it, and the start.
#[derive(Clone, Copy, Debug)]
struct Range {
    position: usize,
    low: f64,
    high: f64,
}

impl<'r> SearchSpace<'r> {
    /// The space around a state in which the given positions change.
    pub fn new(robot: &'r RobotModel, start: &Configuration, movable: &[bool]) -> Self {
        let start = start.positions().to_vec();
        let ranges = ranges(robot, &start);
        let movable = (ranges.into_iter().zip(movable)).enumerate().filter(|(_, (_, movable))| **movable);
        let movable = movable.map(|(position, ([low, high], _))| Range { position, low, high }).collect();
        Self { robot, start, movable }
    }

    /// Number of positions that change.
    pub fn dimension(&self) -> usize {
        self.movable.len()
    }

    /// The state at a distance (rad, m) from the start along a direction, or on the limits where it would exceed them.
    pub fn state(&self, direction: &[f64], distance: f64) -> Configuration {
        let mut positions = self.start.clone();
        for (range, change) in self.movable.iter().zip(direction) {
            let moved = self.start[range.position] + distance * change;
            positions[range.position] = moved.clamp(range.low, range.high);
        }
        // a mimic joint may exceed the largest allowed position
        self.robot.configuration(&positions).unwrap_or_else(|_| self.between(0.0, &positions))
    }

    /// A random state anywhere within the limits; a position without limits changes by up to π (rad, m).
    pub fn anywhere(&self, random: &mut fastrand::Rng) -> Configuration {
        let mut positions = self.start.clone();
        for range in &self.movable {
            let start = positions[range.position];
            let low = if range.low.is_finite() { range.low } else { start - PI };
            let high = if range.high.is_finite() { range.high } else { start + PI };
            positions[range.position] = (low + random.f64() * (high - low)).clamp(range.low, range.high);
        }
        self.robot.configuration(&positions).unwrap_or_else(|_| self.between(0.0, &positions))
    }

    /// The state on the line from the start to another state, at t in 0 to 1.
    pub fn between(&self, t: f64, end: &[f64]) -> Configuration {
        let on_line = |(start, end): (&f64, &f64)| if t < 1.0 { start + t * (end - start) } else { *end };
        Configuration::trusted(self.start.iter().zip(end).map(on_line).collect())
    }

    /// Distance (rad, m) of a state from the start.
    pub fn distance(&self, state: &Configuration) -> f64 {
        let squared = self.start.iter().zip(state.positions()).map(|(a, b)| (a - b) * (a - b));
        squared.sum::<f64>().sqrt()
    }
}

/// By position: the limits of its joint and of the joints that mimic it, widened to the start.
pub fn ranges(robot: &RobotModel, start: &[f64]) -> Vec<[f64; 2]> {
    let widened = |([low, high], start): ([f64; 2], &f64)| [low.lesser(*start), high.greater(*start)];
    robot.position_ranges().into_iter().zip(start).map(widened).collect()
}

/// A vector of length one; `None` for zero.
pub fn normalized(mut vector: Vec<f64>) -> Option<Vec<f64>> {
    let length = vector.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
    if length < f64::MIN_POSITIVE.sqrt() {
        return None;
    }
    for entry in &mut vector {
        *entry /= length;
    }
    Some(vector)
}
