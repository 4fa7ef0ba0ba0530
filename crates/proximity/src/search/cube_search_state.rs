//! State of a search for the elements nearest to the cubes of one body: threshold, direction, test of one pair.

use clearance_geometry::math::MatrixPose;

use super::best_so_far::BestSoFar;
use crate::body::CubeSet;
use crate::bounding_volume::Relative;
use crate::elements::{ElementId, ElementPair, RoundedShape};
use crate::narrow_phase::{separation_within, shortened_to_f32, widened};

/// Cubes of one body, and the elements of the other body found near them. The tree of cubes is the second in a traversal.
pub(crate) struct CubeSearch<'s, 'w> {
    pub cubes: &'s CubeSet,
    /// True if the cubes belong to body a.
    pub cubes_are_a: bool,
    pub pose_ab: &'s MatrixPose,
    /// Pose of the other tree in that of the cubes.
    pub relative: &'s Relative,
    /// Sum of the radii (m) of the balls around the elements of both trees.
    pub radius: f64,
    pub best_so_far: &'s mut BestSoFar<'w>,
}

impl CubeSearch<'_, '_> {
    /// Trees farther apart than this (m) are skipped.
    #[inline]
    pub fn threshold(&self) -> f32 {
        widened(self.best_so_far.threshold(), self.radius)
    }

    /// The direction of the best separation, in the frame of the cubes' tree; length at most one.
    #[inline]
    pub fn direction(&self) -> [f32; 3] {
        let Some(best) = self.best_so_far.separation() else { return [0.0; 3] };
        let along = best.direction();
        let in_body = if self.cubes_are_a { along } else { self.pose_ab.rotation.tr_mul(&along) };
        shortened_to_f32(&self.cubes.pose_bs().rotation.tr_mul(&in_body))
    }

    /// Measures one element of the other body and one cube.
    #[inline]
    pub fn test(&mut self, other: &RoundedShape, other_id: ElementId, cube: u32) {
        self.best_so_far.work.primitive_tests += 1;
        let own = &self.cubes.shape(cube);
        let (a, b) = if self.cubes_are_a { (own, other) } else { (other, own) };
        if let Some(found) = separation_within(a, b, self.pose_ab, self.best_so_far.bound()) {
            let elements = ElementPair::ordered(self.cubes.id(cube), other_id, self.cubes_are_a);
            self.best_so_far.offer_elements(found, elements);
        }
    }
}
