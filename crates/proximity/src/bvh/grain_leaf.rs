//! Leaf with up to eight points or cubes (grains), in f32.

use clearance_geometry::math::{Extremes, Point, Vector};
use clearance_geometry::simd::LANES;

/// A cube along the axes of its tree, or a point, which is a cube of size zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grain {
    pub centre: [f32; 3],
    pub half_edge: f32,
}

/// Grains by their centres, as structure of arrays, relative to the anchor of their tree. Unused lanes repeat the last grain.
#[derive(Clone, Debug)]
#[repr(align(32))]
pub struct GrainLeaf {
    /// By coordinate and grain.
    pub centre: [[f32; LANES]; 3],
    pub half_edge: [f32; LANES],
    /// The box around them.
    pub low: [f32; 3],
    pub high: [f32; 3],
    /// Index of the first grain in the order of the tree; the others follow.
    pub first: u32,
    pub count: u32,
}

impl GrainLeaf {
    /// A leaf with some grains of a tree with this anchor.
    #[allow(clippy::cast_possible_truncation)] // rounding is meant; a leaf has few grains
    #[inline]
    pub(super) fn new(anchor: &Point, first: u32, grains: &[Grain]) -> Self {
        let grain = |lane: usize| &grains[lane.min(grains.len() - 1)];
        let centre: [[f32; LANES]; 3] = std::array::from_fn(|i| {
            std::array::from_fn(|lane| (f64::from(grain(lane).centre[i]) - anchor[i]) as f32)
        });
        Self {
            half_edge: std::array::from_fn(|lane| grain(lane).half_edge),
            low: std::array::from_fn(|i| {
                let lowest = |lane: usize| centre[i][lane] - grain(lane).half_edge;
                (0..LANES).map(lowest).fold(f32::INFINITY, f32::lesser)
            }),
            high: std::array::from_fn(|i| {
                let highest = |lane: usize| centre[i][lane] + grain(lane).half_edge;
                (0..LANES).map(highest).fold(f32::NEG_INFINITY, f32::greater)
            }),
            centre,
            first,
            count: grains.len() as u32,
        }
    }

    /// Bit mask of the grains.
    #[inline(always)]
    #[must_use]
    pub fn mask(&self) -> u64 {
        (1 << self.count) - 1
    }
}

impl Grain {
    /// Smallest and largest corner, from an anchor.
    #[inline]
    pub(super) fn corners(&self, anchor: &Point) -> [Vector; 2] {
        let centre = Vector::from(self.centre.map(f64::from)) - anchor.coords;
        let half = Vector::repeat(f64::from(self.half_edge));
        [centre - half, centre + half]
    }
}
