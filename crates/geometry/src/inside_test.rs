//! Inside test of many points against a mesh.

use crate::math::Point;
use crate::mesh::TriangleMesh;

/// Tests points in sequence. Points in a common box that contains no face have the same result, so a cloud beside a mesh needs only few
/// winding numbers. Results are those of [`TriangleMesh::encloses`].
#[derive(Debug)]
pub struct InsideTest<'m> {
    mesh: &'m TriangleMesh,
    /// A box that contains no face, and whether it is inside.
    clear: Option<([Point; 2], bool)>,
    cost: u64,
}

impl<'m> InsideTest<'m> {
    /// A test of many points against `mesh`.
    #[must_use]
    pub fn new(mesh: &'m TriangleMesh) -> Self {
        Self { mesh, clear: None, cost: 0 }
    }

    /// True if a point is inside the mesh as a solid.
    pub fn encloses(&mut self, point: &Point) -> bool {
        let (solid, vertices) = (self.mesh.solid(), self.mesh.vertices());
        self.cost += 1;
        if let Some((bounds, is_inside)) = &mut self.clear {
            let grown = [bounds[0].inf(point), bounds[1].sup(point)];
            if grown == *bounds || solid.is_clear(vertices, &grown, &mut self.cost) {
                *bounds = grown;
                return *is_inside;
            }
        }
        let is_inside = solid.contains(vertices, point, &mut self.cost);
        let own = [*point; 2];
        self.clear = solid.is_clear(vertices, &own, &mut self.cost).then_some((own, is_inside));
        is_inside
    }

    /// Number of triangles and boxes visited since the last call.
    pub fn take_cost(&mut self) -> u64 {
        std::mem::take(&mut self.cost)
    }
}
