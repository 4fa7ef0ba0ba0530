//! Solid of a triangle mesh: the volume inside its closed surfaces, whatever the winding of their faces.
//!
//! A point is inside a mesh if any closed surface made of its faces winds around it (winding number: Jacobson, Kavan & Sorkine-Hornung
//! 2013). Faces count once, and may be reversed for this purpose. So a point that is inside by the winding of the file, or by any other,
//! is inside. A mesh whose faces occur in both windings, or whose shells are wound against each other, is as solid as a mesh without
//! errors. The only exception are cavities: shells wound inward, each wholly inside another and in contact with none.
//!
//! Assumption: a closed surface does not pass through itself such that it is inside out in one part and not in another, and these parts
//! overlap; in the overlap the winding number is 0.

mod cavities;
mod cycles;
mod inside_test;
mod patches;
mod remarks;
mod weld;
mod winding_tree;

use std::sync::OnceLock;

use crate::math::{Point, Vector};
use cavities::are_cavities;
use cycles::{Cycle, basis};
pub use inside_test::InsideTest;
use patches::Patches;
pub use remarks::SolidRemarks;
use remarks::wound_inward;
use weld::WeldedFaces;
use winding_tree::WindingTree;

/// The closed surfaces of a mesh.
#[derive(Clone, Debug)]
pub struct SolidMesh {
    surfaces: Vec<ClosedSurface>,
    remarks: SolidRemarks,
}

/// Triangles without a free edge, over the vertices of their mesh.
#[derive(Clone, Debug)]
pub struct ClosedSurface {
    triangles: Vec<[u32; 3]>,
    /// Smallest and largest corner of the box around them.
    bounds: [Point; 2],
    /// Built at the first use.
    tree: OnceLock<WindingTree>,
}

impl SolidMesh {
    pub(super) fn new(vertices: &[Point], triangles: &[[u32; 3]]) -> Self {
        let welded = WeldedFaces::new(vertices, triangles);
        let patches = Patches::new(&welded);
        let (mut cycles, is_tangled) = basis(&patches);
        let surface = |cycle: &mut Cycle| ClosedSurface::outward(vertices, &welded, &patches, cycle);
        let mut surfaces: Vec<ClosedSurface> = cycles.iter_mut().map(surface).collect();
        let mut remarks = SolidRemarks::new(triangles.len(), &welded, &patches, &cycles);
        remarks.is_tangled = is_tangled;
        let volumes: Vec<f64> = surfaces.iter().map(|surface| surface.volume(vertices)).collect();
        let inward = wound_inward(&welded, &patches, &cycles, &volumes);
        let inward_count = inward.iter().filter(|inward| **inward).count();
        if inward_count > 0 {
            let as_wound: Vec<ClosedSurface> =
                surfaces.iter().zip(&inward).map(|(surface, inward)| surface.wound(*inward)).collect();
            let are_shells = cycles.iter().all(|cycle| cycle.len() == 1);
            if are_shells && remarks.is_faultless() && are_cavities(vertices, &as_wound) {
                surfaces = vec![ClosedSurface::joined(&as_wound)];
                remarks.cavities = inward_count;
            } else {
                remarks.inward_shells = inward_count;
            }
        }
        Self { surfaces, remarks }
    }

    /// Closed surfaces; a point is inside if one of them winds around it.
    #[must_use]
    pub fn surfaces(&self) -> &[ClosedSurface] {
        &self.surfaces
    }

    /// Repairs and open parts of the mesh.
    #[must_use]
    pub fn remarks(&self) -> &SolidRemarks {
        &self.remarks
    }

    /// True if a point is inside; `vertices` are the mesh's. `cost` counts visited triangles and boxes.
    pub(super) fn contains(&self, vertices: &[Point], point: &Point, cost: &mut u64) -> bool {
        self.surfaces.iter().any(|surface| surface.winding_number(vertices, point, cost).abs() > 0.5)
    }

    /// True if a box certainly contains no part of a closed surface.
    fn is_clear(&self, vertices: &[Point], bounds: &[Point; 2], cost: &mut u64) -> bool {
        self.surfaces.iter().all(|surface| surface.tree(vertices).is_clear(vertices, bounds, cost))
    }

    /// Builds the data for point tests, so that the first costs no more than others.
    pub(super) fn prepare(&self, vertices: &[Point]) {
        for surface in &self.surfaces {
            surface.tree(vertices);
        }
    }
}

impl ClosedSurface {
    /// The surface of a cycle; both are reversed if they are not wound outward.
    fn outward(vertices: &[Point], welded: &WeldedFaces, patches: &Patches, cycle: &mut Cycle) -> Self {
        let faces = |&(patch, times): &(u32, i64)| {
            let faces = patches.faces[patch as usize].iter();
            faces.flat_map(move |&(face, turned)| {
                let [a, b, c] = welded.corners[face as usize];
                let triangle = if turned == (times > 0) { [a, c, b] } else { [a, b, c] };
                (0..times.unsigned_abs()).map(move |_| triangle)
            })
        };
        let mut surface = Self::around(vertices, cycle.iter().flat_map(faces).collect());
        if surface.volume(vertices) < 0.0 {
            for (_, times) in cycle.iter_mut() {
                *times = -*times;
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
    fn wound(&self, turned: bool) -> Self {
        let mut triangles = self.triangles.clone();
        if turned {
            for t in &mut triangles {
                t.swap(1, 2);
            }
        }
        Self { triangles, bounds: self.bounds, tree: OnceLock::new() }
    }

    fn joined(surfaces: &[Self]) -> Self {
        let triangles = surfaces.iter().flat_map(|surface| surface.triangles.iter().copied()).collect();
        let bounds = surfaces.iter().map(|surface| surface.bounds);
        let bounds = bounds.reduce(|a, b| [a[0].inf(&b[0]), a[1].sup(&b[1])]).expect("there are surfaces");
        Self { triangles, bounds, tree: OnceLock::new() }
    }

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
    fn volume(&self, vertices: &[Point]) -> f64 {
        let apex = self.bounds[0];
        let six_times = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| vertices[v as usize] - apex);
            a.dot(&b.cross(&c))
        };
        self.triangles.iter().map(six_times).sum::<f64>() / 6.0
    }

    fn tree(&self, vertices: &[Point]) -> &WindingTree {
        self.tree.get_or_init(|| WindingTree::new(vertices, &self.triangles))
    }

    /// Winding number of the surface around a point: the sum of the triangles' solid angles over 4π.
    fn winding_number(&self, vertices: &[Point], point: &Point, cost: &mut u64) -> f64 {
        let [low, high] = &self.bounds;
        if (0..3).all(|i| (low[i]..=high[i]).contains(&point[i])) {
            self.tree(vertices).winding_number(vertices, point, cost)
        } else {
            0.0
        }
    }
}

/// Half the solid angle of a triangle, from the vectors from a point to its corners (van Oosterom & Strackee 1983).
fn half_angle([a, b, c]: [Vector; 3]) -> f64 {
    let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
    let below = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
    a.dot(&b.cross(&c)).atan2(below)
}

#[cfg(test)]
mod tests;
