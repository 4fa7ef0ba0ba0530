//! Least distances along the motions of a batch, and first times within a distance, as lists of a response. No I/O.

use clearance_checker::{
    CollisionChecker, LeastClearance, MotionClearance, MotionReport, MotionVerdict, PairKind, UndecidedReason,
};

use crate::messages::clearance_srvs::{BatchClearances, BatchEvents, CheckMotionsResponse};
use crate::services::body_list::{BodyList, NOBODY};

/// Adds the least distances along the next motion; `None` if it was not searched before the deadline.
pub fn add_clearance(
    lists: &mut BatchClearances,
    found: Option<&MotionClearance>,
    checker: &CollisionChecker,
    bodies: &mut BodyList,
) {
    let least = |kind| match found {
        Some(found) => Least::new(found.nearest_of(kind), checker, bodies),
        None => Least::unknown(checker.checks(kind)),
    };
    let [of_self, of_world] = PairKind::ALL.map(least);
    lists.self_lower.push(of_self.lower);
    lists.self_upper.push(of_self.upper);
    lists.self_t.push(of_self.t);
    lists.self_pair_a.push(of_self.pair[0]);
    lists.self_pair_b.push(of_self.pair[1]);
    lists.world_lower.push(of_world.lower);
    lists.world_upper.push(of_world.upper);
    lists.world_t.push(of_world.t);
    lists.world_pair_a.push(of_world.pair[0]);
    lists.world_pair_b.push(of_world.pair[1]);
    let unfinished = found.map_or(Some(UndecidedReason::Deadline), |found| found.unfinished);
    lists.clearance_reasons.push(reason_constant(unfinished));
}

/// Adds the first time of the next motion at which a pair is within the distance; `None` if the motion was not checked before
/// the deadline.
pub fn add_event(
    lists: &mut BatchEvents,
    report: Option<&MotionReport>,
    checker: &CollisionChecker,
    bodies: &mut BodyList,
) {
    let (result, t, pair, reason) = match report.map(|report| &report.verdict) {
        Some(MotionVerdict::Free) => (BatchEvents::FARTHER, [1.0; 2], None, None),
        Some(MotionVerdict::Contact { t, pair, .. }) => (BatchEvents::REACHED, *t, Some(*pair), None),
        Some(MotionVerdict::Undecided { t, pair, reason, .. }) => {
            (BatchEvents::UNDECIDED, *t, *pair, Some(*reason))
        }
        None => (BatchEvents::UNDECIDED, [0.0, 1.0], None, Some(UndecidedReason::Deadline)),
    };
    let mut index = |body| bodies.index(checker, body);
    let [a, b] = pair.map_or([NOBODY; 2], |(a, b)| [index(a), index(b)]);
    lists.event_results.push(result);
    lists.event_reasons.push(reason_constant(reason));
    lists.event_t_farther.push(t[0]);
    lists.event_t_reached.push(t[1]);
    lists.event_pair_a.push(a);
    lists.event_pair_b.push(b);
}

/// The constant of a reason. Batches are not canceled, and their motions are of this robot.
pub fn reason_constant(reason: Option<UndecidedReason>) -> u8 {
    match reason {
        None => CheckMotionsResponse::REASON_NONE,
        Some(UndecidedReason::Tolerance) => CheckMotionsResponse::REASON_TOLERANCE,
        Some(UndecidedReason::Tube) => CheckMotionsResponse::REASON_TUBE,
        Some(UndecidedReason::Deadline | UndecidedReason::Canceled) => CheckMotionsResponse::REASON_DEADLINE,
        Some(UndecidedReason::Budget) => CheckMotionsResponse::REASON_BUDGET,
        Some(UndecidedReason::Overflow | UndecidedReason::Mismatch) => CheckMotionsResponse::REASON_OVERFLOW,
    }
}

/// Numbers of one least distance.
struct Least {
    lower: f64,
    upper: f64,
    t: f64,
    pair: [i32; 2],
}

impl Least {
    /// `None` if no such pairs are checked.
    fn new(least: Option<&LeastClearance>, checker: &CollisionChecker, bodies: &mut BodyList) -> Self {
        let (lower, upper) = least.map_or((f64::INFINITY, f64::INFINITY), |least| (least.lower, least.upper));
        let nearest = least.and_then(|least| least.nearest);
        let t = nearest.map_or(f64::NAN, |nearest| nearest.t);
        let mut index = |body| bodies.index(checker, body);
        let pair = nearest.map_or([NOBODY; 2], |nearest| [index(nearest.pair.a), index(nearest.pair.b)]);
        Self { lower, upper, t, pair }
    }

    /// Nothing is known about pairs that are checked.
    fn unknown(are_checked: bool) -> Self {
        let lower = if are_checked { 0.0 } else { f64::INFINITY };
        Self { lower, upper: f64::INFINITY, t: f64::NAN, pair: [NOBODY; 2] }
    }
}
