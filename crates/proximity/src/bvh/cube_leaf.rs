//! Leaf with up to eight cubes, in f32.

use clearance_geometry::Cube;
use clearance_geometry::math::{Extremes, Point, Vector};
use clearance_geometry::simd::LANES;

/// Cubes by their centres, as structure of arrays, relative to the anchor of their tree. Unused lanes repeat the last cube.
#[derive(Clone, Debug)]
#[repr(align(32))]
pub struct CubeLeaf {
    /// By coordinate and cube.
    pub centre: [[f32; LANES]; 3],
    pub half_edge: [f32; LANES],
    /// The box around them.
    pub low: [f32; 3],
    pub high: [f32; 3],
    /// Index of the first cube in the order of the tree; the others follow.
    pub first: u32,
    pub count: u32,
}

impl CubeLeaf {
    /// A leaf with some cubes of a tree with this anchor.
    #[allow(clippy::cast_possible_truncation)] // rounding is meant; a leaf has few cubes
    #[inline]
    pub(super) fn new(anchor: &Point, first: u32, cubes: &[Cube]) -> Self {
        let cube = |lane: usize| &cubes[lane.min(cubes.len() - 1)];
        let centre: [[f32; LANES]; 3] = std::array::from_fn(|i| {
            std::array::from_fn(|lane| (f64::from(cube(lane).centre[i]) - anchor[i]) as f32)
        });
        Self {
            half_edge: std::array::from_fn(|lane| cube(lane).half_edge),
            low: std::array::from_fn(|i| {
                let lowest = |lane: usize| centre[i][lane] - cube(lane).half_edge;
                (0..LANES).map(lowest).fold(f32::INFINITY, f32::lesser)
            }),
            high: std::array::from_fn(|i| {
                let highest = |lane: usize| centre[i][lane] + cube(lane).half_edge;
                (0..LANES).map(highest).fold(f32::NEG_INFINITY, f32::greater)
            }),
            centre,
            first,
            count: cubes.len() as u32,
        }
    }

    /// Bit mask of the cubes.
    #[inline(always)]
    #[must_use]
    pub fn mask(&self) -> u64 {
        (1 << self.count) - 1
    }
}

/// Smallest and largest corner of a cube, from an anchor.
#[inline]
pub(super) fn corners_of(cube: &Cube, anchor: &Point) -> [Vector; 2] {
    let centre = Vector::from(cube.centre.map(f64::from)) - anchor.coords;
    let half = Vector::repeat(f64::from(cube.half_edge));
    [centre - half, centre + half]
}
