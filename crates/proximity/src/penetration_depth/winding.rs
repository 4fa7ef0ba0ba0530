//! Winding of the faces of a body's surface: which side is outside.

use std::collections::{HashMap, HashSet};

use clearance_geometry::math::Point;
use clearance_geometry::{ClosedSurface, TriangleMesh};

/// Sides of the faces of some meshes, whose vertices are numbered one mesh after the other.
#[derive(Debug)]
pub(crate) struct Winding {
    meshes: Vec<MeshWinding>,
}

#[derive(Debug)]
struct MeshWinding {
    /// Number of the first vertex of the mesh.
    first_vertex: u32,
    sides: Sides,
}

/// Which faces of one mesh are wound outward.
#[derive(Debug)]
enum Sides {
    /// None has an outside.
    Open,
    AllOutward,
    AllInward,
    Mixed {
        /// For each vertex, the first at the same position.
        names: Vec<u32>,
        /// Faces of the closed surfaces, the smallest corner first.
        outward: HashSet<[u32; 3]>,
    },
}

impl Winding {
    pub fn new<'m>(meshes: impl Iterator<Item = &'m TriangleMesh>) -> Self {
        let mut first_vertex = 0;
        let meshes = meshes.map(|mesh| {
            let of_mesh = MeshWinding { first_vertex, sides: Sides::of(mesh) };
            first_vertex += u32::try_from(mesh.vertices().len()).expect("vertex count fits 32 bits");
            of_mesh
        });
        Self { meshes: meshes.collect() }
    }

    /// 1 for a face that is wound outward, -1 for one that is wound inward; `None` for a face that bounds no solid.
    pub fn sign(&self, corners: [u32; 3]) -> Option<f64> {
        let index = self.meshes.partition_point(|mesh| mesh.first_vertex <= corners[0]);
        let MeshWinding { first_vertex, sides } = self.meshes.get(index.checked_sub(1)?)?;
        match sides {
            Sides::Open => None,
            Sides::AllOutward => Some(1.0),
            Sides::AllInward => Some(-1.0),
            Sides::Mixed { names, outward } => {
                let [a, b, c] = corners.map(|v| names[(v - first_vertex) as usize]);
                if outward.contains(&smallest_first([a, b, c])) {
                    Some(1.0)
                } else {
                    outward.contains(&smallest_first([a, c, b])).then_some(-1.0)
                }
            }
        }
    }
}

impl Sides {
    fn of(mesh: &TriangleMesh) -> Self {
        let surfaces = mesh.solid().surfaces();
        let Some(first) = surfaces.first() else { return Self::Open };
        if mesh.solid().remarks().has_one_winding() {
            return if is_wound_so(mesh, first.triangles()[0]) { Self::AllOutward } else { Self::AllInward };
        }
        let mut first_at: HashMap<[u64; 3], u32> = HashMap::new();
        let name = |(p, own): (&Point, u32)| *first_at.entry(bits(p)).or_insert(own);
        let names: Vec<u32> = mesh.vertices().iter().zip(0..).map(name).collect();
        let faces = surfaces.iter().flat_map(ClosedSurface::triangles);
        let outward = faces.map(|t| smallest_first(t.map(|v| names[v as usize]))).collect();
        Self::Mixed { names, outward }
    }
}

/// Whether a face of the closed surface is wound so in the mesh.
fn is_wound_so(mesh: &TriangleMesh, face: [u32; 3]) -> bool {
    let at = |t: [u32; 3]| t.map(|v| bits(&mesh.vertices()[v as usize]));
    let [a, b, c] = at(face);
    mesh.triangles().iter().any(|t| [[a, b, c], [b, c, a], [c, a, b]].contains(&at(*t)))
}

/// A position, -0.0 and 0.0 alike.
fn bits(p: &Point) -> [u64; 3] {
    [p.x, p.y, p.z].map(|c| (c + 0.0).to_bits())
}

fn smallest_first([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a < b && a < c {
        [a, b, c]
    } else if b < c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(at: f64) -> TriangleMesh {
        let side = |i: usize, k: usize| if i >> k & 1 == 0 { at - 1.0 } else { at + 1.0 };
        let vertices = (0..8).map(|i| Point::new(side(i, 0), side(i, 1), side(i, 2))).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        TriangleMesh::new(vertices, faces).unwrap()
    }

    /// Faces may be reversed all, in part or not at all, and share vertices or not: the outside is the same.
    #[test]
    fn the_outside_is_known_for_any_winding_of_the_file() {
        for reversed in [vec![], (0..12).collect(), vec![0], vec![3, 7, 8]] {
            for is_welded in [true, false] {
                let plain = cube(0.5);
                let mut faces = plain.triangles().to_vec();
                for i in &reversed {
                    faces[*i].swap(1, 2);
                }
                let mesh = if is_welded {
                    TriangleMesh::new(plain.vertices().to_vec(), faces).unwrap()
                } else {
                    let corners = faces.iter().flatten().map(|v| plain.vertices()[*v as usize]).collect();
                    TriangleMesh::new(corners, (0..12).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
                        .unwrap()
                };
                let (first, centre) = (cube(0.0), Point::new(0.5, 0.5, 0.5));
                let winding = Winding::new([&first, &mesh].into_iter());
                for i in 0..12 {
                    let corners = mesh.triangles()[i].map(|v| v + 8);
                    let triangle = mesh.triangle(i);
                    let sign = winding.sign(corners).unwrap();
                    assert!(triangle.normal().dot(&(triangle.a - centre)) * sign > 0.0, "{reversed:?} {i}");
                    assert_eq!(winding.sign(first.triangles()[i]), Some(1.0));
                }
            }
        }
    }

    #[test]
    fn an_open_face_has_no_outside() {
        let plain = cube(0.0);
        let mut vertices = plain.vertices().to_vec();
        vertices.extend([[5.0, 0.0, 0.0], [6.0, 0.0, 0.0], [5.0, 1.0, 0.0]].map(Point::from));
        let faces = plain.triangles().iter().copied().chain([[8, 9, 10]]).collect();
        let mesh = TriangleMesh::new(vertices, faces).unwrap();
        let winding = Winding::new([&mesh].into_iter());
        assert_eq!(winding.sign([8, 9, 10]), None);
        assert_eq!(winding.sign(mesh.triangles()[0]), Some(1.0));
    }
}
