//! Bounding sphere of a whole body, in f64.

use clearance_geometry::Plane;
use clearance_geometry::constants::FIT_SLACK;
use clearance_geometry::math::{Extremes, MatrixPose, Point};

use super::cube_set::CubeSet;
use super::solid_leaf::Solid;

/// All points of a body lie within `radius` (m) of `centre`, in its frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundingSphere {
    /// In the frame of the body (m).
    pub centre: Point,
    /// Radius (m).
    pub radius: f64,
}

impl BoundingSphere {
    /// Sphere of an infinite body.
    pub(crate) const UNBOUNDED: Self = Self { centre: Point::new(0.0, 0.0, 0.0), radius: f64::INFINITY };

    /// Lower bound on the distance (m) between the contents of two spheres.
    #[inline]
    #[must_use]
    pub fn lower_bound(&self, other: &Self, pose_ab: &MatrixPose) -> f64 {
        let centre = pose_ab * other.centre;
        let reach =
            self.centre.coords.abs().sum() + centre.coords.abs().sum() + other.centre.coords.abs().sum();
        nalgebra::distance(&self.centre, &centre) - self.radius - other.radius - FIT_SLACK * reach
    }

    /// Lower bound (m) on the distance of the sphere's content from a plane, both in one frame.
    #[inline]
    pub(crate) fn plane_bound(&self, plane: &Plane) -> f64 {
        let entered = self.centre.coords.abs().sum() + plane.offset.abs() + self.radius;
        plane.height(&self.centre).abs() - self.radius - FIT_SLACK * entered
    }

    /// Maximum motion (m) of a point of the sphere from one pose to another: the motion of the centre, plus the radius times the
    /// Frobenius norm of the difference of rotations, which bounds the norm of that matrix.
    #[must_use]
    #[inline]
    pub fn displacement(&self, from: &MatrixPose, to: &MatrixPose) -> f64 {
        if self.radius == f64::INFINITY {
            return f64::INFINITY;
        }
        let (p, q) = (from * self.centre, to * self.centre);
        let turn = (to.rotation - from.rotation).norm();
        let reach = p.coords.abs().sum() + q.coords.abs().sum() + self.radius;
        nalgebra::distance(&p, &q) + turn * self.radius + FIT_SLACK * reach
    }

    /// `None` without content. The centre is the middle of the bounding box.
    pub(crate) fn around(
        vertices: &[Point],
        faces: &[[u32; 3]],
        solids: &[Solid],
        cube_sets: &[CubeSet],
    ) -> Option<Self> {
        let corners = || faces.iter().flatten().map(|&v| vertices[v as usize]);
        let of_cubes: Vec<(Point, f64)> = cube_sets.iter().map(CubeSet::ball).collect();
        let balls = || {
            let solid = |s: &Solid| (Point::from(s.pose.translation.vector), s.primitive.bounding_radius());
            solids.iter().map(solid).chain(of_cubes.iter().copied())
        };
        let mut lo = Point::from([f64::INFINITY; 3]);
        let mut hi = Point::from([f64::NEG_INFINITY; 3]);
        for (p, radius) in corners().map(|p| (p, 0.0)).chain(balls()) {
            lo = lo.inf(&(p - nalgebra::Vector3::repeat(radius)));
            hi = hi.sup(&(p + nalgebra::Vector3::repeat(radius)));
        }
        if lo.x > hi.x {
            return None;
        }
        let centre = nalgebra::center(&lo, &hi);
        let reach = |(p, radius): (Point, f64)| nalgebra::distance(&centre, &p) + radius;
        let radius = corners().map(|p| (p, 0.0)).chain(balls()).map(reach).fold(0.0, f64::greater);
        Some(Self { centre, radius: radius + FIT_SLACK * (radius + centre.coords.amax()) })
    }
}
