//! Bounding spheres (Ritter 1990, *An efficient bounding sphere*).

use super::bounding_volume::BoundingVolume;
use clearance::constants::{CONTACT_DISTANCE, FIT_SLACK};

use super::bounding_volume::SEPARATION_SLACK;
use clearance::geometry::Primitive;
use clearance::math::{Point, Pose};

/// All points within a radius of a centre.
#[derive(Clone, Debug, PartialEq)]
pub struct Sphere {
    pub centre: Point,
    pub radius: f64,
}

impl BoundingVolume for Sphere {
    const NAME: &'static str = "PSS";

    fn fit(points: &[Point]) -> Self {
        let farthest = |from: Point| {
            (points.iter().copied())
                .max_by(|p, q| {
                    nalgebra::distance_squared(&from, p).total_cmp(&nalgebra::distance_squared(&from, q))
                })
                .unwrap_or(from)
        };
        let one_end = farthest(points.first().copied().unwrap_or_else(Point::origin));
        let other_end = farthest(one_end);
        let mut centre = nalgebra::center(&one_end, &other_end);
        let mut radius = 0.5 * nalgebra::distance(&one_end, &other_end);
        for p in points {
            let d = nalgebra::distance(&centre, p);
            if d > radius {
                let grown = 0.5 * (radius + d);
                centre += (p - centre) * ((d - grown) / d);
                radius = grown;
            }
        }
        let exact = (points.iter()).map(|p| nalgebra::distance(&centre, p)).fold(0.0, f64::max);
        Self { radius: exact + FIT_SLACK * (exact + centre.coords.amax()), centre }
    }

    fn around(primitive: &Primitive, pose: &Pose) -> Self {
        let radius = primitive.bounding_radius();
        Self {
            centre: Point::from(pose.translation.vector),
            radius: radius + FIT_SLACK * (radius + pose.translation.vector.amax()),
        }
    }

    fn lower_bound(&self, other: &Self, pose_ab: &Pose) -> f64 {
        let centre = pose_ab * other.centre;
        let reach = self.centre.coords.abs().sum()
            + other.centre.coords.abs().sum()
            + pose_ab.translation.vector.abs().sum();
        let gap = nalgebra::distance(&self.centre, &centre) - self.radius - other.radius;
        (gap - SEPARATION_SLACK * reach).max(0.0)
    }

    fn may_touch(&self, other: &Self, pose_ab: &Pose) -> bool {
        self.lower_bound(other, pose_ab) <= CONTACT_DISTANCE
    }

    fn size(&self) -> f64 {
        self.radius
    }
}
