//! Containment: tests whether a body whose surface touches nothing lies inside a closed mesh.
//!
//! If two surfaces do not touch, each connected part of one is wholly inside or wholly outside the other, so one point of each part
//! decides. Meshes that are partly open have an inside where the rest of them is closed. Point tests count as work, and stop at the
//! deadline.

use clearance_geometry::math::{MatrixPose, Point, Pose, Vector};

use super::best_so_far::BestSoFar;
use super::tree_traversal::TreeTraversal;
use crate::body::{BodyPair, ClosedMesh, CubeSet, Interior, MeshTest};
use crate::bounding_volume::BoundingVolume;
use crate::bvh::{CubeLeaf, PlaneVisitor, TreePlane};
use crate::narrow_phase::f32_above;

/// The deadline passed before the containment test was complete.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DeadlinePassed;

/// A point of one body inside a closed mesh of the other, in the frame of a. One point of each connected part is tested, and the centre
/// of each point or cube: where surfaces do not touch, the whole part is inside or outside.
#[inline]
pub(crate) fn contained_point<B: BoundingVolume>(
    bodies: BodyPair<B>,
    best_so_far: &mut BestSoFar,
    traversal: &mut TreeTraversal,
) -> Result<Option<Point>, DeadlinePassed> {
    let BodyPair { a, b, pose_ab } = bodies;
    let Some((inside_a, inside_b)) = a.interior().zip(b.interior()) else { return Ok(None) };
    let pose = Pose::from(pose_ab);
    let part_of_b = |i: usize| pose * inside_b.part_points()[i];
    if let Some(i) = first_inside(inside_a, inside_b.part_points().len(), part_of_b, best_so_far)? {
        return Ok(Some(part_of_b(i)));
    }
    let part_of_a = |i: usize| pose.inverse_transform_point(&inside_a.part_points()[i]);
    if let Some(i) = first_inside(inside_b, inside_a.part_points().len(), part_of_a, best_so_far)? {
        return Ok(Some(inside_a.part_points()[i]));
    }
    if let Some(point) = cube_inside(inside_a, b.cube_sets(), pose_ab, best_so_far, traversal)? {
        return Ok(Some(point));
    }
    let found = cube_inside(inside_b, a.cube_sets(), &pose_ab.inverse(), best_so_far, traversal)?;
    Ok(found.map(|point| pose_ab * point))
}

/// The index of the first of `count` points (frame of the interior's body) that is inside one of the meshes.
fn first_inside(
    interior: &Interior,
    count: usize,
    point: impl Fn(usize) -> Point,
    best_so_far: &mut BestSoFar,
) -> Result<Option<usize>, DeadlinePassed> {
    let mut found = None;
    for mesh in interior.closed_meshes() {
        let mut test = mesh.test();
        for i in 0..found.unwrap_or(count) {
            if best_so_far.interrupted() {
                return if found.is_some() { Ok(found) } else { Err(DeadlinePassed) };
            }
            if test.contains(&point(i), &mut best_so_far.work.volume_tests) {
                found = Some(i);
                break;
            }
        }
    }
    Ok(found)
}

/// The centre of a cube of another body inside one of the meshes, in the frame of the interior's body.
fn cube_inside<B: BoundingVolume>(
    interior: &Interior,
    sets: &[CubeSet<B>],
    pose_to_own: &MatrixPose,
    best_so_far: &mut BestSoFar,
    traversal: &mut TreeTraversal,
) -> Result<Option<Point>, DeadlinePassed> {
    for (mesh, cubes) in
        interior.closed_meshes().iter().flat_map(|mesh| sets.iter().map(move |set| (mesh, set)))
    {
        let mut visitor = CentresInside::new(mesh, cubes, pose_to_own, best_so_far);
        let plane = visitor.middle_plane();
        traversal.run_to_plane(cubes.tree(), &plane, &mut visitor, 0.0);
        match visitor {
            CentresInside { found: Some(point), .. } => return Ok(Some(point)),
            CentresInside { is_interrupted: true, .. } => return Err(DeadlinePassed),
            _ => {}
        }
    }
    Ok(None)
}

/// Finds cubes inside a mesh, between two planes of the box around it.
struct CentresInside<'i, 'w, B: BoundingVolume> {
    test: MeshTest<'i>,
    cubes: &'i CubeSet<B>,
    pose_to_mesh_body: &'i MatrixPose,
    /// The axis along which the box is thinnest.
    axis: usize,
    half_width: f64,
    best_so_far: &'i mut BestSoFar<'w>,
    found: Option<Point>,
    is_interrupted: bool,
}

impl<'i, 'w, B: BoundingVolume> CentresInside<'i, 'w, B> {
    fn new(
        mesh: &'i ClosedMesh,
        cubes: &'i CubeSet<B>,
        pose_to_mesh_body: &'i MatrixPose,
        best_so_far: &'i mut BestSoFar<'w>,
    ) -> Self {
        let (lo, hi) = mesh.bounds();
        let widths = hi - lo;
        let axis = widths.imin();
        let (test, half_width) = (mesh.test(), 0.5 * widths[axis]);
        let (found, is_interrupted) = (None, false);
        Self { test, cubes, pose_to_mesh_body, axis, half_width, best_so_far, found, is_interrupted }
    }

    /// In the frame of the cubes.
    fn middle_plane(&self) -> TreePlane {
        let mesh = self.test.mesh();
        let (lo, hi) = mesh.bounds();
        let pose_mb = MatrixPose::from(mesh.pose_bm()).inverse();
        let pose_ms = pose_mb.compose(self.pose_to_mesh_body).compose(self.cubes.pose_bs());
        let axis = Vector::ith(self.axis, 1.0);
        let offset = nalgebra::center(lo, hi)[self.axis] - pose_ms.translation[self.axis];
        TreePlane::new(&pose_ms.rotation.tr_mul(&axis), offset, self.cubes.tree())
    }
}

impl<B: BoundingVolume> PlaneVisitor<CubeLeaf> for CentresInside<'_, '_, B> {
    fn threshold(&self) -> f32 {
        if self.found.is_some() { f32::NEG_INFINITY } else { f32_above(self.half_width) }
    }

    fn volume_tests(&mut self, count: u32) {
        self.best_so_far.work.volume_tests += u64::from(count);
    }

    fn leaf(&mut self, leaf: &CubeLeaf) {
        for cube in leaf.first..leaf.first + leaf.count {
            let centre = self.pose_to_mesh_body * self.cubes.centre(cube);
            if self.test.contains(&centre, &mut self.best_so_far.work.volume_tests) {
                self.found = Some(centre);
                return;
            }
        }
    }

    fn interrupted(&mut self) -> bool {
        self.is_interrupted = self.best_so_far.interrupted();
        self.is_interrupted
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::time::Instant;

    use super::super::effort::Effort;
    use super::super::goal::Goal;
    use super::super::scratch::{Scratch, ScratchParts};
    use super::*;
    use crate::body::CollisionBody;
    use clearance_geometry::{PointCloud, Primitive, Shape, TriangleMesh};

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
                    let scratch = &mut Scratch::default();
                    let ScratchParts { work, traversal, .. } = scratch.begin();
                    let pose_ab = &MatrixPose::from(&Pose::identity());
                    let bodies = BodyPair { a: &a, b: &b, pose_ab };
                    contained_point(bodies, &mut BestSoFar::new(goal, work), traversal)
                };
                assert!(found(None).unwrap().is_some());
                assert!(found(Some(Instant::now())).is_err());
            }
        }
    }
}
