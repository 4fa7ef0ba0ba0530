//! Methods of the collision checker: least distances along motions, and the first time at which a distance is reached.

use clearance_motion::{MotionSegment, Trajectory};

use crate::collision_checker::CollisionChecker;
use crate::motion::{
    ClearanceAlong, MotionClearance, MotionClearanceOptions, MotionOptions, MotionOrder, MotionReport,
    TrajectoryReport,
};
use crate::workspace::Workspace;

impl CollisionChecker {
    /// Bounds on the least distances along a motion, of self pairs and of world pairs: at no time is a pair nearer than
    /// `lower`, and `upper` is the distance of a pair at one time. They differ by at most the tolerance, unless
    /// [`MotionClearance::unfinished`] has a reason.
    ///
    /// With a tracking tolerance, `lower` holds for all motions within it, and `upper` is attained on the motion itself.
    #[must_use]
    pub fn clearance_along(
        &self,
        segment: &MotionSegment,
        options: &MotionClearanceOptions,
        workspace: &mut Workspace,
    ) -> MotionClearance {
        ClearanceAlong::new(self.begin(workspace), options, workspace.motion()).of_motion(segment)
    }

    /// As [`Self::clearance_along`], along all segments of a trajectory.
    #[must_use]
    pub fn clearance_along_trajectory(
        &self,
        trajectory: &Trajectory,
        options: &MotionClearanceOptions,
        workspace: &mut Workspace,
    ) -> MotionClearance {
        ClearanceAlong::new(self.begin(workspace), options, workspace.motion()).of_trajectory(trajectory)
    }

    /// The first time at which a pair is not farther apart than `distance` (m, padding subtracted; less than 0 counts as 0).
    ///
    /// The report is that of [`Self::check_motion_with`] with this [`margin`](MotionOptions::margin): `Free` if all pairs are
    /// proven farther apart at all times; otherwise `Contact` with `t`: proven farther apart before the first t, not farther
    /// apart at the second; or `Undecided`.
    #[must_use]
    pub fn event_distance(
        &self,
        segment: &MotionSegment,
        distance: f64,
        options: &MotionOptions,
        workspace: &mut Workspace,
    ) -> MotionReport {
        self.check_motion_with(segment, &options_with_margin(distance, options), workspace)
    }

    /// As [`Self::event_distance`], along a trajectory.
    #[must_use]
    pub fn event_distance_along_trajectory(
        &self,
        trajectory: &Trajectory,
        distance: f64,
        options: &MotionOptions,
        workspace: &mut Workspace,
    ) -> TrajectoryReport {
        self.check_trajectory(trajectory, &options_with_margin(distance, options), workspace)
    }
}

fn options_with_margin(distance: f64, options: &MotionOptions) -> MotionOptions {
    MotionOptions { margin: distance, order: MotionOrder::Earliest, ..options.clone() }
}

#[cfg(test)]
mod tests;
