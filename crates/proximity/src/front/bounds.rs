//! Lower bounds on the distances of listed pairs, updated as the bodies move.

use clearance_geometry::math::{MatrixPose, Point, Vector};
use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{LANES, Level, Simd, Vectors, dispatch, f32x8};

use super::eight_pairs::EightPairs;
use super::listed_pair::ListedPair;
use crate::body::BodyPair;
use crate::bounding_volume::Relative;
use crate::elements::RoundedShape;
use crate::narrow_phase::{f32_above, gap_along, separation_within, triangle_slack};

/// Number of pairs that may be nearest from which on new bounds are worth their cost.
const UNCLEAR: usize = 8 * LANES;

/// Rounding error allowed, relative to the inputs: 16 units in the last place.
const F32_ROUNDING: f32 = 16.0 / 16_777_216.0;

/// Rounding error allowed in f64, and in entries of rotations.
const F64_ROUNDING: f64 = 1e-13;

/// A distance (m) beyond all others, but usable in arithmetic.
const FAR: f32 = 1e30;

/// Bounds of pairs at one pose, with their rates of change.
#[derive(Clone, Debug, Default)]
pub(super) struct Bounds {
    /// Pose of b in the frame of a at which the gaps were computed.
    at: Option<MatrixPose>,
    /// The point c, in the frame of a.
    centre: Point,
    eights: Vec<Eight>,
    /// Lower bounds at the last pose.
    now: Vec<[f32; LANES]>,
    /// Number of pairs that could be nearest when the gaps were computed.
    usual: Option<usize>,
}

/// Bounds of eight pairs.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub(super) struct Eight {
    /// Directions from a to b, in the frame of b, of length at most one.
    pub n: [[f32; LANES]; 3],
    /// Gaps along these directions.
    pub gap: [f32; LANES],
    /// Maximum distance (m) of the element of a from the centre.
    pub reach: [f32; LANES],
}

/// The pair with the least bound.
#[derive(Clone, Copy, Debug)]
pub(super) struct Least {
    pub lower: f32,
    pub index: usize,
}

impl Bounds {
    /// Lower bounds on the distances (m) at the last pose.
    #[inline]
    pub fn now(&self) -> &[[f32; LANES]] {
        &self.now
    }

    /// Updates the bounds for another pose of b.
    #[allow(clippy::cast_possible_truncation)] // granted, or rounded up
    #[inline]
    pub fn move_to(&mut self, pose_ab: &MatrixPose, level: Level) -> Least {
        let Some(at) = &self.at else { return Least { lower: f32::INFINITY, index: 0 } };
        let (from, to) = (at.inverse(), pose_ab.inverse());
        let shift = (&to * self.centre) - (&from * self.centre);
        let turn = (to.rotation - from.rotation).norm() * std::f64::consts::FRAC_1_SQRT_2 + F64_ROUNDING;
        let entered =
            self.centre.coords.abs().sum() + from.translation.abs().sum() + to.translation.abs().sum();
        let motion = Motion {
            shift: [shift.x as f32, shift.y as f32, shift.z as f32],
            turn: f32_above(turn),
            rounding: f32_above(F64_ROUNDING * entered) + F32_ROUNDING * f32_above(shift.abs().sum()),
        };
        dispatch!(level, simd => follow(simd, &self.eights, &motion, &mut self.now))
    }

    /// True if more pairs than usual could be nearest, so that new bounds would help.
    #[inline]
    pub fn are_worn(&mut self, unclear: usize) -> bool {
        unclear > UNCLEAR.max(2 * *self.usual.get_or_insert(unclear))
    }

    /// Recomputes the bounds of all pairs; `centre` is a point of a near the nearest elements.
    #[inline]
    pub fn renew(&mut self, bodies: BodyPair, centre: &Point, listed: &[ListedPair], level: Level) {
        (self.at, self.centre, self.usual) = (Some(*bodies.pose_ab), *centre, None);
        self.eights.clear();
        for pairs in listed.chunks(LANES) {
            let mut eight = Eight::NOTHING;
            eight.take_gaps(bodies, centre, pairs, level);
            self.eights.push(eight);
        }
        self.now.clear();
        self.now.extend(self.eights.iter().map(|eight| eight.gap));
    }
}

/// Motion of a relative to b.
struct Motion {
    /// Translation of the centre, in the frame of b (m).
    shift: [f32; 3],
    /// Maximum displacement (m) by the rotation, per metre from the centre.
    turn: f32,
    rounding: f32,
}

/// Computes the bounds at b's present pose, and the least of them.
#[inline(always)]
fn follow<S: Simd>(simd: S, eights: &[Eight], motion: &Motion, now: &mut [[f32; LANES]]) -> Least {
    let mut least = Least { lower: f32::INFINITY, index: 0 };
    for (i, (eight, now)) in eights.iter().zip(now).enumerate() {
        let gap = f32x8::simd_from(simd, eight.gap);
        let shifted = Vectors::load(simd, &eight.n).along(&motion.shift);
        let turned = f32x8::simd_from(simd, eight.reach) * motion.turn;
        let rounding = (gap.abs() + turned) * F32_ROUNDING + motion.rounding;
        let bound = gap - shifted - turned - rounding;
        *now = bound.into();
        if bound.simd_lt(least.lower).any_true() {
            let (lane, lower) = (now.iter().copied().enumerate())
                .fold((0, f32::INFINITY), |best, next| if next.1 < best.1 { next } else { best });
            least = Least { lower, index: i * LANES + lane };
        }
    }
    least
}

impl Eight {
    /// Value for lanes without a pair: farther away than any other.
    const NOTHING: Self = Self { n: [[0.0; LANES]; 3], gap: [FAR; LANES], reach: [0.0; LANES] };

    fn take_gaps(&mut self, bodies: BodyPair, centre: &Point, pairs: &[ListedPair], level: Level) {
        let BodyPair { a, b, pose_ab } = bodies;
        let first = pairs[0].elements;
        if first.a.is_triangle()
            && first.b.is_triangle()
            && let (Some(a), Some(b)) = (a.surface(), b.surface())
        {
            let relative = &a.tree().relative(b.tree(), pose_ab);
            let corners = EightPairs::new(a, b, pairs);
            let centre = EightPairs::point_in_b(a, relative, centre);
            dispatch!(level, simd => self.take_gaps_of_triangles(simd, &corners, relative, &centre));
            self.gap[pairs.len()..].fill(FAR);
            return;
        }
        for (lane, pair) in pairs.iter().enumerate() {
            let (a, b) = (a.element(pair.elements.a), b.element(pair.elements.b));
            self.reach[lane] = f32_above(a.farthest_from(centre));
            self.take_gap(lane, &a, &b, pose_ab);
        }
    }

    #[inline(always)]
    fn take_gaps_of_triangles<S: Simd>(
        &mut self,
        simd: S,
        corners: &EightPairs,
        relative: &Relative,
        centre: &[f32; 3],
    ) {
        let (one, other) = corners.load(simd, relative);
        let slack = triangle_slack(relative);
        let distances = one.bounds(simd, &other, slack);
        self.n = distances.towards.store();
        self.gap = distances.lower.into();
        self.reach = one.farthest_from(simd, centre, slack).into();
    }

    /// Of a pair with a solid, in f64.
    #[allow(clippy::cast_possible_truncation)] // granted, or rounded down
    fn take_gap(&mut self, lane: usize, a: &RoundedShape, b: &RoundedShape, pose_ab: &MatrixPose) {
        let found = separation_within(a, b, pose_ab, f64::INFINITY);
        let between = found.map_or_else(Vector::zeros, |f| f.witness_points[1] - f.witness_points[0]);
        let Some(n) = between.try_normalize(0.0) else {
            self.gap[lane] = f32::NEG_INFINITY;
            return;
        };
        self.gap[lane] = (gap_along(a, b, pose_ab, &n) as f32).next_down();
        let n = pose_ab.rotation.tr_mul(&n) * (1.0 - f64::from(4.0 * f32::EPSILON));
        for i in 0..3 {
            self.n[i][lane] = n[i] as f32;
        }
    }
}
