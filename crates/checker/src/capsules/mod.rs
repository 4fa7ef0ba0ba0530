//! Capsules around links and attached objects, and bounds on their distances.
//!
//! | content | file |
//! |---|---|
//! | capsule of a link, in double precision | `link_capsule` |
//! | fitting a capsule around shapes | `capsule_fit` |
//! | segments in single precision, for one state or eight | `segment` |
//! | distance bounds of eight pairs of segments, with their rounding | `segment_lanes` |
//! | level 0: pairs of a fixed list that may be near | `capsule_pairs` |
//! | capsules and boxes in the root frame, for robot and obstacles | `root_volume` |

mod capsule_fit;
mod capsule_pairs;
mod link_capsule;
mod root_volume;
mod segment;
mod segment_lanes;

pub use capsule_fit::{capsule_around, corners};
pub use capsule_pairs::CapsulePairs;
pub use link_capsule::{LinkCapsule, capsule_distance_bound};
pub use root_volume::{RootCapsule, RootVolume};
pub use segment::{PlacedSegment, Segment, gather, round_up};
