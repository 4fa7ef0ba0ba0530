//! Checks of trajectories: segment by segment, with the gaps between segments that do not join exactly.

use clearance_motion::{Join, MotionSegment, Trajectory, join};
use clearance_proximity::Work;
use clearance_scene::BodyId;

use super::motion_check::MotionCheck;
use super::motion_report::{MotionOptions, MotionReport, MotionVerdict, UndecidedReason};

/// Report on a trajectory: the report on its first segment that is not free, if there is one.
#[derive(Clone, Debug, PartialEq)]
pub struct TrajectoryReport {
    /// The result: free, contact or undecided.
    pub verdict: MotionVerdict,
    /// Index of the segment that the verdict refers to; the last one if all are free.
    pub segment: usize,
    /// Times (s from the start) of the verdict's `t`: the trajectory is proven free before the first. `None` if it is free or has no times.
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
///
/// Moving obstacles may have split a segment: if a part stays undecided, the parts after it are searched as the rest of a segment is, for
/// a contact and for the end of what is undecided.
pub fn check_stretches(
    trajectory: &Trajectory,
    options: &MotionOptions,
    check: impl FnMut(Stretch) -> MotionReport,
) -> TrajectoryReport {
    let (open, work) = (None, Work::default());
    let mut search = StretchSearch { trajectory, options, check, evaluations: 0, work, open };
    for segment in 0..trajectory.segments().len() {
        if search.is_over_before(segment) {
            break;
        }
        if let Some(contact) = search.check_segment(segment) {
            return contact;
        }
    }
    search.report_without_contact()
}

/// Segment, and fraction of it.
type Place = (usize, f64);

/// A place of the trajectory as a fraction of `part`, rounded down.
fn fraction_below(trajectory: &Trajectory, part: usize, place: Place) -> f64 {
    let t = trajectory.fraction_in(part, place);
    if place.0 == part { t } else { t - ROUNDING * (1.0 + t.abs()) }
}

/// As [`fraction_below`], rounded up.
fn fraction_above(trajectory: &Trajectory, part: usize, place: Place) -> f64 {
    let t = trajectory.fraction_in(part, place);
    if place.0 == part { t } else { t + ROUNDING * (1.0 + t.abs()) }
}

/// Relative rounding error of a fraction, with much to spare.
const ROUNDING: f64 = 1e-12;

/// The undecided part of one original segment.
struct OpenStretches {
    /// Where it begins.
    from: Place,
    /// Where the last undecided interval ends, as far as the search went.
    to: Place,
    /// True if the search ended there, and the rest of the segment is unchecked.
    is_unfinished: bool,
    pair: Option<(BodyId, BodyId)>,
    distance: [f64; 2],
    reason: UndecidedReason,
}

impl OpenStretches {
    /// Adds the verdict on a segment or the gap before it; only undecided ones change anything.
    fn extend(open: &mut Option<Self>, segment: usize, verdict: &MotionVerdict) {
        let is_unfinished = verdict.is_unfinished();
        let &MotionVerdict::Undecided { t: [from, to], pair, distance, reason } = verdict else { return };
        let open = open.get_or_insert(Self {
            from: (segment, from),
            to: (segment, to),
            is_unfinished,
            pair,
            distance,
            reason,
        });
        open.to = (segment, to);
        open.is_unfinished |= is_unfinished;
    }

    /// After this place the original segment is proven free.
    fn until(&self, trajectory: &Trajectory) -> Place {
        if !self.is_unfinished {
            return self.to;
        }
        let segments = self.from.0..trajectory.segments().len();
        let last = segments.take_while(|&i| trajectory.are_of_one_segment(self.from.0, i)).last();
        (last.unwrap_or(self.from.0), 1.0)
    }
}

impl MotionVerdict {
    /// True if the check ended early: what comes later is unchecked.
    fn is_unfinished(&self) -> bool {
        use UndecidedReason::{Budget, Canceled, Deadline, Mismatch};
        matches!(self, Self::Undecided { reason: Budget | Canceled | Deadline | Mismatch, .. })
    }
}

/// Search of a trajectory for a proof that it is free, for a contact, or for the undecided part of a segment.
struct StretchSearch<'t, F> {
    trajectory: &'t Trajectory,
    options: &'t MotionOptions,
    check: F,
    evaluations: u64,
    work: Work,
    open: Option<OpenStretches>,
}

impl<F: FnMut(Stretch) -> MotionReport> StretchSearch<'_, F> {
    /// True if the search ended early, or the segment belongs to another original segment than what is undecided.
    fn is_over_before(&self, segment: usize) -> bool {
        self.open.as_ref().is_some_and(|open| {
            open.is_unfinished || !self.trajectory.are_of_one_segment(open.from.0, segment)
        })
    }

    /// Checks the gap before a segment and the segment; returns the report on a contact.
    fn check_segment(&mut self, segment: usize) -> Option<TrajectoryReport> {
        let segments = self.trajectory.segments();
        if let Some(before) = segment.checked_sub(1) {
            let gap = self.check_gap([&segments[before], &segments[segment]]);
            OpenStretches::extend(&mut self.open, segment, &gap);
        }
        if self.open.as_ref().is_some_and(|open| open.is_unfinished) {
            return None;
        }
        let verdict = match self.options.stopped_by() {
            Some(reason) => MotionReport::not_evaluated(reason).verdict,
            None => self.check(Stretch::Segment(&segments[segment])),
        };
        if let MotionVerdict::Contact { t, pair, witness } = verdict {
            let from = self.open.as_ref().map_or((segment, t[0]), |open| open.from);
            let t = [fraction_below(self.trajectory, segment, from), t[1]];
            let verdict = MotionVerdict::Contact { t, pair, witness };
            return Some(self.report(verdict, segment, [from, (segment, t[1])]));
        }
        OpenStretches::extend(&mut self.open, segment, &verdict);
        if let (None, Some(watch)) = (&self.open, &self.options.watch) {
            watch.record_free(segment + 1);
        }
        None
    }

    fn report_without_contact(&self) -> TrajectoryReport {
        let Some(open) = &self.open else {
            let last = self.trajectory.segments().len().saturating_sub(1);
            let report = self.report(MotionVerdict::Free, last, [(last, 1.0); 2]);
            return TrajectoryReport { time: None, ..report };
        };
        let until = open.until(self.trajectory);
        let &OpenStretches { from, pair, distance, reason, .. } = open;
        let t = [from.1, fraction_above(self.trajectory, from.0, until)];
        self.report(MotionVerdict::Undecided { t, pair, distance, reason }, from.0, [from, until])
    }

    /// The report of a verdict whose `t` are fractions of a segment, and these places.
    fn report(&self, verdict: MotionVerdict, segment: usize, places: [Place; 2]) -> TrajectoryReport {
        let [lo, hi] = places.map(|(segment, t)| self.trajectory.time(segment, t));
        let time = lo.zip(hi).map(|(lo, hi)| [lo, hi]);
        TrajectoryReport { verdict, segment, time, evaluations: self.evaluations, work: self.work }
    }

    fn check(&mut self, stretch: Stretch) -> MotionVerdict {
        let report = (self.check)(stretch);
        self.evaluations += report.evaluations;
        self.work += report.work;
        report.verdict
    }

    /// Verdict on the gap between two segments, expressed at the start of the second.
    fn check_gap(&mut self, [before, after]: [&MotionSegment; 2]) -> MotionVerdict {
        let undecided =
            |pair, distance, reason| MotionVerdict::Undecided { t: [0.0, 0.0], pair, distance, reason };
        let found = match join(before, after) {
            Ok(Join::Exact) => return MotionVerdict::Free,
            Ok(Join::Gap(gap)) => self.check(Stretch::Gap(&gap)),
            Err(_) => return undecided(None, [0.0, f64::INFINITY], UndecidedReason::Mismatch),
        };
        let is_loose = before.is_loose() || after.is_loose();
        match found {
            MotionVerdict::Free => MotionVerdict::Free,
            // neither segment itself is that near
            MotionVerdict::Contact { pair, .. } => {
                undecided(Some(pair), [0.0, self.options.kept_margin()], UndecidedReason::Tolerance)
            }
            MotionVerdict::Undecided { pair, distance, reason, .. } => {
                // the gap's own tolerance only covers rounding
                let by_rounding = reason == UndecidedReason::Tube && !is_loose;
                undecided(pair, distance, if by_rounding { UndecidedReason::Tolerance } else { reason })
            }
        }
    }
}

/// A part of a trajectory that is to be checked.
#[derive(Clone, Copy, Debug)]
pub enum Stretch<'t> {
    Segment(&'t MotionSegment),
    /// Gap between two segments. It has no entry in a certificate, since a verifier proves it independently.
    Gap(&'t MotionSegment),
}
