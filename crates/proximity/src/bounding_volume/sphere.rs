//! Bounding spheres, or point swept spheres (Ritter 1990, *An efficient bounding sphere*).

use clearance_geometry::math::{Extremes, Point, RotationMatrix, Vector};
use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{LANES, Simd, Vectors, f32x8};

use super::outline::Outline;
use super::relative::Relative;
use super::rounding::{lanes, round, round_up};
use super::volume_trait::BoundingVolume;

/// All points within a radius of a centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre (m).
    pub centre: [f32; 3],
    /// Radius (m).
    pub radius: f32,
}

/// Eight spheres of one frame.
#[derive(Clone, Debug)]
#[repr(align(32))]
pub struct SpherePack {
    centre: [[f32; LANES]; 3],
    radius: [f32; LANES],
}

/// Eight spheres of a frame, transformed to another frame.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub struct SeenSpheres {
    centre: [[f32; LANES]; 3],
    radius: [f32; LANES],
}

/// Eight spheres, prepared for tests.
#[derive(Clone, Copy, Debug)]
pub struct FacingSpheres<S: Simd> {
    centre: Vectors<S>,
    radius: f32x8<S>,
}

impl BoundingVolume for Sphere {
    type Pack = SpherePack;
    type Seen = SeenSpheres;
    type Facing<S: Simd> = FacingSpheres<S>;

    fn axes(_: &[Vector]) -> RotationMatrix {
        RotationMatrix::identity()
    }

    fn fit(points: &[Vector]) -> Self {
        let centre = ritter(points);
        let centre: [f32; 3] = std::array::from_fn(|i| round(centre[i]));
        let rounded = Vector::from(centre.map(f64::from));
        let radius = points.iter().map(|p| (p - rounded).norm()).fold(0.0, f64::greater);
        Self { centre, radius: round_up(radius) }
    }

    fn outline(&self) -> Outline {
        Outline::Ball { centre: Point::from(self.centre.map(f64::from)), radius: f64::from(self.radius) }
    }

    fn pack(volumes: &[Self]) -> SpherePack {
        SpherePack {
            centre: std::array::from_fn(|i| lanes(volumes, |v| v.centre[i])),
            radius: lanes(volumes, |v| v.radius),
        }
    }

    #[inline(always)]
    fn splat(&self) -> SpherePack {
        let [x, y, z] = self.centre;
        SpherePack { centre: [[x; LANES], [y; LANES], [z; LANES]], radius: [self.radius; LANES] }
    }

    #[inline(always)]
    fn seen<S: Simd>(simd: S, pack: &SpherePack, relative: &Relative) -> SeenSpheres {
        let centre = Vectors::load(simd, &pack.centre).placed(&relative.r, &relative.t);
        SeenSpheres { centre: centre.store(), radius: pack.radius }
    }

    #[inline(always)]
    fn facing<S: Simd>(simd: S, pack: &SpherePack, _: &Relative) -> FacingSpheres<S> {
        FacingSpheres {
            centre: Vectors::load(simd, &pack.centre),
            radius: f32x8::from_slice(simd, &pack.radius),
        }
    }

    #[inline(always)]
    fn coarse_bounds<S: Simd>(simd: S, seen: &SeenSpheres, other: &Self, _: &Relative) -> f32x8<S> {
        let off = Vectors::load(simd, &seen.centre).minus(Vectors::splat(simd, &other.centre));
        off.norm() - f32x8::from_slice(simd, &seen.radius) - other.radius
    }

    #[inline(always)]
    fn bounds<S: Simd, const SEPARATE: bool>(
        simd: S,
        facing: &FacingSpheres<S>,
        seen: &SeenSpheres,
        lane: usize,
        _: &Relative,
    ) -> f32x8<S> {
        let centre = [seen.centre[0][lane], seen.centre[1][lane], seen.centre[2][lane]];
        facing.centre.minus(Vectors::splat(simd, &centre)).norm() - facing.radius - seen.radius[lane]
    }
}

/// The centre of a sphere that starts from two distant points and grows to contain one point after the other.
fn ritter(points: &[Vector]) -> Vector {
    let farthest = |from: Vector| {
        let nearer =
            |p: &&Vector, q: &&Vector| (*p - from).norm_squared().total_cmp(&(*q - from).norm_squared());
        points.iter().max_by(nearer).copied().unwrap_or(from)
    };
    let one_end = farthest(points.first().copied().unwrap_or_else(Vector::zeros));
    let other_end = farthest(one_end);
    let mut centre = (one_end + other_end) * 0.5;
    let mut radius = 0.5 * (other_end - one_end).norm();
    for p in points {
        let d = (p - centre).norm();
        if d > radius {
            let grown = 0.5 * (radius + d);
            centre += (p - centre) * ((d - grown) / d);
            radius = grown;
        }
    }
    centre
}
