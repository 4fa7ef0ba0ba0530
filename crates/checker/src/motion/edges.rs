//! Checks of many motions at once.

use clearance_motion::MotionSegment;
use rayon::prelude::*;

use super::report::{MotionOptions, MotionReport};
use crate::collision_checker::CollisionChecker;

impl CollisionChecker {
    /// Reports on many motions, in their order: the same for any number of threads, unless there is a deadline.
    ///
    /// Runs on the threads of the rayon pool it is called in.
    #[must_use]
    pub fn check_motions(&self, segments: &[MotionSegment], options: &MotionOptions) -> Vec<MotionReport> {
        (segments.par_iter())
            .with_min_len(4)
            .map_init(
                || self.workspace(),
                |workspace, segment| match options.stopped_by() {
                    Some(reason) => MotionReport::not_looked_at(reason),
                    None => self.check_motion_with(segment, options, workspace),
                },
            )
            .collect()
    }
}
