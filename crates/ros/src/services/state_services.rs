//! `~/check_states` and `~/get_distances`. Requests and responses are handled on the services thread. Checks run one request after the
//! other on a separate thread, so that a long batch delays nothing else, and a long motion does not delay a batch.

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
    CheckStatesRequest, CheckStatesResponse, GetDistancesRequest, GetDistancesResponse,
};
use crate::monitor_events::current_evaluation::CurrentEvaluation;
use crate::names::Names;
use crate::services::rejection::Rejection;
use crate::services::request_context::known;
use crate::services::state_requests::{answer_distances, answer_states, refused_distances, refused_states};

/// Maximum length of the request queue. Further requests get the response that the node is busy.
const WAITING: usize = 16;

/// Queued request.
enum Request {
    States(RequestId, CheckStatesRequest),
    Distances(RequestId, GetDistancesRequest),
}

enum Answer {
    States(RequestId, CheckStatesResponse),
    Distances(RequestId, GetDistancesResponse),
}

/// Network side: receives requests and sends responses.
pub struct StateServices {
    states: Server<CheckStatesRequest, CheckStatesResponse>,
    distances: Server<GetDistancesRequest, GetDistancesResponse>,
    requests: Sender<Request>,
    answers: Receiver<Answer>,
}

/// Side that runs the checks. It owns no network resources: the node ends without waiting for it.
pub struct StateWorker {
    requests: Receiver<Request>,
    answers: Sender<Answer>,
    current: CurrentEvaluation,
    clock: Arc<RosClock>,
    workspace: Option<Workspace>,
}

impl StateServices {
    /// Creates both sides. `current` is the evaluation whose robot and world the checks use.
    pub fn offer(
        middleware: &Middleware,
        names: &Names,
        current: CurrentEvaluation,
        clock: Arc<RosClock>,
    ) -> Result<(Self, StateWorker), MiddlewareError> {
        let (requests, requests_in) = channel::bounded(WAITING);
        // at most one item for each queued request
        let (answers, answers_in) = channel::unbounded();
        let services = Self {
            states: middleware
                .server(&names.resolve("~/check_states")?, TypeName::new("clearance_msgs", "CheckStates"))?,
            distances: middleware.server(
                &names.resolve("~/get_distances")?,
                TypeName::new("clearance_msgs", "GetDistances"),
            )?,
            requests,
            answers: answers_in,
        };
        Ok((services, StateWorker { requests: requests_in, answers, current, clock, workspace: None }))
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
        let answers = async {
            while let Ok(answer) = self.answers.recv().await {
                self.send(answer, &sending);
            }
        };
        sending.run(future::zip(future::zip(states, distances), answers)).await;
    }

    fn enqueue<'a>(&'a self, request: Request, sending: &LocalExecutor<'a>) {
        // when the desk has ended, the service reports that it is busy
        if let Err(refused) = self.requests.try_send(request) {
            self.send(refused.into_inner().refused(&Rejection::Busy(WAITING)), sending);
        }
    }

    fn send<'a>(&'a self, answer: Answer, sending: &LocalExecutor<'a>) {
        let send = async move {
            match answer {
                Answer::States(id, response) => self.states.respond(id, response).await,
                Answer::Distances(id, response) => self.distances.respond(id, response).await,
            }
        };
        sending.spawn(send).detach();
    }
}

impl StateWorker {
    /// Processes requests until all senders are gone.
    pub fn work(mut self) {
        while let Ok(request) = self.requests.recv_blocking() {
            let evaluation = known(&self.current, self.clock.read());
            let answer = self.answer(request, evaluation.as_ref());
            if self.answers.send_blocking(answer).is_err() {
                return;
            }
        }
    }

    fn answer(&mut self, request: Request, evaluation: Option<&Evaluation>) -> Answer {
        match request {
            Request::States(id, request) => {
                let response = self.guarded(|workspace| answer_states(&request, evaluation, workspace));
                Answer::States(id, response.unwrap_or_else(|| refused_states(&Rejection::Internal)))
            }
            Request::Distances(id, request) => {
                let response = self.guarded(|workspace| answer_distances(&request, evaluation, workspace));
                Answer::Distances(id, response.unwrap_or_else(|| refused_distances(&Rejection::Internal)))
            }
        }
    }

    /// Processes an untrusted request. A panic in it must not end the node.
    fn guarded<T>(&mut self, answer: impl FnOnce(&mut Option<Workspace>) -> T) -> Option<T> {
        let answered = catch_unwind(AssertUnwindSafe(|| answer(&mut self.workspace)));
        if answered.is_err() {
            log::error!("states could not be checked: the program failed inside");
            self.workspace = None;
        }
        answered.ok()
    }
}

impl Request {
    fn refused(self, refusal: &Rejection) -> Answer {
        match self {
            Self::States(id, _) => Answer::States(id, refused_states(refusal)),
            Self::Distances(id, _) => Answer::Distances(id, refused_distances(refusal)),
        }
    }
}
