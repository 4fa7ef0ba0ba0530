//! Actions: goals and cancellations in, progress and results out.
//!
//! The client library's own asynchronous server keeps a goal until somebody asks for its result, and hears of such questions only while it
//! gives one; so only its endpoints are used here. What becomes of goals is the user's.

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

use super::answering::Answering;
use super::decode_error_log::DecodeErrorLog;
use super::peers::Peers;
use super::wakeup;
use super::{Message, RequestId, lock};
use crate::names::FullName;
use crate::thread_priority::ThreadPriority;

pub use ros2_client::action::GoalId;
pub use ros2_client::action_msgs::{CancelGoalResponseEnum as CancelCode, GoalInfo, GoalStatus};

/// How a goal stands.
pub type Standing = GoalStatusEnum;

/// Serves one action.
pub struct ActionServer<Goal, Outcome, Progress>
where
    Goal: Message + Clone,
    Outcome: Message + Clone,
    Progress: Message,
{
    /// The library gives its three servers one at a time.
    inner: Mutex<ros2_client::ActionServer<Goal, Outcome, Progress>>,
    name: FullName,
    peers: Arc<Peers>,
    /// Results, which may be long.
    results: Answering,
    complaints: DecodeErrorLog,
    priority: ThreadPriority,
}

/// `action_msgs/srv/CancelGoal`, whose fields the library keeps to itself.
#[derive(Serialize, Deserialize)]
struct Cancellation {
    goal_info: GoalInfo,
}

/// The next request of one of the three services, waiting for it. What can not be decoded is logged and passed over.
macro_rules! next_request {
    ($self:ident, $server:ident) => {
        loop {
            let taken = poll_fn(|context| {
                let mut inner = lock(&$self.inner);
                // what has not come leaves its waker with the reader
                pin!(inner.$server().async_receive_request()).poll(context)
            });
            match wakeup::wait($self.priority, taken).await {
                Ok((id, request)) => break (RequestId(id), request),
                Err(error) => {
                    $self
                        .complaints
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
        let results = Answering::new(name.clone(), &format!("{name}/_action/get_result"), Arc::clone(&peers));
        Self {
            inner: Mutex::new(inner),
            name,
            peers,
            results,
            complaints: DecodeErrorLog::default(),
            priority,
        }
    }

    /// Calls the library.
    fn call<T>(&self, call: impl FnOnce(&mut ros2_client::ActionServer<Goal, Outcome, Progress>) -> T) -> T {
        let mut inner = lock(&self.inner);
        let _lent = self.priority.lend();
        call(&mut inner)
    }

    pub async fn next_goal(&self) -> (RequestId, GoalId, Goal) {
        let (id, SendGoalRequest { goal_id, goal }) = next_request!(self, goal_server);
        (id, goal_id, goal)
    }

    /// The goal, or the time, that is to be canceled, as `action_msgs/srv/CancelGoal` has it.
    pub async fn next_cancellation(&self) -> (RequestId, GoalInfo) {
        loop {
            let (id, request) = next_request!(self, cancel_server);
            let read = serde_json::to_value(&request).and_then(serde_json::from_value);
            match read {
                Ok(Cancellation { goal_info }) => return (id, goal_info),
                Err(error) => {
                    self.complaints
                        .warn(|| format!("a cancellation of {} could not be read: {error}", self.name));
                }
            }
        }
    }

    pub async fn next_result_request(&self) -> (RequestId, GoalId) {
        let (id, GetResultRequest { goal_id }) = next_request!(self, result_server);
        (id, goal_id)
    }

    pub async fn answer_goal(&self, RequestId(id): RequestId, accepted: bool, stamp: Stamp) {
        self.await_reader(&id).await;
        let response = SendGoalResponse { accepted, stamp };
        self.check(self.call(|inner| inner.send_goal_response(id, response)));
    }

    pub async fn answer_cancellation(
        &self,
        RequestId(id): RequestId,
        return_code: CancelCode,
        goals_canceling: Vec<GoalInfo>,
    ) {
        self.await_reader(&id).await;
        let response = CancelGoalResponse { return_code, goals_canceling };
        self.check(self.call(|inner| inner.send_cancel_response(id, response)));
    }

    pub async fn answer_result(&self, RequestId(id): RequestId, status: Standing, result: Outcome) {
        let write = |id, response| self.call(|inner| inner.send_result(id, response));
        self.results.send(id, GetResultResponse { status, result }, write).await;
    }

    pub fn tell_progress(&self, goal_id: GoalId, feedback: Progress) {
        let message = FeedbackMessage { goal_id, feedback };
        let sent = self.call(|inner| inner.feedback_publisher().publish(message));
        self.check(sent);
    }

    /// Tells how all known goals stand.
    pub fn tell_standings(&self, status_list: Vec<GoalStatus>) {
        self.check(self.call(|inner| inner.send_goal_statuses(GoalStatusArray { status_list })));
    }

    async fn await_reader(&self, id: &RmwRequestId) {
        self.peers.await_reader(GUID::from(id.writer_gid), &self.name).await;
    }

    fn check<E: std::fmt::Display>(&self, sent: Result<(), E>) {
        if let Err(error) = sent {
            log::warn!("an answer of {} was dropped: {error}", self.name);
        }
    }
}
