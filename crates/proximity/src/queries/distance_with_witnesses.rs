//! Distance query with all witness pairs.

use crate::body::BodyPair;
use crate::narrow_phase::Separation;
use crate::search::{Goal, Scratch, search};
use crate::witnesses::{WitnessOptions, WitnessPairs, collect_witnesses};

/// Number of pairs of elements that are collected as equally near.
const MOST_TIES: usize = 1024;

/// As [`distance`](crate::distance()), with the same result; also lists the witness pairs, in the frame of a. None are listed for bodies
/// that touch, or that are proven farther apart than `limit` (m).
///
/// The points of the first pair belong to the returned distance; for curved primitives they are more exact than the returned ones.
#[must_use]
pub fn distance_with_witnesses(
    bodies: BodyPair,
    limit: f64,
    options: &WitnessOptions,
    found: &mut WitnessPairs,
    scratch: &mut Scratch,
) -> Option<Separation> {
    found.clear();
    let goal = Goal { limit, ties: Some((options.tolerance, MOST_TIES)), ..Goal::EXACT };
    let nearest = search::<false>(bodies, goal, scratch).best?;
    if nearest.distance > 0.0 {
        collect_witnesses(bodies, scratch.ties().finish(nearest.distance), options, found);
        if scratch.ties().is_truncated() {
            found.note_more();
        }
    }
    Some(nearest)
}
