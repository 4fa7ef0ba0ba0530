//! Connected solids of a link: primitives and the closed connected parts of its meshes.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use clearance_geometry::math::{Point, Pose};
use clearance_geometry::{DisjointSets, Shape, TriangleMesh, WeldedMesh};

use crate::inner_points::PointDepth;
use crate::outline::Outline;

/// Largest number of solids of one link.
const MOST_PARTS: usize = 3;

/// A connected solid whose surface is connected, too.
#[derive(Debug)]
pub struct SolidPart {
    /// Depths of points.
    pub depths: PointDepth,
    /// Points around it.
    pub outline: Outline,
    /// Number of its shape among the collision shapes of the link.
    pub shape: usize,
    /// Number of its first face in a mesh; 0 for a primitive.
    pub face: usize,
    /// The meaning of its inside for the checker.
    pub inside: PartInside,
}

/// Meaning of the inside of a solid for the checker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PartInside {
    /// A primitive.
    Solid,
    /// The only part of a mesh: solid if meshes are.
    WholeMesh,
    /// One part of a mesh, whose inside may be a cavity of another part.
    PartOfMesh,
}

impl SolidPart {
    /// The largest solids of shapes at their poses, the largest first.
    #[must_use]
    pub fn all(shapes: &[(Pose, Shape)]) -> Vec<Self> {
        let mut found: Vec<Self> = Vec::new();
        for (number, (pose, shape)) in shapes.iter().enumerate() {
            match shape {
                Shape::Primitive(_) => {
                    found.extend(Self::new(number, *pose, shape.clone(), PartInside::Solid));
                }
                Shape::Mesh(mesh) => found.extend(closed_parts(mesh).filter_map(|part| {
                    let inside = if part.is_whole { PartInside::WholeMesh } else { PartInside::PartOfMesh };
                    let found = Self::new(number, *pose, Shape::Mesh(Arc::new(part.mesh)), inside)?;
                    Some(Self { face: part.face, ..found })
                })),
                Shape::Plane(_) | Shape::Points(_) | Shape::Voxels(_) => {}
            }
        }
        found.sort_by(|a, b| b.extent().total_cmp(&a.extent()));
        found.truncate(MOST_PARTS);
        found
    }

    fn new(number: usize, pose: Pose, shape: Shape, inside: PartInside) -> Option<Self> {
        let depths = PointDepth::new(&pose, &shape)?;
        let outline = Outline::new(&[(pose, shape)])?;
        Some(Self { depths, outline, shape: number, face: 0, inside })
    }

    /// Sum of the widths (m) in many directions.
    fn extent(&self) -> f64 {
        crate::outline::directions().map(|n| self.outline.extent_along(&n)[0]).sum()
    }
}

/// A connected part of a mesh without a free edge.
struct ClosedPart {
    mesh: TriangleMesh,
    /// Number of its first face in the mesh.
    face: usize,
    /// True if the mesh has no other part.
    is_whole: bool,
}

/// The connected parts of a mesh without a free edge; vertices at the same position are one.
fn closed_parts(mesh: &TriangleMesh) -> impl Iterator<Item = ClosedPart> {
    let WeldedMesh { positions, faces } = WeldedMesh::new(mesh);
    let has_corners = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
    let mut sets = DisjointSets::of_faces(positions.len(), faces.iter().filter(|face| has_corners(face)));
    // by part: its first face, and all faces
    let mut parts: BTreeMap<u32, (usize, Vec<[u32; 3]>)> = BTreeMap::new();
    for (number, face) in faces.into_iter().enumerate().filter(|(_, face)| has_corners(face)) {
        parts.entry(sets.smallest(face[0])).or_insert_with(|| (number, Vec::new())).1.push(face);
    }
    let is_whole = parts.len() == 1;
    (parts.into_values()).filter(|(_, faces)| is_closed(faces)).filter_map(move |(face, faces)| {
        Some(ClosedPart { mesh: part_mesh(&positions, &faces)?, face, is_whole })
    })
}

/// True if every edge is used once in each direction.
fn is_closed(triangles: &[[u32; 3]]) -> bool {
    let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
    let mut uses: HashMap<(u32, u32), u32> = HashMap::new();
    for [a, b, c] in triangles {
        for (p, q) in [(*a, *b), (*b, *c), (*c, *a)] {
            let key = (p.min(q), p.max(q));
            *edges.entry(key).or_default() += if p < q { 1 } else { -1 };
            *uses.entry(key).or_default() += 1;
        }
    }
    edges.values().all(|sum| *sum == 0) && uses.values().all(|count| *count == 2)
}

fn part_mesh(vertices: &[Point], triangles: &[[u32; 3]]) -> Option<TriangleMesh> {
    let (mut index_of, mut used) = (HashMap::new(), Vec::new());
    let mut index = |v: u32| {
        *index_of.entry(v).or_insert_with(|| {
            used.push(vertices[v as usize]);
            u32::try_from(used.len() - 1).unwrap_or(u32::MAX)
        })
    };
    let triangles = triangles.iter().map(|t| t.map(&mut index)).collect();
    TriangleMesh::new(used, triangles).ok()
}
