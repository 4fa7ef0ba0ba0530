//! Intersections of five balls (Zhang & Kim 2012, *k-IOS: intersection of spheres for efficient proximity query*): one around all points,
//! and four larger ones that flatten it from both sides along the two directions of least spread.

use clearance_geometry::constants::VOLUME_SLACK;
use clearance_geometry::math::{Extremes, RotationMatrix, Vector};
use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{LANES, Simd, Vectors, f32x8};

use super::outline::{Outline, convex_outline};
use super::principal_axes::principal_axes;
use super::relative::Relative;
use super::rounding::{lanes, round, round_up};
use super::sphere::Sphere;
use super::volume_trait::BoundingVolume;

const BALLS: usize = 5;

/// Distance of the centre of a flattening ball from the face that it flattens, in radii of the points across.
const FLATTENING: f64 = 2.0;

/// All points within each of five balls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kios {
    /// The first is the smallest ball.
    pub balls: [Sphere; BALLS],
}

/// Eight intersections of one frame.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub struct KiosPack {
    centres: [[[f32; LANES]; 3]; BALLS],
    radii: [[f32; LANES]; BALLS],
}

/// Eight intersections, prepared for tests.
#[derive(Clone, Copy, Debug)]
pub struct FacingKios<S: Simd> {
    centres: [Vectors<S>; BALLS],
    radii: [f32x8<S>; BALLS],
}

impl BoundingVolume for Kios {
    type Pack = KiosPack;
    /// In the other frame.
    type Seen = KiosPack;
    type Facing<S: Simd> = FacingKios<S>;

    fn axes(_: &[Vector]) -> RotationMatrix {
        RotationMatrix::identity()
    }

    fn fit(points: &[Vector]) -> Self {
        let central = Sphere::fit(points);
        let middle = Vector::from(central.centre.map(f64::from));
        let axes = principal_axes(points);
        let flattened = |axis: usize, side: f64| {
            let direction: Vector = axes.column(axis) * side;
            let along = |p: &Vector| (p - middle).dot(&direction);
            let high = points.iter().map(along).fold(f64::NEG_INFINITY, f64::greater);
            let across = |p: &Vector| (p - middle - direction * along(p)).norm();
            let across = points.iter().map(across).fold(0.0, f64::greater);
            around(points, &(middle + direction * (high - FLATTENING * across)))
        };
        let balls = [central, flattened(2, 1.0), flattened(2, -1.0), flattened(1, 1.0), flattened(1, -1.0)];
        Self { balls: balls.map(widened) }
    }

    fn outline(&self) -> Outline {
        let [central, others @ ..] = &self.balls;
        let middle = Vector::from(central.centre.map(f64::from));
        // from the middle, which is in all balls, to the nearest surface
        let exit = |direction: &Vector| {
            let of = |ball: &Sphere| {
                let offset = middle - Vector::from(ball.centre.map(f64::from));
                let (along, radius) = (offset.dot(direction), f64::from(ball.radius));
                let inside = radius * radius - offset.norm_squared();
                (along * along + inside).greater(0.0).sqrt() - along
            };
            let nearest = others.iter().map(of).fold(of(central), f64::lesser);
            middle + direction * nearest.greater(0.0)
        };
        Outline::Triangles(convex_outline(exit))
    }

    fn pack(volumes: &[Self]) -> KiosPack {
        let centre = |k: usize, i: usize| lanes(volumes, |v: &Self| v.balls[k].centre[i]);
        KiosPack {
            centres: std::array::from_fn(|k| std::array::from_fn(|i| centre(k, i))),
            radii: std::array::from_fn(|k| lanes(volumes, |v| v.balls[k].radius)),
        }
    }

    #[inline(always)]
    fn splat(&self) -> KiosPack {
        let mut pack = KiosPack { centres: [[[0.0; LANES]; 3]; BALLS], radii: [[0.0; LANES]; BALLS] };
        for k in 0..BALLS {
            let [x, y, z] = self.balls[k].centre;
            pack.centres[k] = [[x; LANES], [y; LANES], [z; LANES]];
            pack.radii[k] = [self.balls[k].radius; LANES];
        }
        pack
    }

    #[inline(always)]
    fn seen<S: Simd>(simd: S, pack: &KiosPack, relative: &Relative) -> KiosPack {
        let mut seen = *pack;
        for k in 0..BALLS {
            let centres = Vectors::load(simd, &pack.centres[k]).placed(&relative.r, &relative.t);
            seen.centres[k] = centres.store();
        }
        seen
    }

    #[inline(always)]
    fn facing<S: Simd>(simd: S, pack: &KiosPack, _: &Relative) -> FacingKios<S> {
        let mut facing = FacingKios {
            centres: [Vectors::splat(simd, &[0.0; 3]); BALLS],
            radii: [f32x8::splat(simd, 0.0); BALLS],
        };
        for k in 0..BALLS {
            facing.centres[k] = Vectors::load(simd, &pack.centres[k]);
            facing.radii[k] = f32x8::from_slice(simd, &pack.radii[k]);
        }
        facing
    }

    #[inline(always)]
    fn coarse_bounds<S: Simd>(simd: S, seen: &KiosPack, other: &Self, _: &Relative) -> f32x8<S> {
        let [ball, ..] = &other.balls;
        let centre = Vectors::splat(simd, &ball.centre);
        let mut gap = f32x8::splat(simd, f32::NEG_INFINITY);
        for k in 0..BALLS {
            let apart = Vectors::load(simd, &seen.centres[k]).minus(centre).norm();
            gap = gap.max(apart - f32x8::from_slice(simd, &seen.radii[k]) - ball.radius);
        }
        gap
    }

    #[inline(always)]
    fn extents<S: Simd>(simd: S, pack: &KiosPack, direction: &[f32; 3]) -> [f32x8<S>; 2] {
        let (mut low, mut high) = (f32x8::splat(simd, f32::NEG_INFINITY), f32x8::splat(simd, f32::INFINITY));
        for k in 0..BALLS {
            let middle = Vectors::load(simd, &pack.centres[k]).along(direction);
            let radius = f32x8::from_slice(simd, &pack.radii[k]);
            low = low.max(middle - radius);
            high = high.min(middle + radius);
        }
        [low, high]
    }

    #[inline(always)]
    fn bounds<S: Simd, const SEPARATE: bool>(
        simd: S,
        facing: &FacingKios<S>,
        seen: &KiosPack,
        lane: usize,
        relative: &Relative,
    ) -> f32x8<S> {
        let mut gap = gap(simd, facing, seen, lane, (0, 0));
        if SEPARATE && gap.simd_gt(relative.slack).all_true() {
            return gap;
        }
        for i in 0..BALLS {
            for k in 0..BALLS {
                gap = gap.max(self::gap(simd, facing, seen, lane, (i, k)));
            }
        }
        gap
    }
}

/// The gaps between ball `k` of eight and ball `i` of the one in a lane.
#[inline(always)]
fn gap<S: Simd>(
    simd: S,
    facing: &FacingKios<S>,
    seen: &KiosPack,
    lane: usize,
    (i, k): (usize, usize),
) -> f32x8<S> {
    let [x, y, z] = &seen.centres[i];
    let centre = Vectors::splat(simd, &[x[lane & 7], y[lane & 7], z[lane & 7]]);
    facing.centres[k].minus(centre).norm() - facing.radii[k] - seen.radii[i][lane & 7]
}

/// The least ball with this centre that contains all points.
fn around(points: &[Vector], centre: &Vector) -> Sphere {
    let centre: [f32; 3] = std::array::from_fn(|i| round(centre[i]));
    let rounded = Vector::from(centre.map(f64::from));
    let radius = points.iter().map(|p| (p - rounded).norm()).fold(0.0, f64::greater);
    Sphere { centre, radius: round_up(radius) }
}

/// The slack of a test grants for coordinates up to the reach of the tree; centres may lie farther out.
fn widened(ball: Sphere) -> Sphere {
    let size: f64 = ball.centre.iter().map(|x| f64::from(x.abs())).sum();
    let radius = f64::from(ball.radius);
    Sphere { radius: round_up(radius + VOLUME_SLACK * (size + radius)), ..ball }
}
