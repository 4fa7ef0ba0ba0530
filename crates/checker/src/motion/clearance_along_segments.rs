//! Least distances along a motion, or along the segments of a trajectory and the gaps between them.

use clearance_motion::{Join, MotionSegment, Trajectory, join};
use clearance_proximity::Work;

use super::checked_motion::CheckedMotion;
use super::clearance_search::{ClearanceSearch, SearchProgress};
use super::least_bounds::NearestSoFar;
use super::motion_clearance::{MotionClearance, MotionClearanceOptions};
use super::motion_report::UndecidedReason;
use super::motion_scratch::MotionWorkspace;
use crate::pair_kind::PairKind;
use crate::pairs::CheckedPairs;

/// Searches segments one after the other; each search starts from the distances of the earlier ones.
pub struct ClearanceAlong<'a> {
    pairs: &'a CheckedPairs,
    options: &'a MotionClearanceOptions,
    workspace: MotionWorkspace<'a>,
    progress: SearchProgress,
}

impl<'a> ClearanceAlong<'a> {
    pub fn new(
        pairs: &'a CheckedPairs,
        options: &'a MotionClearanceOptions,
        workspace: MotionWorkspace<'a>,
    ) -> Self {
        workspace.scratch.work = Work::default();
        Self { pairs, options, workspace, progress: SearchProgress::new() }
    }

    /// The least distances along one motion.
    pub fn of_motion(mut self, segment: &MotionSegment) -> MotionClearance {
        self.search(segment, 0);
        self.finish(|_, _| None)
    }

    /// The least distances along a trajectory.
    pub fn of_trajectory(mut self, trajectory: &Trajectory) -> MotionClearance {
        let segments = trajectory.segments();
        for (i, segment) in segments.iter().enumerate() {
            if i > 0 {
                self.search_gap([&segments[i - 1], segment], i);
            }
            self.search(segment, i);
        }
        self.finish(|segment, t| trajectory.time(segment, t))
    }

    fn search(&mut self, segment: &MotionSegment, number: usize) {
        if self.progress.is_stopped() {
            return;
        }
        let motion = CheckedMotion { pairs: self.pairs, segment, margin: 0.0 };
        if !motion.is_valid() {
            return self.progress.stop(UndecidedReason::Mismatch);
        }
        let (options, progress) = (self.options, &mut self.progress);
        ClearanceSearch { motion, options, workspace: &mut self.workspace, progress, segment: number }.run();
    }

    /// Searches the gap between two segments, which is within rounding; its distances count as those of the start of the
    /// second segment.
    fn search_gap(&mut self, [before, after]: [&MotionSegment; 2], number: usize) {
        match join(before, after) {
            Ok(Join::Exact) => {}
            Ok(Join::Gap(gap)) => {
                self.search(&gap, number);
                for least in &mut self.progress.least {
                    if let Some(nearest) = least.nearest().filter(|nearest| nearest.segment == number) {
                        least.set_exact(NearestSoFar { t: 0.0, ..nearest });
                    }
                }
            }
            Err(_) => self.progress.stop(UndecidedReason::Mismatch),
        }
    }

    fn finish(self, time: impl Fn(usize, f64) -> Option<f64>) -> MotionClearance {
        let Self { pairs, options, workspace, progress } = self;
        let results = PairKind::ALL
            .map(|kind| pairs.include(kind).then(|| progress.least[kind as usize].result(options, &time)));
        let is_done = results.iter().flatten().all(|(_, is_done)| *is_done);
        let [nearest_self, nearest_world] = results.map(|result| result.map(|(least, _)| least));
        MotionClearance {
            nearest_self,
            nearest_world,
            unfinished: match progress.unfinished {
                // such a motion was not searched, even if there are no pairs
                Some(UndecidedReason::Mismatch) => Some(UndecidedReason::Mismatch),
                _ if is_done => None,
                reason => Some(reason.unwrap_or(UndecidedReason::Tolerance)),
            },
            evaluations: progress.evaluations,
            work: workspace.scratch.work,
        }
    }
}
