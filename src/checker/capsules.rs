//! Level 0: one capsule around each link, and which of a fixed list of pairs may be near.
//!
//! A capsule is all points within a radius of a segment. Eight pairs are judged at once: one pair in eight states, or
//! eight pairs in one state, by the same formulas and to the same bits.
//!
//! # The bound
//!
//! Segments are `c₁ + s·u` and `c₂ + t·v` with s, t in [−1, 1]; let w = c₂ − c₁. For *any* direction n they are at
//! least as far apart as their projections onto n,
//!
//! > D ≥ (n·w − |n·u| − |n·v|) / |n|,
//!
//! with equality when n joins the nearest points. So nearest points are sought carelessly (Ericson, *Real-Time
//! Collision Detection*, 5.1.9, with parallel and degenerate segments not set apart), and n between them still gives a
//! bound. Where it is loose, as for nearly parallel or touching segments, it is loose downward.
//!
//! # Its rounding
//!
//! Let ε = 2⁻²⁴ be the rounding of f32, E the largest coordinate of any centre, H the largest |u| + |v| + radii of any
//! pair. Centres are taken relative to the first capsule's body in f64 and rounded once, so with the subtraction each
//! coordinate of w is off by at most 4εE, and each of u and v by ε of itself. For the n that was computed, whatever it
//! is, and with |w| ≤ 2√3·E:
//!
//! | what | off by at most, in ε·\|n\| |
//! |---|---|
//! | w for its true value | 4√3·E < 7E |
//! | n·w: three roundings | 3\|w\| < 10.4E |
//! | n·u, n·v: three roundings, and u, v themselves | (3 + √3)(\|u\| + \|v\|) < 4.8H |
//! | the two differences | 2(\|w\| + \|u\| + \|v\|) < 7E + 2H |
//! | \|n\| and the quotient, or the squares in its stead | 4D ≤ 4\|w\| < 14E |
//! | sums with radii and margin, up to D | 3(D + H) < 10.4E + 3H |
//!
//! Together less than 49E + 10H; 64ε(E + H) = 2⁻¹⁸(E + H) is taken off every bound: 4 µm at a metre. The sphere test
//! before has fewer terms: 7E for w and 4\|w\| for the squares. A tiny constant added to |n|² keeps the quotient
//! defined where the segments touch, and only lowers a positive bound.

use std::ops::{Add, Sub};

use nalgebra::{Vector2, Vector3};

use crate::math::{Point, RotationMatrix, UnitVector, Vector};
use crate::robot::Frame;
use crate::simd::prelude::*;
use crate::simd::{Real, Simd, f32x8};

/// All points within `radius` of the segment from `a` to `b`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkCapsule {
    pub a: Point,
    pub b: Point,
    pub radius: f64,
}

/// Rounding taken off every bound, relative to coordinates and sizes: 64 roundings of f32.
const SLACK: f32 = 64.0 / 16_777_216.0;

/// Added to |n|², m².
const LEAST_SQUARE: f32 = 1e-30;

/// Segments whose squared sine is less count as parallel: below, f32 tells nothing about where they are nearest.
const PARALLEL: f32 = 1e-6;

/// Capsules that ride on bodies, and the pairs of them to judge.
#[derive(Clone, Debug)]
pub struct CapsulePairs {
    riders: Vec<Rider>,
    /// Pairs, eight by eight; the last group is filled up with its last pair.
    groups: Vec<Group>,
    /// H above.
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

/// Eight pairs of segments.
struct Lanes<S: Simd> {
    w: [f32x8<S>; 3],
    u: [f32x8<S>; 3],
    v: [f32x8<S>; 3],
}

/// Eight pairs' constants, in lanes.
struct Constants<S: Simd> {
    uu: f32x8<S>,
    vv: f32x8<S>,
    over_uu: f32x8<S>,
    over_vv: f32x8<S>,
    least: f32x8<S>,
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
                size = size.max(group.reach[lane]);
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

    /// For each pair, in which of eight states it may be as near as `margin` (m, not negative): a bit per state.
    #[inline(always)]
    pub fn near<S: Simd>(&self, simd: S, segments: &[Segment<f32x8<S>>], margin: f64, masks: &mut [u8]) {
        let limit = self.slack(simd, extent_8(simd, segments)) + f32x8::splat(simd, up(margin));
        for (group, masks) in self.groups.iter().zip(masks.chunks_mut(8)) {
            // spheres of all pairs before axes of any: where a branch hangs on chance, fewer are better
            let mut left = 0u8;
            for (lane, mask) in masks.iter_mut().enumerate() {
                let lanes =
                    Lanes::of_eight_states(&segments[group.first[lane]], &segments[group.second[lane]]);
                *mask = lanes.spheres_near(f32x8::splat(simd, group.reach[lane]) + limit);
                left |= u8::from(*mask != 0) << lane;
            }
            while left != 0 {
                let lane = left.trailing_zeros() as usize;
                left &= left - 1;
                let lanes =
                    Lanes::of_eight_states(&segments[group.first[lane]], &segments[group.second[lane]]);
                let radii = f32x8::splat(simd, group.radii[lane]) + limit;
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

    /// As [`Self::near`] for one state: a mask per group of eight pairs.
    #[inline(always)]
    pub fn near_one<S: Simd>(&self, simd: S, segments: &[Segment<f32>], margin: f64, masks: &mut [u8]) {
        let limit = self.slack(simd, f32x8::splat(simd, extent(segments))) + f32x8::splat(simd, up(margin));
        for (group, mask) in self.groups.iter().zip(masks) {
            let lanes = Lanes::of_eight_pairs(simd, segments, group);
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
        let slack = self.slack(simd, f32x8::splat(simd, extent(segments)));
        for (group, bound) in self.groups.iter().zip(bounds) {
            let lanes = Lanes::of_eight_pairs(simd, segments, group);
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

/// The nearest f32 that is not below.
fn up(x: f64) -> f32 {
    let nearest = x.single();
    if f64::from(nearest) < x { nearest.next_up() } else { nearest }
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

impl<S: Simd> Lanes<S> {
    #[inline(always)]
    fn of_eight_states(a: &Segment<f32x8<S>>, b: &Segment<f32x8<S>>) -> Self {
        Self { w: difference(b.centre, a.centre), u: a.half, v: b.half }
    }

    #[inline(always)]
    fn of_eight_pairs(simd: S, segments: &[Segment<f32>], group: &Group) -> Self {
        let (a, b) = (group.first.map(|i| &segments[i]), group.second.map(|i| &segments[i]));
        let ((c, u), (d, v)) = (gather(simd, a), gather(simd, b));
        Self { w: difference(d, c), u, v }
    }

    /// In which lanes the bounding spheres may be near: `reach` is the sum of their radii, margin and slack.
    #[inline(always)]
    fn spheres_near(&self, reach: f32x8<S>) -> u8 {
        // what compares false for want of a number is near
        low_byte(!dot(self.w, self.w).simd_gt(reach * reach).to_bitmask())
    }

    /// In which lanes the axes may be no farther apart along n than `radii`, with margin and slack.
    #[inline(always)]
    fn near_along(&self, n: [f32x8<S>; 3], radii: f32x8<S>) -> u8 {
        let separation = self.separation(n).max(0.0);
        low_byte(!(separation * separation).simd_gt(radii * radii * square(n)).to_bitmask())
    }

    /// Lower bounds of the distance of the axes, less `radii`.
    #[inline(always)]
    fn lower_bound(&self, radii: f32x8<S>, constants: &Constants<S>) -> f32x8<S> {
        let n = self.direction(constants);
        self.separation(n) / square(n).sqrt() - radii
    }

    /// From about where the first segment is nearest to the second, to there.
    #[inline(always)]
    fn direction(&self, c: &Constants<S>) -> [f32x8<S>; 3] {
        let Self { w, u, v } = *self;
        let (uv, uw, vw) = (dot(u, v), dot(u, w), dot(v, w));
        let s = unit_interval((uw * c.vv - uv * vw) / (c.uu * c.vv - uv * uv).max(c.least));
        let t = unit_interval((uv * s - vw) * c.over_vv);
        let s = unit_interval((uv * t + uw) * c.over_uu);
        [w[0] + v[0] * t - u[0] * s, w[1] + v[1] * t - u[1] * s, w[2] + v[2] * t - u[2] * s]
    }

    /// How far apart the segments are along n, times |n|.
    #[inline(always)]
    fn separation(&self, n: [f32x8<S>; 3]) -> f32x8<S> {
        dot(n, self.w) - dot(n, self.u).abs() - dot(n, self.v).abs()
    }
}

/// The centres and halves of eight segments.
#[inline(always)]
fn gather<S: Simd>(simd: S, segments: [&Segment<f32>; 8]) -> ([f32x8<S>; 3], [f32x8<S>; 3]) {
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
fn difference<T: Copy + Sub<Output = T>>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
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
fn dot<S: Simd>(a: [f32x8<S>; 3], b: [f32x8<S>; 3]) -> f32x8<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// |n|², never zero.
#[inline(always)]
fn square<S: Simd>(n: [f32x8<S>; 3]) -> f32x8<S> {
    dot(n, n) + LEAST_SQUARE
}

#[inline(always)]
fn unit_interval<S: Simd>(x: f32x8<S>) -> f32x8<S> {
    x.max(-1.0).min(1.0)
}

#[expect(clippy::cast_possible_truncation, reason = "the other bits are meant to go")]
fn low_byte(bits: u64) -> u8 {
    bits as u8
}

/// A tight capsule around `points`; `None` if there are none.
///
/// The axis starts as the best of the three principal ones, then turns as long as the volume shrinks. Each axis gets
/// the smallest circle around the points seen along it, and the shortest segment whose caps still reach them all.
/// In the end the radius is that of the farthest point, rounded outward.
#[must_use]
pub fn fit_capsule(points: &[Point]) -> Option<LinkCapsule> {
    let count = u32::try_from(points.len()).ok().filter(|&n| n > 0)?;
    let mean = points.iter().map(|p| p.coords).sum::<Vector>() / f64::from(count);
    let spread: RotationMatrix =
        points.iter().map(|p| (p.coords - mean) * (p.coords - mean).transpose()).sum();
    let axes = spread.symmetric_eigen().eigenvectors;
    let principal =
        (0..3).map(|i| along(points, mean, &UnitVector::new_normalize(axes.column(i).into_owned())));
    let mut best = principal.min_by(Fit::by_volume)?;
    let mut turn = 0.25_f64;
    while turn > 1e-3 {
        let (x, y) = square_to(&best.axis);
        let turned =
            [x, -x, y, -y].map(|aside| UnitVector::new_normalize(best.axis.into_inner() + aside * turn));
        match turned.iter().map(|axis| along(points, mean, axis)).min_by(Fit::by_volume) {
            Some(better) if better.volume() < best.volume() => best = better,
            _ => turn *= 0.5,
        }
    }
    let farthest = points.iter().map(|p| best.capsule.axis_distance(p)).fold(0.0, f64::max);
    // distances round by a few units in the last place of the coordinates
    let rounding = 8.0 * f64::EPSILON * points.iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
    Some(LinkCapsule { radius: farthest + rounding, ..best.capsule })
}

/// A capsule around points, and the direction it was made along.
struct Fit {
    capsule: LinkCapsule,
    axis: UnitVector,
}

impl Fit {
    fn volume(&self) -> f64 {
        let LinkCapsule { a, b, radius } = self.capsule;
        radius * radius * ((b - a).norm() + radius * (4.0 / 3.0))
    }

    fn by_volume(&self, other: &Self) -> std::cmp::Ordering {
        self.volume().total_cmp(&other.volume())
    }
}

/// The smallest capsule around `points` along `axis`.
fn along(points: &[Point], mean: Vector, axis: &UnitVector) -> Fit {
    let (x, y) = square_to(axis);
    let seen = |p: &Point| Vector2::new(x.dot(&(p.coords - mean)), y.dot(&(p.coords - mean)));
    let circle = smallest_circle(&points.iter().map(seen).collect::<Vec<_>>());
    // a cap's centre may lie this far behind a point and still reach it
    let depth =
        |p: &Point| (circle.radius.powi(2) - (seen(p) - circle.centre).norm_squared()).max(0.0).sqrt();
    let height = |p: &Point| axis.dot(&(p.coords - mean));
    let low = points.iter().map(|p| height(p) + depth(p)).fold(f64::INFINITY, f64::min);
    let high = points.iter().map(|p| height(p) - depth(p)).fold(f64::NEG_INFINITY, f64::max);
    // where a single ball reaches all, low lies above high
    let (low, high) = if low < high { (low, high) } else { (low.midpoint(high), low.midpoint(high)) };
    let at = |h: f64| Point::from(mean + x * circle.centre.x + y * circle.centre.y + axis.into_inner() * h);
    Fit { capsule: LinkCapsule { a: at(low), b: at(high), radius: circle.radius }, axis: *axis }
}

/// Two directions square to `axis` and to each other.
fn square_to(axis: &UnitVector) -> (Vector, Vector) {
    let x = axis.cross(&Vector::ith(axis.iamin(), 1.0)).normalize();
    (x, axis.cross(&x))
}

#[derive(Clone, Copy, Debug)]
struct Circle {
    centre: Vector2<f64>,
    radius: f64,
}

/// The smallest circle around points: as long as one lies outside, the farthest joins the two or three that hold the
/// circle. Each circle is larger than the last, so none comes twice.
fn smallest_circle(points: &[Vector2<f64>]) -> Circle {
    let mut held = vec![points[0]];
    let mut circle = Circle { centre: points[0], radius: 0.0 };
    // a handful of rounds in practice; the bound is for rounding that makes circles come again
    for _ in 0..100 {
        let distance = |p: &Vector2<f64>| (p - circle.centre).norm_squared();
        let farthest = points.iter().max_by(|a, b| distance(a).total_cmp(&distance(b)));
        let Some(outside) = farthest.filter(|p| distance(p) > circle.radius.powi(2) * (1.0 + 1e-12)) else {
            break;
        };
        held.push(*outside);
        (circle, held) = smallest_circle_of_few(&held);
    }
    circle
}

/// The smallest circle around at most four points, and those that hold it.
fn smallest_circle_of_few(points: &[Vector2<f64>]) -> (Circle, Vec<Vector2<f64>>) {
    let mut best = (Circle { centre: points[0], radius: f64::INFINITY }, points.to_vec());
    let mut consider = |circle: Circle, held: &[Vector2<f64>]| {
        let all = points.iter().all(|p| (p - circle.centre).norm() <= circle.radius * (1.0 + 1e-12));
        if all && circle.radius < best.0.radius {
            best = (circle, held.to_vec());
        }
    };
    for (i, a) in points.iter().enumerate() {
        for (j, b) in points.iter().enumerate().skip(i + 1) {
            consider(Circle { centre: (a + b) * 0.5, radius: (a - b).norm() * 0.5 }, &[*a, *b]);
            for c in &points[j + 1..] {
                if let Some(circle) = circle_through(a, b, c) {
                    consider(circle, &[*a, *b, *c]);
                }
            }
        }
    }
    best
}

/// The circle through three points; `None` when they lie on a line.
fn circle_through(a: &Vector2<f64>, b: &Vector2<f64>, c: &Vector2<f64>) -> Option<Circle> {
    let (b, c) = (b - a, c - a);
    let double_area = 2.0 * b.perp(&c);
    let (bb, cc) = (b.norm_squared(), c.norm_squared());
    let centre = Vector2::new(c.y * bb - b.y * cc, b.x * cc - c.x * bb) / double_area;
    let radius = centre.norm();
    radius.is_finite().then_some(Circle { centre: a + centre, radius })
}

impl LinkCapsule {
    /// Distance of a point from the segment.
    fn axis_distance(&self, p: &Point) -> f64 {
        let d = self.b - self.a;
        let along = if d.norm_squared() > 0.0 { d.dot(&(p - self.a)) / d.norm_squared() } else { 0.0 };
        (p - (self.a + d * along.clamp(0.0, 1.0))).norm()
    }
}

#[cfg(test)]
#[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)]
mod tests {
    use super::*;
    use crate::simd::{Level, dispatch, f64x8};
    use crate::testing::{Random, levels};

    /// Distance of two segments in f64: interior against interior if that is where it is least, else an end.
    fn true_distance(c: &LinkCapsule, d: &LinkCapsule) -> f64 {
        let ends =
            [d.axis_distance(&c.a), d.axis_distance(&c.b), c.axis_distance(&d.a), c.axis_distance(&d.b)];
        let least = ends.into_iter().fold(f64::INFINITY, f64::min);
        let (u, v, w) = (c.b - c.a, d.b - d.a, d.a - c.a);
        let (uu, vv, uv, uw, vw) = (u.dot(&u), v.dot(&v), u.dot(&v), u.dot(&w), v.dot(&w));
        let determinant = uu * vv - uv * uv;
        let (s, t) = ((uw * vv - uv * vw) / determinant, (uv * uw - uu * vw) / determinant);
        let inside = |x: f64| (0.0..=1.0).contains(&x);
        let axes = if inside(s) && inside(t) { least.min((w + v * t - u * s).norm()) } else { least };
        axes - c.radius - d.radius
    }

    /// Two capsules that may be parallel, degenerate, crossing, touching or far away.
    fn random_pair(random: &mut Random) -> (LinkCapsule, LinkCapsule) {
        let size = |random: &mut Random| [0.0, 1e-6, 0.05, 0.3, 1.0][random.below(5)];
        let spread = [0.0, 1e-3, 0.3, 1.0, 30.0][random.below(5)];
        let (middle_c, middle_d) = (random.vector(spread), random.vector(spread));
        let u = random.vector(1.0) * size(random);
        let v = match random.below(5) {
            0 => u * random.within(2.0),
            1 => u * random.within(2.0) + random.vector(1e-4) * u.norm(),
            2 => u * random.within(2.0) + random.vector(1e-7) * u.norm(),
            _ => random.vector(1.0) * size(random),
        };
        let middle_d = match random.below(6) {
            0 => middle_c + u * random.within(1.0) + v * random.within(1.0),
            1 => middle_c + u * random.within(3.0),
            2 => middle_c + u.cross(&v) * random.within(2.0),
            _ => middle_d,
        };
        let capsule = |random: &mut Random, middle: Vector, half: Vector| LinkCapsule {
            a: Point::from(middle - half),
            b: Point::from(middle + half),
            radius: [0.0, 0.05, 0.1][random.below(3)],
        };
        (capsule(random, middle_c, u), capsule(random, middle_d, v))
    }

    /// What all ways to ask say about one state: bounds, nearness to `margin`.
    struct Answers {
        bounds: Vec<f32>,
        near: Vec<bool>,
    }

    #[inline(always)]
    fn ask_eight<S: Simd>(
        simd: S,
        pairs: &CapsulePairs,
        frames: &[Vec<Frame<f64>>],
        margin: f64,
    ) -> Vec<Answers> {
        let lanes = |of: &dyn Fn(usize) -> f64| f64x8::from_fn(simd, of);
        let frames: Vec<Frame<f64x8<S>>> = (0..frames[0].len())
            .map(|body| Frame {
                r: std::array::from_fn(|c| std::array::from_fn(|i| lanes(&|k| frames[k][body].r[c][i]))),
                t: std::array::from_fn(|i| lanes(&|k| frames[k][body].t[i])),
            })
            .collect();
        let zero = [f32x8::splat(simd, 0.0); 3];
        let mut segments = vec![Segment { centre: zero, half: zero }; pairs.capsule_count()];
        let (mut masks, mut bounds) = (vec![0; pairs.pair_count()], vec![[0.0; 8]; pairs.pair_count()]);
        pairs.place(&frames, &mut segments);
        pairs.near(simd, &segments, margin, &mut masks);
        pairs.lower_bounds(simd, &segments, &mut bounds);
        (0..8)
            .map(|k| Answers {
                bounds: bounds.iter().map(|b| b[k]).collect(),
                near: masks.iter().map(|m| m >> k & 1 == 1).collect(),
            })
            .collect()
    }

    #[inline(always)]
    fn ask_one<S: Simd>(simd: S, pairs: &CapsulePairs, frames: &[Frame<f64>], margin: f64) -> Answers {
        let mut segments = vec![Segment { centre: [0.0; 3], half: [0.0; 3] }; pairs.capsule_count()];
        let (mut masks, mut bounds) = (vec![0; pairs.group_count()], vec![[0.0; 8]; pairs.group_count()]);
        pairs.place(frames, &mut segments);
        pairs.near_one(simd, &segments, margin, &mut masks);
        pairs.lower_bounds_one(simd, &segments, &mut bounds);
        let count = pairs.pair_count();
        assert!((count..8 * masks.len()).all(|i| masks[i / 8] >> (i % 8) & 1 == 0));
        Answers {
            bounds: bounds.into_flattened()[..count].to_vec(),
            near: (0..count).map(|i| masks[i / 8] >> (i % 8) & 1 == 1).collect(),
        }
    }

    /// Asks all levels, in eight states and one by one, and that they agree.
    fn ask(pairs: &CapsulePairs, frames: &[Vec<Frame<f64>>], margin: f64, levels: &[Level]) -> Vec<Answers> {
        let bits = |answers: &Answers| answers.bounds.iter().map(|b| b.to_bits()).collect::<Vec<_>>();
        let mut all =
            levels.iter().map(|&level| dispatch!(level, simd => ask_eight(simd, pairs, frames, margin)));
        let first = all.next().unwrap();
        for (level, other) in levels[1..].iter().zip(all) {
            for (a, b) in first.iter().zip(&other) {
                assert!(bits(a) == bits(b) && a.near == b.near, "{level:?}");
            }
        }
        for &level in levels {
            for (state, a) in frames.iter().zip(&first) {
                let b = dispatch!(level, simd => ask_one(simd, pairs, state, margin));
                assert!(bits(a) == bits(&b) && a.near == b.near, "{level:?}");
            }
        }
        first
    }

    /// Random capsules on two bodies in random states: capsules 2i and 2i + 1 make a pair.
    fn check(random: &mut Random, far: f64, levels: &[Level]) -> f64 {
        let count = 1 + random.below(20);
        let capsules: Vec<LinkCapsule> =
            (0..count).map(|_| random_pair(random)).flat_map(|(c, d)| [c, d]).collect();
        let riders: Vec<_> = capsules.iter().enumerate().map(|(i, &c)| (i % 2, c)).collect();
        let list: Vec<_> = (0..count).map(|i| (2 * i, 2 * i + 1)).collect();
        let pairs = CapsulePairs::new(&riders, &list);
        let still = random.below(2) == 0;
        let frames: Vec<Vec<_>> = (0..8)
            .map(|_| {
                let pose = random.pose(far);
                let other = if still { pose } else { pose * random.pose(1.0) };
                vec![Frame::from(&pose), Frame::from(&other)]
            })
            .collect();
        let margin = [0.0, 0.01, 0.2][random.below(3)];
        let mut loosest = 0.0_f64;
        for (state, answers) in frames.iter().zip(ask(&pairs, &frames, margin, levels)) {
            let seen: Vec<_> = riders.iter().map(|(body, c)| c.seen_through(&state[*body])).collect();
            let extent = seen
                .iter()
                .map(|c| (c.a - seen[0].a).amax().max((c.b - seen[0].a).amax()))
                .fold(1.0, f64::max);
            for (i, pair) in seen.chunks_exact(2).enumerate() {
                let distance = true_distance(&pair[0], &pair[1]);
                let bound = f64::from(answers.bounds[i]);
                // far from the origin the poses themselves round
                assert!(bound <= distance + 1e-15 * far, "{bound} > {distance}: {pair:?}");
                assert!(answers.near[i] || distance > margin, "{distance} is near: {pair:?}");
                // a mask says no more than the bound does
                assert!(!answers.near[i] || bound <= margin + 1e-5 * extent, "{bound} is not near: {pair:?}");
                if distance + pair[0].radius + pair[1].radius > 0.05 {
                    loosest = loosest.max((distance - bound) / extent);
                }
            }
        }
        loosest
    }

    #[test]
    fn bounds_never_exceed_the_distance_and_are_tight() {
        let (mut random, levels) = (Random::new(20), [Level::new()]);
        let mut loosest: Vec<f64> = (0..20_000).map(|_| check(&mut random, 1.0, &levels)).collect();
        loosest.sort_by(f64::total_cmp);
        let at = |part: f64| loosest[((loosest.len() - 1) as f64 * part) as usize];
        println!("loosest of a robot: median {:e}, 99 % {:e}, worst {:e}", at(0.5), at(0.99), at(1.0));
        assert!(at(0.5) < 1e-5 && at(1.0) < 1e-3);
    }

    #[test]
    fn levels_and_ways_agree_to_the_bit() {
        let mut random = Random::new(21);
        for _ in 0..1000 {
            check(&mut random, 1.0, &levels());
        }
    }

    #[test]
    fn robots_far_from_the_origin_lose_nothing() {
        let mut random = Random::new(22);
        for _ in 0..1000 {
            assert!(check(&mut random, 1e6, &[Level::new()]) < 1e-3);
        }
    }

    #[test]
    fn no_number_is_near() {
        let capsule = LinkCapsule { a: Point::origin(), b: Point::new(1.0, 0.0, 0.0), radius: 0.1 };
        let pairs = CapsulePairs::new(&[(0, capsule), (1, capsule)], &[(0, 1)]);
        for t in [f64::NAN, f64::INFINITY, 1e30] {
            let frames = vec![vec![Frame::IDENTITY, Frame { t: [t, 9.0, 9.0], ..Frame::IDENTITY }]; 8];
            for level in levels() {
                let eight = dispatch!(level, simd => ask_eight(simd, &pairs, &frames, 0.0));
                let one = dispatch!(level, simd => ask_one(simd, &pairs, &frames[0], 0.0));
                if t.is_nan() {
                    assert!(eight[0].near[0] && one.near[0], "{level:?}");
                }
                for bound in [eight[0].bounds[0], one.bounds[0]] {
                    assert!(bound.is_nan() || t.is_nan() || f64::from(bound) <= t, "{level:?}: {bound}");
                }
            }
        }
    }

    #[test]
    fn fitted_capsules_hold_their_points() {
        let mut random = Random::new(23);
        for _ in 0..2000 {
            let (flatten, centre, turn) = (random.vector(1.0), random.vector(5.0), random.rotation());
            let flatten = flatten.map(|c| if c.abs() < 0.2 { 0.0 } else { c });
            let points: Vec<Point> = (0..=random.below(60))
                .map(|_| Point::from(centre + turn * random.vector(1.0).component_mul(&flatten)))
                .collect();
            let capsule = fit_capsule(&points).unwrap();
            assert!(points.iter().all(|p| capsule.axis_distance(p) <= capsule.radius), "{points:?}");
        }
        assert_eq!(fit_capsule(&[]), None);
    }

    #[test]
    fn fitted_capsules_are_tight() {
        let mut random = Random::new(24);
        for _ in 0..100 {
            let (direction, centre) = (random.direction(), random.vector(1.0));
            let (half, radius) = (0.1 + random.within(0.5).abs(), 0.05 + random.within(0.1).abs());
            let points: Vec<Point> = (0..3000)
                .map(|_| {
                    let along = random.within(half);
                    let out = UnitVector::new_normalize(random.vector(1.0));
                    let end = if out.dot(&direction) > 0.0 { half } else { -half };
                    let at = if random.below(3) == 0 { end } else { along };
                    let out = if at == end { out.into_inner() } else { direction.cross(&out).normalize() };
                    Point::from(centre + direction.into_inner() * at + out * radius)
                })
                .collect();
            let capsule = fit_capsule(&points).unwrap();
            let volume = |length: f64, radius: f64| radius * radius * (length + radius * (4.0 / 3.0));
            let (fitted, made) =
                (volume((capsule.b - capsule.a).norm(), capsule.radius), volume(2.0 * half, radius));
            assert!(fitted < 1.03 * made, "{fitted} {made}");
        }
    }
}
