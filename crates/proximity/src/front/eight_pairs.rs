//! Eight listed pairs of triangles, stored for the SIMD lanes of tests in f32.

use clearance_geometry::math::Point;
use clearance_geometry::simd::{LANES, Simd};

use super::listed_pair::ListedPair;
use crate::body::Surface;
use crate::bounding_volume::Relative;
use crate::elements::ElementId;
use crate::narrow_phase::LaneTriangles;

/// Their corners, each in the frame of its own tree.
#[repr(align(32))]
pub(super) struct EightPairs {
    a: [[[f32; LANES]; 3]; 3],
    b: [[[f32; LANES]; 3]; 3],
}

impl EightPairs {
    /// Of fewer than eight the last is repeated.
    #[inline]
    pub fn new(a: &Surface, b: &Surface, pairs: &[ListedPair]) -> Self {
        let mut all = Self { a: [[[0.0; LANES]; 3]; 3], b: [[[0.0; LANES]; 3]; 3] };
        for lane in 0..LANES {
            let elements = pairs[lane.min(pairs.len() - 1)].elements;
            set(&mut all.a, lane, a, elements.a);
            set(&mut all.b, lane, b, elements.b);
        }
        all
    }

    /// A point of body a, in the frame of b's tree.
    #[allow(clippy::cast_possible_truncation)] // rounding is meant
    #[inline]
    pub fn point_in_b(a: &Surface, relative: &Relative, point: &Point) -> [f32; 3] {
        let p = point - a.tree().anchor();
        relative.point(&[p.x as f32, p.y as f32, p.z as f32])
    }

    /// Both in the frame of b's tree.
    #[inline(always)]
    pub fn load<S: Simd>(&self, simd: S, relative: &Relative) -> (LaneTriangles<S>, LaneTriangles<S>) {
        (LaneTriangles::placed(simd, &self.a, relative), LaneTriangles::load(simd, &self.b))
    }
}

/// As the leaves of the surface's tree have them.
#[allow(clippy::cast_possible_truncation)] // rounding is meant
fn set(corners: &mut [[[f32; LANES]; 3]; 3], lane: usize, surface: &Surface, id: ElementId) {
    let anchor = surface.tree().anchor();
    for (corner, p) in corners.iter_mut().zip(surface.triangle(id.index()).corners()) {
        for i in 0..3 {
            corner[i][lane] = (p[i] - anchor[i]) as f32;
        }
    }
}
