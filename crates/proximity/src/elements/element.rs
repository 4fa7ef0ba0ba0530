//! A triangle or primitive as users pass it.

use clearance_geometry::math::Pose;
use clearance_geometry::{Primitive, Triangle};

/// A triangle of a surface, or a solid primitive, in the frame of its body.
#[derive(Clone, Debug, PartialEq)]
pub enum Element {
    /// A triangle.
    Triangle(Triangle),
    /// A solid primitive.
    Primitive {
        /// The primitive in its own frame.
        primitive: Primitive,
        /// Pose of the primitive in the frame of the body.
        pose: Pose,
    },
}
