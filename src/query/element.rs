//! The convex things that bodies are made of.

use crate::geometry::{Primitive, Triangle};
use crate::math::Pose;

/// A triangle of a surface, or a solid primitive, in the frame of its body.
#[derive(Clone, Debug, PartialEq)]
pub enum Element {
    Triangle(Triangle),
    Primitive { primitive: Primitive, pose: Pose },
}

/// Which element of a body, in the orders of its trees: solids before triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct ElementNumber(u32);

impl ElementNumber {
    const TRIANGLE: u32 = 1 << 31;

    pub const fn of_solid(index: u32) -> Self {
        Self(index)
    }

    pub const fn of_triangle(index: u32) -> Self {
        Self(index | Self::TRIANGLE)
    }

    pub const fn is_triangle(self) -> bool {
        self.0 & Self::TRIANGLE != 0
    }

    /// Among those of its kind.
    pub const fn index(self) -> u32 {
        self.0 & !Self::TRIANGLE
    }
}
