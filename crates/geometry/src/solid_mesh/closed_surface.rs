//! A closed surface made of faces of a mesh.

use std::sync::OnceLock;

use super::cycles::Cycle;
use super::patches::{OrientedFace, PatchMultiple, Patches};
use super::weld::WeldedFaces;
use super::winding_tree::WindingTree;
use crate::math::Point;

/// Triangles without a free edge, over the vertices of their mesh.
#[derive(Clone, Debug)]
pub struct ClosedSurface {
    triangles: Vec<[u32; 3]>,
    /// Smallest and largest corner of the box around them.
    bounds: [Point; 2],
    /// Built at the first use.
    tree: OnceLock<WindingTree>,
}

impl ClosedSurface {
    /// The surface of a cycle; both are reversed if they are not wound outward.
    pub(super) fn outward(
        vertices: &[Point],
        welded: &WeldedFaces,
        patches: &Patches,
        cycle: &mut Cycle,
    ) -> Self {
        let faces = |&PatchMultiple { patch, times }: &PatchMultiple| {
            let faces = patches.faces[patch as usize].iter();
            faces.flat_map(move |&OrientedFace { face, is_reversed }| {
                let [a, b, c] = welded.corners[face as usize];
                let triangle = if is_reversed == (times > 0) { [a, c, b] } else { [a, b, c] };
                (0..times.unsigned_abs()).map(move |_| triangle)
            })
        };
        let mut surface = Self::around(vertices, cycle.iter().flat_map(faces).collect());
        if surface.volume(vertices) < 0.0 {
            for multiple in cycle.iter_mut() {
                multiple.times = -multiple.times;
            }
            surface = surface.wound(true);
        }
        surface
    }

    fn around(vertices: &[Point], triangles: Vec<[u32; 3]>) -> Self {
        let at = |v: &u32| vertices[*v as usize];
        let mut bounds = [at(&triangles[0][0]); 2];
        for p in triangles.iter().flatten().map(at) {
            bounds = [bounds[0].inf(&p), bounds[1].sup(&p)];
        }
        Self { triangles, bounds, tree: OnceLock::new() }
    }

    /// The same surface, reversed if requested.
    pub(super) fn wound(&self, turned: bool) -> Self {
        let mut triangles = self.triangles.clone();
        if turned {
            for t in &mut triangles {
                t.swap(1, 2);
            }
        }
        Self { triangles, bounds: self.bounds, tree: OnceLock::new() }
    }

    pub(super) fn joined(surfaces: &[Self]) -> Self {
        let triangles = surfaces.iter().flat_map(|surface| surface.triangles.iter().copied()).collect();
        let bounds = surfaces.iter().map(|surface| surface.bounds);
        let bounds = bounds.reduce(|a, b| [a[0].inf(&b[0]), a[1].sup(&b[1])]).expect("there are surfaces");
        Self { triangles, bounds, tree: OnceLock::new() }
    }

    /// Vertex indices of each triangle, wound outward.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Smallest and largest corner of the box around the surface.
    #[must_use]
    pub fn bounds(&self) -> &[Point; 2] {
        &self.bounds
    }

    /// Signed volume (m³) by the divergence theorem, with cones from a point of the surface: the accuracy does not depend on the distance
    /// from the origin.
    pub(super) fn volume(&self, vertices: &[Point]) -> f64 {
        let apex = self.bounds[0];
        let six_times = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| vertices[v as usize] - apex);
            a.dot(&b.cross(&c))
        };
        self.triangles.iter().map(six_times).sum::<f64>() / 6.0
    }

    /// Builds the data for point tests.
    pub(super) fn prepare(&self, vertices: &[Point]) {
        self.tree(vertices);
    }

    /// True if a box certainly contains no part of the surface.
    pub(super) fn is_clear(&self, vertices: &[Point], bounds: &[Point; 2], cost: &mut u64) -> bool {
        self.tree(vertices).is_clear(vertices, bounds, cost)
    }

    fn tree(&self, vertices: &[Point]) -> &WindingTree {
        self.tree.get_or_init(|| WindingTree::new(vertices, &self.triangles))
    }

    /// Winding number of the surface around a point: the sum of the triangles' solid angles over 4π.
    pub(super) fn winding_number(&self, vertices: &[Point], point: &Point, cost: &mut u64) -> f64 {
        let [low, high] = &self.bounds;
        if (0..3).all(|i| (low[i]..=high[i]).contains(&point[i])) {
            self.tree(vertices).winding_number(vertices, point, cost)
        } else {
            0.0
        }
    }
}
