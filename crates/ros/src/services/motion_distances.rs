//! Least distances along motions, and the first time within a distance, for responses to motion requests. No I/O.

use clearance_checker::{
    CollisionChecker, LeastClearance, MotionClearanceOptions, MotionOptions, MotionVerdict, NearestMoment,
    TrajectoryReport, UndecidedReason, Watch, Workspace,
};
use clearance_motion::Trajectory;

use crate::messages::clearance_msgs::{DistanceEvent, LeastDistance};
use crate::messages::clearance_srvs::{MotionDistances, MotionTerms};
use crate::messages::collision_state::{distance_message, pair_message};

/// Distances that a request selects along a motion.
#[derive(Clone, Copy)]
pub struct DistanceRequest<'a> {
    pub checker: &'a CollisionChecker,
    pub options: &'a MotionOptions,
    pub terms: &'a MotionTerms,
}

impl DistanceRequest<'_> {
    /// The requested distances along a trajectory.
    pub fn along(self, trajectory: &Trajectory, workspace: &mut Workspace) -> MotionDistances {
        let Self { checker, options, terms } = self;
        let mut distances = MotionDistances::default();
        if terms.with_clearance {
            let options = clearance_options(options);
            let found = checker.clearance_along_trajectory(trajectory, &options, workspace);
            distances.self_clearance = least_distance(checker, trajectory, found.nearest_self.as_ref());
            distances.world_clearance = least_distance(checker, trajectory, found.nearest_world.as_ref());
            found
                .unfinished
                .map_or("", UndecidedReason::code)
                .clone_into(&mut distances.clearance_reason_code);
        }
        if terms.event_distance > 0.0 {
            let (distance, options) = (terms.event_distance, event_options(options));
            let report = checker.event_distance_along_trajectory(trajectory, distance, &options, workspace);
            distances.event = event(checker, trajectory, &report);
        }
        distances
    }
}

/// Options of the search for the least distance, with the limits of the check.
pub fn clearance_options(options: &MotionOptions) -> MotionClearanceOptions {
    let MotionOptions { deadline, budget, watch, .. } = options;
    let watch = watch.clone();
    MotionClearanceOptions {
        deadline: *deadline,
        budget: *budget,
        watch,
        ..MotionClearanceOptions::default()
    }
}

/// Options of the search for the event. Feedback reports the progress of the check of the motion only.
fn event_options(options: &MotionOptions) -> MotionOptions {
    let watch = options.watch.as_ref().map(Watch::of_further_check);
    MotionOptions { watch, ..options.clone() }
}

/// Message of a least distance; `None` if no such pairs are checked.
fn least_distance(
    checker: &CollisionChecker,
    trajectory: &Trajectory,
    least: Option<&LeastClearance>,
) -> LeastDistance {
    let Some(LeastClearance { lower, upper, nearest }) = least else {
        return LeastDistance { lower: f64::INFINITY, ..LeastDistance::default() };
    };
    let bounds = LeastDistance { lower: *lower, upper: *upper, ..LeastDistance::default() };
    let Some(NearestMoment { segment, t, time, pair }) = nearest else { return bounds };
    let (segment, t) = trajectory.origin(*segment, *t);
    LeastDistance {
        segment: count(segment),
        t,
        time: time.unwrap_or(f64::NAN),
        nearest: distance_message(checker, pair),
        ..bounds
    }
}

fn event(checker: &CollisionChecker, trajectory: &Trajectory, report: &TrajectoryReport) -> DistanceEvent {
    let (result, t, pair, reason) = match report.verdict {
        MotionVerdict::Free => (DistanceEvent::FARTHER, [1.0; 2], None, None),
        MotionVerdict::Contact { t, pair, .. } => (DistanceEvent::REACHED, t, Some(pair), None),
        MotionVerdict::Undecided { t, pair, reason, .. } => (DistanceEvent::UNDECIDED, t, pair, Some(reason)),
    };
    let time = |t| trajectory.time(report.segment, t).unwrap_or(f64::NAN);
    let [time_farther, time_reached] = report.time.unwrap_or_else(|| t.map(time));
    let [(segment, t_farther), (_, t_reached)] = t.map(|t| trajectory.origin(report.segment, t));
    DistanceEvent {
        result,
        reason_code: reason.map_or("", UndecidedReason::code).to_owned(),
        segment: count(segment),
        t_farther,
        t_reached,
        time_farther,
        time_reached,
        pair: pair.map(|(a, b)| pair_message(checker, a, b)).unwrap_or_default(),
    }
}

fn count(number: usize) -> u32 {
    u32::try_from(number).unwrap_or(u32::MAX)
}
