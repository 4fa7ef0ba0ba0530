//! Queries on two posed bodies, one file each.

mod collide;
mod distance;
mod distance_candidates;
mod distance_with_witnesses;
mod elements_within_margin;
mod within_margin;

pub use collide::collide;
pub use distance::{DistanceBounds, distance, distance_bounds, distance_bounds_below};
pub use distance_candidates::{DistanceCandidate, distance_candidates};
pub use distance_with_witnesses::distance_with_witnesses;
pub use elements_within_margin::{elements_found_within_margin, elements_within_margin};
pub use within_margin::{margin_bounds, pieces_within_margin, within_margin};
