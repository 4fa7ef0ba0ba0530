//! Vertices and triangles collected by a mesh reader, with limits on number and memory.

use clearance_geometry::TriangleMesh;
use clearance_geometry::math::Point;
use nalgebra::Matrix4;

use super::mesh_memory;

/// Maximum number of triangles of a file, instances included: a file of nested instances can produce any number.
pub(super) const MOST_TRIANGLES: usize = 20_000_000;

/// Maximum nesting depth of the nodes of a scene, and maximum number of visited nodes; instances count.
pub(super) const MOST_NODE_LEVELS: usize = 1000;
pub(super) const MOST_NODES: usize = 2_000_000;

/// Rejects nodes inside of too many others, and too many visited nodes.
///
/// # Errors
/// If a limit is exceeded, with its number.
pub(super) fn check_nodes(level: usize, visited: usize) -> Result<(), String> {
    if level > MOST_NODE_LEVELS {
        return Err(format!("nodes are nested more than {MOST_NODE_LEVELS} levels deep, instances counted"));
    }
    if visited > MOST_NODES {
        return Err(format!("the scene shows more than {MOST_NODES} nodes, instances counted"));
    }
    Ok(())
}

#[derive(Debug, Default)]
pub(super) struct MeshBuilder {
    pub vertices: Vec<Point>,
    pub triangles: Vec<[u32; 3]>,
    /// Memory (bytes) that was available when it was last checked.
    available: usize,
}

impl MeshBuilder {
    /// Checks that this number of additional vertices and triangles is allowed and fits in memory. Call this before adding any.
    ///
    /// # Errors
    /// If there are too many.
    pub fn reserve(&mut self, vertices: usize, triangles: usize) -> Result<(), String> {
        let vertices = self.vertices.len().saturating_add(vertices);
        let triangles = self.triangles.len().saturating_add(triangles);
        if triangles > MOST_TRIANGLES {
            return Err(format!("it has more than {MOST_TRIANGLES} triangles, instances counted"));
        }
        if u32::try_from(vertices).is_err() {
            return Err("it has more vertices than 32-bit indices can name, instances counted".to_owned());
        }
        let needed = mesh_memory::of_mesh(vertices, triangles);
        if needed > self.available {
            let needed = needed.next_multiple_of(mesh_memory::STEP);
            mesh_memory::check(needed).map_err(|e| {
                format!("{triangles} triangles, instances counted, and {vertices} vertices {e}")
            })?;
            self.available = needed;
        }
        Ok(())
    }

    /// Adds a triangle by the indices of its corners.
    ///
    /// # Errors
    /// If the number of triangles exceeds the limit.
    pub fn push(&mut self, corners: [usize; 3]) -> Result<(), String> {
        self.reserve(0, 1)?;
        // `reserve` keeps the number of vertices below this
        self.triangles.push(corners.map(|corner| u32::try_from(corner).unwrap_or(u32::MAX)));
        Ok(())
    }

    /// Adds a transformed instance of another surface. If the transform mirrors, the winding is reversed, so that outward faces stay
    /// outward.
    ///
    /// # Errors
    /// If there are too many vertices or triangles.
    pub fn append(&mut self, other: &Self, moved: &Matrix4<f64>) -> Result<(), String> {
        self.reserve(other.vertices.len(), other.triangles.len())?;
        let first = u32::try_from(self.vertices.len()).unwrap_or(u32::MAX);
        let is_mirrored = moved.fixed_view::<3, 3>(0, 0).determinant() < 0.0;
        self.vertices.extend(other.vertices.iter().map(|p| moved.transform_point(p)));
        self.triangles.extend(other.triangles.iter().map(|corners| {
            let [a, b, c] = corners.map(|corner| corner + first);
            if is_mirrored { [a, c, b] } else { [a, b, c] }
        }));
        Ok(())
    }

    pub fn finish(self) -> Result<TriangleMesh, String> {
        TriangleMesh::new(self.vertices, self.triangles).map_err(|e| e.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_without_end_are_rejected_before_anything_is_allocated() {
        for (vertices, triangles, words) in [
            (0, MOST_TRIANGLES + 1, "triangles"),
            (0, usize::MAX, "triangles"),
            (usize::MAX, 1, "vertices"),
            (1 << 32, 1, "vertices"),
        ] {
            let mut builder = MeshBuilder::default();
            let message = builder.reserve(vertices, triangles).unwrap_err();
            assert!(message.contains(words), "{message}");
            assert_eq!((builder.vertices.capacity(), builder.triangles.capacity()), (0, 0));
        }
    }

    #[test]
    fn instances_are_counted_with_what_is_there() {
        let vertices = vec![Point::origin(), Point::new(1.0, 0.0, 0.0), Point::new(0.0, 1.0, 0.0)];
        let mut one = MeshBuilder { vertices, ..MeshBuilder::default() };
        one.push([0, 1, 2]).unwrap();
        let mut all = MeshBuilder::default();
        all.append(&one, &Matrix4::identity()).unwrap();
        all.append(&one, &Matrix4::new_nonuniform_scaling(&[-1.0, 1.0, 1.0].into())).unwrap();
        assert_eq!(all.triangles, [[0, 1, 2], [3, 5, 4]]);
        assert_eq!(all.vertices[4], Point::new(-1.0, 0.0, 0.0));
        assert!(all.reserve(0, MOST_TRIANGLES - 1).unwrap_err().contains("triangles"));
    }
}
