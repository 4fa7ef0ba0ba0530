//! Inside of a body: its closed meshes, and a point of each of its connected parts.

use std::collections::HashMap;
use std::sync::Arc;

use clearance_geometry::math::{Point, Pose};
use clearance_geometry::{InsideTest, Shape, TriangleMesh};

/// The closed meshes of a body, and a point of each connected part of the body.
#[derive(Clone, Debug)]
pub(crate) struct Interior {
    closed_meshes: Vec<ClosedMesh>,
    part_points: Vec<Point>,
}

/// A mesh with an inside, placed in its body.
#[derive(Clone, Debug)]
pub(crate) struct ClosedMesh {
    mesh: Arc<TriangleMesh>,
    pose_bm: Pose,
    bounds: (Point, Point),
}

impl Interior {
    #[inline]
    pub fn new<'a>(shapes: impl Iterator<Item = (&'a Pose, &'a Shape)>) -> Self {
        let mut interior = Self { closed_meshes: Vec::new(), part_points: Vec::new() };
        for (pose, shape) in shapes {
            match shape {
                // no closed mesh contains a plane; cubes are searched in their tree
                Shape::Plane(_) | Shape::Points(_) | Shape::Voxels(_) => {}
                Shape::Primitive(_) => interior.part_points.push(Point::from(pose.translation.vector)),
                Shape::Mesh(mesh) => {
                    interior.part_points.extend(part_points(mesh).iter().map(|p| pose * p));
                    if !mesh.solid().surfaces().is_empty() {
                        mesh.prepare_solid();
                        interior.closed_meshes.push(ClosedMesh {
                            mesh: Arc::clone(mesh),
                            pose_bm: *pose,
                            bounds: mesh.bounds(),
                        });
                    }
                }
            }
        }
        interior
    }

    /// The meshes that are solid.
    #[inline]
    pub fn closed_meshes(&self) -> &[ClosedMesh] {
        &self.closed_meshes
    }

    /// A point of each connected part of the body, in its frame.
    #[inline]
    pub fn part_points(&self) -> &[Point] {
        &self.part_points
    }
}

impl ClosedMesh {
    /// Pose of the mesh in the frame of its body.
    #[inline]
    pub fn pose_bm(&self) -> &Pose {
        &self.pose_bm
    }

    /// Smallest and largest corner of the box around the mesh, in its frame.
    #[inline]
    pub fn bounds(&self) -> &(Point, Point) {
        &self.bounds
    }

    #[inline]
    pub fn test(&self) -> MeshTest<'_> {
        MeshTest { mesh: self, inside: InsideTest::new(&self.mesh) }
    }
}

/// Tests points against one mesh.
pub(crate) struct MeshTest<'i> {
    mesh: &'i ClosedMesh,
    inside: InsideTest<'i>,
}

impl<'i> MeshTest<'i> {
    #[inline]
    pub fn mesh(&self) -> &'i ClosedMesh {
        self.mesh
    }

    /// True if a point (frame of the mesh's body) is inside. Adds the number of tests of boxes and triangles to `tests`.
    pub fn contains(&mut self, point_b: &Point, tests: &mut u64) -> bool {
        *tests += 1;
        let p = self.mesh.pose_bm.inverse_transform_point(point_b);
        let (lo, hi) = self.mesh.bounds;
        let is_inside = (0..3).all(|i| (lo[i]..=hi[i]).contains(&p[i])) && self.inside.encloses(&p);
        *tests += self.inside.take_cost();
        is_inside
    }
}

/// One vertex of each connected part, corners at equal positions joined.
fn part_points(mesh: &TriangleMesh) -> Vec<Point> {
    let mut parent: Vec<usize> = (0..mesh.vertices().len()).collect();
    let mut first_at: HashMap<[u64; 3], usize> = HashMap::new();
    for (v, p) in mesh.vertices().iter().enumerate() {
        let same = *first_at.entry([p.x, p.y, p.z].map(|c| (c + 0.0).to_bits())).or_insert(v);
        join(&mut parent, same, v);
    }
    for t in mesh.triangles() {
        let [a, b, c] = t.map(|v| v as usize);
        join(&mut parent, a, b);
        join(&mut parent, b, c);
    }
    let mut seen = std::collections::HashSet::new();
    (mesh.triangles().iter().flatten())
        .map(|&v| v as usize)
        .filter(|&v| seen.insert(find(&mut parent, v)))
        .map(|v| mesh.vertices()[v])
        .collect()
}

fn find(parent: &mut [usize], mut v: usize) -> usize {
    while parent[v] != v {
        parent[v] = parent[parent[v]];
        v = parent[v];
    }
    v
}

fn join(parent: &mut [usize], a: usize, b: usize) {
    let (a, b) = (find(parent, a), find(parent, b));
    parent[a.max(b)] = a.min(b);
}
