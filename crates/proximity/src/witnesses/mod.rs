//! Witness pairs: the points at which two bodies are nearest, and the normal there. Where they are not unique, the distance has no
//! derivative, only directional ones: the least over all pairs (Danskin's theorem; Clarke 1990, *Optimization and Nonsmooth Analysis*,
//! 2.8).
//!
//! Two elements that are apart have one normal n. Their nearest points are where the faces that they show each other along n, their
//! support sets, lie above one another; the extreme points of that overlap represent all of them.
//!
//! | file | contents |
//! |---|---|
//! | `witness_pairs` | the pairs of two bodies, without repetitions |
//! | `support_set` | face of a convex core in a direction |
//! | `facing_sets` | extreme points of the overlap of two faces |
//! | `refinement` | exact nearest points of curved cores |
//! | `element_witnesses` | all pairs of two elements |

mod element_witnesses;
mod facing_sets;
mod refinement;
mod support_set;
#[cfg(test)]
mod tests;
mod witness_pairs;

pub use witness_pairs::{WitnessOptions, WitnessPair, WitnessPairs};

pub(crate) use element_witnesses::collect_witnesses;
pub(crate) use facing_sets::FacingSets;
pub(crate) use support_set::SupportSet;
