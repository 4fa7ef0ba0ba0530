//! Containment: tests whether a body whose surface touches nothing lies inside a closed mesh.
//!
//! If two surfaces do not touch, each connected part of one is wholly inside or wholly outside the other, so one point of each part
//! decides. Meshes that are partly open have an inside where the rest of them is closed. Point tests count as work, and stop at the
//! deadline.

use std::collections::HashMap;
use std::sync::Arc;

use clearance_geometry::math::{MatrixPose, Point, Pose, Vector};
use clearance_geometry::{InsideTest, Shape, TriangleMesh};

use super::body::CollisionBody;
use super::grains::Grains;
use super::incumbent::Incumbent;
use super::search::Descent;
use crate::bounding_volume::BoundingVolume;
use crate::bvh::{GrainLeaf, PlaneVisitor, TreePlane};

/// The closed meshes of a body, and a point of each connected part of the body.
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
    #[inline]
    pub fn new<'a>(shapes: impl Iterator<Item = (&'a Pose, &'a Shape)>) -> Self {
        let mut interior = Self { closed_meshes: Vec::new(), part_points: Vec::new() };
        for (pose, shape) in shapes {
            match shape {
                // no closed mesh contains a plane; grains are searched in their tree
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

    /// The first of `count` points (own frame) that is inside one of the meshes.
    fn first_inside(
        &self,
        count: usize,
        point: impl Fn(usize) -> Point,
        incumbent: &mut Incumbent,
    ) -> Result<Option<usize>, DeadlinePassed> {
        let mut found = None;
        for mesh in &self.closed_meshes {
            let mut test = mesh.test();
            for i in 0..found.unwrap_or(count) {
                if incumbent.interrupted() {
                    return if found.is_some() { Ok(found) } else { Err(DeadlinePassed) };
                }
                if test.contains(&point(i), incumbent) {
                    found = Some(i);
                    break;
                }
            }
        }
        Ok(found)
    }

    /// The centre of a grain of another body inside one of the meshes, in the frame of this body.
    fn grain_inside<B: BoundingVolume>(
        &self,
        sets: &[Grains<B>],
        pose_to_own: &MatrixPose,
        incumbent: &mut Incumbent,
        descent: &mut Descent,
    ) -> Result<Option<Point>, DeadlinePassed> {
        for (mesh, grains) in
            self.closed_meshes.iter().flat_map(|mesh| sets.iter().map(move |set| (mesh, set)))
        {
            let mut visitor = CentresInside::new(mesh, grains, pose_to_own, incumbent);
            let plane = visitor.middle_plane();
            descent.run_to_plane(&grains.tree, &plane, &mut visitor, 0.0);
            match visitor {
                CentresInside { found: Some(point), .. } => return Ok(Some(point)),
                CentresInside { is_interrupted: true, .. } => return Err(DeadlinePassed),
                _ => {}
            }
        }
        Ok(None)
    }
}

/// The deadline passed before the containment test was complete.
#[derive(Clone, Copy, Debug)]
pub(super) struct DeadlinePassed;

/// A point of one body inside a closed mesh of the other, in the frame of a. One point of each connected part is tested, and the centre
/// of each point or cube: where surfaces do not touch, the whole part is inside or outside.
#[inline]
pub(super) fn contained_point<B: BoundingVolume>(
    (a, b): (&CollisionBody<B>, &CollisionBody<B>),
    pose_ab: &MatrixPose,
    incumbent: &mut Incumbent,
    descent: &mut Descent,
) -> Result<Option<Point>, DeadlinePassed> {
    let Some((of_a, of_b)) = a.interior.as_ref().zip(b.interior.as_ref()) else { return Ok(None) };
    let pose = Pose::from(pose_ab);
    let part_of_b = |i: usize| pose * of_b.part_points[i];
    if let Some(i) = of_a.first_inside(of_b.part_points.len(), part_of_b, incumbent)? {
        return Ok(Some(part_of_b(i)));
    }
    let part_of_a = |i: usize| pose.inverse_transform_point(&of_a.part_points[i]);
    if let Some(i) = of_b.first_inside(of_a.part_points.len(), part_of_a, incumbent)? {
        return Ok(Some(of_a.part_points[i]));
    }
    if let Some(point) = of_a.grain_inside(&b.grains, pose_ab, incumbent, descent)? {
        return Ok(Some(point));
    }
    let inside_b = of_b.grain_inside(&a.grains, &pose_ab.inverse(), incumbent, descent)?;
    Ok(inside_b.map(|point| pose_ab * point))
}

impl ClosedMesh {
    fn test(&self) -> MeshTest<'_> {
        MeshTest { mesh: self, inside: self.mesh.inside_test() }
    }
}

/// Tests points against one mesh.
struct MeshTest<'i> {
    mesh: &'i ClosedMesh,
    inside: InsideTest<'i>,
}

impl MeshTest<'_> {
    /// True if a point (frame of the mesh's body) is inside.
    fn contains(&mut self, point_b: &Point, incumbent: &mut Incumbent) -> bool {
        incumbent.work.volume_tests += 1;
        let p = self.mesh.pose_bm.inverse_transform_point(point_b);
        let (lo, hi) = self.mesh.bounds;
        let is_inside = (0..3).all(|i| (lo[i]..=hi[i]).contains(&p[i])) && self.inside.encloses(&p);
        incumbent.work.volume_tests += self.inside.take_cost();
        is_inside
    }
}

/// Finds grains inside a mesh, between two planes of the box around it.
struct CentresInside<'i, 'w, B: BoundingVolume> {
    test: MeshTest<'i>,
    grains: &'i Grains<B>,
    pose_to_mesh_body: &'i MatrixPose,
    /// The axis along which the box is thinnest.
    axis: usize,
    half_width: f64,
    incumbent: &'i mut Incumbent<'w>,
    found: Option<Point>,
    is_interrupted: bool,
}

impl<'i, 'w, B: BoundingVolume> CentresInside<'i, 'w, B> {
    fn new(
        mesh: &'i ClosedMesh,
        grains: &'i Grains<B>,
        pose_to_mesh_body: &'i MatrixPose,
        incumbent: &'i mut Incumbent<'w>,
    ) -> Self {
        let widths = mesh.bounds.1 - mesh.bounds.0;
        let axis = widths.imin();
        let (test, half_width) = (mesh.test(), 0.5 * widths[axis]);
        let (found, is_interrupted) = (None, false);
        Self { test, grains, pose_to_mesh_body, axis, half_width, incumbent, found, is_interrupted }
    }

    /// In the frame of the grains.
    fn middle_plane(&self) -> TreePlane {
        let mesh = self.test.mesh;
        let (lo, hi) = mesh.bounds;
        let pose_mb = MatrixPose::from(&mesh.pose_bm).inverse();
        let pose_mg = pose_mb.compose(self.pose_to_mesh_body).compose(&self.grains.pose_bg);
        let axis = Vector::ith(self.axis, 1.0);
        let offset = nalgebra::center(&lo, &hi)[self.axis] - pose_mg.translation[self.axis];
        TreePlane::new(&pose_mg.rotation.tr_mul(&axis), offset, &self.grains.tree)
    }
}

impl<B: BoundingVolume> PlaneVisitor<GrainLeaf> for CentresInside<'_, '_, B> {
    #[allow(clippy::cast_possible_truncation)] // rounded up right after
    fn threshold(&self) -> f32 {
        if self.found.is_some() { f32::NEG_INFINITY } else { (self.half_width as f32).next_up() }
    }

    fn volume_tests(&mut self, count: u32) {
        self.incumbent.work.volume_tests += u64::from(count);
    }

    fn leaf(&mut self, leaf: &GrainLeaf) {
        for grain in leaf.first..leaf.first + leaf.count {
            let centre = self.pose_to_mesh_body * self.grains.centre(grain);
            if self.test.contains(&centre, self.incumbent) {
                self.found = Some(centre);
                return;
            }
        }
    }

    fn interrupted(&mut self) -> bool {
        self.is_interrupted = self.incumbent.interrupted();
        self.is_interrupted
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

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use super::super::distance::Effort;
    use super::super::scratch::Scratch;
    use super::super::search::Goal;
    use super::*;
    use clearance_geometry::{PointCloud, Primitive};

    fn box_mesh(half: f64) -> Shape {
        let at = |i: usize, k: usize| if i >> k & 1 == 0 { -half } else { half };
        let vertices = (0..8).map(|i| Point::new(at(i, 0), at(i, 1), at(i, 2))).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        Shape::Mesh(Arc::new(TriangleMesh::new(vertices, faces).unwrap()))
    }

    /// A point inside is found in either body; after the deadline no point counts as outside.
    #[test]
    fn the_deadline_counts_for_points_inside() {
        let cloud = PointCloud::new(vec![[0.1, 0.2, 0.3], [0.2, 0.1, 0.0], [5.0, 5.0, 5.0]], 0.01).unwrap();
        let inside = [
            box_mesh(0.1),
            Shape::Primitive(Primitive::Sphere { radius: 0.1 }),
            Shape::Points(Arc::new(cloud)),
        ];
        let (poses, solid) = ([Pose::identity(); 1], box_mesh(1.0));
        let body = |shape| CollisionBody::with_solid_meshes(poses.iter().zip([shape])).unwrap();
        for shape in &inside {
            for (a, b) in [(body(&solid), body(shape)), (body(shape), body(&solid))] {
                let found = |deadline| {
                    let goal = Goal { effort: Effort { deadline, ..Effort::default() }, ..Goal::CONTACT };
                    let Scratch { work, stack, starts, level, .. } = &mut Scratch::default();
                    let mut descent = Descent::new(*level, stack, starts);
                    let pose = MatrixPose::from(&Pose::identity());
                    contained_point((&a, &b), &pose, &mut Incumbent::new(goal, work), &mut descent)
                };
                assert!(found(None).unwrap().is_some());
                assert!(found(Some(Instant::now())).is_err());
            }
        }
    }
}
