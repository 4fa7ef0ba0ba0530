//! Action server: receives goals and cancellations, publishes feedback and results.
//!
//! The asynchronous action server of `ros2_client` keeps each goal until a client requests its result, and reads result
//! requests only while it sends a result. Therefore only its endpoints are used here. The caller of this module manages
//! the goals.

use std::future::poll_fn;
use std::pin::pin;
use std::sync::{Arc, Mutex};

use ros2_client::RmwRequestId;
use ros2_client::action::{FeedbackMessage, GetResultRequest, GetResultResponse, GoalStatusEnum};
use ros2_client::action::{SendGoalRequest, SendGoalResponse};
use ros2_client::action_msgs::{CancelGoalResponse, GoalStatusArray};
use ros2_client::builtin_interfaces::Time as Stamp;
use rustdds::GUID;
use serde::{Deserialize, Serialize};

use crate::dds::decode_error_log::DecodeErrorLog;
use crate::dds::lock::lock;
use crate::dds::peers::Peers;
use crate::dds::response_sender::ResponseSender;
use crate::dds::server::RequestId;
use crate::dds::{Message, wakeup};
use crate::names::FullName;
use crate::threading::thread_priority::ThreadPriority;

pub use ros2_client::action::GoalId;
pub use ros2_client::action_msgs::{CancelGoalResponseEnum as CancelCode, GoalInfo, GoalStatus};

/// Status of a goal.
pub type GoalStatusCode = GoalStatusEnum;

/// Server of one action.
pub struct ActionServer<Goal, Outcome, Progress>
where
    Goal: Message + Clone,
    Outcome: Message + Clone,
    Progress: Message,
{
    /// The library lends its three service servers one at a time, hence the mutex.
    inner: Mutex<ros2_client::ActionServer<Goal, Outcome, Progress>>,
    name: FullName,
    peers: Arc<Peers>,
    /// Sends the results, which may be longer than a datagram.
    results: ResponseSender,
    decode_errors: DecodeErrorLog,
    priority: ThreadPriority,
}

/// `action_msgs/srv/CancelGoal`. The library's own type has private fields.
#[derive(Serialize, Deserialize)]
struct Cancellation {
    goal_info: GoalInfo,
}

/// Waits for the next request of one of the three services. A request that cannot be decoded is logged and skipped.
macro_rules! next_request {
    ($self:ident, $server:ident) => {
        loop {
            let taken = poll_fn(|context| {
                let mut inner = lock(&$self.inner);
                // a pending future leaves its waker with the reader
                pin!(inner.$server().async_receive_request()).poll(context)
            });
            match wakeup::wait($self.priority, taken).await {
                Ok((id, request)) => break (RequestId(id), request),
                Err(error) => {
                    $self
                        .decode_errors
                        .warn(|| format!("a request to {} could not be read: {error}", $self.name));
                }
            }
        }
    };
}

impl<Goal, Outcome, Progress> ActionServer<Goal, Outcome, Progress>
where
    Goal: Message + Clone + 'static,
    Outcome: Message + Clone + 'static,
    Progress: Message + 'static,
{
    pub(super) fn new(
        inner: ros2_client::ActionServer<Goal, Outcome, Progress>,
        name: FullName,
        peers: Arc<Peers>,
        priority: ThreadPriority,
    ) -> Self {
        let results =
            ResponseSender::new(name.clone(), &format!("{name}/_action/get_result"), Arc::clone(&peers));
        Self {
            inner: Mutex::new(inner),
            name,
            peers,
            results,
            decode_errors: DecodeErrorLog::default(),
            priority,
        }
    }

    /// Calls the library with the priority of its threads.
    fn call<T>(&self, call: impl FnOnce(&mut ros2_client::ActionServer<Goal, Outcome, Progress>) -> T) -> T {
        let mut inner = lock(&self.inner);
        let _lent = self.priority.lend();
        call(&mut inner)
    }

    pub async fn next_goal(&self) -> (RequestId, GoalId, Goal) {
        let (id, SendGoalRequest { goal_id, goal }) = next_request!(self, goal_server);
        (id, goal_id, goal)
    }

    /// Waits for the next cancellation: the goal or the time to cancel, as `action_msgs/srv/CancelGoal` defines it.
    pub async fn next_cancellation(&self) -> (RequestId, GoalInfo) {
        loop {
            let (id, request) = next_request!(self, cancel_server);
            let read = serde_json::to_value(&request).and_then(serde_json::from_value);
            match read {
                Ok(Cancellation { goal_info }) => return (id, goal_info),
                Err(error) => {
                    self.decode_errors
                        .warn(|| format!("a cancellation of {} could not be read: {error}", self.name));
                }
            }
        }
    }

    pub async fn next_result_request(&self) -> (RequestId, GoalId) {
        let (id, GetResultRequest { goal_id }) = next_request!(self, result_server);
        (id, goal_id)
    }

    pub async fn respond_to_goal(&self, RequestId(id): RequestId, accepted: bool, stamp: Stamp) {
        self.await_reader(&id).await;
        let response = SendGoalResponse { accepted, stamp };
        self.check(self.call(|inner| inner.send_goal_response(id, response)));
    }

    pub async fn respond_to_cancellation(
        &self,
        RequestId(id): RequestId,
        return_code: CancelCode,
        goals_canceling: Vec<GoalInfo>,
    ) {
        self.await_reader(&id).await;
        let response = CancelGoalResponse { return_code, goals_canceling };
        self.check(self.call(|inner| inner.send_cancel_response(id, response)));
    }

    pub async fn respond_to_result(&self, RequestId(id): RequestId, status: GoalStatusCode, result: Outcome) {
        let write = |id, response| self.call(|inner| inner.send_result(id, response));
        self.results.send(id, GetResultResponse { status, result }, write).await;
    }

    pub fn publish_feedback(&self, goal_id: GoalId, feedback: Progress) {
        let message = FeedbackMessage { goal_id, feedback };
        let sent = self.call(|inner| inner.feedback_publisher().publish(message));
        self.check(sent);
    }

    /// Publishes the status of all known goals.
    pub fn publish_statuses(&self, status_list: Vec<GoalStatus>) {
        self.check(self.call(|inner| inner.send_goal_statuses(GoalStatusArray { status_list })));
    }

    async fn await_reader(&self, id: &RmwRequestId) {
        self.peers.await_reader(GUID::from(id.writer_gid), &self.name).await;
    }

    fn check<E: std::fmt::Display>(&self, sent: Result<(), E>) {
        if let Err(error) = sent {
            log::warn!("a response of {} was dropped: {error}", self.name);
        }
    }
}
