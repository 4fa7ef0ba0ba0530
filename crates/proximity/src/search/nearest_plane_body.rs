//! Queries of planes against all kinds of elements. A plane has no bounding volume and no tree: each plane is tested against the trees of
//! the other body, whose volumes have a range along its normal.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{MatrixPose, Pose};
use clearance_geometry::{Plane, PointPair};

use super::best_so_far::BestSoFar;
use super::tree_traversal::TreeTraversal;
use crate::body::{BodyPair, CollisionBody, CubeSet, SolidLeaf, Surface};
use crate::bvh::{CubeLeaf, PlaneVisitor, TreePlane, TriangleLeaf};
use crate::elements::{ElementId, ElementPair, RoundedShape};
use crate::narrow_phase::{Separation, widened};

/// Sine of an angle that counts as zero: normals have a smaller rounding error, and planes a metre apart with a larger angle meet within
/// 10¹⁴ m.
const PARALLEL: f64 = 1e-14;

/// Finds the elements nearest to planes of either body.
pub(crate) fn nearest_to_planes(
    bodies: BodyPair,
    best_so_far: &mut BestSoFar,
    traversal: &mut TreeTraversal,
) {
    let BodyPair { a, b, pose_ab } = bodies;
    let (pose_ba, rigid) = (pose_ab.inverse(), Pose::from(pose_ab));
    for (plane, index) in a.planes().iter().zip(0..) {
        let plane_b = plane.placed(&pose_ba);
        let id = ElementId::of_plane(index);
        PlaneSearch { plane: plane_b, id, plane_is_a: true, pose_ab, best_so_far }.all_of(b, traversal);
        for (other, index) in b.planes().iter().zip(0..) {
            let found = between_planes(plane, &other.transformed(&rigid));
            best_so_far.offer_elements(found, ElementPair { a: id, b: ElementId::of_plane(index) });
        }
    }
    for (plane, index) in b.planes().iter().zip(0..) {
        let plane_a = plane.placed(pose_ab);
        let id = ElementId::of_plane(index);
        PlaneSearch { plane: plane_a, id, plane_is_a: false, pose_ab, best_so_far }.all_of(a, traversal);
    }
}

/// One plane, and the elements found near it.
struct PlaneSearch<'s, 'w> {
    /// In the frame of the other body.
    plane: Plane,
    id: ElementId,
    /// Whether the plane belongs to body a.
    plane_is_a: bool,
    pose_ab: &'s MatrixPose,
    best_so_far: &'s mut BestSoFar<'w>,
}

impl PlaneSearch<'_, '_> {
    /// Searches the whole other body.
    fn all_of(&mut self, body: &CollisionBody, traversal: &mut TreeTraversal) {
        self.best_so_far.work.volume_tests += 1;
        if body.bounded().is_none_or(|sphere| sphere.plane_bound(&self.plane) > self.best_so_far.bound()) {
            return;
        }
        let Plane { normal, offset } = self.plane;
        if let Some(solids) = body.solids() {
            let plane = TreePlane::new(&normal, offset, solids);
            traversal.run_to_plane(
                solids,
                &plane,
                &mut NearPlane { search: self, elements: (), radius: 0.0 },
                0.0,
            );
        }
        if let Some(surface) = body.surface() {
            let plane = TreePlane::new(&normal, offset, surface.tree());
            let visitor = &mut NearPlane { search: self, elements: surface, radius: 0.0 };
            traversal.run_to_plane(surface.tree(), &plane, visitor, 0.0);
        }
        for cubes in body.cube_sets() {
            // transformed from the frame of the cubes
            let Plane { normal, offset } = self.plane.placed(&cubes.pose_bs().inverse());
            let plane = TreePlane::new(&normal, offset, cubes.tree());
            let visitor = &mut NearPlane { search: self, elements: cubes, radius: cubes.radius() };
            traversal.run_to_plane(cubes.tree(), &plane, visitor, cubes.radius());
        }
    }

    fn test(&mut self, element: &RoundedShape, id: ElementId) {
        self.best_so_far.work.primitive_tests += 1;
        let Separation { distance, witness_points } = separation(element, &self.plane);
        let [on_element, on_plane] = witness_points;
        let witness_points = if self.plane_is_a {
            [on_plane, on_element].map(|p| self.pose_ab * p)
        } else {
            [on_element, on_plane]
        };
        let elements = ElementPair::ordered(self.id, id, self.plane_is_a);
        self.best_so_far.offer_elements(Separation { distance, witness_points }, elements);
    }
}

/// Elements of one kind near a plane.
struct NearPlane<'p, 's, 'w, E> {
    search: &'p mut PlaneSearch<'s, 'w>,
    elements: E,
    /// Of the balls around what the tree holds (m).
    radius: f64,
}

/// All elements of a leaf.
trait Elements<L> {
    fn each(&self, leaf: &L, see: impl FnMut(&RoundedShape, ElementId));
}

impl Elements<SolidLeaf> for () {
    fn each(&self, leaf: &SolidLeaf, mut see: impl FnMut(&RoundedShape, ElementId)) {
        see(&leaf.shape, ElementId::of_solid(leaf.index));
    }
}

impl Elements<TriangleLeaf> for &Surface {
    fn each(&self, leaf: &TriangleLeaf, mut see: impl FnMut(&RoundedShape, ElementId)) {
        for i in leaf.first..leaf.first + leaf.count {
            see(&self.shape(i), ElementId::of_triangle(i));
        }
    }
}

impl Elements<CubeLeaf> for &CubeSet {
    fn each(&self, leaf: &CubeLeaf, mut see: impl FnMut(&RoundedShape, ElementId)) {
        for i in leaf.first..leaf.first + leaf.count {
            see(&self.shape(i), self.id(i));
        }
    }
}

impl<L, E: Elements<L>> PlaneVisitor<L> for NearPlane<'_, '_, '_, E> {
    fn threshold(&self) -> f32 {
        widened(self.search.best_so_far.threshold(), self.radius)
    }

    fn volume_tests(&mut self, count: u32) {
        self.search.best_so_far.work.volume_tests += u64::from(count);
    }

    fn leaf(&mut self, leaf: &L) {
        self.elements.each(leaf, |element, id| self.search.test(element, id));
    }

    fn interrupted(&mut self) -> bool {
        self.search.best_so_far.interrupted()
    }
}

/// Distance of a convex element from a plane of its body's frame; the witness points are on the element and on the plane.
fn separation(element: &RoundedShape, plane: &Plane) -> Separation {
    let Plane { normal, .. } = plane;
    let along = element.pose.rotation.tr_mul(normal);
    let [top, bottom] = [along, -along].map(|n| &element.pose * element.core.support(&n));
    let (high, low) = (plane.height(&top), plane.height(&bottom));
    if low <= 0.0 && high >= 0.0 {
        let share = if high > low { -low / (high - low) } else { 0.0 };
        return Separation::touching_at(bottom + (top - bottom) * share);
    }
    let (nearest, height) = if low > 0.0 { (bottom, low) } else { (top, high) };
    let on_plane = nearest - normal.into_inner() * height;
    let distance = height.abs() - element.radius;
    if distance <= CONTACT_DISTANCE {
        return Separation::touching_at(on_plane);
    }
    let on_element = nearest - normal.into_inner() * element.radius.copysign(height);
    Separation { distance, witness_points: [on_element, on_plane] }
}

/// Two planes meet, unless they are parallel.
fn between_planes(a: &Plane, b: &Plane) -> Separation {
    let on_a = a.foot();
    let height = b.height(&on_a);
    let on_b = on_a - b.normal.into_inner() * height;
    let across = a.normal.cross(&b.normal).norm_squared();
    let pair: PointPair = if across > PARALLEL * PARALLEL {
        let downhill = b.normal.into_inner() - a.normal.into_inner() * a.normal.dot(&b.normal);
        [on_a - downhill * (height / across); 2]
    } else {
        [on_a, on_b]
    };
    Separation::of(pair)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clearance_geometry::math::Vector;

    #[test]
    fn planes_meet_unless_they_are_parallel() {
        let plane = |c: [f64; 4]| Plane::from_coefficients(c).unwrap();
        let floor = plane([0.0, 0.0, 1.0, 0.0]);
        let ceiling = between_planes(&floor, &plane([0.0, 0.0, -2.0, 5.0]));
        assert!((ceiling.distance - 2.5).abs() < 1e-15);
        assert_eq!(ceiling.witness_points[1] - ceiling.witness_points[0], Vector::new(0.0, 0.0, 2.5));
        let ramp = plane([1e-3, 0.0, 1.0, -2.0]);
        let met = between_planes(&floor, &ramp);
        assert_eq!(met.distance, 0.0);
        let [p, _] = met.witness_points;
        assert!(floor.height(&p).abs() < 1e-9 && ramp.height(&p).abs() < 1e-9);
    }
}
