//! Goal of a search: distance limit, distance that is enough, tolerances, and whether ties are collected.

use clearance_geometry::constants::CONTACT_DISTANCE;

use super::effort::Effort;
use super::ties::TieTolerance;

/// Goal of a search.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Goal {
    /// Elements farther apart than this (m) do not matter.
    pub limit: f64,
    /// True if something this near is already known: tolerances then apply to this limit, even before anything is found.
    pub is_reached: bool,
    /// The search ends at a distance of at most this (m).
    pub enough: f64,
    pub effort: Effort,
    /// True if triangles that may be nearest are left among the candidates, to be measured by the caller.
    pub postpones: bool,
    /// Set if pairs of elements that are as near as the nearest are collected in [`Scratch`](super::Scratch), at most so many.
    pub ties: Option<(TieTolerance, usize)>,
}

impl Goal {
    /// Finds the least distance, however large.
    pub const EXACT: Self = Self {
        limit: f64::INFINITY,
        is_reached: false,
        enough: 0.0,
        effort: Effort {
            relative_tolerance: 0.0,
            absolute_tolerance: 0.0,
            exact_within: 0.0,
            exact_cost: 0,
            deadline: None,
        },
        postpones: false,
        ties: None,
    };

    /// Finds anything that touches.
    pub const CONTACT: Self = Self { limit: CONTACT_DISTANCE, enough: CONTACT_DISTANCE, ..Self::EXACT };
}
