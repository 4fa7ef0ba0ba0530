//! Monitor thread: passes joint states to the monitor and publishes the evaluations. It must never wait for other work.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use clearance_monitor::{Evaluation, JointStateHistory, Monitor, Now, Reason, SourceId};
use futures_lite::future;
use ros2_interfaces_jazzy_serde::sensor_msgs::msg::JointState;

use crate::clock::RosClock;
use crate::dds::sequence_gaps::SequenceGaps;
use crate::dds::subscription::{Origin, Subscription};
use crate::log_rate_limiter::LogRateLimiter;
use crate::messages::joint_state::joint_state_input;
use crate::monitor_events::cloud_report::CloudReports;
use crate::monitor_events::current_evaluation::CurrentEvaluation;
use crate::monitor_events::current_evaluation::Observer;
use crate::monitor_events::monitor_event::MonitorEvent;
use crate::parameters::parameter_set::Parameters;
use crate::recording::recorded_event::{RecordedEvaluation, RecordedEvent};
use crate::recording::recorder_handle::RecorderHandle;
use crate::recording::step::RecordedMonitorEvent;
use crate::scene::shared_state::Transforms;
use crate::threading::mailbox::Receiver;
use crate::threading::timed_wait::wait_at_most;
use crate::topics::activity::Activity;
use crate::topics::diagnostics::diagnostics;
use crate::topics::evaluation_publishers::Publishers;

/// Period of the diagnostics while the status does not change.
const DIAGNOSTICS_PERIOD: Duration = Duration::from_secs(1);

/// If a joint state waited longer than this, checks take longer than the period of the joint states: then only the
/// newest one is evaluated.
const LONGEST_WAIT: Duration = Duration::from_millis(20);

/// State of the monitor thread.
pub struct MonitorLoop {
    pub node: String,
    pub monitor: Monitor,
    pub parameters: Parameters,
    pub clock: Arc<RosClock>,
    pub joint_states: Subscription<JointState>,
    pub transforms: Transforms,
    pub own_motion: OwnMotion,
    pub events: Receiver<MonitorEvent>,
    pub publishers: Publishers,
    pub current: CurrentEvaluation,
    pub joint_state_history: Arc<Mutex<JointStateHistory>>,
    pub observer: Option<Observer>,
    pub recording: RecorderHandle,
    pub report: Report,
}

/// Joint states that this program publishes itself. They arrive through this queue; their copies from the topic are
/// ignored.
pub struct OwnMotion {
    pub source: Option<SourceId>,
    pub joint_states: Receiver<JointState>,
}

/// Content of the next diagnostics message.
#[derive(Default)]
pub struct Report {
    activity: Activity,
    sequence_gaps: SequenceGaps,
    clouds: CloudReports,
    /// Status and reason code of the last log line.
    logged: Option<(&'static str, Option<&'static str>)>,
    changes: LogRateLimiter,
    /// Status and steady time of the last diagnostics.
    last: Option<(&'static str, Duration)>,
    /// Whether the next diagnostics are published without waiting for the period.
    is_due: bool,
}

impl Report {
    fn note_sequence_number(&mut self, origin: &Origin) {
        if let Some(number) = origin.number {
            self.activity.note_lost(self.sequence_gaps.missing_before(origin.publisher, number));
        }
    }
}

/// Cause for which the thread woke up.
enum Wake {
    Event(MonitorEvent),
    JointState(JointState, Origin),
    Heartbeat,
}

impl MonitorLoop {
    /// Runs until it receives `MonitorEvent::Stop`.
    pub fn run(mut self) {
        loop {
            match self.wake() {
                Wake::Event(MonitorEvent::Stop) => return,
                Wake::Event(event) => self.on_event(event),
                Wake::JointState(message, origin) => self.on_joint_state(message, origin),
                Wake::Heartbeat => self.on_heartbeat(),
            }
        }
    }

    fn wake(&self) -> Wake {
        let due = self.monitor.time_to_heartbeat(self.clock.read());
        let event = async { Wake::Event(self.events.receive().await.unwrap_or(MonitorEvent::Stop)) };
        let joint_state = async {
            loop {
                let (message, origin) = self.joint_states.next().await;
                if Some(origin.publisher) != self.own_motion.source {
                    return Wake::JointState(message, origin);
                }
            }
        };
        let own_joint_state = async {
            match (self.own_motion.joint_states.receive().await, self.own_motion.source) {
                (Some(message), Some(source)) => Wake::JointState(message, Origin::here(source)),
                _ => future::pending().await,
            }
        };
        let input = future::or(event, future::or(own_joint_state, joint_state));
        wait_at_most(due, input).unwrap_or(Wake::Heartbeat)
    }

    fn on_event(&mut self, event: MonitorEvent) {
        self.record(&event);
        match event {
            MonitorEvent::Stop => {}
            MonitorEvent::Checker(revision) => self.monitor.set_checker(revision),
            MonitorEvent::ModelSwap => self.monitor.note_model_swap(),
            MonitorEvent::DescriptionReceived => self.monitor.note_description(),
            MonitorEvent::DescriptionsProcessed(descriptions) => {
                self.monitor.note_processed_descriptions(descriptions);
            }
            MonitorEvent::WorldUpdate(update) => update.apply_to(&mut self.monitor),
            MonitorEvent::Enabled(enabled, applied) => {
                self.monitor.set_enabled(enabled);
                self.on_heartbeat();
                // the requester may be gone already
                let _ = applied.send(());
            }
            MonitorEvent::PublishNow(published) => {
                self.on_heartbeat();
                let _ = published.send(());
            }
            MonitorEvent::Memory { used, limit, published } => {
                self.monitor.note_memory(used, limit);
                self.on_heartbeat();
                let _ = published.send(());
            }
            MonitorEvent::ModelFault(fault) => {
                self.report.is_due = true;
                self.monitor.note_model_fault(fault);
            }
            MonitorEvent::World { clouds, faults, incomplete } => {
                self.report.clouds = clouds;
                self.monitor.note_world_faults(faults, incomplete);
            }
            MonitorEvent::Parameters(parameters) => {
                self.monitor.set_settings(parameters.monitor_settings());
                self.parameters = *parameters;
            }
        }
    }

    fn on_heartbeat(&mut self) {
        self.read_transforms();
        let now = self.clock.read();
        let evaluation = self.monitor.on_heartbeat(now);
        let (evaluation, _) = self.publish(evaluation, now, None);
        self.publish_diagnostics(&evaluation);
    }

    fn read_transforms(&mut self) {
        if !self.monitor.uses_transforms() {
            return;
        }
        let tree = self.transforms.lock().unwrap_or_else(PoisonError::into_inner);
        // the recording stores this at its position among the transforms
        self.recording.note(|| RecordedEvent::TransformsRead);
        self.monitor.note_transforms(&tree);
    }

    /// Records an event and its time.
    fn record(&self, event: &MonitorEvent) {
        let recorded = match event {
            // the published evaluation is recorded like any other
            MonitorEvent::Stop | MonitorEvent::PublishNow(_) => return,
            MonitorEvent::Checker(_) => RecordedMonitorEvent::Checker,
            MonitorEvent::ModelSwap => RecordedMonitorEvent::ModelSwap,
            MonitorEvent::DescriptionReceived => RecordedMonitorEvent::Described,
            MonitorEvent::DescriptionsProcessed(_) => RecordedMonitorEvent::Heeded,
            MonitorEvent::ModelFault(fault) => RecordedMonitorEvent::ModelFault(fault.clone()),
            MonitorEvent::World { .. } => RecordedMonitorEvent::World,
            MonitorEvent::WorldUpdate(update) => RecordedMonitorEvent::WorldUpdate(*update),
            MonitorEvent::Memory { used, limit, .. } => {
                RecordedMonitorEvent::Memory { used: *used, limit: *limit }
            }
            MonitorEvent::Enabled(enabled, _) => {
                return self.recording.note(|| RecordedEvent::Enabled(*enabled));
            }
            MonitorEvent::Parameters(parameters) => {
                return self.recording.note(|| RecordedEvent::Parameters(parameters.clone()));
            }
        };
        self.recording.note(|| RecordedEvent::MonitorEvent(recorded));
    }

    fn on_joint_state(&mut self, mut message: JointState, mut origin: Origin) {
        self.report.note_sequence_number(&origin);
        if origin.waited() > LONGEST_WAIT {
            while let Some(newer) = self.joint_states.try_next() {
                if Some(newer.1.publisher) == self.own_motion.source {
                    continue;
                }
                self.report.note_sequence_number(&newer.1);
                self.report.activity.note_skipped();
                // the newer message may contain other joints
                self.receive(message, origin.publisher);
                (message, origin) = newer;
            }
        }
        self.read_transforms();
        let received = self.recording.is_on().then(|| (message.clone(), origin.publisher));
        let input = joint_state_input(message, origin.publisher);
        let now = self.clock.read();
        let evaluation = self.monitor.on_joint_state(input, now);
        let (evaluation, published_at) = self.publish(evaluation, now, received);
        let latency = published_at.saturating_duration_since(origin.received);
        self.report.activity.note_evaluated(&evaluation, latency);
        self.publish_diagnostics(&evaluation);
        self.monitor.prepare();
    }

    /// Stores a joint state that is not evaluated by itself.
    fn receive(&mut self, message: JointState, source: SourceId) {
        let now = self.clock.read();
        self.recording.note(|| RecordedEvent::JointStateReceived {
            now,
            message: Box::new(message.clone()),
            source,
        });
        let input = joint_state_input(message, source);
        self.joint_state_history.lock().unwrap_or_else(PoisonError::into_inner).note_received(
            &input,
            &self.monitor,
            now.ros,
        );
        self.monitor.receive(input, now);
    }

    /// Publishes the evaluation made at `now`, from a joint state if one was received, as it is valid after the check.
    /// Returns it, and the time at which `~/state` was published. A recording stores the evaluation itself, because the
    /// duration of a check depends on the machine.
    fn publish(
        &mut self,
        evaluation: Evaluation,
        now: Now,
        received: Option<(JointState, SourceId)>,
    ) -> (Evaluation, Instant) {
        let mut current = self.current.lock().unwrap_or_else(PoisonError::into_inner);
        *current = Some(evaluation.clone());
        self.joint_state_history.lock().unwrap_or_else(PoisonError::into_inner).note(&evaluation, now.ros);
        // the recording stores the evaluation before everything that results from it
        self.recording.note(|| {
            RecordedEvent::Evaluated(Box::new(RecordedEvaluation {
                now,
                joint_state: received,
                result: (&evaluation).into(),
            }))
        });
        drop(current);
        let now = self.clock.read();
        let evaluation = evaluation.aged(now).with_warning(self.recording.fault());
        self.log_change(&evaluation);
        if let Some(remark) = self.monitor.take_contact_remark() {
            log::warn!("{remark}");
        }
        let published = self.publishers.publish(&evaluation, &self.parameters, now.steady);
        self.report.activity.note_dropped(published.dropped);
        if let Some(observe) = &mut self.observer {
            observe(&evaluation, &self.parameters.monitor_settings());
        }
        (evaluation, published.state_at)
    }

    /// Logs one line when the status or the reason for UNKNOWN changes. Frequent changes are rate-limited; then the
    /// final status is logged.
    fn log_change(&mut self, evaluation: &Evaluation) {
        let reason = evaluation.status.reason();
        let now = (evaluation.status.word(), reason.map(Reason::code));
        if self.report.logged == Some(now) || !self.report.changes.admit(self.clock.steady()) {
            return;
        }
        self.report.logged = Some(now);
        match (evaluation.status.word(), reason) {
            (status, Some(reason)) => log::warn!("{status}: {reason}"),
            (status, None) => match evaluation.foremost() {
                Some(foremost) => log::info!("{status}: {foremost}"),
                None => log::info!("{status}"),
            },
        }
    }

    /// Publishes diagnostics once per second, and at every change of status.
    fn publish_diagnostics(&mut self, evaluation: &Evaluation) {
        let steady = self.clock.steady();
        let status = evaluation.status.word();
        let since = |at: Duration| steady.saturating_sub(at);
        let report = &mut self.report;
        let is_published = |(last, at)| last == status && since(at) < DIAGNOSTICS_PERIOD;
        if !std::mem::take(&mut report.is_due) && report.last.is_some_and(is_published) {
            return;
        }
        let interval = report.last.map_or(steady, |(_, at)| since(at));
        report.last = Some((status, steady));
        let now = self.clock.now().unwrap_or_default();
        let fault = self.monitor.model_fault();
        let message =
            diagnostics(&self.node, now, evaluation, &report.activity, interval, fault, &report.clouds);
        report.activity.start_period();
        let sent = self.publishers.publish_diagnostics(message);
        report.activity.note_dropped(u64::from(!sent));
    }
}
