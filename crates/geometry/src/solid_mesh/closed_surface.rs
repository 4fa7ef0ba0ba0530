//! A closed surface made of faces of a mesh.

use std::sync::OnceLock;

use super::cycles::Cycle;
use super::inside_work::InsideWork;
use super::patches::{OrientedFace, PatchMultiple, Patches};
use super::welded_faces::WeldedFaces;
use super::winding_tree::{WindingNumber, WindingTree, half_solid_angle};
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

    /// The surface of triangles without a free edge.
    pub(super) fn around(vertices: &[Point], triangles: Vec<[u32; 3]>) -> Self {
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
    pub(super) fn is_clear(&self, vertices: &[Point], bounds: &[Point; 2], work: &mut InsideWork) -> bool {
        self.tree(vertices).is_clear(vertices, bounds, work)
    }

    fn tree(&self, vertices: &[Point]) -> &WindingTree {
        self.tree.get_or_init(|| WindingTree::new(vertices, &self.triangles))
    }

    /// True if the winding number of the surface around a point is not 0. For a point of the surface itself, where it is no integer, the
    /// sum over all triangles decides: true above one half.
    pub(super) fn winds_around(&self, vertices: &[Point], point: &Point, work: &mut InsideWork) -> bool {
        let decision = |WindingNumber { value, error }: WindingNumber| {
            ((value.abs() - 0.5).abs() > error).then_some(value.abs() > 0.5)
        };
        self.is_in_bounds(point)
            && (self.tree(vertices).decide(vertices, point, work, decision))
                .unwrap_or_else(|| self.sum_of_angles(vertices, point, work).abs() > 0.5)
    }

    /// Winding number of the surface around a point that is not of the surface.
    pub(super) fn winding_number(&self, vertices: &[Point], point: &Point) -> f64 {
        if !self.is_in_bounds(point) {
            return 0.0;
        }
        let work = &mut InsideWork::default();
        let decision = |WindingNumber { value, error }: WindingNumber| (error < 0.5).then_some(value.round());
        let decided = self.tree(vertices).decide(vertices, point, work, decision);
        decided.unwrap_or_else(|| self.sum_of_angles(vertices, point, work).round())
    }

    fn is_in_bounds(&self, point: &Point) -> bool {
        let [low, high] = &self.bounds;
        (0..3).all(|i| (low[i]..=high[i]).contains(&point[i]))
    }

    /// Winding number by the solid angles of all triangles.
    pub(super) fn sum_of_angles(&self, vertices: &[Point], point: &Point, work: &mut InsideWork) -> f64 {
        work.visited += self.triangles.len() as u64;
        let half_angles = self.triangles.iter().map(|t| half_solid_angle(vertices, t, point));
        half_angles.sum::<f64>() / std::f64::consts::TAU
    }
}
