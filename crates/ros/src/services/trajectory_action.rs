//! `~/check_trajectory` as an action: goals share the request queue of the services, and publish feedback.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use clearance_checker::{UndecidedReason, Watch};
use clearance_motion::TrajectoryPoint;
use futures_lite::future;
use smol::{LocalExecutor, Timer};

use crate::clock::RosClock;
use crate::dds::Stamp;
use crate::dds::action_server::{ActionServer, GoalId, GoalInfo, GoalStatusCode};
use crate::dds::middleware::Middleware;
use crate::dds::middleware_error::MiddlewareError;
use crate::dds::server::RequestId;
use crate::dds::type_name::TypeName;
use crate::messages::clearance_srvs::{
    CheckTrajectoryFeedback, CheckTrajectoryRequest, CheckTrajectoryResponse, MotionFindings,
};
use crate::names::Names;
use crate::services::action_goals::{CancelResult, Goals, ResultRequest};

/// Period of the feedback.
const PERIOD: Duration = Duration::from_millis(50);

/// Queued goal.
pub struct Goal {
    pub id: GoalId,
    pub request: CheckTrajectoryRequest,
    pub watch: Watch,
}

/// Data for the feedback of a goal that is being checked.
pub struct StartedGoal {
    pub id: GoalId,
    pub watch: Watch,
    /// Time (s) of each point; if the trajectory has no times, its number.
    points: Vec<f64>,
    /// The same, with the times at which moving obstacles split the segments.
    parts: Vec<f64>,
    is_timed: bool,
}

pub struct TrajectoryAction {
    server: ActionServer<CheckTrajectoryRequest, CheckTrajectoryResponse, CheckTrajectoryFeedback>,
    goals: Mutex<Goals<RequestId, CheckTrajectoryResponse>>,
    clock: Arc<RosClock>,
}

impl TrajectoryAction {
    pub fn open(
        middleware: &Middleware,
        names: &Names,
        clock: Arc<RosClock>,
    ) -> Result<Self, MiddlewareError> {
        let name = names.resolve_action("~/check_trajectory")?;
        let server = middleware.action_server(&name, TypeName::new("clearance_msgs", "CheckTrajectory"))?;
        Ok(Self { server, goals: Mutex::default(), clock })
    }

    fn goals(&self) -> MutexGuard<'_, Goals<RequestId, CheckTrajectoryResponse>> {
        // the goals are valid between any two statements, so a poisoned lock is safe to use
        self.goals.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Handles requests without end; `enqueue` returns whether the queue had space for a goal.
    pub async fn serve<'a>(&'a self, sending: &LocalExecutor<'a>, enqueue: impl Fn(Goal) -> bool) {
        let goals = async {
            loop {
                let (request_id, id, request) = self.server.next_goal().await;
                let (accepted, stamp) = self.accept(id, request, &enqueue);
                sending.spawn(self.server.respond_to_goal(request_id, accepted, stamp)).detach();
            }
        };
        let cancellations = async {
            loop {
                let (request_id, wanted) = self.server.next_cancellation().await;
                self.cancel(request_id, &wanted, sending);
            }
        };
        let results = async {
            loop {
                let (request_id, id) = self.server.next_result_request().await;
                self.goals().discard_expired(self.clock.steady());
                let requested = self.goals().request_result(id, request_id);
                let (request_id, status, result) = match requested {
                    ResultRequest::Ended(request_id, status, result) => (request_id, status, result),
                    ResultRequest::Later => continue,
                    ResultRequest::Unknown(request_id) => {
                        (request_id, GoalStatusCode::Unknown, CheckTrajectoryResponse::default())
                    }
                };
                sending.spawn(self.server.respond_to_result(request_id, status, result)).detach();
            }
        };
        future::zip(future::zip(goals, cancellations), results).await;
    }

    fn accept(
        &self,
        id: GoalId,
        request: CheckTrajectoryRequest,
        enqueue: impl Fn(Goal) -> bool,
    ) -> (bool, Stamp) {
        let now = self.clock.now().unwrap_or_default();
        let stamp = Stamp::from_nanos(now.nanoseconds());
        let watch = Watch::default();
        if !self.goals().accept(id, stamp, watch.clone()) {
            log::debug!("a goal of check_trajectory is rejected: its identifier is that of another");
            return (false, stamp);
        }
        let accepted = enqueue(Goal { id, request, watch });
        if accepted {
            self.publish_statuses();
        } else {
            log::debug!("a goal of check_trajectory is rejected: too many requests are waiting already");
            self.goals().reject(id);
        }
        (accepted, stamp)
    }

    fn cancel<'a>(&'a self, request_id: RequestId, wanted: &GoalInfo, sending: &LocalExecutor<'a>) {
        let CancelResult { code, canceling, not_begun } = self.goals().cancel(wanted);
        sending.spawn(self.server.respond_to_cancellation(request_id, code, canceling)).detach();
        self.publish_statuses();
        for id in not_begun {
            self.end(id, &canceled(), sending);
        }
    }

    /// Publishes feedback about a check periodically, until it ends.
    pub fn publish_feedback<'a>(&'a self, started: StartedGoal, sending: &LocalExecutor<'a>) {
        self.goals().begin(started.id);
        self.publish_statuses();
        let publish = async move {
            let mut published = None;
            while self.goals().is_open(started.id) {
                let free = started.watch.segments_free();
                if published.replace(free) != Some(free) {
                    self.server.publish_feedback(started.id, started.feedback(free));
                }
                Timer::after(PERIOD).await;
            }
        };
        sending.spawn(publish).detach();
    }

    /// Ends a goal with its result.
    pub fn end<'a>(&'a self, id: GoalId, response: &CheckTrajectoryResponse, sending: &LocalExecutor<'a>) {
        let motion = &response.motion;
        let status = if motion.verdict == MotionFindings::ERROR {
            GoalStatusCode::Aborted
        } else if motion.reason_code == UndecidedReason::Canceled.code() {
            GoalStatusCode::Canceled
        } else {
            GoalStatusCode::Succeeded
        };
        let waiting = self.goals().end(id, status, response.clone(), self.clock.steady());
        // a goal that was canceled before it started has ended already
        let Some(waiting) = waiting else { return };
        self.publish_statuses();
        for request_id in waiting {
            sending.spawn(self.server.respond_to_result(request_id, status, response.clone())).detach();
        }
    }

    fn publish_statuses(&self) {
        let statuses = self.goals().statuses();
        self.server.publish_statuses(statuses);
    }
}

/// Result of a trajectory that was canceled before its check started.
fn canceled() -> CheckTrajectoryResponse {
    let motion = MotionFindings {
        verdict: MotionFindings::UNDECIDED,
        message: "canceled before it was looked at".to_owned(),
        reason_code: UndecidedReason::Canceled.code().to_owned(),
        t_contact: 1.0,
        distance_upper: f64::INFINITY,
        ..MotionFindings::default()
    };
    CheckTrajectoryResponse::unchecked(motion)
}

impl StartedGoal {
    pub fn of(goal: &Goal) -> Self {
        let points = &goal.request.trajectory.points;
        let times = points
            .iter()
            .map(|p| TrajectoryPoint::seconds(p.time_from_start.sec, p.time_from_start.nanosec.into()));
        let is_timed = points.iter().any(|p| p.time_from_start.sec != 0 || p.time_from_start.nanosec != 0);
        let points: Vec<f64> =
            if is_timed { times.collect() } else { (0..points.len()).map(as_time).collect() };
        let end = points.last().copied().unwrap_or(0.0);
        let obstacles = &goal.request.terms.moving_obstacles;
        let splits = obstacles.iter().flat_map(|obstacle| &obstacle.times).copied();
        let begin = points.first().copied().unwrap_or(0.0);
        let mut parts: Vec<f64> =
            points.iter().copied().chain(splits.filter(|time| begin < *time && *time < end)).collect();
        parts.sort_unstable_by(f64::total_cmp);
        parts.dedup();
        Self { id: goal.id, watch: goal.watch.clone(), points, parts, is_timed }
    }

    /// Feedback once so many parts of the trajectory are free.
    fn feedback(&self, free_parts: usize) -> CheckTrajectoryFeedback {
        let time_free = self.parts.get(free_parts).copied().unwrap_or(f64::NAN);
        let segments_free = self.points.partition_point(|time| *time <= time_free).saturating_sub(1);
        let segments = self.points.len().saturating_sub(1);
        CheckTrajectoryFeedback {
            segments_free: count(segments_free),
            segments: count(segments),
            t_free: as_time(segments_free) / as_time(segments.max(1)),
            time_free: if self.is_timed { time_free } else { f64::NAN },
        }
    }
}

fn count(number: usize) -> u32 {
    u32::try_from(number).unwrap_or(u32::MAX)
}

fn as_time(number: usize) -> f64 {
    f64::from(count(number))
}

#[cfg(test)]
mod tests {
    use ros2_interfaces_jazzy_serde::builtin_interfaces::msg::Duration as SpanMessage;
    use ros2_interfaces_jazzy_serde::trajectory_msgs::msg::JointTrajectoryPoint;

    use super::*;
    use crate::messages::clearance_msgs::MovingObstacle;

    /// A moving obstacle splits the second segment twice, and has poses before and after the trajectory.
    #[test]
    fn feedback_counts_segments_of_the_request() {
        let mut goal = goal(&[1, 2, 4]);
        let obstacle = MovingObstacle { times: vec![0.0, 2.5, 3.0, 9.0], ..MovingObstacle::default() };
        goal.request.terms.moving_obstacles.push(obstacle);
        let started = StartedGoal::of(&goal);
        let free = |parts| {
            let feedback = started.feedback(parts);
            (feedback.segments_free, feedback.time_free)
        };
        assert_eq!([0, 1, 2, 3, 4].map(free), [(0, 1.0), (1, 2.0), (1, 2.5), (1, 3.0), (2, 4.0)]);
    }

    fn started(seconds: &[i32]) -> StartedGoal {
        StartedGoal::of(&goal(seconds))
    }

    fn goal(seconds: &[i32]) -> Goal {
        let mut request = CheckTrajectoryRequest::default();
        request.trajectory.points = (seconds.iter())
            .map(|&sec| JointTrajectoryPoint {
                time_from_start: SpanMessage { sec, nanosec: 0 },
                ..JointTrajectoryPoint::default()
            })
            .collect();
        Goal { id: GoalId::ZERO, request, watch: Watch::default() }
    }

    #[test]
    fn feedback_contains_segments_and_time() {
        let published = started(&[0, 2, 3, 7, 9]).feedback(2);
        assert_eq!((published.segments_free, published.segments), (2, 4));
        assert_eq!((published.t_free, published.time_free), (0.5, 3.0));
        let published = started(&[0, 0, 0]).feedback(2);
        assert!(published.t_free == 1.0 && published.time_free.is_nan());
        let published = started(&[0]).feedback(0);
        assert!(published.t_free == 0.0 && published.segments == 0);
        let published = started(&[]).feedback(0);
        assert!(published.t_free == 0.0 && published.segments == 0);
    }
}
