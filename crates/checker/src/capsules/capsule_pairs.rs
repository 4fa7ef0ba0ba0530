//! Level 0 of a query: one capsule around each link; finds the pairs of a fixed list that may be near.
//!
//! A capsule is the set of all points within a radius of a segment. Eight pairs are tested at once: one pair in eight
//! states, or eight pairs in one state, by the same formulas and with bit-identical results ([`super::segment_lanes`]).

use std::ops::{Add, Range};

use clearance_geometry::math::Extremes;
use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{self, LANES, Real, Simd, f32x4, f32x8, f64x4};
use clearance_robot::{Columns, Frame, PlacedFrame};
use nalgebra::Vector3;

use super::link_capsule::LinkCapsule;
use super::segment::{PlacedSegment, Segment, centres, difference, halves, round_up};
use super::segment_lanes::{Constants, LEAST_SQUARE, Lanes, PARALLEL, SLACK, spheres_near};

/// Capsules attached to bodies, and the pairs of them to test.
#[derive(Clone, Debug)]
pub struct CapsulePairs {
    /// All capsules, sorted by body.
    body_segments: Vec<BodySegment>,
    /// By body: the indices of its capsules.
    on_bodies: Vec<Range<usize>>,
    /// The first body that has a capsule.
    first_body: usize,
    /// Pairs in groups of eight; the last group is filled up with its last pair.
    groups: Vec<Group>,
    /// H of the bound, over the pairs of finite size.
    size: f32,
    /// C of the bound.
    offset: f32,
}

/// A capsule's segment `centre ± half` in the frame of its body.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
struct BodySegment {
    capsule: usize,
    /// The coordinates of the centre, four times each, then those of the half.
    coordinates: [[f32; LANES]; 3],
}

/// Eight pairs and their constants.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(32))]
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

/// Places the capsules of one state, body by body.
#[derive(Debug)]
pub struct Placing<'c, S: Simd> {
    capsules: &'c CapsulePairs,
    /// Origin of the first body that has a capsule.
    origin: f64x4<S>,
    segments: &'c mut [PlacedSegment],
}

impl CapsulePairs {
    /// `capsules` with the indices of their bodies, in the frames of these bodies; `pairs` by index of capsule.
    ///
    /// # Panics
    /// When a pair names no capsule.
    #[must_use]
    pub fn new(capsules: &[(usize, LinkCapsule)], pairs: &[(usize, usize)]) -> Self {
        let halves: Vec<Vector3<f64>> = capsules.iter().map(|(_, c)| (c.b - c.a) * 0.5).collect();
        let mut size = 0.0_f32;
        let mut groups = Vec::new();
        for chunk in pairs.chunks(8) {
            let mut group = Group { used: 0xff >> (8 - chunk.len()), ..Group::default() };
            for lane in 0..8 {
                let (a, b) = *chunk.get(lane).unwrap_or(&chunk[chunk.len() - 1]);
                group.set(
                    lane,
                    [(a, halves[a].norm_squared()), (b, halves[b].norm_squared())],
                    capsules[a].1.radius + capsules[b].1.radius,
                );
                // an infinitely large pair is never proven apart, whatever the rounding slack
                if group.reach[lane].is_finite() {
                    size = size.greater(group.reach[lane]);
                }
            }
            groups.push(group);
        }
        let mut order: Vec<usize> = (0..capsules.len()).collect();
        order.sort_by_key(|&i| capsules[i].0);
        let body = |rank: usize| capsules[order[rank]].0;
        let bodies = if order.is_empty() { 0 } else { body(order.len() - 1) + 1 };
        let first_on = |body: usize| order.partition_point(|&i| capsules[i].0 < body);
        let centre = |c: &LinkCapsule| c.a.coords + (c.b - c.a) * 0.5;
        let offset = capsules.iter().map(|(_, c)| centre(c).norm()).filter(|offset| offset.is_finite());
        Self {
            body_segments: order
                .iter()
                .map(|&i| BodySegment::new(i, &centre(&capsules[i].1), &halves[i]))
                .collect(),
            on_bodies: (0..bodies).map(|body| first_on(body)..first_on(body + 1)).collect(),
            first_body: if order.is_empty() { 0 } else { body(0) },
            groups,
            size,
            offset: round_up(offset.fold(0.0, f64::greater)),
        }
    }

    #[must_use]
    pub fn capsule_count(&self) -> usize {
        self.body_segments.len()
    }

    #[cfg(test)]
    fn pair_count(&self) -> usize {
        self.groups.iter().map(|g| g.used.count_ones() as usize).sum()
    }

    /// Number of groups of eight pairs.
    #[must_use]
    pub fn group_count(&self) -> usize {
        self.groups.len()
    }

    /// The segments of all capsules, relative to the first body that has a capsule: for one state or for eight.
    #[inline(always)]
    pub fn place<T: Real>(&self, frames: &[Frame<T>], segments: &mut [Segment<T::Single>]) {
        let origin = frames[self.first_body].t;
        for (body_segments, Frame { r: [x, y, z], t }) in self.on_bodies.iter().zip(frames) {
            let columns = [single(*x), single(*y), single(*z)];
            let t = single(difference(*t, origin));
            for body_segment in &self.body_segments[body_segments.clone()] {
                let [p, q, r] = body_segment.coordinates;
                segments[body_segment.capsule] = Segment {
                    centre: sum(turned(&columns, [p[0], q[0], r[0]]), t),
                    half: turned(&columns, [p[4], q[4], r[4]]),
                };
            }
        }
    }

    /// As [`Self::place`] for one state, with bit-identical results; each column of a frame is one SIMD vector.
    #[inline(always)]
    pub fn place_one<S: Simd>(&self, simd: S, frames: &[PlacedFrame], segments: &mut [PlacedSegment]) {
        let mut placing = self.placing(simd, segments);
        for (body, frame) in frames.iter().enumerate() {
            placing.place(simd, body, &Columns::of(simd, frame));
        }
    }

    /// As above, for a caller that has the frames of the bodies one after the other.
    #[inline(always)]
    pub fn placing<'c, S: Simd>(&'c self, simd: S, segments: &'c mut [PlacedSegment]) -> Placing<'c, S> {
        Placing { capsules: self, origin: f64x4::splat(simd, 0.0), segments }
    }

    /// Origin (m) that segments are relative to, in single precision.
    #[inline(always)]
    #[must_use]
    pub fn origin<T: Real>(&self, frame: impl Fn(usize) -> Frame<T>) -> [T::Single; 3] {
        single(frame(self.first_body).t)
    }

    /// For each pair, a bit mask of the eight states in which it may be as near as its margin (m, not negative).
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
            // sphere tests of all pairs come before any axis test: the outcome is hard to predict, so fewer branches
            // are faster
            let mut left = 0u8;
            for (lane, mask) in masks.iter_mut().enumerate() {
                let lanes =
                    Lanes::of_eight_states(&segments[group.first[lane]], &segments[group.second[lane]]);
                let limit = slack + f32x8::splat(simd, margin(first + lane));
                *mask = spheres_near(lanes.w, f32x8::splat(simd, group.reach[lane]) + limit);
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

    /// For each pair, lower bounds (m) on its distance in eight states, negative where capsules overlap. Uses the same
    /// formulas as [`Self::lower_bounds_one`]; tests compare the two.
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

    /// As [`Self::near`] for one state: a mask per group of eight pairs; margins are given by number of group.
    #[inline(always)]
    pub fn near_one<S: Simd>(
        &self,
        simd: S,
        segments: &[PlacedSegment],
        margins: impl Fn(usize) -> [f32; 8],
        masks: &mut [u8],
    ) {
        assert_eq!(self.groups.len(), masks.len(), "a mask for every group");
        if self.groups.is_empty() {
            return;
        }
        let slack = self.slack(simd, f32x8::splat(simd, extent(simd, segments)));
        for (i, (group, mask)) in self.groups.iter().zip(masks).enumerate() {
            let limit = slack + f32x8::simd_from(simd, margins(i));
            let w = group.between_centres(simd, segments);
            *mask = group.used & spheres_near(w, f32x8::simd_from(simd, group.reach) + limit);
            if *mask != 0 {
                let lanes = group.lanes(simd, w, segments);
                let radii = f32x8::simd_from(simd, group.radii) + limit;
                *mask &= lanes.near_along(lanes.direction(&group.all_constants(simd)), radii);
            }
        }
    }

    /// As [`Self::lower_bounds`] for one state: eight bounds per group.
    #[inline(always)]
    pub fn lower_bounds_one<S: Simd>(&self, simd: S, segments: &[PlacedSegment], bounds: &mut [[f32; 8]]) {
        assert_eq!(self.groups.len(), bounds.len(), "bounds for every group");
        let slack = self.slack(simd, f32x8::splat(simd, extent(simd, segments)));
        for (group, bound) in self.groups.iter().zip(bounds) {
            let lanes = group.lanes(simd, group.between_centres(simd, segments), segments);
            let radii = f32x8::simd_from(simd, group.radii) + slack;
            *bound = lanes.lower_bound(radii, &group.all_constants(simd)).into();
        }
    }

    #[inline(always)]
    fn slack<S: Simd>(&self, simd: S, extent: f32x8<S>) -> f32x8<S> {
        (extent + f32x8::splat(simd, self.size.greater(self.offset))) * f32x8::splat(simd, SLACK)
    }

    /// C of the bound: the largest distance (m) of a centre from the origin of its body.
    #[must_use]
    pub fn offset(&self) -> f32 {
        self.offset
    }
}

/// The largest coordinate of any centre. NaN is ignored here: a capsule with NaN counts as near whatever the slack.
#[inline(always)]
fn extent<S: Simd>(simd: S, segments: &[PlacedSegment]) -> f32 {
    let mut extent = f32x4::splat(simd, 0.0);
    for segment in segments {
        extent = f32x4::from_slice(simd, segment.centre()).abs().max(extent);
    }
    extent[0].greater(extent[1]).greater(extent[2])
}

/// As [`extent`], for eight states.
#[inline(always)]
fn extent_8<S: Simd>(simd: S, segments: &[Segment<f32x8<S>>]) -> f32x8<S> {
    let mut extent = [f32x8::splat(simd, 0.0); 3];
    for Segment { centre: [x, y, z], .. } in segments {
        extent = [x.abs().max(extent[0]), y.abs().max(extent[1]), z.abs().max(extent[2])];
    }
    extent[0].max(extent[1]).max(extent[2])
}

impl BodySegment {
    fn new(capsule: usize, centre: &Vector3<f64>, half: &Vector3<f64>) -> Self {
        let number = |i: usize, lane: usize| if lane < 4 { centre[i].single() } else { half[i].single() };
        Self { capsule, coordinates: [0, 1, 2].map(|i| std::array::from_fn(|lane| number(i, lane))) }
    }
}

impl Group {
    /// A pair of capsules, with the squares (m²) of their halves.
    fn set(&mut self, lane: usize, [(a, uu), (b, vv)]: [(usize, f64); 2], radii: f64) {
        let over = |x: f32| if x > 0.0 { 1.0 / x } else { 0.0 };
        (self.first[lane], self.second[lane]) = (a, b);
        (self.radii[lane], self.reach[lane]) = (round_up(radii), round_up(radii + uu.sqrt() + vv.sqrt()));
        (self.uu[lane], self.vv[lane]) = (uu.single(), vv.single());
        (self.over_uu[lane], self.over_vv[lane]) = (over(uu.single()), over(vv.single()));
        self.least[lane] = (uu * vv).single() * PARALLEL + LEAST_SQUARE;
    }

    /// Vectors from the centres of the first segments to those of the second segments.
    #[inline(always)]
    fn between_centres<S: Simd>(&self, simd: S, segments: &[PlacedSegment]) -> [f32x8<S>; 3] {
        difference(centres(simd, segments, &self.second), centres(simd, segments, &self.first))
    }

    #[inline(always)]
    fn lanes<S: Simd>(&self, simd: S, w: [f32x8<S>; 3], segments: &[PlacedSegment]) -> Lanes<S> {
        Lanes { w, u: halves(simd, segments, &self.first), v: halves(simd, segments, &self.second) }
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

impl<S: Simd> Placing<'_, S> {
    /// Bodies must be placed in ascending order.
    #[inline(always)]
    pub fn place(&mut self, simd: S, body: usize, columns: &Columns<S>) {
        if body == self.capsules.first_body {
            self.origin = columns.origin();
        }
        let Some(body_segments) = self.capsules.on_bodies.get(body) else { return };
        let [x, y, z, t] = columns.doubled(simd, self.origin);
        for BodySegment { capsule, coordinates: [p, q, r] } in
            &self.capsules.body_segments[body_segments.clone()]
        {
            let placed = x * f32x8::from_slice(simd, p)
                + y * f32x8::from_slice(simd, q)
                + z * f32x8::from_slice(simd, r)
                + t;
            self.segments[*capsule] = PlacedSegment(placed.into());
        }
    }
}

#[inline(always)]
fn sum<T: Copy + Add<Output = T>>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
fn single<T: Real>(v: [T; 3]) -> [T::Single; 3] {
    [v[0].single(), v[1].single(), v[2].single()]
}

/// Transforms a vector from a frame, given by its columns, to the parent frame.
#[inline(always)]
fn turned<V: simd::Single>([x, y, z]: &[[V; 3]; 3], [p, q, r]: [f32; 3]) -> [V; 3] {
    [x[0] * p + y[0] * q + z[0] * r, x[1] * p + y[1] * q + z[1] * r, x[2] * p + y[2] * q + z[2] * r]
}

#[cfg(test)]
pub mod tests;
