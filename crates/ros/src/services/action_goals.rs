//! State of an action's goals: their status, the pending result requests, and the expiry of results. No I/O.

use std::time::Duration;

use clearance_checker::Watch;

use crate::dds::Stamp;
use crate::dds::action_server::{CancelCode, GoalId, GoalInfo, GoalStatus, GoalStatusCode};

/// Maximum number of stored results.
const RESULTS: usize = 64;

/// Time for which a result is stored.
const KEPT: Duration = Duration::from_secs(60);

/// Maximum number of pending result requests per goal.
const WAITING: usize = 8;

/// Goals in the order of their acceptance. `RequestId` identifies a result request, `Outcome` is a result.
pub struct Goals<RequestId, Outcome> {
    goals: Vec<Goal<RequestId, Outcome>>,
}

struct Goal<RequestId, Outcome> {
    info: GoalInfo,
    status: GoalStatusCode,
    watch: Watch,
    waiting: Vec<RequestId>,
    /// Steady time of the goal's end, and its result.
    ended: Option<(Duration, Outcome)>,
}

/// Response to a result request.
#[derive(Debug, PartialEq)]
pub enum ResultRequest<RequestId, Outcome> {
    Ended(RequestId, GoalStatusCode, Outcome),
    /// The response follows when the goal ends.
    Later,
    Unknown(RequestId),
}

/// Effect of a cancel request.
#[derive(Debug)]
pub struct CancelResult {
    pub code: CancelCode,
    pub canceling: Vec<GoalInfo>,
    /// CancelResult goals that had not started. The caller must end them now.
    pub not_begun: Vec<GoalId>,
}

impl<RequestId, Outcome> Default for Goals<RequestId, Outcome> {
    fn default() -> Self {
        Self { goals: Vec::new() }
    }
}

impl<RequestId, Outcome: Clone> Goals<RequestId, Outcome> {
    /// Accepts a goal; returns false if its id is already in use.
    pub fn accept(&mut self, goal_id: GoalId, stamp: Stamp, watch: Watch) -> bool {
        if self.goals.iter().any(|goal| goal.info.goal_id == goal_id) {
            return false;
        }
        let info = GoalInfo { goal_id, stamp };
        let (status, waiting) = (GoalStatusCode::Accepted, Vec::new());
        self.goals.push(Goal { info, status, watch, waiting, ended: None });
        true
    }

    /// Removes an accepted goal.
    pub fn reject(&mut self, id: GoalId) {
        self.goals.retain(|goal| goal.info.goal_id != id);
    }

    pub fn begin(&mut self, id: GoalId) {
        if let Some(goal) = self.open(id)
            && goal.status == GoalStatusCode::Accepted
        {
            goal.status = GoalStatusCode::Executing;
        }
    }

    /// Whether a goal exists and has not ended yet.
    pub fn is_open(&mut self, id: GoalId) -> bool {
        self.open(id).is_some()
    }

    fn open(&mut self, id: GoalId) -> Option<&mut Goal<RequestId, Outcome>> {
        self.goals.iter_mut().find(|goal| goal.info.goal_id == id && goal.ended.is_none())
    }

    /// Cancels the goal with the given id, the goals accepted up to the given stamp, or both; all goals if neither is
    /// given. See `action_msgs/srv/CancelGoal`.
    pub fn cancel(&mut self, GoalInfo { goal_id, stamp }: &GoalInfo) -> CancelResult {
        let by_id = *goal_id != GoalId::ZERO;
        let by_stamp = *stamp != Stamp::ZERO;
        let mut canceled =
            CancelResult { code: CancelCode::Rejected, canceling: Vec::new(), not_begun: Vec::new() };
        let all = !by_id && !by_stamp;
        let (mut known, mut open) = (false, false);
        for goal in &mut self.goals {
            let named = by_id && goal.info.goal_id == *goal_id;
            known |= named;
            let old = by_stamp && goal.info.stamp <= *stamp;
            if goal.ended.is_some() || !(named || old || all) {
                continue;
            }
            open |= named;
            if goal.status == GoalStatusCode::Accepted {
                canceled.not_begun.push(goal.info.goal_id);
            }
            goal.status = GoalStatusCode::Canceling;
            goal.watch.stop();
            canceled.canceling.push(goal.info.clone());
        }
        canceled.code = match (canceled.canceling.is_empty(), by_id) {
            (false, _) => CancelCode::None,
            (true, true) if !known => CancelCode::UnknownGoal,
            (true, true) if !open => CancelCode::GoalTerminated,
            (true, _) => CancelCode::Rejected,
        };
        canceled
    }

    /// Ends a goal and returns its pending result requests; `None` if it has already ended.
    pub fn end(
        &mut self,
        id: GoalId,
        status: GoalStatusCode,
        outcome: Outcome,
        now: Duration,
    ) -> Option<Vec<RequestId>> {
        let goal = self.open(id)?;
        goal.status = status;
        goal.ended = Some((now, outcome));
        let waiting = std::mem::take(&mut goal.waiting);
        self.discard_expired(now);
        Some(waiting)
    }

    /// Discards expired results, and the oldest results above the maximum number.
    pub fn discard_expired(&mut self, now: Duration) {
        self.goals.retain(|goal| goal.ended.as_ref().is_none_or(|(at, _)| now.saturating_sub(*at) < KEPT));
        let ended = self.goals.iter().filter(|goal| goal.ended.is_some()).count();
        let mut too_many = ended.saturating_sub(RESULTS);
        self.goals.retain(|goal| {
            let is_discarded = goal.ended.is_some() && too_many > 0;
            too_many -= usize::from(is_discarded);
            !is_discarded
        });
    }

    /// Responds to a result request, or stores it until the goal has ended.
    pub fn request_result(&mut self, id: GoalId, request_id: RequestId) -> ResultRequest<RequestId, Outcome> {
        match self.goals.iter_mut().find(|goal| goal.info.goal_id == id) {
            Some(Goal { status, ended: Some((_, outcome)), .. }) => {
                ResultRequest::Ended(request_id, *status, outcome.clone())
            }
            Some(goal) if goal.waiting.len() < WAITING => {
                goal.waiting.push(request_id);
                ResultRequest::Later
            }
            _ => ResultRequest::Unknown(request_id),
        }
    }

    /// Status of all stored goals.
    pub fn statuses(&self) -> Vec<GoalStatus> {
        let status_of = |goal: &Goal<_, _>| GoalStatus { goal_info: goal.info.clone(), status: goal.status };
        self.goals.iter().map(status_of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const T0: Duration = Duration::ZERO;

    fn stamp(seconds: i32) -> Stamp {
        Stamp::new(seconds, 0)
    }

    fn accepted(goals: &mut Goals<u8, &'static str>, second: i32) -> (GoalId, Watch) {
        let (id, watch) = (GoalId::new_random(), Watch::default());
        assert!(goals.accept(id, stamp(second), watch.clone()));
        (id, watch)
    }

    #[test]
    fn early_result_requests_wait_and_late_ones_get_the_result_at_once() {
        let mut goals = Goals::default();
        let (id, _) = accepted(&mut goals, 1);
        assert!(!goals.accept(id, stamp(2), Watch::default()), "known already");
        assert_eq!(goals.request_result(id, 1), ResultRequest::Later);
        goals.begin(id);
        assert!(goals.statuses()[0].status == GoalStatusCode::Executing);
        assert_eq!(goals.end(id, GoalStatusCode::Succeeded, "free", T0), Some(vec![1]));
        assert_eq!(goals.end(id, GoalStatusCode::Aborted, "again", T0), None);
        assert_eq!(goals.request_result(id, 2), ResultRequest::Ended(2, GoalStatusCode::Succeeded, "free"));
        assert_eq!(goals.request_result(GoalId::new_random(), 3), ResultRequest::Unknown(3));
        goals.discard_expired(KEPT);
        assert_eq!(goals.request_result(id, 4), ResultRequest::Unknown(4));
    }

    #[test]
    fn neither_results_nor_questions_are_kept_without_bound() {
        let mut goals = Goals::default();
        let ids: Vec<GoalId> = (0..3 * RESULTS).map(|_| accepted(&mut goals, 1).0).collect();
        for request_id in 0..u8::try_from(WAITING).unwrap() {
            assert_eq!(goals.request_result(ids[0], request_id), ResultRequest::Later);
        }
        assert_eq!(goals.request_result(ids[0], 99), ResultRequest::Unknown(99));
        for id in &ids[1..] {
            goals.end(*id, GoalStatusCode::Succeeded, "free", T0);
        }
        let statuses = goals.statuses();
        assert_eq!(statuses.len(), 1 + RESULTS);
        assert!(statuses[0].goal_info.goal_id == ids[0], "what goes on is never forgotten");
        assert!(statuses[RESULTS].goal_info.goal_id == ids[3 * RESULTS - 1], "the oldest go first");
    }

    #[test]
    fn goals_are_canceled_by_name_by_stamp_or_all() {
        let mut goals = Goals::default();
        let (old, old_watch) = accepted(&mut goals, 1);
        let (new, new_watch) = accepted(&mut goals, 5);
        goals.begin(old);
        let zero = GoalInfo { goal_id: GoalId::ZERO, stamp: Stamp::ZERO };

        let canceled = goals.cancel(&GoalInfo { stamp: stamp(2), ..zero.clone() });
        assert!(canceled.code == CancelCode::None && canceled.not_begun.is_empty());
        assert!(old_watch.is_stopped() && !new_watch.is_stopped());

        let canceled = goals.cancel(&GoalInfo { goal_id: new, ..zero.clone() });
        assert_eq!((canceled.canceling.len(), canceled.not_begun), (1, vec![new]));
        assert!(new_watch.is_stopped());

        for id in [old, new] {
            goals.end(id, GoalStatusCode::Canceled, "stopped", T0);
        }
        let terminated = goals.cancel(&GoalInfo { goal_id: new, ..zero.clone() });
        assert!(terminated.code == CancelCode::GoalTerminated && terminated.canceling.is_empty());
        let unknown = goals.cancel(&GoalInfo { goal_id: GoalId::new_random(), ..zero.clone() });
        assert!(unknown.code == CancelCode::UnknownGoal);
        assert!(goals.cancel(&zero).code == CancelCode::Rejected);
        let (last, _) = accepted(&mut goals, 9);
        assert_eq!(goals.cancel(&zero).not_begun, [last]);
    }
}
