//! Methods of the collision checker: whether one motion or many are free, without further results.

use clearance_motion::MotionSegment;
use clearance_robot::Configuration;
use rayon::prelude::*;

use crate::collision_checker::CollisionChecker;
use crate::motion::MotionOptions;
use crate::workspace::Workspace;

/// Motions that one thread takes at a time.
const BLOCK: usize = 64;

impl CollisionChecker {
    /// True if the straight line in joint space between two configurations is proven free, with default options; false if
    /// it collides or could not be decided. [`Self::check_motion`] returns the reason.
    ///
    /// The result is that of [`Self::check_motion`], but nothing is searched after the first contact: on free motions this
    /// takes about the time of [`MotionOrder::Earliest`](crate::MotionOrder::Earliest), on most colliding motions about that
    /// of [`MotionOrder::Any`](crate::MotionOrder::Any).
    #[must_use]
    pub fn is_motion_free(
        &self,
        from: &Configuration,
        to: &Configuration,
        workspace: &mut Workspace,
    ) -> bool {
        let segment = MotionSegment::straight(self.robot(), from, to);
        self.is_motion_free_with(&segment, &MotionOptions::default(), workspace)
    }

    /// As [`Self::is_motion_free`], for any motion and with options; [`MotionOptions::order`] has no effect.
    #[must_use]
    pub fn is_motion_free_with(
        &self,
        segment: &MotionSegment,
        options: &MotionOptions,
        workspace: &mut Workspace,
    ) -> bool {
        self.motion_check(options, workspace).is_free(segment)
    }

    /// For each motion, the result of [`Self::is_motion_free_with`]: the same for any number of threads, unless there is a
    /// deadline. Motions that are not checked before the deadline are not free.
    ///
    /// Runs on the threads of the rayon pool it is called in.
    #[must_use]
    pub fn are_motions_free(&self, segments: &[MotionSegment], options: &MotionOptions) -> Vec<bool> {
        let mut free = vec![false; segments.len()];
        (free.par_chunks_mut(BLOCK).zip(segments.par_chunks(BLOCK))).for_each_init(
            || self.workspace(),
            |workspace, (free, segments)| self.are_motions_free_with(segments, options, workspace, free),
        );
        free
    }

    /// As [`Self::are_motions_free`], on this thread and with this workspace; writes to `free`, which is as long as
    /// `segments`.
    ///
    /// # Panics
    /// When `free` is not as long as `segments`.
    pub fn are_motions_free_with(
        &self,
        segments: &[MotionSegment],
        options: &MotionOptions,
        workspace: &mut Workspace,
        free: &mut [bool],
    ) {
        assert_eq!(segments.len(), free.len(), "a result for every motion");
        let mut check = self.motion_check(options, workspace);
        for (segment, free) in segments.iter().zip(free) {
            *free = options.stopped_by().is_none() && check.is_free(segment);
        }
    }
}

#[cfg(test)]
mod tests;
