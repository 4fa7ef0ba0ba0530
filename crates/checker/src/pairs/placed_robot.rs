//! Poses of the robot in one state, and the results of level 0 for its self pairs.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::Extremes;
use clearance_geometry::simd::{LANES, Level, Simd, dispatch};
use clearance_robot::{Frame, PlacedFrame};

use super::checked_pairs::CheckedPairs;
use crate::capsules::{PlacedSegment, round_up};
use crate::robot::PlacedSegments;

/// Scratch memory for one state. Each method overwrites what the one before it computed.
#[derive(Clone, Debug)]
pub struct PlacedRobot {
    /// Poses of the chain's bodies in the root frame.
    frames: Vec<PlacedFrame>,
    /// Segments of the capsules around bodies.
    segments: Vec<PlacedSegment>,
    /// For each group of eight self pairs, a bit mask of the pairs that may be near.
    near: Vec<u8>,
    /// For each group of eight self pairs, lower bounds (m) on their distances.
    bounds: Vec<[f32; LANES]>,
}

impl PlacedRobot {
    pub fn new(pairs: &CheckedPairs) -> Self {
        let capsules = pairs.self_pairs().capsules();
        let groups = capsules.group_count();
        Self {
            frames: vec![PlacedFrame::IDENTITY; pairs.robot().chain().body_count()],
            segments: vec![PlacedSegment::default(); capsules.capsule_count()],
            near: vec![0; groups],
            bounds: vec![[0.0; LANES]; groups],
        }
    }

    /// Poses of the chain's bodies in the root frame.
    #[inline]
    pub fn frames(&self) -> &[PlacedFrame] {
        &self.frames
    }

    /// For callers that place some of the bodies themselves.
    #[inline]
    pub fn frames_mut(&mut self) -> &mut [PlacedFrame] {
        &mut self.frames
    }

    /// Pose of a chain body in the root frame.
    #[inline]
    pub fn frame(&self, body: usize) -> Frame<f64> {
        self.frames[body].frame()
    }

    /// Segments of all parts.
    #[inline]
    pub fn segments(&self, pairs: &CheckedPairs) -> PlacedSegments<'_> {
        PlacedSegments {
            segments: &self.segments,
            origin: pairs.self_pairs().capsules().origin(|body| self.frame(body)),
        }
    }

    /// For each group of eight self pairs, a bit mask of the pairs that capsules do not prove apart.
    #[inline]
    pub fn near(&self) -> &[u8] {
        &self.near
    }

    /// Lower bound (m) on the padded distance of a self pair.
    #[inline]
    pub fn lower_bound(&self, index: usize, padding: f64) -> f64 {
        (f64::from(self.bounds[index / LANES][index % LANES]) - padding).greater(0.0)
    }

    /// Places all bodies.
    pub fn place(&mut self, pairs: &CheckedPairs, positions: &[f64], level: Level) {
        let frames = &mut self.frames;
        dispatch!(level, simd => pairs.robot().chain().frames_of_one(simd, positions, frames, |_, _| {}));
    }

    /// Places all bodies, and computes the self pairs whose capsules do not prove them farther apart than their margins
    /// (m).
    #[inline(always)]
    pub fn screen<S: Simd>(
        &mut self,
        simd: S,
        pairs: &CheckedPairs,
        positions: &[f64],
        margins: impl Fn(usize) -> [f32; LANES],
    ) {
        let Self { frames, segments, near, .. } = self;
        let capsules = pairs.self_pairs().capsules();
        let mut placing = capsules.placing(simd, segments);
        pairs.robot().chain().frames_of_one(
            simd,
            positions,
            frames,
            #[inline(always)]
            |body, columns| placing.place(simd, body, columns),
        );
        capsules.near_one(simd, segments, margins, near);
    }

    /// As [`Self::screen`], for contact with paddings.
    #[inline(always)]
    pub fn screen_for_contact<S: Simd>(&mut self, simd: S, pairs: &CheckedPairs, positions: &[f64]) {
        let margin = [round_up(pairs.self_pairs().largest_padding() + CONTACT_DISTANCE); LANES];
        self.screen(
            simd,
            pairs,
            positions,
            #[inline(always)]
            |_| margin,
        );
    }

    /// Bounds the distances of all self pairs by their capsules; all bodies must be placed.
    pub fn bound(&mut self, pairs: &CheckedPairs, level: Level) {
        let capsules = pairs.self_pairs().capsules();
        let Self { frames, segments, bounds, .. } = self;
        dispatch!(level, simd => {
            capsules.place_one(simd, frames, segments);
            capsules.lower_bounds_one(simd, segments, bounds);
        });
    }
}
