//! Whether a body whose surface touches nothing lies inside a closed mesh.
//!
//! If two surfaces do not touch, each connected part of one is wholly inside or wholly outside the other, so one point
//! of each part decides. Meshes that are open in part have an inside where the rest of them is closed.

use std::collections::HashMap;
use std::sync::Arc;

use super::body::CollisionBody;
use super::grains::Grains;
use super::search::Descent;
use crate::bounding_volume::BoundingVolume;
use crate::bvh::{GrainLeaf, PlaneVisitor, TreePlane};
use crate::geometry::{Shape, TriangleMesh};
use crate::math::{MatrixPose, Point, Pose, Vector};

/// The closed meshes of a body, and a point of each connected part of it.
#[derive(Clone, Debug)]
pub(super) struct Interior {
    closed_meshes: Vec<ClosedMesh>,
    part_points: Vec<Point>,
}

#[derive(Clone, Debug)]
struct ClosedMesh {
    mesh: Arc<TriangleMesh>,
    pose_bm: Pose,
    bounds: (Point, Point),
}

impl Interior {
    pub fn new<'a>(shapes: impl Iterator<Item = (&'a Pose, &'a Shape)>) -> Self {
        let mut interior = Self { closed_meshes: Vec::new(), part_points: Vec::new() };
        for (pose, shape) in shapes {
            match shape {
                // no closed mesh holds a plane; grains are looked for in their tree
                Shape::Plane(_) | Shape::Points(_) | Shape::Voxels(_) => {}
                Shape::Primitive(_) => interior.part_points.push(Point::from(pose.translation.vector)),
                Shape::Mesh(mesh) => {
                    interior.part_points.extend(part_points(mesh).iter().map(|p| pose * p));
                    if !mesh.solid().surfaces().is_empty() {
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

    /// A point of one body inside a closed mesh of the other, in the frame of a.
    pub fn contained_point(a: &Self, b: &Self, pose_ab: &Pose) -> Option<Point> {
        let in_a = || {
            let points = b.part_points.iter().map(|p| pose_ab * p);
            points.into_iter().find(|p| a.contains(p))
        };
        let in_b = || {
            let inside = |p: &&Point| b.contains(&pose_ab.inverse_transform_point(p));
            a.part_points.iter().find(inside).copied()
        };
        in_a().or_else(in_b)
    }

    fn contains(&self, point: &Point) -> bool {
        self.closed_meshes.iter().any(|m| m.contains(point))
    }
}

impl ClosedMesh {
    fn contains(&self, point_b: &Point) -> bool {
        let p = self.pose_bm.inverse_transform_point(point_b);
        let (lo, hi) = self.bounds;
        (0..3).all(|i| (lo[i]..=hi[i]).contains(&p[i])) && self.mesh.encloses(&p)
    }
}

/// The centre of a point or cube of one body inside a closed mesh of the other, in the frame of a: where surfaces do not touch
/// them, all of each is inside or outside.
pub(super) fn contained_grain<B: BoundingVolume>(
    (a, b): (&CollisionBody<B>, &CollisionBody<B>),
    pose_ab: &MatrixPose,
    descent: &mut Descent,
) -> Option<Point> {
    let (of_a, of_b) = a.interior.as_ref().zip(b.interior.as_ref())?;
    let in_a = of_a.grain_inside(&b.grains, pose_ab, descent);
    in_a.or_else(|| Some(pose_ab * of_b.grain_inside(&a.grains, &pose_ab.inverse(), descent)?))
}

impl Interior {
    /// The centre of a grain of another body inside one of the meshes, in the frame of this.
    fn grain_inside<B: BoundingVolume>(
        &self,
        sets: &[Grains<B>],
        pose_to_own: &MatrixPose,
        descent: &mut Descent,
    ) -> Option<Point> {
        self.closed_meshes.iter().find_map(|mesh| {
            sets.iter().find_map(|grains| {
                let mut visitor = CentresInside::new(mesh, grains, pose_to_own);
                let plane = visitor.middle_plane();
                descent.run_to_plane(&grains.tree, &plane, &mut visitor, 0.0);
                visitor.found
            })
        })
    }
}

/// Looks for grains inside a mesh, between two planes of the box around it.
struct CentresInside<'i, B: BoundingVolume> {
    mesh: &'i ClosedMesh,
    grains: &'i Grains<B>,
    pose_to_mesh_body: &'i MatrixPose,
    /// The axis along which the box is thinnest.
    axis: usize,
    half_width: f64,
    found: Option<Point>,
}

impl<'i, B: BoundingVolume> CentresInside<'i, B> {
    fn new(mesh: &'i ClosedMesh, grains: &'i Grains<B>, pose_to_mesh_body: &'i MatrixPose) -> Self {
        let widths = mesh.bounds.1 - mesh.bounds.0;
        let axis = widths.imin();
        Self { mesh, grains, pose_to_mesh_body, axis, half_width: 0.5 * widths[axis], found: None }
    }

    /// In the frame of the grains.
    fn middle_plane(&self) -> TreePlane {
        let (lo, hi) = self.mesh.bounds;
        let pose_mb = MatrixPose::from(&self.mesh.pose_bm).inverse();
        let pose_mg = pose_mb.compose(self.pose_to_mesh_body).compose(&self.grains.pose_bg);
        let axis = Vector::ith(self.axis, 1.0);
        let offset = nalgebra::center(&lo, &hi)[self.axis] - pose_mg.translation[self.axis];
        TreePlane::new(&pose_mg.rotation.tr_mul(&axis), offset, &self.grains.tree)
    }
}

impl<B: BoundingVolume> PlaneVisitor<GrainLeaf> for CentresInside<'_, B> {
    #[allow(clippy::cast_possible_truncation)] // rounded up right after
    fn threshold(&self) -> f32 {
        if self.found.is_some() { f32::NEG_INFINITY } else { (self.half_width as f32).next_up() }
    }

    fn volume_tests(&mut self, _: u32) {}

    fn leaf(&mut self, leaf: &GrainLeaf) {
        let centres =
            (leaf.first..leaf.first + leaf.count).map(|i| self.pose_to_mesh_body * self.grains.centre(i));
        self.found = self.found.or(centres.into_iter().find(|p| self.mesh.contains(p)));
    }

    fn interrupted(&mut self) -> bool {
        false
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
