//! The convex things that bodies are made of.

use crate::geometry::{Primitive, Triangle};
use crate::math::Pose;

/// A triangle of a surface, or a solid primitive, in the frame of its body.
#[derive(Clone, Debug, PartialEq)]
pub enum Element {
    Triangle(Triangle),
    Primitive { primitive: Primitive, pose: Pose },
}
