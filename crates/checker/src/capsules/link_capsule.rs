//! Capsule around a link or an attached object, and the lower bound on the distance of two, in double precision.

use clearance_geometry::constants::MOTION_SLACK;
use clearance_geometry::math::{MatrixPose, Point};
#[cfg(test)]
use clearance_robot::Frame;
use clearance_robot::Reach;

/// All points within `radius` of the segment from `a` to `b`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkCapsule {
    pub a: Point,
    pub b: Point,
    pub radius: f64,
}

impl LinkCapsule {
    /// Transforms the capsule from a frame to that frame's parent.
    #[cfg(test)]
    #[must_use]
    pub fn seen_through(&self, frame: &Frame<f64>) -> Self {
        let seen = |p: Point| Point::from(frame.point(p.coords.into()));
        Self { a: seen(self.a), b: seen(self.b), radius: self.radius }
    }

    /// Bounding volume of the capsule, transformed to the parent frame.
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

/// Lower bound (m) on the distance between two capsules: the separation of their axes along the line between
/// approximately nearest points, as at level 0, but in f64.
pub fn capsule_distance_bound([a, b]: &[Reach; 2]) -> f64 {
    let (c, u) = ((a.ends[0] + a.ends[1]) * 0.5, (a.ends[1] - a.ends[0]) * 0.5);
    let (d, v) = ((b.ends[0] + b.ends[1]) * 0.5, (b.ends[1] - b.ends[0]) * 0.5);
    let w = d - c;
    let (uu, vv, uv) = (u.norm_squared(), v.norm_squared(), u.dot(&v));
    let (uw, vw) = (u.dot(&w), v.dot(&w));
    let over = |numerator: f64, denominator: f64| {
        if denominator > 0.0 { (numerator / denominator).clamp(-1.0, 1.0) } else { 0.0 }
    };
    let determinant = uu * vv - uv * uv;
    let s = if determinant > 1e-12 * uu * vv { over(uw * vv - uv * vw, determinant) } else { 0.0 };
    let t = over(uv * s - vw, vv);
    let s = over(uv * t + uw, uu);
    let n = w + v * t - u * s;
    let rounding = MOTION_SLACK * (1.0 + c.amax() + d.amax());
    let length = n.norm();
    if length > 0.0 {
        (n.dot(&w) - n.dot(&u).abs() - n.dot(&v).abs()) / length - a.radius - b.radius - rounding
    } else if length == 0.0 {
        -a.radius - b.radius
    } else {
        f64::NEG_INFINITY
    }
}
