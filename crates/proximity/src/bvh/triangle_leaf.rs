//! Leaf with up to eight triangles, in f32.

use clearance_geometry::math::{Extremes, Point, RotationMatrix};
use clearance_geometry::simd::LANES;

use super::tree::Content;

/// Triangles of a surface by their corners, as structure of arrays, relative to the anchor of their tree. Unused lanes repeat the last
/// triangle.
#[derive(Clone, Debug)]
#[repr(align(32))]
pub struct TriangleLeaf {
    /// By corner, coordinate and triangle.
    pub corners: [[[f32; LANES]; 3]; 3],
    /// The box around the triangles, along the axes of the tree.
    pub low: [f32; 3],
    pub high: [f32; 3],
    /// Index of the first triangle in the order of the tree; the others follow.
    pub first: u32,
    pub count: u32,
}

impl Content for TriangleLeaf {
    type Item = [Point; 3];

    const CAPACITY: usize = LANES;

    fn corners(item: &[Point; 3], corners: &mut Vec<Point>) {
        corners.extend_from_slice(item);
    }

    fn axes(_: &[&[Point; 3]]) -> Option<RotationMatrix> {
        None
    }

    #[allow(clippy::cast_possible_truncation)] // rounding is meant; a leaf has few triangles
    fn new(anchor: &Point, first: u32, triangles: &[&[Point; 3]]) -> Self {
        let number = |corner: usize, i: usize, lane: usize| {
            let triangle = triangles[lane.min(triangles.len() - 1)];
            (triangle[corner][i] - anchor[i]) as f32
        };
        let corners = std::array::from_fn(|corner| {
            std::array::from_fn(|i| std::array::from_fn(|lane| number(corner, i, lane)))
        });
        let along = |i: usize| corners.iter().flat_map(move |c: &[[f32; LANES]; 3]| c[i]);
        Self {
            low: std::array::from_fn(|i| along(i).fold(f32::INFINITY, f32::lesser)),
            high: std::array::from_fn(|i| along(i).fold(f32::NEG_INFINITY, f32::greater)),
            corners,
            first,
            count: triangles.len() as u32,
        }
    }
}

impl TriangleLeaf {
    /// Bit mask of the triangles.
    #[inline(always)]
    #[must_use]
    pub fn mask(&self) -> u64 {
        (1 << self.count) - 1
    }
}
