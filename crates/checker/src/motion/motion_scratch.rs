//! Scratch memory of motion checks.

use clearance_proximity::Scratch;

use super::free_search::FreeSearchScratch;
use super::level_zero::LevelZeroScratch;
use crate::pairs::{ObstacleScratch, PlacedRobot};
use crate::robot::PairPriority;

/// Scratch memory that only motion checks use.
#[derive(Clone, Debug, Default)]
pub struct MotionScratch {
    pub level_zero: LevelZeroScratch,
    pub free_search: FreeSearchScratch,
    pub positions: Vec<f64>,
    /// Intervals that are to be evaluated next, the last one first.
    pub stack: Vec<PairInterval>,
}

/// An interval of t in which a pair is to be evaluated.
#[derive(Clone, Copy, Debug)]
pub struct PairInterval {
    pub pair: usize,
    pub from: f64,
    pub to: f64,
}

/// Memory of a thread that a motion check uses.
pub struct MotionWorkspace<'w> {
    pub robot: &'w mut PlacedRobot,
    pub priority: &'w mut PairPriority,
    pub obstacles: &'w mut ObstacleScratch,
    pub scratch: &'w mut Scratch,
    pub motion: &'w mut MotionScratch,
}
