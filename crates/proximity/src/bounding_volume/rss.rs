//! Rectangle swept spheres: all points within a radius of a rectangle (Larsen, Gottschalk, Lin & Manocha 1999).
//!
//! The distance of two rectangles is exact (`rectangle_distance`); where only a separation is sought, separating axes of boxes of zero
//! thickness come first.

use clearance_geometry::math::{Extremes, RotationMatrix, Vector};
use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{LANES, Simd, f32x8};

use super::obb::{FacingObbs, Obb, ObbPack, SeenObbs};
use super::outline::{Outline, convex_outline};
use super::principal_axes::principal_axes;
use super::rectangle_distance::rectangle_bounds;
use super::relative::Relative;
use super::rounding::{lanes, round, round_up};
use super::volume_trait::BoundingVolume;

/// A rectangle normal to the third axis of its frame, and a radius around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rss {
    /// A box of zero thickness.
    pub rectangle: Obb,
    /// Radius (m).
    pub radius: f32,
}

/// Eight rectangle swept spheres of one frame.
#[derive(Clone, Debug)]
pub struct RssPack {
    rectangles: ObbPack,
    radius: [f32; LANES],
}

/// Eight rectangle swept spheres of a frame, transformed to another frame.
#[derive(Clone, Copy, Debug)]
pub struct SeenRss {
    rectangles: SeenObbs,
    radius: [f32; LANES],
}

/// Eight rectangle swept spheres, prepared for tests.
#[derive(Clone, Copy, Debug)]
pub struct FacingRss<S: Simd> {
    rectangles: FacingObbs<S>,
    radius: f32x8<S>,
}

impl BoundingVolume for Rss {
    type Pack = RssPack;
    type Seen = SeenRss;
    type Facing<S: Simd> = FacingRss<S>;

    /// Principal axes: the third is the direction of least spread.
    fn axes(points: &[Vector]) -> RotationMatrix {
        principal_axes(points)
    }

    /// The rectangle lies in the middle of the thickness, as short as the half thickness allows on each side; the radius
    /// is then the largest distance of a point from it.
    fn fit(points: &[Vector]) -> Self {
        let (lo, hi) = range(points.iter().map(|p| (p.z, p.z)));
        let (middle, thickness) = (0.5 * (lo + hi), 0.5 * (hi - lo));
        let cap = |p: &Vector| (thickness * thickness - (p.z - middle).powi(2)).greater(0.0).sqrt();
        let span = |i: usize| range(points.iter().map(|p| (p[i] + cap(p), p[i] - cap(p))));
        let spans = [span(0), span(1)];
        let centre =
            [round(0.5 * (spans[0].0 + spans[0].1)), round(0.5 * (spans[1].0 + spans[1].1)), round(middle)];
        let half = spans.map(|(lo, hi)| round((0.5 * (hi - lo)).greater(0.0)));
        let rectangle = Obb { centre, half_extents: [half[0], half[1], 0.0] };
        let radius = points.iter().map(|p| distance_from(&rectangle, p)).fold(0.0, f64::greater);
        Self { rectangle, radius: round_up(radius) }
    }

    fn outline(&self) -> Outline {
        let centre = Vector::from(self.rectangle.centre.map(f64::from));
        let half = Vector::from(self.rectangle.half_extents.map(f64::from));
        let farthest = |direction: &Vector| {
            centre + half.zip_map(direction, f64::copysign) + direction * f64::from(self.radius)
        };
        Outline::Triangles(convex_outline(farthest))
    }

    fn pack(volumes: &[Self]) -> RssPack {
        let rectangles: Vec<Obb> = volumes.iter().map(|v| v.rectangle).collect();
        RssPack { rectangles: Obb::pack(&rectangles), radius: lanes(volumes, |v| v.radius) }
    }

    #[inline(always)]
    fn splat(&self) -> RssPack {
        RssPack { rectangles: self.rectangle.splat(), radius: [self.radius; LANES] }
    }

    #[inline(always)]
    fn seen<S: Simd>(simd: S, pack: &RssPack, relative: &Relative) -> SeenRss {
        SeenRss { rectangles: Obb::seen(simd, &pack.rectangles, relative), radius: pack.radius }
    }

    #[inline(always)]
    fn facing<S: Simd>(simd: S, pack: &RssPack, relative: &Relative) -> FacingRss<S> {
        let rectangles = Obb::facing(simd, &pack.rectangles, relative);
        FacingRss { rectangles, radius: f32x8::from_slice(simd, &pack.radius) }
    }

    #[inline(always)]
    fn extents<S: Simd>(simd: S, pack: &RssPack, direction: &[f32; 3]) -> [f32x8<S>; 2] {
        let [low, high] = Obb::extents(simd, &pack.rectangles, direction);
        let radius = f32x8::from_slice(simd, &pack.radius);
        [low - radius, high + radius]
    }

    #[inline(always)]
    fn coarse_bounds<S: Simd>(simd: S, seen: &SeenRss, other: &Self, relative: &Relative) -> f32x8<S> {
        let gap = Obb::coarse_bounds(simd, &seen.rectangles, &other.rectangle, relative);
        gap - f32x8::from_slice(simd, &seen.radius) - other.radius
    }

    #[inline(always)]
    fn bounds<S: Simd, const SEPARATE: bool>(
        simd: S,
        facing: &FacingRss<S>,
        seen: &SeenRss,
        lane: usize,
        relative: &Relative,
    ) -> f32x8<S> {
        let (faces, rectangles) = (&facing.rectangles, &seen.rectangles);
        let radii = facing.radius + seen.radius[lane];
        if SEPARATE {
            let bound = Obb::bounds::<S, false>(simd, faces, rectangles, lane, relative) - radii;
            if bound.simd_gt(relative.slack).all_true() {
                return bound;
            }
        }
        rectangle_bounds(simd, faces, rectangles, lane, relative) - radii
    }
}

/// The largest first and the smallest second number, in rising order if they do not cross.
fn range(numbers: impl Iterator<Item = (f64, f64)>) -> (f64, f64) {
    numbers.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), (a, b)| (lo.lesser(a), hi.greater(b)))
}

fn distance_from(rectangle: &Obb, p: &Vector) -> f64 {
    let beyond = |i: usize| {
        let from_centre = (p[i] - f64::from(rectangle.centre[i])).abs();
        (from_centre - f64::from(rectangle.half_extents[i])).greater(0.0)
    };
    Vector::new(beyond(0), beyond(1), beyond(2)).norm()
}
