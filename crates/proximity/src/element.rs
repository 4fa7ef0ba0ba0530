//! Elements: the convex parts of bodies.

use clearance_geometry::math::Pose;
use clearance_geometry::{Primitive, Triangle};

/// A triangle of a surface, or a solid primitive, in the frame of its body.
#[derive(Clone, Debug, PartialEq)]
pub enum Element {
    Triangle(Triangle),
    Primitive { primitive: Primitive, pose: Pose },
}

/// Reference to an element of a body, in the order of its trees: solids before triangles before planes before grains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct ElementNumber {
    kind: u32,
    index: u32,
}

impl ElementNumber {
    const SOLID: u32 = 0;
    const TRIANGLE: u32 = 1;
    const PLANE: u32 = 2;
    /// Index in the first set; the others follow.
    const GRAIN: u32 = 3;

    #[inline]
    pub const fn of_solid(index: u32) -> Self {
        Self { kind: Self::SOLID, index }
    }

    #[inline]
    pub const fn of_triangle(index: u32) -> Self {
        Self { kind: Self::TRIANGLE, index }
    }

    #[inline]
    pub const fn of_plane(index: u32) -> Self {
        Self { kind: Self::PLANE, index }
    }

    /// Element of one of the body's sets of grains.
    #[inline]
    pub const fn of_grain(set: u32, index: u32) -> Self {
        Self { kind: Self::GRAIN + set, index }
    }

    #[inline]
    pub const fn is_triangle(self) -> bool {
        self.kind == Self::TRIANGLE
    }

    /// Index among the elements of its kind.
    #[inline]
    pub const fn index(self) -> u32 {
        self.index
    }
}
