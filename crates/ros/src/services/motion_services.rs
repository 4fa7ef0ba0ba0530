//! `~/check_motion` and `~/check_trajectory`, the latter also as an action. Requests and responses are handled on the services thread.
//! Checks run one after the other on a separate thread, so that a long motion does not delay other work.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use clearance_checker::Workspace;
use clearance_monitor::Evaluation;
use futures_lite::future;
use ros2_interfaces_jazzy_serde::std_msgs::msg::String as StringMessage;
use ros2_interfaces_jazzy_serde::visualization_msgs::msg::MarkerArray;
use smol::LocalExecutor;
use smol::channel::{self, Receiver, Sender};

use crate::clock::RosClock;
use crate::dds::action_server::GoalId;
use crate::dds::middleware::Middleware;
use crate::dds::middleware_error::MiddlewareError;
use crate::dds::publisher::Publisher;
use crate::dds::quality::Quality;
use crate::dds::server::{RequestId, Server};
use crate::dds::type_name::TypeName;
use crate::messages::clearance_srvs::{
    CheckMotionRequest, CheckMotionResponse, CheckTrajectoryRequest, CheckTrajectoryResponse,
};
use crate::monitor_events::current_evaluation::CurrentEvaluation;
use crate::names::Names;
use crate::parameters::parameter_store::ParameterStore;
use crate::services::motion_requests::{MotionResponse, answer_motion, answer_trajectory};
use crate::services::rejection::Rejection;
use crate::services::request_context::known;
use crate::services::trajectory_action::{Goal, StartedGoal, TrajectoryAction};

/// Maximum length of the request queue. Further requests get the response that the node is busy.
const WAITING: usize = 16;

/// Queued request.
enum Request {
    Motion(RequestId, CheckMotionRequest),
    Trajectory(RequestId, CheckTrajectoryRequest),
    Goal(Goal),
}

enum Answer {
    Motion(RequestId, Box<MotionResponse>),
    Trajectory(RequestId, Box<MotionResponse>),
    /// The check of a goal has started.
    StartedGoal(StartedGoal),
    Goal(GoalId, Box<MotionResponse>),
}

/// Network side: receives requests and sends responses.
pub struct MotionServices {
    motions: Server<CheckMotionRequest, CheckMotionResponse>,
    trajectories: Server<CheckTrajectoryRequest, CheckTrajectoryResponse>,
    goals: TrajectoryAction,
    certificates: Publisher<StringMessage>,
    swept_volumes: Publisher<MarkerArray>,
    requests: Sender<Request>,
    answers: Receiver<Answer>,
}

/// Side that runs the checks. It owns no network resources: the node ends without waiting for it.
pub struct MotionWorker {
    requests: Receiver<Request>,
    answers: Sender<Answer>,
    current: CurrentEvaluation,
    clock: Arc<RosClock>,
    parameters: ParameterStore,
    workspace: Option<Workspace>,
}

impl MotionServices {
    /// Creates both sides. `current` is the evaluation whose robot and world the checks use.
    pub fn offer(
        middleware: &Middleware,
        names: &Names,
        current: CurrentEvaluation,
        clock: Arc<RosClock>,
        parameters: ParameterStore,
    ) -> Result<(Self, MotionWorker), MiddlewareError> {
        let (requests, requests_in) = channel::bounded(WAITING);
        // at most two items for each queued request
        let (answers, answers_in) = channel::unbounded();
        let string = TypeName::new("std_msgs", "String");
        let markers = TypeName::new("visualization_msgs", "MarkerArray");
        let services = Self {
            motions: middleware
                .server(&names.resolve("~/check_motion")?, TypeName::new("clearance_msgs", "CheckMotion"))?,
            trajectories: middleware.server(
                &names.resolve("~/check_trajectory")?,
                TypeName::new("clearance_msgs", "CheckTrajectory"),
            )?,
            goals: TrajectoryAction::offer(middleware, names, Arc::clone(&clock))?,
            certificates: middleware.publisher(
                &names.resolve("~/certificates")?,
                string,
                Quality::Reliable,
            )?,
            swept_volumes: middleware.publisher(
                &names.resolve("~/swept_volume")?,
                markers,
                Quality::Reliable,
            )?,
            requests,
            answers: answers_in,
        };
        let desk =
            MotionWorker { requests: requests_in, answers, current, clock, parameters, workspace: None };
        Ok((services, desk))
    }

    /// Handles requests without end.
    pub async fn serve(&self) {
        // each response waits only for its own client
        let sending = LocalExecutor::new();
        let motions = async {
            loop {
                let (id, request) = self.motions.next().await;
                self.enqueue(Request::Motion(id, request), &sending);
            }
        };
        let trajectories = async {
            loop {
                let (id, request) = self.trajectories.next().await;
                self.enqueue(Request::Trajectory(id, request), &sending);
            }
        };
        let answers = async {
            while let Ok(answer) = self.answers.recv().await {
                self.send(answer, &sending);
            }
        };
        let goals = self.goals.serve(&sending, |goal| self.requests.try_send(Request::Goal(goal)).is_ok());
        let services = future::zip(future::zip(motions, trajectories), answers);
        sending.run(future::zip(services, goals)).await;
    }

    fn enqueue<'a>(&'a self, request: Request, sending: &LocalExecutor<'a>) {
        // when the desk has ended, the service reports that it is busy
        if let Err(refused) = self.requests.try_send(request) {
            let answered = MotionResponse::from(&Rejection::Busy(WAITING));
            self.send(refused.into_inner().answered(answered), sending);
        }
    }

    fn send<'a>(&'a self, answer: Answer, sending: &LocalExecutor<'a>) {
        match answer {
            Answer::Motion(id, answered) => {
                let CheckTrajectoryResponse { motion, turns, .. } = self.publish_more(*answered);
                sending.spawn(self.motions.respond(id, CheckMotionResponse { motion, turns })).detach();
            }
            Answer::Trajectory(id, answered) => {
                let response = self.publish_more(*answered);
                sending.spawn(self.trajectories.respond(id, response)).detach();
            }
            Answer::StartedGoal(begun) => self.goals.follow(begun, sending),
            Answer::Goal(id, answered) => {
                let response = self.publish_more(*answered);
                self.goals.end(id, &response, sending);
            }
        }
    }

    /// Publishes the optional results and returns the response.
    fn publish_more(&self, answered: MotionResponse) -> CheckTrajectoryResponse {
        let MotionResponse { response, certificate, swept_volume } = answered;
        if let Some(data) = certificate {
            self.certificates.publish(StringMessage { data });
        }
        if let Some(markers) = swept_volume {
            self.swept_volumes.publish(markers);
        }
        response
    }
}

impl MotionWorker {
    /// Processes requests until all senders are gone.
    pub fn work(mut self) {
        while let Ok(request) = self.requests.recv_blocking() {
            let evaluation = known(&self.current, self.clock.read());
            // a goal that was canceled in the queue has its result already
            if matches!(&request, Request::Goal(goal) if goal.watch.is_stopped()) {
                continue;
            }
            if let Request::Goal(goal) = &request
                && self.answers.send_blocking(Answer::StartedGoal(StartedGoal::of(goal))).is_err()
            {
                return;
            }
            let answer = self.answer(request, evaluation.as_ref());
            if self.answers.send_blocking(answer).is_err() {
                return;
            }
        }
    }

    fn answer(&mut self, request: Request, evaluation: Option<&Evaluation>) -> Answer {
        let usual = self.parameters.get().continuous_direction();
        let answered = self.guarded(|workspace| match &request {
            Request::Motion(_, request) => answer_motion(request, usual, evaluation, workspace),
            Request::Trajectory(_, request) => answer_trajectory(request, None, evaluation, workspace),
            Request::Goal(Goal { request, watch, .. }) => {
                answer_trajectory(request, Some(watch.clone()), evaluation, workspace)
            }
        });
        request.answered(answered)
    }

    /// Processes an untrusted request. A panic in it must not end the node.
    fn guarded(&mut self, answer: impl FnOnce(&mut Option<Workspace>) -> MotionResponse) -> MotionResponse {
        catch_unwind(AssertUnwindSafe(|| answer(&mut self.workspace))).unwrap_or_else(|_| {
            log::error!("a motion could not be checked: the program failed inside");
            self.workspace = None;
            MotionResponse::from(&Rejection::Internal)
        })
    }
}

impl Request {
    fn answered(self, answered: MotionResponse) -> Answer {
        match self {
            Self::Motion(id, _) => Answer::Motion(id, Box::new(answered)),
            Self::Trajectory(id, _) => Answer::Trajectory(id, Box::new(answered)),
            Self::Goal(goal) => Answer::Goal(goal.id, Box::new(answered)),
        }
    }
}
