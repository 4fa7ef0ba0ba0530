//! Buffer of joint states and positions from `tf` that newer ones replaced before they were evaluated.
//!
//! The robot was in these states, wherever the straight line between the evaluated states lies.

use std::collections::BTreeMap;

use clearance_checker::CollisionChecker;
use clearance_geometry::math::{Extremes, without_whole_turns};

use super::JointStateInput;

/// Rounding (rad, m) of positions on a line.
const ROUNDING: f64 = 1e-12;

/// Largest number of them that are kept between two evaluations.
const MOST_STATES: usize = 256;

/// Joint states and positions from `tf` between the previous evaluated state and the next one, in the order of reception.
#[derive(Debug, Default)]
pub(super) struct UnevaluatedStates {
    states: Vec<PartialState>,
    /// The last positions from `tf`, until others come or a state is evaluated.
    latest_transforms: Option<PartialState>,
    /// Whether one could not be kept or read.
    any_unknown: bool,
}

/// Positions (rad, m) by their index; the others are those of the states before.
pub(super) type PartialState = Vec<(usize, f64)>;

/// The positions that a joint state gives by name; `index_of` gives the index of the position with a name. `None` if it is not valid.
pub(super) fn named_positions(
    input: &JointStateInput,
    index_of: impl Fn(&str) -> Option<usize>,
) -> Option<PartialState> {
    let JointStateInput { names, positions, .. } = input;
    let named = names.iter().zip(positions).filter_map(|(name, q)| Some((index_of(name)?, *q)));
    let state: PartialState = named.collect();
    (names.len() == positions.len() && state.iter().all(|(_, q)| q.is_finite())).then_some(state)
}

/// Whether all states of the same joint are equal.
pub(super) fn are_equal(states: &[PartialState]) -> bool {
    let index = |state: &PartialState| state.first().map(|(index, _)| *index);
    let last_of: BTreeMap<_, _> = states.iter().map(|state| (index(state), state)).collect();
    states.iter().all(|state| last_of[&index(state)] == state)
}

/// A motion as a straight line with tolerances.
#[derive(Clone, Copy)]
pub(super) struct TolerantLine<'l> {
    pub from: &'l [f64],
    pub to: &'l [f64],
    /// By position: tolerance (rad, m); empty without tolerances.
    pub tube: &'l [f64],
    /// By position: whether full turns make no difference.
    pub turns: &'l [bool],
}

impl UnevaluatedStates {
    /// Adds the positions of a joint state; `None` if it is not valid.
    pub fn add(&mut self, state: Option<PartialState>) {
        self.end_transforms();
        self.push(state);
    }

    /// Adds positions from `tf`, in the order of reception; `None` if they are not known. The last ones are part of the next state
    /// that is evaluated, unless something else comes before.
    pub fn add_transforms(&mut self, states: Option<Vec<PartialState>>) {
        let Some(states) = states else {
            self.any_unknown = true;
            return;
        };
        for state in states {
            self.end_transforms();
            self.latest_transforms = Some(state);
        }
    }

    /// Something comes after the last positions from `tf`.
    pub fn end_transforms(&mut self) {
        if let Some(state) = self.latest_transforms.take() {
            self.push(Some(state));
        }
    }

    fn push(&mut self, state: Option<PartialState>) {
        match state.filter(|_| self.states.len() < MOST_STATES) {
            Some(state) => self.states.push(state),
            None => self.any_unknown = true,
        }
    }

    /// Whether there are none; the last positions from `tf` are part of the next state.
    pub fn is_empty(&self) -> bool {
        self.states.is_empty() && !self.any_unknown
    }

    /// There are none any more: the next motion begins.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// The configurations on the way, each with the positions that came last before it.
    fn configurations(&self, line: TolerantLine) -> impl Iterator<Item = Vec<f64>> {
        self.states.iter().scan(line.from.to_vec(), move |at, state| {
            for &(index, q) in state {
                at[index] = beside(q, at[index], line.turns[index]);
            }
            Some(at.clone())
        })
    }

    /// Whether all of them lie on a line within its tolerances.
    pub fn are_within(&self, line: TolerantLine) -> bool {
        !self.any_unknown && self.configurations(line).all(|q| line.contains(&q))
    }

    /// Upper bound (m) on the travel of any point on the way through all of them; infinite if one is unknown.
    pub fn travel(&self, checker: &CollisionChecker, line: TolerantLine) -> f64 {
        if self.any_unknown {
            return f64::INFINITY;
        }
        let (mut at, mut travel) = (line.from.to_vec(), 0.0);
        for next in self.configurations(line).chain([line.to.to_vec()]) {
            travel += checker.travel(&at, &next);
            at = next;
        }
        travel
    }
}

/// A position, in the turn that is nearest to another one.
fn beside(q: f64, other: f64, turns: bool) -> f64 {
    if turns { other + without_whole_turns(q - other) } else { q }
}

impl TolerantLine<'_> {
    /// Whether one point of the line is near enough in all positions.
    fn contains(&self, q: &[f64]) -> bool {
        let mut range = [0.0, 1.0];
        for (index, q) in q.iter().enumerate() {
            let tolerance = self.tube.get(index).copied().unwrap_or(0.0) + ROUNDING;
            let (start, way) = (self.from[index], self.to[index] - self.from[index]);
            let off = beside(*q, start + 0.5 * way, self.turns[index]) - start;
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
}
