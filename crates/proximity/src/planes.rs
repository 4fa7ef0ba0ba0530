//! Queries of planes against all kinds of elements. A plane has no bounding volume and no tree: each plane is tested against the trees of
//! the other body, whose volumes have a range along its normal.

use clearance_geometry::constants::{CONTACT_DISTANCE, FIT_SLACK};
use clearance_geometry::math::{Extremes, MatrixPose, Pose, UnitVector};
use clearance_geometry::{Plane, PointPair};

use super::body::CollisionBody;
use super::bounding_sphere::BoundingSphere;
use super::core::RoundedCore;
use super::element::ElementNumber;
use super::element_pair::Separation;
use super::grains::{Grains, widened};
use super::incumbent::Incumbent;
use super::search::Descent;
use super::solid::SolidLeaf;
use super::surface::Surface;
use crate::bounding_volume::BoundingVolume;
use crate::bvh::{GrainLeaf, PlaneVisitor, TreePlane, TriangleLeaf};

/// Sine of an angle that counts as zero: normals have a smaller rounding error, and planes a metre apart with a larger angle meet within
/// 10¹⁴ m.
const PARALLEL: f64 = 1e-14;

/// Finds the elements nearest to planes of either body.
#[inline]
pub(super) fn planes<B: BoundingVolume>(
    (a, b): (&CollisionBody<B>, &CollisionBody<B>),
    pose_ab: &MatrixPose,
    incumbent: &mut Incumbent,
    descent: &mut Descent,
) {
    let (pose_ba, rigid) = (pose_ab.inverse(), Pose::from(pose_ab));
    for (plane, number) in a.planes.iter().zip(0..) {
        let plane_b = placed(plane, &pose_ba);
        let number = ElementNumber::of_plane(number);
        PlaneSearch { plane: plane_b, number, plane_is_a: true, pose_ab, incumbent }.all_of(b, descent);
        for (other, index) in b.planes.iter().zip(0..) {
            let found = between_planes(plane, &other.transformed(&rigid));
            incumbent.offer_numbered(found, (number, ElementNumber::of_plane(index)));
        }
    }
    for (plane, number) in b.planes.iter().zip(0..) {
        let plane_a = placed(plane, pose_ab);
        let number = ElementNumber::of_plane(number);
        PlaneSearch { plane: plane_a, number, plane_is_a: false, pose_ab, incumbent }.all_of(a, descent);
    }
}

/// Lower bound on the distance (m) of planes of either body from anything of the other body.
#[inline]
pub(super) fn planes_bound<B: BoundingVolume>(
    (a, b): (&CollisionBody<B>, &CollisionBody<B>),
    pose_ab: &MatrixPose,
) -> f64 {
    if a.has_planes() && b.has_planes() {
        return 0.0;
    }
    let least = |planes: &[Plane], body: &CollisionBody<B>, pose: &MatrixPose| {
        let bound = |plane: &Plane| body.bounded().map(|sphere| sphere_bound(&placed(plane, pose), sphere));
        planes.iter().filter_map(bound).fold(f64::INFINITY, f64::lesser)
    };
    if a.has_planes() { least(&a.planes, b, &pose_ab.inverse()) } else { least(&b.planes, a, pose_ab) }
}

/// As above, for a plane and the content of a sphere, in one frame.
fn sphere_bound(plane: &Plane, sphere: &BoundingSphere) -> f64 {
    let entered = sphere.centre.coords.abs().sum() + plane.offset.abs() + sphere.radius;
    plane.height(&sphere.centre).abs() - sphere.radius - FIT_SLACK * entered
}

/// Transforms a plane from a frame placed at `pose` to the parent frame.
fn placed(plane: &Plane, pose: &MatrixPose) -> Plane {
    let normal = pose.rotation * plane.normal.into_inner();
    Plane { offset: plane.offset + normal.dot(&pose.translation), normal: UnitVector::new_unchecked(normal) }
}

/// One plane, and the elements found near it.
struct PlaneSearch<'s, 'w> {
    /// In the frame of the other body.
    plane: Plane,
    number: ElementNumber,
    /// Whether the plane belongs to body a.
    plane_is_a: bool,
    pose_ab: &'s MatrixPose,
    incumbent: &'s mut Incumbent<'w>,
}

impl PlaneSearch<'_, '_> {
    /// Searches the whole other body.
    fn all_of<B: BoundingVolume>(&mut self, body: &CollisionBody<B>, descent: &mut Descent) {
        self.incumbent.work.volume_tests += 1;
        if body.bounded().is_none_or(|sphere| sphere_bound(&self.plane, sphere) > self.incumbent.bound()) {
            return;
        }
        let Plane { normal, offset } = self.plane;
        if let Some(solids) = &body.solids {
            let plane = TreePlane::new(&normal, offset, solids);
            descent.run_to_plane(
                solids,
                &plane,
                &mut OfElements { search: self, elements: (), radius: 0.0 },
                0.0,
            );
        }
        if let Some(surface) = &body.surface {
            let plane = TreePlane::new(&normal, offset, &surface.tree);
            let visitor = &mut OfElements { search: self, elements: surface, radius: 0.0 };
            descent.run_to_plane(&surface.tree, &plane, visitor, 0.0);
        }
        for grains in &body.grains {
            // transformed from the frame of the grains
            let Plane { normal, offset } = placed(&self.plane, &grains.pose_bg.inverse());
            let plane = TreePlane::new(&normal, offset, &grains.tree);
            let visitor = &mut OfElements { search: self, elements: grains, radius: grains.radius };
            descent.run_to_plane(&grains.tree, &plane, visitor, grains.radius);
        }
    }

    fn test(&mut self, element: &RoundedCore, number: ElementNumber) {
        self.incumbent.work.primitive_tests += 1;
        let Separation { distance, witness_points } = separation(element, &self.plane);
        let [on_element, on_plane] = witness_points;
        let (witness_points, numbers) = if self.plane_is_a {
            ([on_plane, on_element].map(|p| self.pose_ab * p), (self.number, number))
        } else {
            ([on_element, on_plane], (number, self.number))
        };
        self.incumbent.offer_numbered(Separation { distance, witness_points }, numbers);
    }
}

/// Elements of one kind near a plane.
struct OfElements<'p, 's, 'w, E> {
    search: &'p mut PlaneSearch<'s, 'w>,
    elements: E,
    /// Of the balls around what the tree holds (m).
    radius: f64,
}

/// All elements of a leaf.
trait Elements<L> {
    fn each(&self, leaf: &L, see: impl FnMut(&RoundedCore, ElementNumber));
}

impl Elements<SolidLeaf> for () {
    fn each(&self, leaf: &SolidLeaf, mut see: impl FnMut(&RoundedCore, ElementNumber)) {
        see(&leaf.core, ElementNumber::of_solid(leaf.number));
    }
}

impl<B: BoundingVolume> Elements<TriangleLeaf> for &Surface<B> {
    fn each(&self, leaf: &TriangleLeaf, mut see: impl FnMut(&RoundedCore, ElementNumber)) {
        for i in leaf.first..leaf.first + leaf.count {
            see(&self.core(i), ElementNumber::of_triangle(i));
        }
    }
}

impl<B: BoundingVolume> Elements<GrainLeaf> for &Grains<B> {
    fn each(&self, leaf: &GrainLeaf, mut see: impl FnMut(&RoundedCore, ElementNumber)) {
        for i in leaf.first..leaf.first + leaf.count {
            see(&self.core(i), ElementNumber::of_grain(self.set, i));
        }
    }
}

impl<L, E: Elements<L>> PlaneVisitor<L> for OfElements<'_, '_, '_, E> {
    fn threshold(&self) -> f32 {
        widened(self.search.incumbent.threshold(), self.radius)
    }

    fn volume_tests(&mut self, count: u32) {
        self.search.incumbent.work.volume_tests += u64::from(count);
    }

    fn leaf(&mut self, leaf: &L) {
        self.elements.each(leaf, |element, number| self.search.test(element, number));
    }

    fn interrupted(&mut self) -> bool {
        self.search.incumbent.interrupted()
    }
}

/// Distance of a convex element from a plane of its body's frame; the witness points are on the element and on the plane.
fn separation(element: &RoundedCore, plane: &Plane) -> Separation {
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
