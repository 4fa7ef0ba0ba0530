//! `~/check_motion`, `~/check_motions` and `~/check_trajectory`, the last also as an action. Requests and responses are handled on the
//! services thread. Checks run one after the other on a separate thread, so that a long motion does not delay other
//! work.

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
    CheckMotionRequest, CheckMotionResponse, CheckMotionsRequest, CheckMotionsResponse,
    CheckTrajectoryRequest, CheckTrajectoryResponse,
};
use crate::monitor_events::current_evaluation::{CurrentEvaluation, newest};
use crate::names::Names;
use crate::parameters::parameter_store::ParameterStore;
use crate::services::motion_batches::{evaluate_motions, rejected_motions};
use crate::services::motion_requests::{MotionResponse, evaluate_motion, evaluate_trajectory};
use crate::services::request_rejection::RequestRejection;
use crate::services::trajectory_action::{Goal, StartedGoal, TrajectoryAction};

/// Maximum length of the request queue. Further requests get the response that the node is busy.
const WAITING: usize = 16;

/// Queued request.
enum Request {
    Motion(RequestId, CheckMotionRequest),
    Motions(RequestId, CheckMotionsRequest),
    Trajectory(RequestId, CheckTrajectoryRequest),
    Goal(Goal),
}

enum Response {
    Motion(RequestId, Box<MotionResponse>),
    Motions(RequestId, Box<CheckMotionsResponse>),
    Trajectory(RequestId, Box<MotionResponse>),
    /// The check of a goal has started.
    Started(StartedGoal),
    Goal(GoalId, Box<MotionResponse>),
}

/// Network side: receives requests and sends responses.
pub struct MotionServices {
    motions: Server<CheckMotionRequest, CheckMotionResponse>,
    batches: Server<CheckMotionsRequest, CheckMotionsResponse>,
    trajectories: Server<CheckTrajectoryRequest, CheckTrajectoryResponse>,
    goals: TrajectoryAction,
    certificates: Publisher<StringMessage>,
    swept_volumes: Publisher<MarkerArray>,
    requests: Sender<Request>,
    responses: Receiver<Response>,
}

/// Side that runs the checks. It owns no network resources: the node ends without waiting for it.
pub struct MotionWorker {
    requests: Receiver<Request>,
    responses: Sender<Response>,
    current: CurrentEvaluation,
    clock: Arc<RosClock>,
    parameters: ParameterStore,
    workspace: Option<Workspace>,
}

impl MotionServices {
    /// Creates both sides. `current` is the evaluation whose robot and world the checks use.
    pub fn open(
        middleware: &Middleware,
        names: &Names,
        current: CurrentEvaluation,
        clock: Arc<RosClock>,
        parameters: ParameterStore,
    ) -> Result<(Self, MotionWorker), MiddlewareError> {
        let (requests, requests_in) = channel::bounded(WAITING);
        // at most two items for each queued request
        let (responses, responses_in) = channel::unbounded();
        let string = TypeName::new("std_msgs", "String");
        let markers = TypeName::new("visualization_msgs", "MarkerArray");
        let services = Self {
            motions: middleware.server(
                &names.resolve_service("~/check_motion")?,
                TypeName::new("clearance_msgs", "CheckMotion"),
            )?,
            batches: middleware.server(
                &names.resolve_service("~/check_motions")?,
                TypeName::new("clearance_msgs", "CheckMotions"),
            )?,
            trajectories: middleware.server(
                &names.resolve_service("~/check_trajectory")?,
                TypeName::new("clearance_msgs", "CheckTrajectory"),
            )?,
            goals: TrajectoryAction::open(middleware, names, Arc::clone(&clock))?,
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
            responses: responses_in,
        };
        let worker =
            MotionWorker { requests: requests_in, responses, current, clock, parameters, workspace: None };
        Ok((services, worker))
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
        let batches = async {
            loop {
                let (id, request) = self.batches.next().await;
                self.enqueue(Request::Motions(id, request), &sending);
            }
        };
        let trajectories = async {
            loop {
                let (id, request) = self.trajectories.next().await;
                self.enqueue(Request::Trajectory(id, request), &sending);
            }
        };
        let responses = async {
            while let Ok(response) = self.responses.recv().await {
                self.send(response, &sending);
            }
        };
        let goals = self.goals.serve(&sending, |goal| self.requests.try_send(Request::Goal(goal)).is_ok());
        let requests = future::zip(future::zip(motions, batches), trajectories);
        let services = future::zip(requests, responses);
        sending.run(future::zip(services, goals)).await;
    }

    fn enqueue<'a>(&'a self, request: Request, sending: &LocalExecutor<'a>) {
        // when the worker has ended, the service reports that it is busy
        if let Err(rejected) = self.requests.try_send(request) {
            self.send(rejected.into_inner().rejected(&RequestRejection::Busy(WAITING)), sending);
        }
    }

    fn send<'a>(&'a self, response: Response, sending: &LocalExecutor<'a>) {
        match response {
            Response::Motion(id, motion_response) => {
                let CheckTrajectoryResponse { motion, turns, distances, .. } =
                    self.publish_results(*motion_response);
                let response = CheckMotionResponse { motion, turns, distances };
                sending.spawn(self.motions.respond(id, response)).detach();
            }
            Response::Motions(id, response) => {
                sending.spawn(self.batches.respond(id, *response)).detach();
            }
            Response::Trajectory(id, motion_response) => {
                let response = self.publish_results(*motion_response);
                sending.spawn(self.trajectories.respond(id, response)).detach();
            }
            Response::Started(started) => self.goals.publish_feedback(started, sending),
            Response::Goal(id, motion_response) => {
                let response = self.publish_results(*motion_response);
                self.goals.end(id, &response, sending);
            }
        }
    }

    /// Publishes the optional results and returns the response.
    fn publish_results(&self, motion_response: MotionResponse) -> CheckTrajectoryResponse {
        let MotionResponse { response, certificate, swept_volume } = motion_response;
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
    pub fn run(mut self) {
        while let Ok(request) = self.requests.recv_blocking() {
            let evaluation = newest(&self.current, self.clock.read());
            // a goal that was canceled in the queue has its result already
            if matches!(&request, Request::Goal(goal) if goal.watch.is_stopped()) {
                continue;
            }
            if let Request::Goal(goal) = &request
                && self.responses.send_blocking(Response::Started(StartedGoal::of(goal))).is_err()
            {
                return;
            }
            let response = self.evaluate(request, evaluation.as_ref());
            if self.responses.send_blocking(response).is_err() {
                return;
            }
        }
    }

    fn evaluate(&mut self, request: Request, evaluation: Option<&Evaluation>) -> Response {
        let usual = self.parameters.get().continuous_direction();
        let or_failed = |response: Option<MotionResponse>| {
            Box::new(response.unwrap_or_else(|| MotionResponse::from(&RequestRejection::Internal)))
        };
        match request {
            Request::Motion(id, request) => {
                let response = self.guarded(|memory| evaluate_motion(&request, usual, evaluation, memory));
                Response::Motion(id, or_failed(response))
            }
            Request::Motions(id, request) => {
                let response = self.guarded(|memory| evaluate_motions(&request, evaluation, memory));
                let response = response.unwrap_or_else(|| rejected_motions(&RequestRejection::Internal));
                Response::Motions(id, Box::new(response))
            }
            Request::Trajectory(id, request) => {
                let response = self.guarded(|memory| evaluate_trajectory(&request, None, evaluation, memory));
                Response::Trajectory(id, or_failed(response))
            }
            Request::Goal(Goal { id, request, watch, .. }) => {
                let response =
                    self.guarded(|memory| evaluate_trajectory(&request, Some(watch), evaluation, memory));
                Response::Goal(id, or_failed(response))
            }
        }
    }

    /// Processes an untrusted request. A panic in it must not end the node.
    fn guarded<T>(&mut self, evaluate: impl FnOnce(&mut Option<Workspace>) -> T) -> Option<T> {
        let evaluated = catch_unwind(AssertUnwindSafe(|| evaluate(&mut self.workspace)));
        if evaluated.is_err() {
            log::error!("a motion could not be checked: the program failed inside");
            self.workspace = None;
        }
        evaluated.ok()
    }
}

impl Request {
    fn rejected(self, rejection: &RequestRejection) -> Response {
        let motion_response = || Box::new(MotionResponse::from(rejection));
        match self {
            Self::Motion(id, _) => Response::Motion(id, motion_response()),
            Self::Motions(id, _) => Response::Motions(id, Box::new(rejected_motions(rejection))),
            Self::Trajectory(id, _) => Response::Trajectory(id, motion_response()),
            Self::Goal(goal) => Response::Goal(goal.id, motion_response()),
        }
    }
}
