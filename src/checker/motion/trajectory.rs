//! Stretches one after the other.

use super::report::{MotionOptions, MotionReport, MotionVerdict};
use crate::checker::collision_checker::CollisionChecker;
use crate::checker::workspace::Workspace;
use crate::motion::{MotionSegment, Trajectory};
use crate::query::Work;

/// The answer about a trajectory: that about its first segment that is not free, if there is one.
#[derive(Clone, Debug, PartialEq)]
pub struct TrajectoryReport {
    pub verdict: MotionVerdict,
    /// The segment that the verdict is about; the last one if all are free.
    pub segment: usize,
    /// Seconds from the start: free before the first, proven. `None` if the trajectory is free or has no times.
    pub time: Option<[f64; 2]>,
    pub looks: u64,
    pub work: Work,
}

impl TrajectoryReport {
    #[must_use]
    pub fn is_free(&self) -> bool {
        self.verdict == MotionVerdict::Free
    }
}

impl CollisionChecker {
    /// Whether a trajectory is free: all of its segments proven, or what is with the first that is not.
    #[must_use]
    pub fn check_trajectory(
        &self,
        trajectory: &Trajectory,
        options: &MotionOptions,
        workspace: &mut Workspace,
    ) -> TrajectoryReport {
        each_segment(trajectory, options, |segment| self.check_motion_with(segment, options, workspace))
    }
}

/// Asks about one segment after the other until one is not free.
pub(super) fn each_segment(
    trajectory: &Trajectory,
    options: &MotionOptions,
    mut check: impl FnMut(&MotionSegment) -> MotionReport,
) -> TrajectoryReport {
    let (mut looks, mut work) = (0, Work::default());
    for (i, segment) in trajectory.segments().iter().enumerate() {
        let report = options.stopped_by().map_or_else(|| check(segment), MotionReport::not_looked_at);
        looks += report.looks;
        work += report.work;
        let t = match report.verdict {
            MotionVerdict::Free => {
                if let Some(watch) = &options.watch {
                    watch.note_free(i + 1);
                }
                continue;
            }
            MotionVerdict::Contact { t, .. } | MotionVerdict::Undecided { t, .. } => t,
        };
        let time = trajectory.time(i, t[0]).zip(trajectory.time(i, t[1])).map(|(lo, hi)| [lo, hi]);
        return TrajectoryReport { verdict: report.verdict, segment: i, time, looks, work };
    }
    let segment = trajectory.segments().len().saturating_sub(1);
    TrajectoryReport { verdict: MotionVerdict::Free, segment, time: None, looks, work }
}
