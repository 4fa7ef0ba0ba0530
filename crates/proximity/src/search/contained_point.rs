//! Containment: tests whether a body whose surface touches nothing lies inside a closed mesh.
//!
//! If two surfaces do not touch, each connected part of one is wholly inside or wholly outside the other, so one point of each part
//! decides. Meshes that are partly open have an inside where the rest of them is closed. Point tests count as work, and stop at the
//! deadline.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{MatrixPose, Point, Pose};
use clearance_geometry::simd::Simd;

use super::best_so_far::BestSoFar;
use super::searched_pieces::SearchedPieces;
use super::tree_traversal::TreeTraversal;
use crate::body::{BodyPair, CubeSet, Interior, MeshTest, SolidLeaf};
use crate::bvh::{CubeLeaf, TreePair, Visitor};
use crate::narrow_phase::f32_above;

/// The deadline passed before the containment test was complete.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DeadlinePassed;

/// A point of one body inside a closed mesh of the other, in the frame of a. A point of each connected part is tested, or a point that it
/// encloses, and the centre of each point or cube: where surfaces do not touch, the whole part is inside or outside.
///
/// Of pieces of b, only the inside may contain a part of a. A part of b that is inside a mesh of a has other pieces near that mesh.
pub(crate) fn contained_point(
    bodies: BodyPair,
    pieces: SearchedPieces,
    best_so_far: &mut BestSoFar,
    traversal: &mut TreeTraversal,
) -> Result<Option<Point>, DeadlinePassed> {
    let BodyPair { a, b, pose_ab } = bodies;
    let Some((inside_a, inside_b)) = a.interior().zip(b.interior()) else { return Ok(None) };
    let searches_inside_a = pieces.has_elements() && !inside_a.closed_meshes().is_empty();
    let searches_inside_b = pieces.has_inside() && !inside_b.closed_meshes().is_empty();
    let pose_ba = &pose_ab.inverse();
    if searches_inside_a {
        let decisive = first_inside(inside_a, inside_b.decisive_points(), pose_ab, best_so_far)?;
        if let Some(i) = decisive {
            let known = pose_ab * inside_b.decisive_points()[i];
            return Ok(Some(part_inside([inside_a, inside_b], pose_ab, known, best_so_far)));
        }
    }
    if searches_inside_b {
        let decisive = first_inside(inside_b, inside_a.decisive_points(), pose_ba, best_so_far)?;
        if let Some(i) = decisive {
            let known = inside_a.decisive_points()[i];
            return Ok(Some(part_inside([inside_a, inside_b], pose_ab, known, best_so_far)));
        }
    }
    for cubes in b.cube_sets() {
        pieces.of_cubes(cubes.index(), cubes.tree().root(), traversal.starts());
        if let Some(point) = cube_inside(inside_a, cubes, pose_ab, best_so_far, traversal)? {
            return Ok(Some(point));
        }
    }
    if searches_inside_b {
        for cubes in a.cube_sets() {
            traversal.start_at(cubes.tree().root());
            if let Some(point) = cube_inside(inside_b, cubes, pose_ba, best_so_far, traversal)? {
                return Ok(Some(pose_ab * point));
            }
        }
    }
    Ok(None)
}

/// A point of a connected part that is inside the other body, of two of which one has a part inside the other; `known` is a common point
/// (frame of a) of their insides.
fn part_inside(
    [inside_a, inside_b]: [&Interior; 2],
    pose_ab: &MatrixPose,
    known: Point,
    best_so_far: &mut BestSoFar,
) -> Point {
    // the contact is proven; a deadline only ends the search for a better point
    if let Ok(Some(i)) = first_inside(inside_a, inside_b.part_points(), pose_ab, best_so_far) {
        return Pose::from(pose_ab) * inside_b.part_points()[i];
    }
    match first_inside(inside_b, inside_a.part_points(), &pose_ab.inverse(), best_so_far) {
        Ok(Some(i)) => inside_a.part_points()[i],
        Ok(None) | Err(DeadlinePassed) => known,
    }
}

/// The index of the first point of another body that is inside one of the meshes.
fn first_inside(
    interior: &Interior,
    points: &[Point],
    pose_to_own: &MatrixPose,
    best_so_far: &mut BestSoFar,
) -> Result<Option<usize>, DeadlinePassed> {
    let mut found = None;
    for mesh in interior.closed_meshes() {
        let mut test = mesh.test();
        for (i, point) in points.iter().enumerate().take(found.unwrap_or(points.len())) {
            if best_so_far.interrupted() {
                return if found.is_some() { Ok(found) } else { Err(DeadlinePassed) };
            }
            let is_inside = test.contains(&(pose_to_own * *point));
            best_so_far.work.volume_tests += 1;
            best_so_far.work.add_inside_tests(test.take_work());
            if is_inside {
                found = Some(i);
                break;
            }
        }
    }
    Ok(found)
}

/// The centre of a cube, of those below the start nodes, inside one of the meshes; in the frame of the interior's body.
fn cube_inside(
    interior: &Interior,
    cubes: &CubeSet,
    pose_to_own: &MatrixPose,
    best_so_far: &mut BestSoFar,
    traversal: &mut TreeTraversal,
) -> Result<Option<Point>, DeadlinePassed> {
    for mesh in interior.closed_meshes() {
        let relative = &mesh.outline().relative(cubes.tree(), &pose_to_own.compose(cubes.pose_bs()));
        let (test, found, is_interrupted) = (mesh.test(), None, false);
        let mut visitor = CentresInside { test, cubes, pose_to_own, best_so_far, found, is_interrupted };
        let trees = TreePair { a: mesh.outline(), b: cubes.tree(), relative };
        traversal.run_from_starts(trees, &mut visitor, 0.0);
        match visitor {
            CentresInside { found: Some(point), .. } => return Ok(Some(point)),
            CentresInside { is_interrupted: true, .. } => return Err(DeadlinePassed),
            _ => {}
        }
    }
    Ok(None)
}

/// Finds a cube whose centre is inside a mesh, among those in the box around it.
struct CentresInside<'i, 'w> {
    test: MeshTest<'i>,
    cubes: &'i CubeSet,
    /// Pose of the cubes' body in the mesh's body.
    pose_to_own: &'i MatrixPose,
    best_so_far: &'i mut BestSoFar<'w>,
    found: Option<Point>,
    is_interrupted: bool,
}

impl Visitor<SolidLeaf, CubeLeaf> for CentresInside<'_, '_> {
    const SEPARATE: bool = true;

    fn threshold(&self) -> f32 {
        if self.found.is_some() { f32::NEG_INFINITY } else { f32_above(CONTACT_DISTANCE) }
    }

    fn volume_tests(&mut self, count: u32) {
        self.best_so_far.work.volume_tests += u64::from(count);
    }

    #[inline(always)]
    fn leaves<S: Simd>(&mut self, _: S, _: &SolidLeaf, leaf: &CubeLeaf) {
        for cube in leaf.first..leaf.first + leaf.count {
            let centre = self.pose_to_own * self.cubes.centre(cube);
            if self.test.contains(&centre) {
                self.found = Some(centre);
                break;
            }
        }
        self.best_so_far.work.volume_tests += u64::from(leaf.count);
        self.best_so_far.work.add_inside_tests(self.test.take_work());
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
                    contained_point(bodies, SearchedPieces::All, &mut BestSoFar::new(goal, work), traversal)
                };
                assert!(found(None).unwrap().is_some());
                assert!(found(Some(Instant::now())).is_err());
            }
        }
    }
}
