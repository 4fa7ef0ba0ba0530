//! Test oracle: trait of the reference engine's bounding volumes (OBB, RSS).

use clearance::geometry::Primitive;
use clearance::geometry::math::{Point, Pose, RotationMatrix, Vector};

/// Slack of a separating-axis test, relative to the coordinates that enter it: a separation must exceed the rounding of
/// the sums it is made of, else the axis does not count as separating (Ericson, *Real-Time Collision Detection*, 4.4.1).
pub const SEPARATION_SLACK: f64 = 1e-14;

/// Axes along which points spread, the largest spread first.
pub fn principal_axes(points: &[Point]) -> RotationMatrix {
    let vectors: Vec<Vector> = points.iter().map(|p| p.coords).collect();
    clearance::proximity::bounding_volume::principal_axes(&vectors)
}

/// A solid that is cheap to test and holds what it was fitted to.
pub trait BoundingVolume: Clone {
    /// A volume that holds the convex hull of `points`, in their frame. Rounding never leaves a point outside.
    fn fit(points: &[Point]) -> Self;

    /// A volume that holds a primitive placed at `pose`.
    fn around(primitive: &Primitive, pose: &Pose) -> Self;

    /// A number never larger than the distance (m) between the two volumes; `pose_ab` is the pose of `other`'s frame
    /// in this one's. Zero when they overlap.
    fn lower_bound(&self, other: &Self, pose_ab: &Pose) -> f64;

    /// False only if the volumes are more than [`CONTACT_DISTANCE`](clearance::geometry::constants::CONTACT_DISTANCE) apart.
    fn may_touch(&self, other: &Self, pose_ab: &Pose) -> bool;

    /// A measure by which the larger of two volumes is split first.
    fn size(&self) -> f64;
}
