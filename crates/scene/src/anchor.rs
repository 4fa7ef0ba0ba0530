//! Anchor: the pose of an object in a world-fixed frame, which it keeps while the robot moves.

use clearance_geometry::math::Pose;

/// Smaller displacements (m, rad) do not count as motion of the root.
pub const LEAST_MOTION: f64 = 1e-4;

/// Pose of an object or frame in a world-fixed frame, which is no part of the robot.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Anchor {
    pub frame: String,
    pose_fo: Pose,
    /// Pose of the world-fixed frame in the root frame at the last update. It cannot be computed from the two other poses: far from the
    /// root, rounding exceeds the motion threshold.
    pub pose_rf: Pose,
    pub certainty: Certainty,
}

/// A world-fixed frame that objects are anchored to.
pub(super) struct AnchorFrame {
    pub frame: String,
    /// Its present pose in the root frame.
    pub pose_rf: Pose,
    pub certainty: Certainty,
}

/// Source of a world-fixed frame's pose, in ascending order of information about where the root may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Certainty {
    /// A fixed virtual joint puts the root at zero in the frame.
    Fixed,
    /// Without any information, the root is assumed to be at zero in the frame.
    Assumed,
    /// `tf` has given the pose at least once.
    FromTf,
}

impl Anchor {
    /// Anchors an object at this pose in the root frame to a world-fixed frame.
    pub fn new(AnchorFrame { frame, pose_rf, certainty }: AnchorFrame, pose_ro: &Pose) -> Self {
        Self { frame, pose_fo: pose_rf.inverse() * pose_ro, pose_rf, certainty }
    }

    /// The same anchored pose, for an object that was placed at its own pose in the root frame.
    pub fn at_pose(&self, pose_ro: &Pose) -> Self {
        Self { pose_rf: pose_ro * self.pose_fo.inverse(), ..self.clone() }
    }

    /// The new pose in the root frame, if it differs from the last one.
    /// `now`: present pose of the world-fixed frame in the root frame by `tf`.
    pub fn follow(&mut self, now: Option<Pose>) -> Option<Pose> {
        let now = now?;
        self.certainty = Certainty::FromTf;
        is_elsewhere(&self.pose_rf, &now).then(|| {
            self.pose_rf = now;
            now * self.pose_fo
        })
    }
}

/// True if a frame's pose in the root frame has changed, as observed from the root.
pub fn is_elsewhere(before: &Pose, now: &Pose) -> bool {
    // far from the root, the product of a pose and its own inverse differs from the identity by rounding
    let way = now * before.inverse();
    before != now && (way.translation.vector.norm() > LEAST_MOTION || way.rotation.angle() > LEAST_MOTION)
}
