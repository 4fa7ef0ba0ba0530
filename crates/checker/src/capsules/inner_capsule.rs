//! Part of a body's capsule that contains a point of every connected part of the body.
//!
//! If surfaces are apart, and a connected part of the body is inside an obstacle, so is this point of it. A point that is enclosed by a
//! part is as good as a point of the part: if it is not inside the obstacle, then a surface of the obstacle is wholly inside the part. So a
//! body is outside where this capsule is outside. For most links it is one point of the capsule's axis.

use clearance_geometry::constants::MOTION_SLACK;
use clearance_geometry::math::{Extremes, Point, Pose};
use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{LANES, Simd, f32x8};
use clearance_geometry::{Shape, TriangleMesh};

use super::link_capsule::LinkCapsule;
use super::segment::round_up;

/// Number of points of the axis that are tried, in either direction from its middle.
const STEPS: i8 = 8;

/// A capsule within another one, relative to that; one, or eight in lanes.
#[derive(Clone, Copy, Debug)]
pub struct InnerCapsule<V = f32> {
    /// Position of its centre on the axis: 0 in the middle, -1 and 1 at the ends.
    pub shift: V,
    /// Its length as a share of the other's.
    pub share: V,
    /// Radius (m).
    pub radius: V,
}

impl InnerCapsule {
    /// A small capsule, here a ball, that contains a point of every connected part of some shapes.
    pub fn new(capsule: &LinkCapsule, shapes: &[(Pose, Shape)]) -> Self {
        let whole = Self::whole(capsule);
        if !shapes.iter().all(|(_, shape)| matches!(shape, Shape::Mesh(_) | Shape::Primitive(_))) {
            return whole;
        }
        let parts: Vec<ConnectedParts> = shapes.iter().filter_map(ConnectedParts::new).collect();
        let ball = |step: i8| {
            let shift = f32::from(step) / f32::from(STEPS);
            let centre =
                nalgebra::center(&capsule.a, &capsule.b) + (capsule.b - capsule.a) * (0.5 * f64::from(shift));
            let radius = parts.iter().map(|parts| parts.radius(&centre)).fold(0.0, f64::greater);
            let radius = round_up(radius + MOTION_SLACK * (1.0 + centre.coords.amax()));
            Self { shift, share: 0.0, radius }
        };
        // the nearest to the middle of equal ones
        let steps = (0..=STEPS).flat_map(|step| [step, -step]);
        let smallest =
            steps.map(ball).reduce(|best, next| if next.radius < best.radius { next } else { best });
        smallest.filter(|ball| ball.radius < whole.radius).unwrap_or(whole)
    }

    /// All of the capsule.
    pub fn whole(capsule: &LinkCapsule) -> Self {
        Self {
            shift: 0.0,
            share: 1.0,
            radius: round_up(capsule.radius * (1.0 + MOTION_SLACK) + MOTION_SLACK),
        }
    }

    /// The same in all lanes.
    #[inline(always)]
    pub fn splat<S: Simd>(&self, simd: S) -> InnerCapsule<f32x8<S>> {
        let splat = |value| f32x8::splat(simd, value);
        InnerCapsule { shift: splat(self.shift), share: splat(self.share), radius: splat(self.radius) }
    }

    /// Eight in lanes.
    #[inline(always)]
    pub fn gather<S: Simd>(simd: S, of: impl Fn(usize) -> Self) -> InnerCapsule<f32x8<S>> {
        let eight: [Self; LANES] = std::array::from_fn(of);
        let lanes = |value: fn(&Self) -> f32| f32x8::simd_from(simd, eight.each_ref().map(value));
        InnerCapsule { shift: lanes(|c| c.shift), share: lanes(|c| c.share), radius: lanes(|c| c.radius) }
    }
}

/// The connected parts of a shape.
enum ConnectedParts<'s> {
    /// One part, of which any vertex and any point inside is a point.
    Mesh(&'s Pose, &'s TriangleMesh),
    /// A point of each part.
    Points(Vec<Point>),
}

impl<'s> ConnectedParts<'s> {
    fn new((pose, shape): &'s (Pose, Shape)) -> Option<Self> {
        match shape {
            Shape::Primitive(_) => Some(Self::Points(vec![Point::from(pose.translation.vector)])),
            Shape::Mesh(mesh) => match mesh.part_points() {
                points if points.len() == 1 => Some(Self::Mesh(pose, mesh)),
                points => Some(Self::Points(points.iter().map(|p| pose * p).collect())),
            },
            Shape::Plane(_) | Shape::Points(_) | Shape::Voxels(_) => None,
        }
    }

    /// Radius (m) of a ball around `centre` that contains a point of each part.
    fn radius(&self, centre: &Point) -> f64 {
        let distance = |p: Point| nalgebra::distance(&p, centre);
        match self {
            Self::Points(points) => points.iter().copied().map(distance).fold(0.0, f64::greater),
            Self::Mesh(pose, mesh) if mesh.encloses(&pose.inverse_transform_point(centre)) => 0.0,
            Self::Mesh(pose, mesh) => {
                let corners = mesh.triangles().iter().flatten().map(|v| mesh.vertices()[*v as usize]);
                corners.map(|p| distance(*pose * p)).fold(f64::INFINITY, f64::lesser)
            }
        }
    }
}
