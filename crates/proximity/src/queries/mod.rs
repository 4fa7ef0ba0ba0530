//! Queries on two posed bodies, one file each.

mod collide;
mod distance;
mod distance_candidates;
mod signed_distance;
mod within_margin;

pub use collide::collide;
pub use distance::{DistanceBounds, distance, distance_bounds, distance_bounds_below};
pub use distance_candidates::{DistanceCandidate, distance_candidates};
pub use signed_distance::{deepest_overlap, signed_distance};
pub use within_margin::{margin_bounds, pieces_within_margin, within_margin};
