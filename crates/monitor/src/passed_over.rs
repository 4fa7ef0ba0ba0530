//! Joint states that were received and never evaluated: a newer one of the same publisher came before their turn.
//!
//! The robot was in them, wherever the straight line between the evaluated states lies.

use clearance_checker::CollisionChecker;
use clearance_geometry::math::{Extremes, without_whole_turns};

use super::JointStateInput;

/// Rounding (rad, m) of positions on a line.
const ROUNDING: f64 = 1e-12;

/// Largest number of joint states that are kept between two evaluations.
const MOST_STATES: usize = 64;

/// Joint states between the previous evaluated state and the next one, in the order of reception.
#[derive(Debug, Default)]
pub(super) struct PassedOver {
    states: Vec<PartialState>,
    /// Whether one could not be kept or read.
    any_unknown: bool,
}

/// Positions (rad, m) by their index; other joints are not named.
type PartialState = Vec<(usize, f64)>;

impl PassedOver {
    /// Adds a joint state; `index_of` gives the index of the position with a name.
    pub fn add(&mut self, input: &JointStateInput, index_of: impl Fn(&str) -> Option<usize>) {
        let JointStateInput { names, positions, .. } = input;
        let named = names.iter().zip(positions).filter_map(|(name, q)| Some((index_of(name)?, *q)));
        let state: PartialState = named.collect();
        let is_known = names.len() == positions.len() && state.iter().all(|(_, q)| q.is_finite());
        if is_known && self.states.len() < MOST_STATES {
            self.states.push(state);
        } else {
            self.any_unknown = true;
        }
    }

    /// There are none any more: the next motion begins.
    pub fn clear(&mut self) {
        self.states.clear();
        self.any_unknown = false;
    }

    /// Whether all of them lie on the straight line from a configuration to another one, or beside it within the tolerances
    /// (rad, m) of `tube`, which may be empty. `turns`: by position, whether full turns make no difference.
    pub fn are_within(&self, from: &[f64], to: &[f64], tube: &[f64], turns: &[bool]) -> bool {
        !self.any_unknown && self.states.iter().all(|state| is_within(state, [from, to], tube, turns))
    }

    /// Upper bound (m) on the travel of any point on the way through all of them; infinite if one is unknown.
    pub fn travel(&self, checker: &CollisionChecker, from: &[f64], to: &[f64], turns: &[bool]) -> f64 {
        if self.any_unknown {
            return f64::INFINITY;
        }
        let (mut at, mut travel) = (from.to_vec(), 0.0);
        for state in &self.states {
            let before = at.clone();
            for &(index, q) in state {
                at[index] = beside(q, before[index], turns[index]);
            }
            travel += checker.travel(&before, &at);
        }
        travel + checker.travel(&at, to)
    }
}

/// A position, in the turn that is nearest to another one.
fn beside(q: f64, other: f64, turns: bool) -> f64 {
    if turns { other + without_whole_turns(q - other) } else { q }
}

/// Whether one point of the line is within the tolerances in all positions that the state names.
fn is_within(state: &PartialState, [from, to]: [&[f64]; 2], tube: &[f64], turns: &[bool]) -> bool {
    let mut range = [0.0, 1.0];
    for &(index, q) in state {
        let tolerance = tube.get(index).copied().unwrap_or(0.0) + ROUNDING;
        let (start, way) = (from[index], to[index] - from[index]);
        let off = beside(q, start + 0.5 * way, turns[index]) - start;
        if way.abs() <= ROUNDING {
            if off.abs() > tolerance {
                return false;
            }
            continue;
        }
        let [a, b] = [(off - tolerance) / way, (off + tolerance) / way];
        range = [range[0].greater(a.lesser(b)), range[1].lesser(a.greater(b))];
    }
    range[0] <= range[1]
}
