//! Connected solids of a link: primitives and the closed connected parts of its meshes.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use clearance_geometry::math::{Point, Pose};
use clearance_geometry::{DisjointSets, Shape, TriangleMesh, WeldedMesh};
use clearance_proximity::SolidBody;

use crate::inner_points::PointDepth;
use crate::outline::Outline;

/// Largest number of solids of one link.
const MOST_PARTS: usize = 3;

/// A connected solid whose surface is connected, too.
#[derive(Debug)]
pub struct SolidPart {
    /// For depths.
    pub solid: SolidBody,
    /// Depths of points.
    pub depths: PointDepth,
    /// Points around it.
    pub outline: Outline,
    /// True if only its surface counts for the checker.
    pub is_mesh: bool,
}

impl SolidPart {
    /// The largest solids of shapes at their poses, the largest first.
    #[must_use]
    pub fn all(shapes: &[(Pose, Shape)]) -> Vec<Self> {
        let mut found: Vec<Self> = Vec::new();
        for (pose, shape) in shapes {
            match shape {
                Shape::Primitive(_) => found.extend(Self::new(*pose, shape.clone(), false)),
                Shape::Mesh(mesh) => {
                    let parts = closed_parts(mesh).into_iter();
                    found
                        .extend(parts.filter_map(|part| Self::new(*pose, Shape::Mesh(Arc::new(part)), true)));
                }
                Shape::Plane(_) | Shape::Points(_) | Shape::Voxels(_) => {}
            }
        }
        found.sort_by(|a, b| b.extent().total_cmp(&a.extent()));
        found.truncate(MOST_PARTS);
        found
    }

    fn new(pose: Pose, shape: Shape, is_mesh: bool) -> Option<Self> {
        let solid = SolidBody::new([(&pose, &shape)]);
        let depths = PointDepth::new(&pose, &shape)?;
        let outline = Outline::new(&[(pose, shape)])?;
        Some(Self { solid, depths, outline, is_mesh })
    }

    /// Sum of the widths (m) in many directions.
    fn extent(&self) -> f64 {
        crate::outline::directions().map(|n| self.outline.extent_along(&n)[0]).sum()
    }
}

/// The connected parts of a mesh without a free edge; vertices at the same position are one.
fn closed_parts(mesh: &TriangleMesh) -> Vec<TriangleMesh> {
    let WeldedMesh { positions, mut faces } = WeldedMesh::new(mesh);
    faces.retain(|[a, b, c]| a != b && b != c && c != a);
    let mut sets = DisjointSets::of_faces(positions.len(), &faces);
    let mut parts: BTreeMap<u32, Vec<[u32; 3]>> = BTreeMap::new();
    for face in faces {
        parts.entry(sets.smallest(face[0])).or_default().push(face);
    }
    (parts.into_values())
        .filter(|faces| is_closed(faces))
        .filter_map(|faces| part_mesh(&positions, &faces))
        .collect()
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
