//! The services `get_planning_scene`, `apply_planning_scene`, `clear_octomap` and `check_state_validity`. Requests and
//! responses are handled on the thread of the world topics; states are checked on their own thread.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, PoisonError};
use std::time::Instant;

use futures_lite::future;
use ros2_interfaces_jazzy_serde::moveit_msgs::srv::{
    ApplyPlanningSceneRequest, ApplyPlanningSceneResponse, GetPlanningSceneRequest, GetPlanningSceneResponse,
    GetStateValidityRequest, GetStateValidityResponse,
};
use serde::{Deserialize, Serialize};
use smol::LocalExecutor;
use smol::channel::{self, Receiver, Sender};
use smol::lock::Semaphore;

use crate::dds::Message;
use crate::dds::decode_error_log::DecodeErrorLog;
use crate::dds::middleware::Middleware;
use crate::dds::middleware_error::MiddlewareError;
use crate::dds::server::{RequestId, Server};
use crate::dds::type_name::TypeName;
use crate::log_rate_limiter::LogRateLimiter;
use crate::monitor_events::current_evaluation::{CurrentEvaluation, newest};
use crate::names::Names;
use crate::recording::step::{RecordedCommand, SceneSource};
use crate::scene::active_scene::{ActiveScene, CurrentScene};
use crate::scene::command_conversion::clear_octomap;
use crate::scene::scene_command_sender::SceneCommandSender;
use crate::scene::scene_message_writer::{SceneMessages, scene_message};
use crate::scene::shared_state::SharedState;
use crate::services::request_rejection::shortened;
use crate::services::state_validity::{StateValidity, ValidityContext, constraints_given, state_validity};

/// Largest number of state queries in the queue. Further queries are rejected at once as not valid.
const WAITING: usize = 64;

/// Largest number of scenes that are being sent at once, since each may be large.
const MOST_SCENES: usize = 8;

/// `std_srvs/srv/Empty`, request and response: ROS sends one byte for an empty message.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Empty {
    structure_needs_at_least_one_member: u8,
}

impl Message for Empty {}

/// Communication with clients, on the thread of the world sender.
pub struct SceneServices {
    get: Server<GetPlanningSceneRequest, GetPlanningSceneResponse>,
    apply: Server<ApplyPlanningSceneRequest, ApplyPlanningSceneResponse>,
    clear: Server<Empty, Empty>,
    validity: Server<GetStateValidityRequest, GetStateValidityResponse>,
    scene: CurrentScene,
    evaluation: CurrentEvaluation,
    requests: Sender<(RequestId, GetStateValidityRequest)>,
    responses: Receiver<(RequestId, GetStateValidityResponse)>,
    busy: DecodeErrorLog,
    empty: DecodeErrorLog,
}

/// State checks, on their own thread.
pub struct ValidityWorker {
    requests: Receiver<(RequestId, GetStateValidityRequest)>,
    responses: Sender<(RequestId, GetStateValidityResponse)>,
    scene: CurrentScene,
    evaluation: CurrentEvaluation,
    shared: SharedState,
}

impl SceneServices {
    /// Creates the services; returns both parts.
    pub fn open(
        middleware: &Middleware,
        names: &Names,
        evaluation: CurrentEvaluation,
        shared: SharedState,
    ) -> Result<(Self, ValidityWorker), MiddlewareError> {
        let scene = Arc::clone(&shared.scene);
        let (requests, requests_in) = channel::bounded(WAITING);
        let (responses, responses_in) = channel::unbounded();
        let moveit = |kind| TypeName::new("moveit_msgs", kind);
        let services = Self {
            get: middleware
                .server(&names.resolve_service("get_planning_scene")?, moveit("GetPlanningScene"))?,
            apply: middleware
                .server(&names.resolve_service("apply_planning_scene")?, moveit("ApplyPlanningScene"))?,
            clear: middleware
                .server(&names.resolve_service("clear_octomap")?, TypeName::new("std_srvs", "Empty"))?,
            validity: middleware
                .server(&names.resolve_service("check_state_validity")?, moveit("GetStateValidity"))?,
            scene: Arc::clone(&scene),
            evaluation: Arc::clone(&evaluation),
            requests,
            responses: responses_in,
            busy: DecodeErrorLog::default(),
            empty: DecodeErrorLog::default(),
        };
        Ok((services, ValidityWorker { requests: requests_in, responses, scene, evaluation, shared }))
    }

    /// Serves requests. Never returns.
    pub async fn serve(&self, sender: &SceneCommandSender) {
        // each response waits only for its own client
        let sending = LocalExecutor::new();
        let scene_permits = Arc::new(Semaphore::new(MOST_SCENES));
        let get = async {
            loop {
                let (id, request) = self.get.next().await;
                let permit = scene_permits.acquire_arc().await;
                let response =
                    GetPlanningSceneResponse { scene: self.scene_response(request.components.components) };
                let send = async move {
                    self.get.respond(id, response).await;
                    drop(permit);
                };
                sending.spawn(send).detach();
            }
        };
        let apply = async {
            loop {
                let (id, request) = self.apply.next().await;
                sender.note_update(Instant::now());
                let command = sender.scene(SceneSource::ApplyPlanningScene, request.scene);
                let send = async move {
                    let success = sender.apply(command).await;
                    self.apply.respond(id, ApplyPlanningSceneResponse { success }).await;
                };
                sending.spawn(send).detach();
            }
        };
        let clear = async {
            loop {
                let (id, _) = self.clear.next().await;
                sender.note_update(Instant::now());
                let send = async move {
                    sender
                        .apply(clear_octomap().with_original(Some((RecordedCommand::ClearOctomap, None))))
                        .await;
                    self.clear.respond(id, Empty::default()).await;
                };
                sending.spawn(send).detach();
            }
        };
        let requests = async {
            loop {
                let request = self.validity.next().await;
                if let Err(rejected) = self.requests.try_send(request) {
                    self.busy.warn(|| {
                        format!("check_state_validity: not valid: {WAITING} requests are waiting already: ask again later")
                    });
                    let (id, _) = rejected.into_inner();
                    sending.spawn(self.validity.respond(id, GetStateValidityResponse::default())).detach();
                }
            }
        };
        let responses = async {
            while let Ok((id, response)) = self.responses.recv().await {
                sending.spawn(self.validity.respond(id, response)).detach();
            }
        };
        let scenes = future::zip(future::zip(get, apply), clear);
        sending.run(future::zip(scenes, future::zip(requests, responses))).await;
    }

    fn scene_response(
        &self,
        components: u32,
    ) -> ros2_interfaces_jazzy_serde::moveit_msgs::msg::PlanningScene {
        let scene = self.scene.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let Some(scene) = scene else {
            self.empty.warn(|| "get_planning_scene: there is no robot model yet".to_owned());
            return ros2_interfaces_jazzy_serde::moveit_msgs::msg::PlanningScene::default();
        };
        let evaluation = self.evaluation.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let robot_state = evaluation.and_then(|evaluation| {
            let same = evaluation.revision?.model == scene.revision.model;
            evaluation.robot_state.filter(|_| same)
        });
        let ActiveScene { revision, scene: state, octomap, parameters, .. } = scene.as_ref();
        let writer = SceneMessages {
            robot: revision.checker.robot(),
            scene: state,
            padding: parameters.padding,
            configuration: robot_state.as_ref().map(|checked_state| &checked_state.configuration),
            octomap: octomap.as_deref(),
        };
        scene_message(&writer, components)
    }
}

impl ValidityWorker {
    /// Checks queued states until the queue is closed.
    pub fn run(self) {
        let mut rate_limiter = LogRateLimiter::default();
        let mut warn = |what: &str| {
            if rate_limiter.admit(self.shared.clock.read().steady) {
                log::warn!("check_state_validity: {what}");
            }
        };
        while let Ok((id, request)) = self.requests.recv_blocking() {
            if constraints_given(&request.constraints) {
                warn("not valid: constraints are not evaluated here; leave them out");
            }
            let evaluated = catch_unwind(AssertUnwindSafe(|| self.evaluate(&request)));
            let response = match evaluated {
                Ok(Ok(StateValidity { response, remark })) => {
                    if let Some(remark) = remark {
                        warn(&remark);
                    }
                    response
                }
                Ok(Err(why)) => {
                    warn(&format!("not valid: {}", shortened(why)));
                    GetStateValidityResponse::default()
                }
                Err(_) => {
                    log::error!("check_state_validity: checking failed inside the program");
                    GetStateValidityResponse::default()
                }
            };
            if self.responses.send_blocking((id, response)).is_err() {
                return;
            }
        }
    }

    fn evaluate(&self, request: &GetStateValidityRequest) -> Result<StateValidity, String> {
        let scene = self.scene.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let scene = scene.ok_or("there is no robot model yet")?;
        let now = self.shared.clock.read();
        let evaluation = newest(&self.evaluation, now);
        let transforms = self.shared.transforms.lock().unwrap_or_else(PoisonError::into_inner).latest();
        state_validity(
            request,
            &ValidityContext { scene: &scene, evaluation: evaluation.as_ref(), transforms: &transforms, now },
        )
    }
}
