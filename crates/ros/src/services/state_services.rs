//! `~/check_states`, `~/get_distances` and `~/find_free_state`. Requests and responses are handled on the services
//! thread. Checks run one request after the other on a separate thread, so that a long batch delays nothing else, and a
//! long motion does not delay a batch.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use clearance_checker::Workspace;
use clearance_monitor::Evaluation;
use futures_lite::future;
use smol::LocalExecutor;
use smol::channel::{self, Receiver, Sender};

use crate::clock::RosClock;
use crate::dds::middleware::Middleware;
use crate::dds::middleware_error::MiddlewareError;
use crate::dds::server::{RequestId, Server};
use crate::dds::type_name::TypeName;
use crate::messages::clearance_srvs::{
    CheckStatesRequest, CheckStatesResponse, FindFreeStateRequest, FindFreeStateResponse,
    GetDistancesRequest, GetDistancesResponse,
};
use crate::monitor_events::current_evaluation::{CurrentEvaluation, newest};
use crate::names::Names;
use crate::services::recovery_requests::{rejected_search, search_free_state};
use crate::services::request_rejection::RequestRejection;
use crate::services::state_requests::{
    evaluate_distances, evaluate_states, rejected_distances, rejected_states,
};

/// Maximum length of the request queue. Further requests get the response that the node is busy.
const WAITING: usize = 16;

/// Queued request.
enum Request {
    States(RequestId, CheckStatesRequest),
    Distances(RequestId, GetDistancesRequest),
    FreeState(RequestId, FindFreeStateRequest),
}

enum Response {
    States(RequestId, CheckStatesResponse),
    Distances(RequestId, GetDistancesResponse),
    FreeState(RequestId, FindFreeStateResponse),
}

/// Network side: receives requests and sends responses.
pub struct StateServices {
    states: Server<CheckStatesRequest, CheckStatesResponse>,
    distances: Server<GetDistancesRequest, GetDistancesResponse>,
    free_states: Server<FindFreeStateRequest, FindFreeStateResponse>,
    requests: Sender<Request>,
    responses: Receiver<Response>,
}

/// Side that runs the checks. It owns no network resources: the node ends without waiting for it.
pub struct StateWorker {
    requests: Receiver<Request>,
    responses: Sender<Response>,
    current: CurrentEvaluation,
    clock: Arc<RosClock>,
    workspace: Option<Workspace>,
}

impl StateServices {
    /// Creates both sides. `current` is the evaluation whose robot and world the checks use.
    pub fn open(
        middleware: &Middleware,
        names: &Names,
        current: CurrentEvaluation,
        clock: Arc<RosClock>,
    ) -> Result<(Self, StateWorker), MiddlewareError> {
        let (requests, requests_in) = channel::bounded(WAITING);
        // at most one item for each queued request
        let (responses, responses_in) = channel::unbounded();
        let kind = |name| TypeName::new("clearance_msgs", name);
        let services = Self {
            states: middleware.server(&names.resolve_service("~/check_states")?, kind("CheckStates"))?,
            distances: middleware.server(&names.resolve_service("~/get_distances")?, kind("GetDistances"))?,
            free_states: middleware
                .server(&names.resolve_service("~/find_free_state")?, kind("FindFreeState"))?,
            requests,
            responses: responses_in,
        };
        Ok((services, StateWorker { requests: requests_in, responses, current, clock, workspace: None }))
    }

    /// Handles requests without end.
    pub async fn serve(&self) {
        // each response waits only for its own client
        let sending = LocalExecutor::new();
        let states = async {
            loop {
                let (id, request) = self.states.next().await;
                self.enqueue(Request::States(id, request), &sending);
            }
        };
        let distances = async {
            loop {
                let (id, request) = self.distances.next().await;
                self.enqueue(Request::Distances(id, request), &sending);
            }
        };
        let free_states = async {
            loop {
                let (id, request) = self.free_states.next().await;
                self.enqueue(Request::FreeState(id, request), &sending);
            }
        };
        let requests = future::zip(future::zip(states, distances), free_states);
        let responses = async {
            while let Ok(response) = self.responses.recv().await {
                self.send(response, &sending);
            }
        };
        sending.run(future::zip(requests, responses)).await;
    }

    fn enqueue<'a>(&'a self, request: Request, sending: &LocalExecutor<'a>) {
        // when the worker has ended, the service reports that it is busy
        if let Err(rejected) = self.requests.try_send(request) {
            self.send(rejected.into_inner().rejected(&RequestRejection::Busy(WAITING)), sending);
        }
    }

    fn send<'a>(&'a self, response: Response, sending: &LocalExecutor<'a>) {
        let send = async move {
            match response {
                Response::States(id, response) => self.states.respond(id, response).await,
                Response::Distances(id, response) => self.distances.respond(id, response).await,
                Response::FreeState(id, response) => self.free_states.respond(id, response).await,
            }
        };
        sending.spawn(send).detach();
    }
}

impl StateWorker {
    /// Processes requests until all senders are gone.
    pub fn run(mut self) {
        while let Ok(request) = self.requests.recv_blocking() {
            let evaluation = newest(&self.current, self.clock.read());
            let response = self.evaluate(request, evaluation.as_ref());
            if self.responses.send_blocking(response).is_err() {
                return;
            }
        }
    }

    fn evaluate(&mut self, request: Request, evaluation: Option<&Evaluation>) -> Response {
        match request {
            Request::States(id, request) => {
                let response = self.guarded(|workspace| evaluate_states(&request, evaluation, workspace));
                Response::States(id, response.unwrap_or_else(|| rejected_states(&RequestRejection::Internal)))
            }
            Request::Distances(id, request) => {
                let response = self.guarded(|workspace| evaluate_distances(&request, evaluation, workspace));
                Response::Distances(
                    id,
                    response.unwrap_or_else(|| rejected_distances(&RequestRejection::Internal)),
                )
            }
            Request::FreeState(id, request) => {
                let response = self.guarded(|workspace| search_free_state(&request, evaluation, workspace));
                Response::FreeState(
                    id,
                    response.unwrap_or_else(|| rejected_search(&RequestRejection::Internal)),
                )
            }
        }
    }

    /// Processes an untrusted request. A panic in it must not end the node.
    fn guarded<T>(&mut self, evaluate: impl FnOnce(&mut Option<Workspace>) -> T) -> Option<T> {
        let evaluated = catch_unwind(AssertUnwindSafe(|| evaluate(&mut self.workspace)));
        if evaluated.is_err() {
            log::error!("states could not be checked: the program failed inside");
            self.workspace = None;
        }
        evaluated.ok()
    }
}

impl Request {
    fn rejected(self, rejection: &RequestRejection) -> Response {
        match self {
            Self::States(id, _) => Response::States(id, rejected_states(rejection)),
            Self::Distances(id, _) => Response::Distances(id, rejected_distances(rejection)),
            Self::FreeState(id, _) => Response::FreeState(id, rejected_search(rejection)),
        }
    }
}
