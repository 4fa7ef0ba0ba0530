//! Level 0 of eight states in SIMD lanes.

use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{Simd, f32x8, f64x8};
use clearance_robot::Frame;

use crate::capsules::{RootCapsule, Segment};
use crate::pairs::CheckedPairs;

/// Scratch memory of eight states in lanes.
pub struct EightStates<S: Simd> {
    frames: Vec<Frame<f64x8<S>>>,
    segments: Vec<Segment<f32x8<S>>>,
    near: Vec<u8>,
}

impl<S: Simd> EightStates<S> {
    pub fn new(pairs: &CheckedPairs, simd: S) -> Self {
        let zero = f32x8::splat(simd, 0.0);
        let segment = Segment { centre: [zero; 3], half: [zero; 3] };
        Self {
            frames: vec![Frame::splat(simd, &Frame::IDENTITY); pairs.robot().chain().body_count()],
            segments: vec![segment; pairs.self_pairs().capsules().capsule_count()],
            near: vec![0; pairs.self_pairs().count()],
        }
    }

    /// Level 0 on the positions: computes kinematics and the self pairs that capsules do not prove farther apart than
    /// their margins (m).
    #[inline(always)]
    pub fn screen(
        &mut self,
        simd: S,
        pairs: &CheckedPairs,
        positions: impl Fn(usize) -> f64x8<S>,
        margin: impl Fn(usize) -> f32,
    ) {
        let capsules = pairs.self_pairs().capsules();
        pairs.robot().chain().frames(simd, positions, &mut self.frames);
        capsules.place(&self.frames, &mut self.segments);
        capsules.near(simd, &self.segments, margin, &mut self.near);
    }

    /// By self pair: a bit for each state in which it may be near.
    #[inline]
    pub fn near(&self) -> &[u8] {
        &self.near
    }

    /// Removes and returns the bits of a self pair.
    #[inline]
    pub fn take_near(&mut self, pair: usize) -> u8 {
        std::mem::take(&mut self.near[pair])
    }

    /// Origins that the segments of the states are relative to.
    #[inline(always)]
    pub fn origins(&self, pairs: &CheckedPairs) -> [f32x8<S>; 3] {
        pairs.self_pairs().capsules().origin(|body| self.frames[body])
    }

    /// A part's capsule with its padding in each of the states.
    #[inline(always)]
    pub fn padded_capsule(
        &self,
        simd: S,
        pairs: &CheckedPairs,
        part: usize,
        origins: [f32x8<S>; 3],
    ) -> RootCapsule<f32x8<S>> {
        pairs.self_pairs().padded_capsule_in_eight_states(simd, part, self.segments[part], origins)
    }

    /// Pose of a body in one of the states.
    pub fn frame(&self, body: usize, lane: usize) -> Frame<f64> {
        let Frame { r: [x, y, z], t } = &self.frames[body];
        let taken = |v: &[f64x8<S>; 3]| [v[0][lane], v[1][lane], v[2][lane]];
        Frame { r: [taken(x), taken(y), taken(z)], t: taken(t) }
    }
}
