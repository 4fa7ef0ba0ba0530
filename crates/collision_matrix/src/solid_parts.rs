//! Connected solids of a link: primitives and the closed connected parts of its meshes.

use std::collections::HashMap;
use std::sync::Arc;

use clearance_geometry::math::{Point, Pose};
use clearance_geometry::{Shape, TriangleMesh};
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
    let mut first_at: HashMap<[u64; 3], u32> = HashMap::new();
    let mut welded = Vec::with_capacity(mesh.vertices().len());
    for (p, v) in mesh.vertices().iter().zip(0u32..) {
        welded.push(*first_at.entry([p.x, p.y, p.z].map(|c| (c + 0.0).to_bits())).or_insert(v));
    }
    let corners = mesh.triangles().iter().map(|t| t.map(|v| welded[v as usize]));
    let triangles: Vec<[u32; 3]> = corners.filter(|[a, b, c]| a != b && b != c && c != a).collect();
    let mut parent: Vec<u32> = (0..).take(mesh.vertices().len()).collect();
    for [a, b, c] in &triangles {
        join(&mut parent, *a, *b);
        join(&mut parent, *b, *c);
    }
    let mut parts: HashMap<u32, Vec<[u32; 3]>> = HashMap::new();
    for t in triangles {
        parts.entry(find(&mut parent, t[0])).or_default().push(t);
    }
    let mut parts: Vec<_> = parts.into_iter().collect();
    parts.sort_by_key(|(first, _)| *first);
    (parts.into_iter().map(|(_, triangles)| triangles))
        .filter(|triangles| is_closed(triangles))
        .filter_map(|triangles| part_mesh(mesh.vertices(), &triangles))
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

fn find(parent: &mut [u32], mut v: u32) -> u32 {
    while parent[v as usize] != v {
        parent[v as usize] = parent[parent[v as usize] as usize];
        v = parent[v as usize];
    }
    v
}

fn join(parent: &mut [u32], a: u32, b: u32) {
    let (a, b) = (find(parent, a), find(parent, b));
    parent[a.max(b) as usize] = a.min(b);
}
