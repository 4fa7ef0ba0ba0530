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
mod closed_surface;
mod cycles;
mod patches;
mod remarks;
mod weld;
mod winding_tree;

use crate::math::Point;
use cavities::are_cavities;
pub use closed_surface::ClosedSurface;
use cycles::{Cycle, basis};
use patches::Patches;
pub use remarks::SolidRemarks;
use remarks::wound_inward;
use weld::WeldedFaces;

/// The closed surfaces of a mesh.
#[derive(Clone, Debug)]
pub struct SolidMesh {
    surfaces: Vec<ClosedSurface>,
    remarks: SolidRemarks,
}

impl SolidMesh {
    pub(super) fn new(vertices: &[Point], triangles: &[[u32; 3]]) -> Self {
        let welded = WeldedFaces::new(vertices, triangles);
        let patches = Patches::new(&welded);
        let (mut cycles, is_tangled) = basis(&patches);
        let surface = |cycle: &mut Cycle| ClosedSurface::outward(vertices, &welded, &patches, cycle);
        let mut surfaces: Vec<ClosedSurface> = cycles.iter_mut().map(surface).collect();
        let mut remarks = SolidRemarks::new(triangles.len(), &welded, &patches, &cycles, is_tangled);
        let volumes: Vec<f64> = surfaces.iter().map(|surface| surface.volume(vertices)).collect();
        let inward = wound_inward(&welded, &patches, &cycles, &volumes);
        let inward_count = inward.iter().filter(|inward| **inward).count();
        if inward_count > 0 {
            let as_wound: Vec<ClosedSurface> =
                surfaces.iter().zip(&inward).map(|(surface, inward)| surface.wound(*inward)).collect();
            let are_shells = cycles.iter().all(|cycle| cycle.len() == 1);
            if are_shells && remarks.is_faultless() && are_cavities(vertices, &as_wound) {
                surfaces = vec![ClosedSurface::joined(&as_wound)];
                remarks.note_cavities(inward_count);
            } else {
                remarks.note_inward_shells(inward_count);
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
    pub(super) fn is_clear(&self, vertices: &[Point], bounds: &[Point; 2], cost: &mut u64) -> bool {
        self.surfaces.iter().all(|surface| surface.is_clear(vertices, bounds, cost))
    }

    /// Builds the data for point tests, so that the first costs no more than others.
    pub(super) fn prepare(&self, vertices: &[Point]) {
        for surface in &self.surfaces {
            surface.prepare(vertices);
        }
    }
}

#[cfg(test)]
mod tests;
