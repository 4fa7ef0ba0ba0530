//! The convex things at the leaves.

use crate::bounding_volume::{BoundingVolume, Obb};
use crate::geometry::{Primitive, Triangle};
use crate::math::{Point, Pose};

/// A triangle of a surface, or a solid primitive, in the frame of its body.
#[derive(Clone, Debug, PartialEq)]
pub enum Element {
    Triangle(Triangle),
    Primitive { primitive: Primitive, pose: Pose },
}

impl Element {
    /// Points whose convex hull holds the element.
    pub fn hull_points(&self, points: &mut Vec<Point>) {
        match self {
            Self::Triangle(t) => points.extend(t.corners()),
            Self::Primitive { primitive, pose } => {
                points.extend(Obb::around(primitive, pose).corners());
            }
        }
    }

    /// The point by which elements are sorted to one side or the other.
    #[must_use]
    pub fn middle(&self) -> Point {
        match self {
            Self::Triangle(t) => Point::from((t.a.coords + t.b.coords + t.c.coords) / 3.0),
            Self::Primitive { pose, .. } => Point::from(pose.translation.vector),
        }
    }
}
