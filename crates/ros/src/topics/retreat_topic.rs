//! `~/retreat_direction`: joint direction out of a collision, computed and published on a separate thread. A
//! penetration depth takes milliseconds, and would delay the joint states.
//!
//! A direction is computed at most at the rate of the parameter `retreat_rate`, for the newest evaluation. An empty
//! message withdraws it: at once when the status is no longer COLLIDING or the topic is turned off, and when no direction
//! can be computed.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use clearance_checker::{CollisionChecker, RecoveryOptions, Retreat, Workspace};
use clearance_monitor::{Evaluation, Status};
use clearance_robot::quoted_list;
use clearance_scene::BodyId;
use ros2_interfaces_jazzy_serde::sensor_msgs::msg::JointState;

use crate::clock::RosClock;
use crate::dds::middleware::Middleware;
use crate::dds::middleware_error::MiddlewareError;
use crate::dds::publisher::Publisher;
use crate::dds::quality::Quality;
use crate::dds::type_name::TypeName;
use crate::log_rate_limiter::LogRateLimiter;
use crate::messages::collision_state::header;
use crate::monitor_events::current_evaluation::{CurrentEvaluation, newest};
use crate::names::Names;
use crate::parameters::parameter_set::Parameters;
use crate::threading::mailbox;
use crate::threading::mailbox::{Receiver, Sender};
use crate::threading::timed_wait::wait_at_most;

/// Task of the worker, for the newest evaluation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Task {
    /// Publish its direction, or that there is none.
    Publish,
    /// Withdraw the last direction, because the robot has left the collision.
    Withdraw,
    /// Withdraw the last direction, because the topic is turned off.
    TurnOff,
}

/// Sending end on the monitor's thread: notifies the thread that computes directions.
#[derive(Debug)]
pub struct RetreatFeed {
    tasks: Sender<Task>,
    /// Steady time of the last queued direction, and whether the robot has collided since the last task; `None` if the
    /// topic is off.
    last: Option<(Duration, bool)>,
    dropped: Arc<AtomicU64>,
}

/// Receiving end: computes and publishes directions until the sending end is dropped.
pub struct RetreatWorker {
    tasks: Receiver<Task>,
    publisher: Publisher<JointState>,
    current: CurrentEvaluation,
    clock: Arc<RosClock>,
    workspace: Option<Workspace>,
    /// Why no direction is published; `None` if one is.
    withdrawn: Option<NoDirection>,
    lines: LogRateLimiter,
    dropped: Arc<AtomicU64>,
}

/// Why no direction is published.
#[derive(Clone, Debug, PartialEq, Eq)]
enum NoDirection {
    TurnedOff,
    /// The status is not COLLIDING, but this one.
    NotColliding(&'static str),
    /// No joint reduces the depth of this pair.
    Stuck([String; 2]),
    /// The depth of this pair is not known, for this reason.
    UnknownDepth([String; 2], &'static str),
    /// The computation failed inside the program.
    Failed,
}

/// Creates the sending end and the receiving end of the topic. `current` is the evaluation that directions are computed for.
pub fn open(
    middleware: &Middleware,
    names: &Names,
    current: CurrentEvaluation,
    clock: Arc<RosClock>,
) -> Result<(RetreatFeed, RetreatWorker), MiddlewareError> {
    let kind = TypeName::new("sensor_msgs", "JointState");
    let publisher = middleware.publisher(&names.resolve("~/retreat_direction")?, kind, Quality::Reliable)?;
    let (feed, tasks) = feed();
    let dropped = Arc::clone(&feed.dropped);
    let worker = RetreatWorker {
        tasks,
        publisher,
        current,
        clock,
        workspace: None,
        withdrawn: Some(NoDirection::TurnedOff),
        lines: LogRateLimiter::default(),
        dropped,
    };
    Ok((feed, worker))
}

/// The queue holds one task: the worker reads the newest evaluation when it begins.
fn feed() -> (RetreatFeed, Receiver<Task>) {
    let (sender, tasks) = mailbox::bounded(1);
    (RetreatFeed { tasks: sender, last: None, dropped: Arc::default() }, tasks)
}

impl RetreatFeed {
    /// Queues a task at the retreat rate, and at once when the robot has left the collision. It is skipped if the worker
    /// has not begun the last one.
    pub fn note(&mut self, evaluation: &Evaluation, parameters: &Parameters, steady: Duration) {
        if parameters.retreat_rate <= 0.0 {
            if self.last.is_some() && self.tasks.send(Task::TurnOff).is_ok() {
                self.last = None;
            }
            return;
        }
        let collides = evaluation.status == Status::Colliding;
        let period = Duration::try_from_secs_f64(1.0 / parameters.retreat_rate).unwrap_or(Duration::MAX);
        let is_due = self.last.is_none_or(|(at, _)| steady.saturating_sub(at) >= period);
        if is_due {
            if self.tasks.send(Task::Publish).is_ok() {
                self.last = Some((steady, collides));
            }
        } else if let Some((_, collided)) = &mut self.last {
            // the worker may begin a queued task at any later evaluation
            *collided = collides || (*collided && self.tasks.send(Task::Withdraw).is_err());
        }
    }

    /// Number of messages dropped since the last call.
    pub fn take_dropped(&self) -> u64 {
        self.dropped.swap(0, Ordering::Relaxed)
    }
}

impl RetreatWorker {
    pub fn run(mut self) {
        while let Some(Some(task)) = wait_at_most(Duration::MAX, self.tasks.receive()) {
            let Some(evaluation) = newest(&self.current, self.clock.read()) else { continue };
            match task {
                Task::Publish => self.publish(&evaluation),
                Task::Withdraw => self.withdraw(&evaluation, not_colliding(&evaluation)),
                Task::TurnOff => self.withdraw(&evaluation, NoDirection::TurnedOff),
            }
        }
    }

    fn publish(&mut self, evaluation: &Evaluation) {
        let found = self.guarded_direction(evaluation);
        // the computation takes time, in which the robot may have left the collision
        let left = newest(&self.current, self.clock.read()).filter(|now| now.status != Status::Colliding);
        match (found, left) {
            (_, Some(now)) => self.withdraw(&now, not_colliding(&now)),
            (Err(why), None) => self.withdraw(evaluation, why),
            (Ok(message), None) => {
                if self.send(message) {
                    self.withdrawn = None;
                }
            }
        }
    }

    /// A panic in the computation must not end the node.
    fn guarded_direction(&mut self, evaluation: &Evaluation) -> Result<JointState, NoDirection> {
        let workspace = &mut self.workspace;
        catch_unwind(AssertUnwindSafe(|| direction(evaluation, workspace))).unwrap_or_else(|_| {
            self.workspace = None;
            Err(NoDirection::Failed)
        })
    }

    /// Publishes and logs once that there is no direction any more, and again if the reason changes.
    fn withdraw(&mut self, evaluation: &Evaluation, why: NoDirection) {
        if self.withdrawn.as_ref() == Some(&why) {
            return;
        }
        if self.send(JointState { header: header(evaluation), ..JointState::default() }) {
            if let Some(text) = why.text().filter(|_| self.lines.admit(self.clock.steady())) {
                log::warn!("~/retreat_direction is empty: {text}");
            }
            // a message that was not sent is repeated with the next task
            self.withdrawn = Some(why);
        }
    }

    fn send(&self, message: JointState) -> bool {
        let sent = self.publisher.publish(message);
        self.dropped.fetch_add(u64::from(!sent), Ordering::Relaxed);
        sent
    }
}

fn not_colliding(evaluation: &Evaluation) -> NoDirection {
    NoDirection::NotColliding(evaluation.status.word())
}

/// The message with the direction of an evaluation.
fn direction(evaluation: &Evaluation, workspace: &mut Option<Workspace>) -> Result<JointState, NoDirection> {
    let (Status::Colliding, Some(checked_state), Some(revision)) =
        (&evaluation.status, &evaluation.checked_state, &evaluation.revision)
    else {
        return Err(not_colliding(evaluation));
    };
    let checker = &revision.checker;
    let memory = workspace.get_or_insert_with(|| checker.workspace());
    let q = &checked_state.configuration;
    let retreat = checker.retreat_direction(q, &RecoveryOptions::default(), memory);
    match retreat.map_err(|_| NoDirection::Failed)? {
        Retreat::Direction(found) => Ok(JointState {
            header: header(evaluation),
            name: checker.robot().position_names().to_vec(),
            velocity: found.velocities,
            ..JointState::default()
        }),
        Retreat::Free => Err(NoDirection::NotColliding(Status::Free.word())),
        Retreat::Stuck(pair) => Err(NoDirection::Stuck(names(checker, pair))),
        Retreat::UnknownDepth(pair, why) => {
            let code = why.map_or("unknown", clearance_proximity::UnknownDepth::code);
            Err(NoDirection::UnknownDepth(names(checker, pair), code))
        }
    }
}

fn names(checker: &CollisionChecker, (a, b): (BodyId, BodyId)) -> [String; 2] {
    [a, b].map(|body| checker.body_name(body).to_owned())
}

impl NoDirection {
    /// Text for the log, where the robot collides.
    fn text(&self) -> Option<String> {
        match self {
            Self::TurnedOff | Self::NotColliding(_) => None,
            Self::Stuck(pair) => {
                Some(format!("no joint velocity reduces the penetration of {}", quoted_list(pair)))
            }
            Self::UnknownDepth(pair, code) => {
                Some(format!("the penetration depth of {} is not known ({code})", quoted_list(pair)))
            }
            Self::Failed => Some("the computation failed inside the program".to_owned()),
        }
    }
}

#[cfg(test)]
mod tests;
