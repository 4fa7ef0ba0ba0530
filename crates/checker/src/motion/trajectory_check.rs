//! Checks of trajectories: segment by segment, with the gaps between segments that do not join exactly.

use clearance_motion::{Join, MotionSegment, Trajectory, join};
use clearance_proximity::Work;

use super::motion_check::MotionCheck;
use super::motion_report::{MotionOptions, MotionReport, MotionVerdict, UndecidedReason};

/// Report on a trajectory: the report on its first segment that is not free, if there is one.
#[derive(Clone, Debug, PartialEq)]
pub struct TrajectoryReport {
    /// The result: free, contact or undecided.
    pub verdict: MotionVerdict,
    /// Index of the segment that the verdict refers to; the last one if all are free.
    pub segment: usize,
    /// Times (s from the start): the trajectory is proven free before the first. `None` if it is free or has no times.
    pub time: Option<[f64; 2]>,
    /// Number of evaluations of a pair in one interval.
    pub evaluations: u64,
    /// Volume tests and primitive tests that the check took.
    pub work: Work,
}

impl TrajectoryReport {
    /// True only if the whole trajectory is proven free.
    #[must_use]
    pub fn is_free(&self) -> bool {
        self.verdict == MotionVerdict::Free
    }
}

/// Checks whether a trajectory is free: either all segments are proven free, or the report is on the first that is not.
pub fn check_trajectory(check: &mut MotionCheck, trajectory: &Trajectory) -> TrajectoryReport {
    let options = check.options();
    check_stretches(trajectory, options, |stretch| match stretch {
        Stretch::Segment(segment) => check.check(segment),
        Stretch::Gap(gap) => check.prove(gap, false).0,
    })
}

/// Checks segment by segment until one is not free; `check` is called for gaps between segments, too.
pub fn check_stretches(
    trajectory: &Trajectory,
    options: &MotionOptions,
    mut check: impl FnMut(Stretch) -> MotionReport,
) -> TrajectoryReport {
    let (mut evaluations, mut work) = (0, Work::default());
    let segments = trajectory.segments();
    for (i, segment) in segments.iter().enumerate() {
        let gap = if i == 0 {
            None
        } else {
            check_gap([&segments[i - 1], segment], options.kept_margin(), &mut check)
        };
        if let Some(report) = &gap {
            evaluations += report.evaluations;
            work += report.work;
        }
        let report = match (gap.filter(|report| !report.is_free()), options.stopped_by()) {
            (Some(open), _) => MotionReport { evaluations: 0, work: Work::default(), ..open },
            (None, Some(reason)) => MotionReport::not_evaluated(reason),
            (None, None) => check(Stretch::Segment(segment)),
        };
        evaluations += report.evaluations;
        work += report.work;
        let t = match report.verdict {
            MotionVerdict::Free => {
                if let Some(watch) = &options.watch {
                    watch.record_free(i + 1);
                }
                continue;
            }
            MotionVerdict::Contact { t, .. } | MotionVerdict::Undecided { t, .. } => t,
        };
        let time = trajectory.time(i, t[0]).zip(trajectory.time(i, t[1])).map(|(lo, hi)| [lo, hi]);
        return TrajectoryReport { verdict: report.verdict, segment: i, time, evaluations, work };
    }
    let segment = trajectory.segments().len().saturating_sub(1);
    TrajectoryReport { verdict: MotionVerdict::Free, segment, time: None, evaluations, work }
}

/// A part of a trajectory that is to be checked.
#[derive(Clone, Copy, Debug)]
pub enum Stretch<'t> {
    Segment(&'t MotionSegment),
    /// Gap between two segments. It has no entry in a certificate, since a verifier proves it independently.
    Gap(&'t MotionSegment),
}

/// Report on the gap between two segments, expressed at the start of the second; `None` if they join exactly.
fn check_gap(
    [before, after]: [&MotionSegment; 2],
    margin: f64,
    check: &mut impl FnMut(Stretch) -> MotionReport,
) -> Option<MotionReport> {
    let undecided =
        |pair, distance, reason| MotionVerdict::Undecided { t: [0.0, 0.0], pair, distance, reason };
    let report = match join(before, after) {
        Ok(Join::Exact) => return None,
        Ok(Join::Gap(gap)) => check(Stretch::Gap(&gap)),
        Err(_) => {
            let mut report = MotionReport::not_evaluated(UndecidedReason::Mismatch);
            report.verdict = undecided(None, [0.0, f64::INFINITY], UndecidedReason::Mismatch);
            return Some(report);
        }
    };
    let is_loose = before.is_loose() || after.is_loose();
    let verdict = match report.verdict {
        MotionVerdict::Free => MotionVerdict::Free,
        // neither segment itself is that near
        MotionVerdict::Contact { pair, .. } => {
            undecided(Some(pair), [0.0, margin], UndecidedReason::Tolerance)
        }
        MotionVerdict::Undecided { pair, distance, reason, .. } => {
            // the gap's own tolerance only covers rounding
            let by_rounding = reason == UndecidedReason::Tube && !is_loose;
            undecided(pair, distance, if by_rounding { UndecidedReason::Tolerance } else { reason })
        }
    };
    Some(MotionReport { verdict, ..report })
}
