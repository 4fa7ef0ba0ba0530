//! A mesh whose vertices at equal positions are joined.

use std::collections::HashMap;

use clearance_geometry::math::Point;
use clearance_geometry::{Triangle, TriangleMesh};

/// Faces over distinct positions; faces keep their order and winding.
#[derive(Debug)]
pub(crate) struct WeldedMesh {
    pub positions: Vec<Point>,
    pub faces: Vec<[u32; 3]>,
}

impl WeldedMesh {
    pub fn new(mesh: &TriangleMesh) -> Self {
        let mut names: HashMap<[u64; 3], u32> = HashMap::new();
        let mut positions = Vec::new();
        let mut name = |vertex: u32| {
            let p = mesh.vertices()[vertex as usize];
            // -0.0 and 0.0 are one position
            let key = [p.x, p.y, p.z].map(|c| (c + 0.0).to_bits());
            *names.entry(key).or_insert_with(|| {
                positions.push(p);
                u32::try_from(positions.len() - 1).unwrap_or(u32::MAX)
            })
        };
        let faces = mesh.triangles().iter().map(|face| face.map(&mut name)).collect();
        Self { positions, faces }
    }

    pub fn triangle(&self, face: usize) -> Triangle {
        let [a, b, c] = self.faces[face].map(|v| self.positions[v as usize]);
        Triangle { a, b, c }
    }
}
