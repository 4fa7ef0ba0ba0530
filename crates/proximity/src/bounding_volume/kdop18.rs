//! Discrete oriented polytopes of 18 faces: intervals along nine fixed directions (Klosowski, Held, Mitchell, Sowizral & Zikan 1998,
//! *Efficient collision detection using bounding volume hierarchies of k-DOPs*; QuickCD).
//!
//! The directions are those of the tree. In a rotated frame a polytope is bounded along any direction by three of its own: the direction is a
//! sum of these with positive weights, the same for all polytopes of a node.

use clearance_geometry::math::{Extremes, RotationMatrix, Vector};
use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{LANES, Simd, Vectors, f32x8};

use super::outline::{Outline, convex_outline};
use super::relative::Relative;
use super::rounding::{lanes, round_up};
use super::volume_trait::BoundingVolume;

const DIRECTIONS: usize = 9;
const DIAGONAL: f32 = std::f32::consts::FRAC_1_SQRT_2;
const ROOT_2: f32 = std::f32::consts::SQRT_2;

/// The axes, then the diagonals of each two of them: their sum and their difference.
const UNIT_DIRECTIONS: [[f32; 3]; DIRECTIONS] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [DIAGONAL, DIAGONAL, 0.0],
    [DIAGONAL, -DIAGONAL, 0.0],
    [DIAGONAL, 0.0, DIAGONAL],
    [DIAGONAL, 0.0, -DIAGONAL],
    [0.0, DIAGONAL, DIAGONAL],
    [0.0, DIAGONAL, -DIAGONAL],
];

/// A polytope of 18 faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kdop18 {
    /// Lower ends (m) of the intervals.
    pub low: [f32; DIRECTIONS],
    /// Upper ends (m).
    pub high: [f32; DIRECTIONS],
}

/// Eight polytopes of one frame.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub struct Kdop18Pack {
    low: [[f32; LANES]; DIRECTIONS],
    high: [[f32; LANES]; DIRECTIONS],
}

/// Eight polytopes of a frame a, transformed to another frame, b.
#[derive(Clone, Copy, Debug)]
pub struct SeenKdop18 {
    /// Along the directions of b.
    along_b: Kdop18Pack,
    /// Along their own directions, from the anchor of b.
    own: Kdop18Pack,
}

/// Eight polytopes of b, and the same along the directions of a.
#[derive(Clone, Copy, Debug)]
pub struct FacingKdop18<S: Simd> {
    own: [[f32x8<S>; 2]; DIRECTIONS],
    along_a: [[f32x8<S>; 2]; DIRECTIONS],
}

/// A direction as a sum of three directions of the polytope: their numbers and signed weights.
type Combination = [(usize, f32); 3];

/// The direction as a sum of its nearest three directions of the polytope, none of them with the opposite sign.
#[inline(always)]
fn combination(direction: &[f32; 3]) -> Combination {
    let size = [direction[0].abs(), direction[1].abs(), direction[2].abs()];
    // axes by falling size of the component
    let (mut i, mut j, mut k) = (0, 1, 2);
    if size[j] > size[i] {
        (i, j) = (j, i);
    }
    if size[k] > size[j] {
        (j, k) = (k, j);
    }
    if size[j] > size[i] {
        (i, j) = (j, i);
    }
    let (a, b, c) = (size[i], size[j], size[k]);
    let sign = |axis: usize| 1_f32.copysign(direction[axis]);
    let diagonal = |p: usize, q: usize, weight: f32| {
        let (p, q) = if p < q { (p, q) } else { (q, p) };
        let sum = 2 * (p + q) + 1;
        let number = if sign(p) == sign(q) { sum } else { sum + 1 };
        (number, weight * sign(p))
    };
    if a >= b + c {
        return [(i, sign(i) * (a - b - c)), diagonal(i, j, ROOT_2 * b), diagonal(i, k, ROOT_2 * c)];
    }
    let half = 0.5 * ROOT_2;
    [
        diagonal(i, j, half * (a + b - c)),
        diagonal(i, k, half * (a + c - b)),
        diagonal(j, k, half * (b + c - a)),
    ]
}

/// The interval of eight polytopes along a direction.
#[inline(always)]
fn interval<S: Simd>(simd: S, pack: &Kdop18Pack, direction: &[f32; 3]) -> [f32x8<S>; 2] {
    let [first, second, third] = combination(direction);
    let [l, h] = weighted(simd, pack, first);
    let [m, i] = weighted(simd, pack, second);
    let [n, j] = weighted(simd, pack, third);
    [l + m + n, h + i + j]
}

#[inline(always)]
fn weighted<S: Simd>(simd: S, pack: &Kdop18Pack, (number, weight): (usize, f32)) -> [f32x8<S>; 2] {
    let low = f32x8::from_slice(simd, &pack.low[number]) * weight;
    let high = f32x8::from_slice(simd, &pack.high[number]) * weight;
    if weight < 0.0 { [high, low] } else { [low, high] }
}

impl BoundingVolume for Kdop18 {
    type Pack = Kdop18Pack;
    type Seen = SeenKdop18;
    type Facing<S: Simd> = FacingKdop18<S>;

    fn axes(_: &[Vector]) -> RotationMatrix {
        RotationMatrix::identity()
    }

    fn fit(points: &[Vector]) -> Self {
        let mut polytope = Self { low: [f32::INFINITY; DIRECTIONS], high: [f32::NEG_INFINITY; DIRECTIONS] };
        for (k, direction) in UNIT_DIRECTIONS.iter().enumerate() {
            let direction = Vector::from(direction.map(f64::from));
            for point in points {
                let along = direction.dot(point);
                polytope.high[k] = polytope.high[k].greater(round_up(along));
                polytope.low[k] = polytope.low[k].lesser(-round_up(-along));
            }
        }
        polytope
    }

    fn outline(&self) -> Outline {
        let (corners, faces) = (self.corners(), self.faces());
        #[allow(clippy::cast_precision_loss)] // there are few corners
        let middle = corners.iter().sum::<Vector>() / corners.len().max(1) as f64;
        // from the middle, which is inside, to the nearest face
        let exit = |direction: &Vector| {
            let ahead = faces.iter().filter(|(normal, _)| normal.dot(direction) > 1e-9);
            let to =
                |(normal, offset): &(Vector, f64)| (offset - normal.dot(&middle)) / normal.dot(direction);
            middle + direction * ahead.map(to).fold(f64::INFINITY, f64::lesser).greater(0.0)
        };
        Outline::Triangles(convex_outline(exit))
    }

    fn pack(volumes: &[Self]) -> Kdop18Pack {
        Kdop18Pack {
            low: std::array::from_fn(|k| lanes(volumes, |v| v.low[k])),
            high: std::array::from_fn(|k| lanes(volumes, |v| v.high[k])),
        }
    }

    #[inline(always)]
    fn splat(&self) -> Kdop18Pack {
        let mut pack = Kdop18Pack { low: [[0.0; LANES]; DIRECTIONS], high: [[0.0; LANES]; DIRECTIONS] };
        for k in 0..DIRECTIONS {
            pack.low[k] = [self.low[k]; LANES];
            pack.high[k] = [self.high[k]; LANES];
        }
        pack
    }

    #[inline(always)]
    fn seen<S: Simd>(simd: S, pack: &Kdop18Pack, relative: &Relative) -> SeenKdop18 {
        let mut seen = SeenKdop18 { along_b: *pack, own: *pack };
        let anchor = relative.along_a(&relative.t);
        for (k, direction) in UNIT_DIRECTIONS.iter().enumerate() {
            let [low, high] = interval(simd, pack, &relative.along_a(direction));
            let offset = relative.offset_along(direction);
            seen.along_b.low[k] = (low + offset).into();
            seen.along_b.high[k] = (high + offset).into();
            let own = anchor[0] * direction[0] + anchor[1] * direction[1] + anchor[2] * direction[2];
            seen.own.low[k] = (f32x8::from_slice(simd, &pack.low[k]) + own).into();
            seen.own.high[k] = (f32x8::from_slice(simd, &pack.high[k]) + own).into();
        }
        seen
    }

    #[inline(always)]
    fn facing<S: Simd>(simd: S, pack: &Kdop18Pack, relative: &Relative) -> FacingKdop18<S> {
        let zero = [f32x8::splat(simd, 0.0); 2];
        let mut facing = FacingKdop18 { own: [zero; DIRECTIONS], along_a: [zero; DIRECTIONS] };
        let back = Relative { t: [0.0; 3], ..*relative };
        for (k, direction) in UNIT_DIRECTIONS.iter().enumerate() {
            facing.own[k] = [f32x8::from_slice(simd, &pack.low[k]), f32x8::from_slice(simd, &pack.high[k])];
            facing.along_a[k] = interval(simd, pack, &back.point(direction));
        }
        facing
    }

    #[inline(always)]
    fn coarse_bounds<S: Simd>(simd: S, seen: &SeenKdop18, other: &Self, _: &Relative) -> f32x8<S> {
        let mut gap = f32x8::splat(simd, f32::NEG_INFINITY);
        for k in 0..DIRECTIONS {
            let low = f32x8::from_slice(simd, &seen.along_b.low[k]);
            let high = f32x8::from_slice(simd, &seen.along_b.high[k]);
            gap = gap.max(low - other.high[k]).max(high * -1.0 + other.low[k]);
        }
        gap
    }

    #[inline(always)]
    fn extents<S: Simd>(simd: S, pack: &Kdop18Pack, direction: &[f32; 3]) -> [f32x8<S>; 2] {
        interval(simd, pack, direction)
    }

    #[inline(always)]
    fn bounds<S: Simd, const SEPARATE: bool>(
        simd: S,
        facing: &FacingKdop18<S>,
        seen: &SeenKdop18,
        lane: usize,
        relative: &Relative,
    ) -> f32x8<S> {
        let along_b = gaps(&facing.own, &seen.along_b, lane);
        let gap = largest(&along_b);
        if SEPARATE && gap.simd_gt(relative.slack).all_true() {
            return gap;
        }
        let along_a = gaps(&facing.along_a, &seen.own, lane);
        let gap = gap.max(largest(&along_a));
        if SEPARATE {
            return gap;
        }
        // the gaps along three axes add up, as those of boxes
        let zero = Vectors::splat(simd, &[0.0; 3]);
        let of_box = |g: &[f32x8<S>; DIRECTIONS]| Vectors { x: g[0], y: g[1], z: g[2] }.max(zero).norm();
        let apart = of_box(&along_b).max(of_box(&along_a)).max(gap);
        apart.simd_gt(f32x8::splat(simd, 0.0)).select(apart, gap)
    }
}

/// The gaps between eight polytopes and one in a lane of `seen`, along each direction of one frame.
#[inline(always)]
fn gaps<S: Simd>(
    eight: &[[f32x8<S>; 2]; DIRECTIONS],
    seen: &Kdop18Pack,
    lane: usize,
) -> [f32x8<S>; DIRECTIONS] {
    let mut gaps = [eight[0][0]; DIRECTIONS];
    for k in 0..DIRECTIONS {
        let [low, high] = eight[k];
        gaps[k] = (low - seen.high[k][lane & 7]).max(high * -1.0 + seen.low[k][lane & 7]);
    }
    gaps
}

#[inline(always)]
fn largest<S: Simd>(gaps: &[f32x8<S>; DIRECTIONS]) -> f32x8<S> {
    let mut largest = gaps[0];
    for gap in &gaps[1..] {
        largest = largest.max(*gap);
    }
    largest
}

impl Kdop18 {
    /// Outward normals of the faces, and their distances (m) from the origin along them.
    fn faces(&self) -> Vec<(Vector, f64)> {
        (UNIT_DIRECTIONS.iter().zip(self.low.iter().zip(&self.high)))
            .flat_map(|(direction, (low, high))| {
                let direction = Vector::from(direction.map(f64::from));
                [(direction, f64::from(*high)), (-direction, -f64::from(*low))]
            })
            .collect()
    }

    /// Corners, for visualisation: points where three faces meet, within all others up to rounding.
    fn corners(&self) -> Vec<Vector> {
        let faces = self.faces();
        let size = faces.iter().map(|(_, offset)| offset.abs()).fold(0.0, f64::greater);
        let is_inside = |p: &Vector| faces.iter().all(|(n, offset)| n.dot(p) <= offset + 1e-5 * size);
        let mut corners = Vec::new();
        for i in 0..faces.len() {
            for j in 0..i {
                for k in 0..j {
                    let [(l, f), (m, g), (n, h)] = [faces[i], faces[j], faces[k]];
                    let normals = RotationMatrix::from_rows(&[l.transpose(), m.transpose(), n.transpose()]);
                    let meet = normals.try_inverse().map(|inverse| inverse * Vector::new(f, g, h));
                    corners.extend(meet.filter(&is_inside));
                }
            }
        }
        corners
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clearance_geometry::testing::Random;

    /// The weights are positive along the signed directions, and the sum is the direction.
    #[test]
    #[expect(clippy::cast_possible_truncation, reason = "directions are short")]
    fn every_direction_is_a_positive_sum_of_three_directions() {
        let mut random = Random::new(5);
        for round in 0..2_000 {
            let mut direction = random.direction().into_inner();
            if round % 7 == 0 {
                direction[round % 3] = 0.0;
            }
            let wanted = [direction.x as f32, direction.y as f32, direction.z as f32];
            let mut sum = [0.0_f32; 3];
            for (number, weight) in combination(&wanted) {
                let unit = UNIT_DIRECTIONS[number];
                let along: f32 = (0..3).map(|i| weight * unit[i] * wanted[i]).sum();
                assert!(along >= -1e-6, "{wanted:?}");
                for i in 0..3 {
                    sum[i] += weight * unit[i];
                }
            }
            assert!((0..3).all(|i| (sum[i] - wanted[i]).abs() < 1e-6), "{wanted:?} {sum:?}");
        }
    }
}
