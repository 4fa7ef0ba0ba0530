//! Level 0: one capsule around each link, and which of a fixed list of pairs may be near.
//!
//! A capsule is all points within a radius of a segment. Eight pairs are judged at once: one pair in eight states, or
//! eight pairs in one state, by the same formulas and to the same bits ([`super::capsule_lanes`]).

use std::ops::Add;

use nalgebra::Vector3;

use super::capsule_lanes::{Constants, LEAST_SQUARE, Lanes, PARALLEL, SLACK, difference};
use crate::constants::MOTION_SLACK;
use crate::math::{Extremes, MatrixPose, Point};
use crate::robot::{Columns, Frame, Reach};
use crate::simd::prelude::*;
use crate::simd::{Real, Simd, f32x8, f64x4};

/// All points within `radius` of the segment from `a` to `b`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkCapsule {
    pub a: Point,
    pub b: Point,
    pub radius: f64,
}

/// Capsules that ride on bodies, and the pairs of them to judge.
#[derive(Clone, Debug)]
pub struct CapsulePairs {
    riders: Vec<Rider>,
    /// Pairs, eight by eight; the last group is filled up with its last pair.
    groups: Vec<Group>,
    /// H of the bound, of pairs that have one.
    size: f32,
}

/// A capsule's segment in the frame of its body: `centre ± half`.
#[derive(Clone, Copy, Debug)]
struct Rider {
    body: usize,
    centre: [f64; 3],
    half: [f64; 3],
}

/// Eight pairs and what never changes about them.
#[derive(Clone, Copy, Debug, Default)]
struct Group {
    /// A bit for each lane that holds a pair.
    used: u8,
    first: [usize; 8],
    second: [usize; 8],
    /// Sum of radii, rounded up.
    radii: [f32; 8],
    /// Sum of radii and half lengths, rounded up.
    reach: [f32; 8],
    uu: [f32; 8],
    vv: [f32; 8],
    over_uu: [f32; 8],
    over_vv: [f32; 8],
    /// Least determinant of the nearest-point equations.
    least: [f32; 8],
}

/// A segment `centre ± half`, in single precision.
#[derive(Clone, Copy, Debug)]
pub struct Segment<V> {
    pub centre: [V; 3],
    pub half: [V; 3],
}

impl LinkCapsule {
    /// The capsule as seen from outside a frame that it is in.
    #[cfg(test)]
    #[must_use]
    pub fn seen_through(&self, frame: &Frame<f64>) -> Self {
        let seen = |p: Point| Point::from(frame.point(p.coords.into()));
        Self { a: seen(self.a), b: seen(self.b), radius: self.radius }
    }
}

impl CapsulePairs {
    /// `capsules` with their bodies, in the frames of these; `pairs` by index of capsule.
    ///
    /// # Panics
    /// When a pair names no capsule.
    #[must_use]
    pub fn new(capsules: &[(usize, LinkCapsule)], pairs: &[(usize, usize)]) -> Self {
        let riders: Vec<Rider> = capsules.iter().map(|(body, c)| Rider::new(*body, c)).collect();
        let mut size = 0.0_f32;
        let mut groups = Vec::new();
        for chunk in pairs.chunks(8) {
            let mut group = Group { used: 0xff >> (8 - chunk.len()), ..Group::default() };
            for lane in 0..8 {
                let (a, b) = *chunk.get(lane).unwrap_or(&chunk[chunk.len() - 1]);
                group.set(
                    lane,
                    (a, &riders[a]),
                    (b, &riders[b]),
                    capsules[a].1.radius + capsules[b].1.radius,
                );
                // what is infinitely large is never proven apart, whatever rounding is granted
                if group.reach[lane].is_finite() {
                    size = size.greater(group.reach[lane]);
                }
            }
            groups.push(group);
        }
        Self { riders, groups, size }
    }

    #[must_use]
    pub fn capsule_count(&self) -> usize {
        self.riders.len()
    }

    #[cfg(test)]
    fn pair_count(&self) -> usize {
        self.groups.iter().map(|g| g.used.count_ones() as usize).sum()
    }

    /// How many groups of eight the pairs make.
    #[must_use]
    pub fn group_count(&self) -> usize {
        self.groups.len()
    }

    /// The segments of all capsules, relative to the first one's body: one state's or eight's.
    #[inline(always)]
    pub fn place<T: Real>(&self, frames: &[Frame<T>], segments: &mut [Segment<T::Single>]) {
        let Some(first) = self.riders.first() else { return };
        let origin = frames[first.body].t;
        for (rider, segment) in self.riders.iter().zip(segments) {
            let frame = &frames[rider.body];
            let centre = sum(difference(frame.t, origin), frame.turn(rider.centre));
            *segment = Segment { centre: single(centre), half: single(frame.turn(rider.half)) };
        }
    }

    /// As [`Self::place`] for one state, to the same bits, with a vector for each column of a frame.
    #[inline(always)]
    pub fn place_one<S: Simd>(&self, simd: S, frames: &[Frame<f64>], segments: &mut [Segment<f32>]) {
        let Some(first) = self.riders.first() else { return };
        let origin = Columns::of(simd, &frames[first.body]).origin();
        for (rider, segment) in self.riders.iter().zip(segments) {
            let columns = Columns::of(simd, &frames[rider.body]);
            let centre = columns.origin() - origin + columns.turn(rider.centre);
            *segment = Segment { centre: singles(centre), half: singles(columns.turn(rider.half)) };
        }
    }

    /// What segments are relative to (m), in single precision.
    #[inline(always)]
    #[must_use]
    pub fn origin<T: Real>(&self, frames: &[Frame<T>]) -> [T::Single; 3] {
        let first = self.riders.first().map_or(0, |first| first.body);
        single(frames[first].t)
    }

    /// For each pair, in which of eight states it may be as near as its margin (m, not negative): a bit per state.
    #[inline(always)]
    pub fn near<S: Simd>(
        &self,
        simd: S,
        segments: &[Segment<f32x8<S>>],
        margin: impl Fn(usize) -> f32,
        masks: &mut [u8],
    ) {
        if self.groups.is_empty() {
            return;
        }
        let slack = self.slack(simd, extent_8(simd, segments));
        for ((group, masks), first) in self.groups.iter().zip(masks.chunks_mut(8)).zip((0..).step_by(8)) {
            // spheres of all pairs before axes of any: where a branch hangs on chance, fewer are better
            let mut left = 0u8;
            for (lane, mask) in masks.iter_mut().enumerate() {
                let lanes =
                    Lanes::of_eight_states(&segments[group.first[lane]], &segments[group.second[lane]]);
                let limit = slack + f32x8::splat(simd, margin(first + lane));
                *mask = lanes.spheres_near(f32x8::splat(simd, group.reach[lane]) + limit);
                left |= u8::from(*mask != 0) << lane;
            }
            while left != 0 {
                let lane = left.trailing_zeros() as usize;
                left &= left - 1;
                let lanes =
                    Lanes::of_eight_states(&segments[group.first[lane]], &segments[group.second[lane]]);
                let radii = f32x8::splat(simd, group.radii[lane])
                    + (slack + f32x8::splat(simd, margin(first + lane)));
                masks[lane] &= lanes.near_along(lanes.w, radii);
                if masks[lane] != 0 {
                    masks[lane] &= lanes.near_along(lanes.direction(&group.constants(simd, lane)), radii);
                }
            }
        }
    }

    /// For each pair, lower bounds (m) of its distance in eight states, less than zero where capsules overlap: by the same
    /// formulas as [`Self::lower_bounds_one`], which is checked against it.
    #[cfg(test)]
    #[inline(always)]
    pub fn lower_bounds<S: Simd>(&self, simd: S, segments: &[Segment<f32x8<S>>], bounds: &mut [[f32; 8]]) {
        let slack = self.slack(simd, extent_8(simd, segments));
        let pairs = self.groups.iter().flat_map(|g| (0..8).map(move |lane| (g, lane)));
        for ((group, lane), bound) in pairs.zip(&mut bounds[..self.pair_count()]) {
            let lanes = Lanes::of_eight_states(&segments[group.first[lane]], &segments[group.second[lane]]);
            let radii = f32x8::splat(simd, group.radii[lane]) + slack;
            *bound = lanes.lower_bound(radii, &group.constants(simd, lane)).into();
        }
    }

    /// As [`Self::near`] for one state: a mask per group of eight pairs, from their margins by number of group.
    #[inline(always)]
    pub fn near_one<S: Simd>(
        &self,
        simd: S,
        segments: &[Segment<f32>],
        margins: impl Fn(usize) -> [f32; 8],
        masks: &mut [u8],
    ) {
        assert_eq!(self.groups.len(), masks.len(), "a mask for every group");
        if self.groups.is_empty() {
            return;
        }
        let slack = self.slack(simd, f32x8::splat(simd, extent(segments)));
        for (i, (group, mask)) in self.groups.iter().zip(masks).enumerate() {
            let limit = slack + f32x8::simd_from(simd, margins(i));
            let lanes = eight_pairs(simd, segments, group);
            let (reach, radii) = (f32x8::simd_from(simd, group.reach), f32x8::simd_from(simd, group.radii));
            *mask = group.used & lanes.spheres_near(reach + limit);
            if *mask != 0 {
                *mask &= lanes.near_along(lanes.direction(&group.all_constants(simd)), radii + limit);
            }
        }
    }

    /// As [`Self::lower_bounds`] for one state: eight bounds per group.
    #[inline(always)]
    pub fn lower_bounds_one<S: Simd>(&self, simd: S, segments: &[Segment<f32>], bounds: &mut [[f32; 8]]) {
        assert_eq!(self.groups.len(), bounds.len(), "bounds for every group");
        let slack = self.slack(simd, f32x8::splat(simd, extent(segments)));
        for (group, bound) in self.groups.iter().zip(bounds) {
            let lanes = eight_pairs(simd, segments, group);
            let radii = f32x8::simd_from(simd, group.radii) + slack;
            *bound = lanes.lower_bound(radii, &group.all_constants(simd)).into();
        }
    }

    #[inline(always)]
    fn slack<S: Simd>(&self, simd: S, extent: f32x8<S>) -> f32x8<S> {
        (extent + f32x8::splat(simd, self.size)) * f32x8::splat(simd, SLACK)
    }
}

/// The largest coordinate of any centre. Without their signs floats are ordered as their bits, which compare faster.
#[inline(always)]
fn extent(segments: &[Segment<f32>]) -> f32 {
    let mut extent = [0; 3];
    for Segment { centre, .. } in segments {
        for (extent, c) in extent.iter_mut().zip(centre) {
            *extent = c.abs().to_bits().max(*extent);
        }
    }
    f32::from_bits(extent[0].max(extent[1]).max(extent[2]))
}

/// As [`extent`], of eight states.
#[inline(always)]
fn extent_8<S: Simd>(simd: S, segments: &[Segment<f32x8<S>>]) -> f32x8<S> {
    let mut extent = [f32x8::splat(simd, 0.0); 3];
    for Segment { centre: [x, y, z], .. } in segments {
        extent = [extent[0].max(x.abs()), extent[1].max(y.abs()), extent[2].max(z.abs())];
    }
    extent[0].max(extent[1]).max(extent[2])
}

/// The nearest f32 that is not below; infinite for what is no number.
pub fn up(x: f64) -> f32 {
    let nearest = x.single();
    if f64::from(nearest) >= x {
        nearest
    } else if x.is_nan() {
        f32::INFINITY
    } else {
        nearest.next_up()
    }
}

impl Rider {
    fn new(body: usize, capsule: &LinkCapsule) -> Self {
        let half = (capsule.b - capsule.a) * 0.5;
        Self { body, centre: (capsule.a + half).coords.into(), half: half.into() }
    }

    fn half_squared(&self) -> f64 {
        Vector3::from(self.half).norm_squared()
    }
}

impl Group {
    fn set(&mut self, lane: usize, (a, first): (usize, &Rider), (b, second): (usize, &Rider), radii: f64) {
        let over = |x: f32| if x > 0.0 { 1.0 / x } else { 0.0 };
        let (uu, vv) = (first.half_squared(), second.half_squared());
        (self.first[lane], self.second[lane]) = (a, b);
        (self.radii[lane], self.reach[lane]) = (up(radii), up(radii + uu.sqrt() + vv.sqrt()));
        (self.uu[lane], self.vv[lane]) = (uu.single(), vv.single());
        (self.over_uu[lane], self.over_vv[lane]) = (over(uu.single()), over(vv.single()));
        self.least[lane] = (uu * vv).single() * PARALLEL + LEAST_SQUARE;
    }

    /// One pair's constants in all lanes.
    #[inline(always)]
    fn constants<S: Simd>(&self, simd: S, lane: usize) -> Constants<S> {
        Constants {
            uu: f32x8::splat(simd, self.uu[lane]),
            vv: f32x8::splat(simd, self.vv[lane]),
            over_uu: f32x8::splat(simd, self.over_uu[lane]),
            over_vv: f32x8::splat(simd, self.over_vv[lane]),
            least: f32x8::splat(simd, self.least[lane]),
        }
    }

    /// Each pair's constants in its lane.
    #[inline(always)]
    fn all_constants<S: Simd>(&self, simd: S) -> Constants<S> {
        Constants {
            uu: f32x8::simd_from(simd, self.uu),
            vv: f32x8::simd_from(simd, self.vv),
            over_uu: f32x8::simd_from(simd, self.over_uu),
            over_vv: f32x8::simd_from(simd, self.over_vv),
            least: f32x8::simd_from(simd, self.least),
        }
    }
}

/// Eight pairs in one state.
#[inline(always)]
fn eight_pairs<S: Simd>(simd: S, segments: &[Segment<f32>], group: &Group) -> Lanes<S> {
    let (a, b) = (group.first.map(|i| &segments[i]), group.second.map(|i| &segments[i]));
    let ((c, u), (d, v)) = (gather(simd, a), gather(simd, b));
    Lanes { w: difference(d, c), u, v }
}

/// The centres and halves of eight segments.
#[inline(always)]
pub(super) fn gather<S: Simd>(simd: S, segments: [&Segment<f32>; 8]) -> ([f32x8<S>; 3], [f32x8<S>; 3]) {
    let (mut centre, mut half) = ([[0.0; 8]; 3], [[0.0; 8]; 3]);
    for (lane, segment) in segments.iter().enumerate() {
        for i in 0..3 {
            centre[i][lane] = segment.centre[i];
            half[i][lane] = segment.half[i];
        }
    }
    (load(simd, &centre), load(simd, &half))
}

#[inline(always)]
fn load<S: Simd>(simd: S, v: &[[f32; 8]; 3]) -> [f32x8<S>; 3] {
    [f32x8::simd_from(simd, v[0]), f32x8::simd_from(simd, v[1]), f32x8::simd_from(simd, v[2])]
}

#[inline(always)]
fn sum<T: Copy + Add<Output = T>>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
fn single<T: Real>(v: [T; 3]) -> [T::Single; 3] {
    [v[0].single(), v[1].single(), v[2].single()]
}

#[inline(always)]
fn singles<S: Simd>(v: f64x4<S>) -> [f32; 3] {
    let [x, y, z, _] = v.narrow(v).split().0.into();
    [x, y, z]
}

impl LinkCapsule {
    /// All that it reaches, seen from outside a frame that it is in.
    #[must_use]
    pub fn reach_at(&self, pose: &MatrixPose) -> Reach {
        let seen = |p: Point| (pose * p).coords;
        let radius = self.radius * (1.0 + MOTION_SLACK) + MOTION_SLACK;
        Reach { ends: [seen(self.a), seen(self.b)], radius }
    }

    /// Distance of a point from the segment.
    pub fn axis_distance(&self, p: &Point) -> f64 {
        let d = self.b - self.a;
        let along = if d.norm_squared() > 0.0 { d.dot(&(p - self.a)) / d.norm_squared() } else { 0.0 };
        (p - (self.a + d * along.clamp(0.0, 1.0))).norm()
    }
}

#[cfg(test)]
pub(super) mod tests;
