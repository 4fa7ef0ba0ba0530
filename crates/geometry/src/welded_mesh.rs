//! A mesh whose vertices at equal positions are joined.

use std::collections::HashMap;

use crate::math::Point;
use crate::{Triangle, TriangleMesh};

/// Faces over distinct positions. Faces keep their order and winding; positions are in the order of the faces.
#[derive(Clone, Debug)]
pub struct WeldedMesh {
    /// Distinct positions (m).
    pub positions: Vec<Point>,
    /// Indices of the corners of each face; equal for a face without area.
    pub faces: Vec<[u32; 3]>,
}

impl WeldedMesh {
    /// Joins the vertices of a mesh.
    #[must_use]
    pub fn new(mesh: &TriangleMesh) -> Self {
        let mut indices: HashMap<[u64; 3], u32> = HashMap::new();
        let mut positions = Vec::new();
        let mut index = |vertex: u32| {
            let p = mesh.vertices()[vertex as usize];
            // -0.0 and 0.0 are one position
            let key = [p.x, p.y, p.z].map(|c| (c + 0.0).to_bits());
            *indices.entry(key).or_insert_with(|| {
                positions.push(p);
                u32::try_from(positions.len() - 1).unwrap_or(u32::MAX)
            })
        };
        let faces = mesh.triangles().iter().map(|face| face.map(&mut index)).collect();
        Self { positions, faces }
    }

    /// A face with its positions.
    #[must_use]
    pub fn triangle(&self, face: usize) -> Triangle {
        let [a, b, c] = self.faces[face].map(|v| self.positions[v as usize]);
        Triangle { a, b, c }
    }
}
