//! Inside test of many points against one mesh; successive points share results.

use crate::InsideWork;
use crate::math::Point;
use crate::mesh::TriangleMesh;

/// Tests points in sequence. Points in a common box that contains no face have the same result, so a cloud beside a mesh needs only few
/// winding numbers. Results are those of [`TriangleMesh::encloses`].
#[derive(Debug)]
pub struct InsideTest<'m> {
    mesh: &'m TriangleMesh,
    /// A box that contains no face, and whether it is inside.
    clear: Option<([Point; 2], bool)>,
    work: InsideWork,
}

impl<'m> InsideTest<'m> {
    /// A test of many points against `mesh`.
    #[must_use]
    pub fn new(mesh: &'m TriangleMesh) -> Self {
        Self { mesh, clear: None, work: InsideWork::default() }
    }

    /// True if a point is inside the mesh as a solid.
    pub fn encloses(&mut self, point: &Point) -> bool {
        let Self { mesh, clear, work } = self;
        let (solid, vertices) = (mesh.solid(), mesh.vertices());
        if let Some(is_inside) = solid.known(vertices, point, work) {
            return is_inside;
        }
        if let Some((bounds, is_inside)) = clear {
            let grown = [bounds[0].inf(point), bounds[1].sup(point)];
            if grown == *bounds || solid.is_clear(vertices, &grown, work) {
                *bounds = grown;
                return *is_inside;
            }
        }
        let is_inside = solid.winds_around(vertices, point, work);
        let own = [*point; 2];
        *clear = solid.is_clear(vertices, &own, work).then_some((own, is_inside));
        is_inside
    }

    /// Number of steps since the last call.
    pub fn take_work(&mut self) -> InsideWork {
        std::mem::take(&mut self.work)
    }
}
