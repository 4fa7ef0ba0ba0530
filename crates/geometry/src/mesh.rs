//! Triangle meshes, validated at construction: every index is in range, every coordinate finite.

use std::sync::{Arc, OnceLock};

use super::connected_parts::part_vertices;
use super::{InsideGrid, InsideWork, SolidMesh, Triangle, WeldedMesh};
use crate::constants::LARGEST_COORDINATE;
use crate::math::{Point, Vector};

/// A set of triangles over shared vertices, in metres, in its own frame. Never empty.
#[derive(Clone, Debug)]
pub struct TriangleMesh {
    vertices: Vec<Point>,
    triangles: Vec<[u32; 3]>,
    /// Computed at the first use, since it needs a sort of all edges.
    solid: OnceLock<Arc<SolidMesh>>,
}

impl PartialEq for TriangleMesh {
    fn eq(&self, other: &Self) -> bool {
        self.vertices == other.vertices && self.triangles == other.triangles
    }
}

/// Reason why a list of vertices and faces is not a valid mesh.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MeshError {
    /// There are no faces.
    #[error("the mesh has no triangles")]
    NoTriangles,
    /// A face names a vertex that does not exist.
    #[error("triangle {triangle} names vertex {vertex}, but there are {vertices} vertices")]
    IndexOutOfRange {
        /// Index of the triangle.
        triangle: usize,
        /// Index of the vertex that does not exist.
        vertex: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// A coordinate is not finite or larger than [`LARGEST_COORDINATE`].
    #[error("vertex {vertex} has a coordinate that is not finite or larger than {LARGEST_COORDINATE} m")]
    BadVertex {
        /// Index of the vertex.
        vertex: usize,
    },
    /// There are more vertices than 32-bit indices can name.
    #[error("the mesh has {0} vertices, more than 32-bit indices can name")]
    TooManyVertices(usize),
}

impl TriangleMesh {
    /// A mesh of vertices (m) and triangles of three vertex indices each; rejects invalid input.
    pub fn new(vertices: Vec<Point>, triangles: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        if triangles.is_empty() {
            return Err(MeshError::NoTriangles);
        }
        if u32::try_from(vertices.len()).is_err() {
            return Err(MeshError::TooManyVertices(vertices.len()));
        }
        for (triangle, corners) in triangles.iter().enumerate() {
            for &vertex in corners {
                if vertex as usize >= vertices.len() {
                    return Err(MeshError::IndexOutOfRange { triangle, vertex, vertices: vertices.len() });
                }
            }
        }
        let usable = |p: &Point| p.iter().all(|c| c.abs() <= LARGEST_COORDINATE);
        match vertices.iter().position(|p| !usable(p)) {
            Some(vertex) => Err(MeshError::BadVertex { vertex }),
            None => Ok(Self { vertices, triangles, solid: OnceLock::new() }),
        }
    }

    /// All vertices (m), used or not.
    #[must_use]
    pub fn vertices(&self) -> &[Point] {
        &self.vertices
    }

    /// Vertex indices of each triangle.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The corners of triangle number `index`.
    #[must_use]
    pub fn triangle(&self, index: usize) -> Triangle {
        let [a, b, c] = self.triangles[index].map(|v| self.vertices[v as usize]);
        Triangle { a, b, c }
    }

    /// The mesh scaled along its axes. An odd number of negative factors mirrors it, and reverses the winding so that outward faces stay
    /// outward.
    pub fn scaled(mut self, factors: Vector) -> Result<Self, MeshError> {
        for p in &mut self.vertices {
            p.coords.component_mul_assign(&factors);
        }
        if factors.iter().filter(|f| f.is_sign_negative()).count() % 2 == 1 {
            for t in &mut self.triangles {
                t.swap(1, 2);
            }
        }
        Self::new(self.vertices, self.triangles)
    }

    /// The mesh scaled by a factor about the mean of all vertices, used or not.
    #[allow(clippy::cast_precision_loss)] // a mean needs no more than 52 bits of the count
    pub fn scaled_about_mean(&self, factor: f64) -> Result<Self, MeshError> {
        let mean = self.vertices.iter().map(|p| p.coords).sum::<Vector>() / self.vertices.len() as f64;
        let grown = self.vertices.iter().map(|p| Point::from(mean + (p.coords - mean) * factor));
        Self::new(grown.collect(), self.triangles.clone())
    }

    /// Smallest and largest corner of the axis-aligned bounding box of the vertices that triangles use.
    #[must_use]
    pub fn bounds(&self) -> (Point, Point) {
        let mut lo = Point::from([f64::INFINITY; 3]);
        let mut hi = Point::from([f64::NEG_INFINITY; 3]);
        for &v in self.triangles.iter().flatten() {
            let p = self.vertices[v as usize];
            lo = lo.inf(&p);
            hi = hi.sup(&p);
        }
        (lo, hi)
    }

    /// Signed volume (m³) by the divergence theorem: positive when a closed mesh is wound outward.
    #[must_use]
    pub fn signed_volume(&self) -> f64 {
        (0..self.triangles.len())
            .map(|i| {
                let t = self.triangle(i);
                t.a.coords.dot(&t.b.coords.cross(&t.c.coords)) / 6.0
            })
            .sum()
    }

    /// Number of triangles without area.
    #[must_use]
    pub fn degenerate_triangles(&self) -> usize {
        (0..self.triangles.len()).filter(|&i| self.triangle(i).normal() == Vector::zeros()).count()
    }

    /// The closed surfaces of the mesh.
    #[must_use]
    pub fn solid(&self) -> &SolidMesh {
        self.solid.get_or_init(|| Arc::new(SolidMesh::new(&self.vertices, &self.triangles)))
    }

    /// Whether a point is inside the mesh as a solid; open parts have no inside.
    #[must_use]
    pub fn encloses(&self, point: &Point) -> bool {
        self.solid().contains(&self.vertices, point, &mut InsideWork::default())
    }

    /// A vertex of each connected part (m). Parts are connected where corners have the same position.
    #[must_use]
    pub fn part_points(&self) -> Vec<Point> {
        self.part_vertices().into_iter().map(|vertices| vertices[0]).collect()
    }

    /// The vertices of each connected part (m), each once. Parts are connected where corners have the same position.
    #[must_use]
    pub fn part_vertices(&self) -> Vec<Vec<Point>> {
        part_vertices(&WeldedMesh::new(self))
    }

    /// A point well inside the mesh as a solid, if one is known.
    #[must_use]
    pub fn inner_point(&self) -> Option<Point> {
        self.solid().inner_point(&self.vertices)
    }

    /// False if a point is certainly not inside the mesh as a solid, found without computing a winding number.
    #[must_use]
    pub fn may_enclose(&self, point: &Point) -> bool {
        self.solid().known(&self.vertices, point, &mut InsideWork::default()) != Some(false)
    }

    /// Grid of the cells that may contain points inside the mesh as a solid; `None` if nothing is inside.
    #[must_use]
    pub fn inside_grid(&self) -> Option<&Arc<InsideGrid>> {
        self.solid().inside_grid(&self.vertices)
    }

    /// Builds the data for [`Self::encloses`], so that the first point costs no more than others.
    pub fn prepare_solid(&self) {
        self.solid().prepare(&self.vertices);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> TriangleMesh {
        TriangleMesh::new(
            vec![
                Point::new(0.0, 0.0, 0.0),
                Point::new(1.0, 0.0, 0.0),
                Point::new(0.0, 1.0, 0.0),
                Point::new(0.0, 0.0, 1.0),
            ],
            vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        )
        .unwrap()
    }

    #[test]
    fn a_mirror_keeps_faces_outward() {
        let mesh = tetrahedron();
        assert!((mesh.signed_volume() - 1.0 / 6.0).abs() < 1e-15);
        let mirrored = mesh.scaled(Vector::new(1.0, -2.0, 1.0)).unwrap();
        assert!((mirrored.signed_volume() - 2.0 / 6.0).abs() < 1e-15);
    }

    #[test]
    fn faults_are_named() {
        let p = vec![Point::origin(); 3];
        assert_eq!(TriangleMesh::new(p.clone(), vec![]), Err(MeshError::NoTriangles));
        assert_eq!(
            TriangleMesh::new(p.clone(), vec![[0, 1, 7]]),
            Err(MeshError::IndexOutOfRange { triangle: 0, vertex: 7, vertices: 3 })
        );
        let mut bad = p;
        bad[1].y = f64::NAN;
        assert_eq!(TriangleMesh::new(bad, vec![[0, 1, 2]]), Err(MeshError::BadVertex { vertex: 1 }));
    }
}
