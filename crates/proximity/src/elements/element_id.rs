//! Identifiers of the elements of a body, by kind and index, and pairs of them.

/// Reference to an element of a body, in the order of its trees: solids before triangles before planes before cubes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct ElementId {
    kind: u32,
    index: u32,
}

impl ElementId {
    const SOLID: u32 = 0;
    const TRIANGLE: u32 = 1;
    const PLANE: u32 = 2;
    /// Index in the first set; the others follow.
    const CUBE: u32 = 3;

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

    /// Element of one of the body's sets of cubes.
    #[inline]
    pub const fn of_cube(set: u32, index: u32) -> Self {
        Self { kind: Self::CUBE + set, index }
    }

    #[inline]
    pub const fn is_triangle(self) -> bool {
        self.kind == Self::TRIANGLE
    }

    #[inline]
    pub const fn is_plane(self) -> bool {
        self.kind == Self::PLANE
    }

    /// Number of the set that a cube belongs to; `None` for other elements.
    #[inline]
    pub const fn cube_set(self) -> Option<usize> {
        if self.kind < Self::CUBE { None } else { Some((self.kind - Self::CUBE) as usize) }
    }

    /// Index among the elements of its kind.
    #[inline]
    pub const fn index(self) -> u32 {
        self.index
    }
}

/// The identifiers of two measured elements, one of each body; they decide which of equally near pairs is reported.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ElementPair {
    pub(crate) a: ElementId,
    pub(crate) b: ElementId,
}

impl ElementPair {
    /// The pair of an element of one body and an element of the other, in the order of the bodies.
    #[inline]
    pub(crate) fn ordered(own: ElementId, other: ElementId, own_is_a: bool) -> Self {
        if own_is_a { Self { a: own, b: other } } else { Self { a: other, b: own } }
    }
}
