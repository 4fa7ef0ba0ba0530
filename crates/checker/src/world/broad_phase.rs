//! Data types of the broad phase: queries, near pieces of obstacles, and scratch memory.

use clearance_geometry::simd::{LANES, Simd, f32x8};
use clearance_proximity::Piece;

use super::world_index::WorldPair;
use crate::capsules::{RootCapsule, round_up};

/// Scratch memory of the broad phase.
#[derive(Clone, Debug, Default)]
pub struct BroadPhaseScratch {
    pub(super) stack: Vec<u32>,
    pub(super) found: Vec<u32>,
    /// As `stack` and `found`, for eight capsules at once; each entry has a bit mask.
    pub(super) eight_stack: Vec<(u32, u8)>,
    pub(super) eight_found: Vec<(u32, u8)>,
    /// Pieces of obstacles that may be near, grouped by obstacle.
    pub near: Vec<NearPiece>,
    /// As `near`, for eight capsules.
    pub near_eight: Vec<NearEight>,
    /// Pieces of one obstacle.
    pub pieces: Vec<Piece>,
    /// Pairs of which the robot body is inside the obstacle.
    pub inside: Vec<WorldPair>,
}

/// Search for the obstacles near one part in one state.
#[derive(Clone, Copy, Debug)]
pub struct PartQuery<'q> {
    pub part: usize,
    /// The part's capsule with its padding, in the root frame.
    pub capsule: &'q RootCapsule,
    /// Largest padded distance (m), rounded up.
    pub limit: f32,
}

impl<'q> PartQuery<'q> {
    /// Obstacles within `limit` (m) of a part's padded capsule.
    #[inline]
    pub fn new(part: usize, capsule: &'q RootCapsule, limit: f64) -> Self {
        Self { part, capsule, limit: round_up(limit) }
    }
}

/// Search for the obstacles near eight capsules: of eight parts in one state, or of one part in eight states.
#[derive(Debug)]
pub struct EightQuery<'q, S: Simd, C: Fn(clearance_scene::ObstacleId, u8) -> u8> {
    /// The capsules with their paddings, in the root frame.
    pub capsules: &'q RootCapsule<f32x8<S>>,
    /// Bit mask of the capsules that are searched for.
    pub among: u8,
    /// True if all their states are expected; false if none is known to be.
    pub are_expected: bool,
    /// Largest padded distance (m).
    pub limit: f32,
    /// Reduces a bit mask to the capsules that are to be checked against an obstacle.
    pub checks: C,
}

/// Search for the obstacles near one part in any of eight states.
#[derive(Clone, Copy, Debug)]
pub struct EightStatesQuery<'q> {
    pub part: usize,
    /// The part's capsules with its padding, in the root frame.
    pub capsules: &'q [RootCapsule; LANES],
    /// Largest padded distance (m), rounded up.
    pub limit: f32,
}

/// A piece of an obstacle that may be near a part.
#[derive(Clone, Copy, Debug)]
pub struct NearPiece {
    pub place: u32,
    pub piece: Piece,
    /// Lower bound (m) on its padded distance.
    pub lower: f32,
}

/// A piece of an obstacle that may be near some of eight capsules.
#[derive(Clone, Copy, Debug)]
pub struct NearEight {
    pub place: u32,
    pub piece: Piece,
    /// Bit mask of these capsules.
    pub lanes: u8,
}

impl BroadPhaseScratch {
    /// Bit mask of the capsules that anything may be near.
    pub fn lanes_near(&self) -> u8 {
        self.near_eight.iter().fold(0, |lanes, near| lanes | near.lanes)
    }
}

impl NearEight {
    pub(super) const NONE: Self = Self { place: 0, piece: Piece::Whole, lanes: 0 };
}
