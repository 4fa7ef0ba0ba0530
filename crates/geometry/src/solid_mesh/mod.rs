//! Solid of a triangle mesh: the volume inside its closed surfaces, whatever the winding of their faces.
//!
//! A point is inside a mesh if any closed surface made of its faces winds around it (winding number: Jacobson, Kavan & Sorkine-Hornung
//! 2013). Faces count once, and may be reversed for this purpose. So a point that is inside by the winding of the file, or by any other,
//! is inside. A mesh whose faces occur in both windings, or whose shells are wound against each other, is as solid as a mesh without
//! errors. The only exception are cavities: shells wound inward, each wholly inside another and in contact with none.
//!
//! Assumption: a closed surface does not pass through itself such that it is inside out in one part and not in another, and these parts
//! overlap; in the overlap the winding number is 0.

mod angle_sum;
mod cavities;
mod closed_surface;
mod cycles;
mod far_field;
mod inside_grid;
mod inside_work;
mod moments;
mod patches;
mod region_octree;
mod remarks;
mod welded_faces;
mod winding_tree;

use std::sync::{Arc, OnceLock};

use crate::math::Point;
use cavities::are_cavities;
pub use closed_surface::ClosedSurface;
use cycles::{Cycle, basis};
pub use inside_grid::InsideGrid;
pub use inside_work::InsideWork;
use patches::Patches;
use region_octree::{Region, RegionOctree};
pub use remarks::SolidRemarks;
use remarks::wound_inward;
use welded_faces::WeldedFaces;

/// The closed surfaces of a mesh.
#[derive(Clone, Debug)]
pub struct SolidMesh {
    surfaces: Vec<ClosedSurface>,
    remarks: SolidRemarks,
    /// Built at the first use; `None` without closed surfaces.
    regions: OnceLock<Option<RegionOctree>>,
    /// As `regions`.
    inside_grid: OnceLock<Option<Arc<InsideGrid>>>,
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
        Self { surfaces, remarks, regions: OnceLock::new(), inside_grid: OnceLock::new() }
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

    /// A grid over the box around the mesh, of the cells with points inside; `vertices` are the mesh's.
    pub(super) fn inside_grid(&self, vertices: &[Point]) -> Option<&Arc<InsideGrid>> {
        let build = || self.regions(vertices).map(|regions| Arc::new(InsideGrid::new(regions)));
        self.inside_grid.get_or_init(build).as_ref()
    }

    /// A point well inside, if one is known; `vertices` are the mesh's.
    pub(super) fn inner_point(&self, vertices: &[Point]) -> Option<Point> {
        self.regions(vertices)?.inner_point()
    }

    /// True if a point is inside; `vertices` are the mesh's.
    pub(super) fn contains(&self, vertices: &[Point], point: &Point, work: &mut InsideWork) -> bool {
        self.known(vertices, point, work).unwrap_or_else(|| self.winds_around(vertices, point, work))
    }

    /// True if a point is inside, false if not; `None` if it is too near a face to tell without a winding number.
    pub(super) fn known(&self, vertices: &[Point], point: &Point, work: &mut InsideWork) -> Option<bool> {
        work.visited += 1;
        match self.regions(vertices).map_or(Region::Outside, |regions| regions.region(point)) {
            Region::Outside => Some(false),
            Region::Inside => Some(true),
            Region::Boundary => None,
        }
    }

    /// True if a closed surface winds around a point.
    pub(super) fn winds_around(&self, vertices: &[Point], point: &Point, work: &mut InsideWork) -> bool {
        work.winding_numbers += 1;
        self.surfaces.iter().any(|surface| surface.winds_around(vertices, point, work))
    }

    /// True if a box certainly contains no part of a closed surface.
    pub(super) fn is_clear(&self, vertices: &[Point], bounds: &[Point; 2], work: &mut InsideWork) -> bool {
        self.surfaces.iter().all(|surface| surface.is_clear(vertices, bounds, work))
    }

    fn regions(&self, vertices: &[Point]) -> Option<&RegionOctree> {
        let build = || {
            let bounds = self.surfaces.iter().map(|surface| *surface.bounds());
            let bounds = bounds.reduce(|a, b| [a[0].inf(&b[0]), a[1].sup(&b[1])])?;
            let faces = self.surfaces.iter().map(|surface| surface.triangles().len()).sum();
            let is_clear = |cell: &[Point; 2]| self.is_clear(vertices, cell, &mut InsideWork::default());
            let is_inside = |point: &Point| self.winds_around(vertices, point, &mut InsideWork::default());
            Some(RegionOctree::new(bounds, faces, is_clear, is_inside))
        };
        self.regions.get_or_init(build).as_ref()
    }

    /// Builds the data for point tests, so that the first costs no more than others.
    pub(super) fn prepare(&self, vertices: &[Point]) {
        for surface in &self.surfaces {
            surface.prepare(vertices);
        }
        self.regions(vertices);
    }
}

#[cfg(test)]
mod tests;
