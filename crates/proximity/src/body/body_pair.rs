//! Two posed bodies, the input of every query.

use clearance_geometry::math::MatrixPose;

use super::collision_body::CollisionBody;

/// Two bodies, the second posed in the frame of the first.
#[derive(Clone, Copy, Debug)]
pub struct BodyPair<'b> {
    /// First body; results are in its frame.
    pub a: &'b CollisionBody,
    /// Second body.
    pub b: &'b CollisionBody,
    /// Pose of b in the frame of a.
    pub pose_ab: &'b MatrixPose,
}

impl BodyPair<'_> {
    /// True if closed meshes are solids, and either body has one.
    #[inline]
    pub(crate) fn has_inside(&self) -> bool {
        let interiors = self.a.interior().zip(self.b.interior());
        interiors.is_some_and(|(a, b)| !a.closed_meshes().is_empty() || !b.closed_meshes().is_empty())
    }
}
