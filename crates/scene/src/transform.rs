//! Transform of one frame relative to its parent, as `tf` publishes it.

use clearance_geometry::math::Pose;

use super::Time;

/// The transform of a frame relative to its parent.
#[derive(Clone, Debug, PartialEq)]
pub struct Transform {
    /// Name of the parent frame.
    pub parent: String,
    /// Pose of the frame in its parent.
    pub pose_pf: Pose,
    /// Stamp of the transform; `None` if it is static.
    pub stamp: Option<Time>,
}

/// The latest transform of a frame.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct StoredTransform {
    pub transform: Transform,
    /// Time (s) by which its stamp was later than the clock when it was received.
    pub lead: f64,
    /// Number of this transform in the order of reception.
    pub number: u64,
    /// True if the frame was received more than once, with different stamps; a frame received only once need not be repeated.
    pub is_alive: bool,
}
