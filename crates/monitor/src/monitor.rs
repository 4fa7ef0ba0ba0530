//! The monitor: receives joint states, heartbeats, transforms and settings, and returns evaluations.

mod notifications;
mod staleness;

use std::sync::Arc;
use std::time::Duration;

use clearance_robot::{RobotModel, quoted_list};
use clearance_scene::TransformTree;

use super::between_states::{BetweenStates, StateTime};
use super::check_budget::CheckBudget;
use super::contact_counter::{ContactCounter, ContactHistory};
use super::contact_watch::ContactWatch;
use super::contribution::Contributions;
use super::joint_state_merger::JointStateMerger;
use super::look_ahead::LookAheadEvaluator;
use super::obstacle_pose_histories::ObstaclePoseHistories;
use super::past_states::PastStates;
use super::received_states::{ReceivedState, ReceivedStates};
use super::root_location::RootLocationWatch;
use super::speed::SpeedGovernor;
use super::state_evaluator::{CheckResult, EvaluationInput, StateEvaluator, Stopwatch};
use super::transform_joints::TransformJoints;
use super::unevaluated_states::{PartialState, are_equal, named_positions};
use super::world_updates::WorldUpdates;
use super::{
    Evaluation, JointStateInput, LeftOut, MonitorSettings, MotionSincePrevious, Now, Reason, Revision,
    Status, Time,
};

/// Largest number of names that are stored of a joint state without positions.
const MOST_UNPOSITIONED: usize = 64;

/// Evaluates the state of one robot.
#[derive(Debug)]
pub struct Monitor {
    settings: MonitorSettings,
    stopwatch: Stopwatch,
    enabled: bool,
    /// Reason for the status UNKNOWN once the process uses too much memory.
    out_of_memory: Option<Reason>,
    /// The part that checks leave out, regardless of their time; `None`: the deadline decides.
    left_out: Option<LeftOut>,
    evaluator: Option<StateEvaluator>,
    /// Whether another model is being built, so that the current one is no longer valid.
    swapping: bool,
    /// Number of received robot descriptions, and how many of them were loaded or rejected.
    received_descriptions: u64,
    processed_descriptions: u64,
    /// Error of the last rejected model, until a model is loaded.
    model_fault: Option<String>,
    /// Errors of the last changes of the world.
    world_faults: Vec<String>,
    /// Why the world is incomplete, if it is.
    incomplete_world: Option<Reason>,
    world_updates: WorldUpdates,
    received_states: ReceivedStates,
    /// The last joint state without positions: time of reception and names.
    unpositioned: Option<(Duration, Vec<String>)>,
    check_budget: CheckBudget,
    between_states: BetweenStates,
    contact_watch: ContactWatch,
    contact_counter: ContactCounter,
    /// Messages that make up the robot's state, regardless of the result.
    contributions: Contributions,
    /// Time (s) by which the clock was set back since the last joint state, if it was.
    set_back: Option<f64>,
    /// Positions of joints from `tf`.
    transform_joints: TransformJoints,
    /// Number of the last transform that was read.
    last_transform: u64,
    root_location: RootLocationWatch,
    obstacle_poses: ObstaclePoseHistories,
    past_states: PastStates,
    check_result: CheckResult,
    speed_governor: SpeedGovernor,
    /// Whether the model or a setting changed since the last check.
    outdated: bool,
    published_at: Option<Duration>,
    latest_ros_time: Option<Time>,
}

impl Monitor {
    /// Creates a monitor without a robot.
    #[must_use]
    pub fn new(settings: MonitorSettings, stopwatch: Stopwatch) -> Self {
        Self {
            settings,
            stopwatch,
            enabled: true,
            out_of_memory: None,
            left_out: None,
            evaluator: None,
            swapping: false,
            received_descriptions: 0,
            processed_descriptions: 0,
            model_fault: None,
            world_faults: Vec::new(),
            incomplete_world: None,
            world_updates: WorldUpdates::default(),
            received_states: ReceivedStates::default(),
            unpositioned: None,
            check_budget: CheckBudget::default(),
            between_states: BetweenStates::default(),
            contact_watch: ContactWatch::default(),
            contact_counter: ContactCounter::default(),
            contributions: Contributions::default(),
            set_back: None,
            transform_joints: TransformJoints::default(),
            last_transform: 0,
            root_location: RootLocationWatch::default(),
            obstacle_poses: ObstaclePoseHistories::default(),
            past_states: PastStates::default(),
            check_result: CheckResult::unknown(Reason::NoModel { fault: None }),
            speed_governor: SpeedGovernor::default(),
            outdated: true,
            published_at: None,
            latest_ros_time: None,
        }
    }

    /// From now on, checks after a pause of the joint states have no limit until their rate is known again: so they were
    /// in earlier versions, whose recordings are replayed.
    pub fn forget_rate_in_pauses(&mut self) {
        self.check_budget.forgets_in_pauses = true;
    }

    /// Sets the robot and world to check. The last joint state is evaluated again at the next heartbeat.
    pub fn set_checker(&mut self, revision: Arc<Revision>) {
        // a change of the world does not resolve the rejection of a new robot description
        if self.evaluator.as_ref().is_none_or(|before| before.revision.model != revision.model) {
            self.model_fault = None;
            self.swapping = false;
        }
        let robot = |evaluator: &StateEvaluator| Arc::clone(evaluator.revision.checker.robot());
        if !self.evaluator.as_ref().is_some_and(|s| Arc::ptr_eq(&robot(s), revision.checker.robot())) {
            self.speed_governor.discard_poses();
            self.contact_watch = ContactWatch::default();
            self.between_states = BetweenStates::default();
            self.past_states = PastStates::default();
            self.transform_joints = TransformJoints::default();
            self.root_location = RootLocationWatch::default();
            self.obstacle_poses = ObstaclePoseHistories::default();
        }
        self.obstacle_poses.note(self.evaluator.as_ref().map(|before| &*before.revision), &revision);
        if revision.anchor_frames.is_empty() {
            self.root_location = RootLocationWatch::default();
        }
        self.root_location.note_placed(revision.placed_at);
        self.between_states.note_world_changed();
        self.world_updates.complete();
        // set before the first state that is checked in this world is published
        self.incomplete_world.clone_from(&revision.incomplete);
        self.evaluator = Some(StateEvaluator {
            joint_state_merger: JointStateMerger::new(revision.checker.robot()),
            workspace: revision.checker.streaming_workspace(),
            look_ahead: LookAheadEvaluator::new(&revision.checker),
            has_geometry: revision.has_geometry(),
            revision,
        });
        self.outdated = true;
    }

    fn is_swapping(&self) -> bool {
        self.swapping || self.received_descriptions > self.processed_descriptions
    }

    /// Switches checking off or on; while it is off, the status is UNKNOWN.
    pub fn set_enabled(&mut self, enabled: bool) {
        self.enabled = enabled;
        self.outdated = true;
    }

    /// Makes checks leave out this part from now on, as in a recorded run. A deadline would leave out different parts
    /// on each machine.
    pub fn leave_out(&mut self, left_out: LeftOut) {
        self.left_out = Some(left_out);
    }

    /// Changes the settings. The last joint state is evaluated again at the next heartbeat.
    pub fn set_settings(&mut self, settings: MonitorSettings) {
        self.settings = settings;
        self.outdated = true;
        if self.settings.transform_joints.is_empty() {
            self.transform_joints = TransformJoints::default();
        }
    }

    /// Whether evaluations depend on `tf`.
    #[must_use]
    pub fn uses_transforms(&self) -> bool {
        let stands = |evaluator: &StateEvaluator| !evaluator.revision.anchor_frames.is_empty();
        !self.settings.transform_joints.is_empty() || self.evaluator.as_ref().is_some_and(stands)
    }

    /// Updates the data from `tf`; later evaluations use it.
    pub fn note_transforms(&mut self, tree: &TransformTree) {
        let last = std::mem::replace(&mut self.last_transform, tree.stored()).min(tree.stored());
        let Some(evaluator) = &self.evaluator else { return };
        self.root_location.look(&evaluator.revision.anchor_frames, tree, last);
        let robot = evaluator.revision.checker.robot();
        let mut transform_joints = TransformJoints::look_up(robot, &self.settings, tree);
        transform_joints.inherit(&self.transform_joints);
        let is_changed = transform_joints != self.transform_joints;
        if is_changed || tree.stored() > last {
            let positions = transform_joints.positions_since(robot, tree, last);
            self.transform_joints = transform_joints;
            self.note_positions(positions, is_changed);
        }
    }

    /// Adds positions from `tf`, in the order of reception; `None` if they are not known. Those that nothing changes are the last
    /// ones again.
    fn note_positions(&mut self, positions: Option<Vec<PartialState>>, is_changed: bool) {
        let is_known = positions.as_ref().is_some_and(|positions| are_equal(positions));
        if is_changed || !is_known {
            self.note_passed_over();
            self.between_states.note_transforms(positions);
        }
        self.outdated |= is_changed;
    }

    /// The last joint state is not evaluated, if it was not before: something else comes.
    fn note_passed_over(&mut self) {
        if let Some(unread) = self.received_states.take_unread()
            && let Some(evaluator) = &self.evaluator
        {
            let index_of = |name: &str| evaluator.joint_state_merger.position_index(name);
            self.between_states.note_passed_over(named_positions(unread, index_of));
        }
    }

    /// The positions that a joint state gives, except those that come from `tf`, and their robot; `None` without a robot, or if the joint
    /// state is not valid.
    pub(crate) fn measured_positions(
        &self,
        input: &JointStateInput,
    ) -> Option<(&Arc<RobotModel>, PartialState)> {
        let StateEvaluator { revision, joint_state_merger, .. } = self.evaluator.as_ref()?;
        let robot = revision.checker.robot();
        let index_of = |name: &str| {
            joint_state_merger.position_index(name).filter(|&index| !self.comes_from_transforms(robot, index))
        };
        Some((robot, named_positions(input, index_of)?))
    }

    fn comes_from_transforms(&self, robot: &RobotModel, position: usize) -> bool {
        let has_position = |id| {
            let count = robot.joint(id).kind.position_suffixes().len();
            robot.first_position(id).is_some_and(|first| (first..first + count).contains(&position))
        };
        let mut joints = self.settings.transform_joints.iter().filter_map(|name| robot.joint_by_name(name));
        joints.any(has_position)
    }

    /// Stores a joint state that is not evaluated by itself. Returns whether it contains positions.
    ///
    /// A joint state without positions is skipped, with its velocities. The positions received before stay in force,
    /// and their age grows.
    pub fn receive(&mut self, mut input: JointStateInput, now: Now) -> bool {
        self.note_clock(now);
        if input.positions.is_empty() && !input.names.is_empty() {
            input.names.retain(|name| name.starts_with(&self.settings.joint_prefix));
            input.names.truncate(MOST_UNPOSITIONED);
            if !input.names.is_empty() {
                self.unpositioned = Some((now.steady, input.names));
            }
            return false;
        }
        self.check_budget.note(now.steady);
        self.note_passed_over();
        self.received_states.receive(input, now);
        self.set_back = None;
        true
    }

    /// Evaluates a joint state, merged with the joint states of other publishers for the joints that it does not name.
    pub fn on_joint_state(&mut self, input: JointStateInput, now: Now) -> Evaluation {
        if !self.receive(input, now) {
            return self.on_heartbeat(now);
        }
        self.evaluate(now);
        if let (Some(checked_state), Some(evaluator)) = (&self.check_result.checked_state, &self.evaluator) {
            self.contact_watch.note(
                checked_state,
                self.contributions.newest_stamp(),
                &evaluator.revision.checker,
            );
        }
        self.current_evaluation(now)
    }

    /// Warning about pairs of links that touch in every state; returned once.
    pub fn take_contact_remark(&mut self) -> Option<String> {
        self.contact_watch.take_remark()
    }

    /// Prepares data that the next joint state will probably need. Best called after the last evaluation was published.
    pub fn prepare(&mut self) {
        if let Some(evaluator) = &mut self.evaluator {
            evaluator.revision.checker.prepare(&mut evaluator.workspace);
        }
    }

    /// Returns the last evaluation again, or reports that it is stale. Evaluates again if the model, a setting or the
    /// clock changed, if the robot's root moves, or if there was no time for exact distances.
    pub fn on_heartbeat(&mut self, now: Now) -> Evaluation {
        self.note_clock(now);
        let waits_for_clock = self.check_result.status.reason().is_some_and(Reason::is_about_time);
        self.root_location.note_seen(now);
        let checked_state = self.check_result.checked_state.as_ref();
        let has_moved = checked_state.is_some_and(|checked_state| {
            checked_state.obstacle_motions != self.root_location.obstacle_motions()
        });
        let has_rested = self.check_budget.is_paused(now.steady);
        let is_rough = checked_state.is_some_and(|checked_state| checked_state.is_hurried) && has_rested;
        if self.outdated || waits_for_clock || has_moved || is_rough {
            self.evaluate(now);
        }
        self.current_evaluation(now)
    }

    /// Detects that the clock was set back. Earlier stamps then no longer define an order. If it was set back by more
    /// than `stale_after`, all received joint states are discarded.
    fn note_clock(&mut self, now: Now) {
        if now.ros < self.latest_ros_time {
            self.received_states.discard_order();
            self.between_states.note_clock_set_back();
        }
        if let (Some(before), Some(ros)) = (self.latest_ros_time, now.ros) {
            let back = before.seconds_since(ros);
            if back > self.settings.stale_after && !self.received_states.messages().is_empty() {
                self.received_states.clear();
                self.set_back = Some(back);
                self.outdated = true;
            }
        }
        self.latest_ros_time = now.ros;
    }

    fn evaluate(&mut self, now: Now) {
        self.outdated = false;
        self.check_result = self.decide(now).unwrap_or_else(CheckResult::unknown);
        match &self.evaluator {
            Some(StateEvaluator { revision, .. }) => {
                let CheckResult { status, checked_state, .. } = &self.check_result;
                let stamp = self.contributions.newest_stamp().max(self.transform_joints.newest_stamp(now));
                self.speed_governor.update(
                    &revision.checker,
                    status,
                    checked_state.as_ref(),
                    stamp,
                    &self.settings,
                );
            }
            None => self.speed_governor.stop(),
        }
    }

    fn decide(&mut self, now: Now) -> Result<CheckResult, Reason> {
        self.contributions = Contributions::default();
        if let Some(reason) = &self.out_of_memory {
            return Err(reason.clone());
        }
        if !self.enabled {
            return Err(Reason::Disabled);
        }
        let (fault, is_swapping) = (self.model_fault.clone(), self.is_swapping());
        let evaluator = self.evaluator.as_mut().ok_or(Reason::NoModel { fault })?;
        if is_swapping {
            return Err(Reason::ModelSwap);
        }
        if !evaluator.has_geometry {
            return Err(Reason::NoGeometry);
        }
        let messages = self.received_states.messages();
        let robot = evaluator.revision.checker.robot();
        if messages.is_empty() && !self.transform_joints.place_all(robot) {
            return Err(self.set_back.map_or(Reason::NoJointState, |back| Reason::ClockJump { back }));
        }
        self.transform_joints.note_seen(now);
        self.root_location.note_seen(now);
        let from_transforms = self.transform_joints.read(robot, now, &self.settings);
        let is_fresh = |received: &ReceivedState| received.since_reception(now) <= self.settings.stale_after;
        let (merged, contributions) =
            evaluator.joint_state_merger.read(robot, messages, is_fresh, from_transforms, &self.settings);
        self.contributions = contributions;
        let mut merged = merged?;
        merged.warnings.extend_from_slice(&self.transform_joints.warnings);
        merged.warnings.extend(self.root_location.warning());
        // a stale state is not checked
        self.contributions.freshness(now, &self.settings, robot.position_names())?;
        let stamp = self.contributions.stamp().or(self.transform_joints.pose_stamp(now)).unwrap_or_default();
        let transforms = self.transform_joints.stamps();
        let check_result = evaluator.evaluate(EvaluationInput {
            placed_at: self.transform_joints.placed_at(robot, now),
            merged,
            obstacle_motions: self.root_location.obstacle_motions(),
            obstacle_displacements: self.obstacle_poses.displacements(),
            obstacle_lag: self.root_location.lag(now),
            unwatched_frame: self.root_location.unwatched_frame(),
            settings: &self.settings,
            check_budget: &self.check_budget,
            time: StateTime {
                stamp,
                at: now.steady,
                spread_of_transforms: transforms.spread(stamp, now.ros),
                transforms,
            },
            between_states: &mut self.between_states,
            past_states: &mut self.past_states,
            fixed: self.left_out,
            stopwatch: self.stopwatch,
        });
        self.received_states.note_evaluated();
        if check_result.starts_motion {
            self.root_location.start_motion();
            self.obstacle_poses.start();
        }
        Ok(check_result)
    }

    /// The evaluation as it is valid now: it may have become stale since the check.
    fn current_evaluation(&mut self, now: Now) -> Evaluation {
        self.published_at = Some(now.steady);
        self.root_location.note_seen(now);
        let evaluator = self.evaluator.as_ref();
        let messages = self.received_states.messages();
        let precedes_joint_states =
            self.check_result.status.reason().is_some_and(Reason::precedes_joint_states);
        let evaluator_in_use = evaluator.filter(|_| !precedes_joint_states);
        let stale = evaluator_in_use.and_then(|evaluator| self.freshness(evaluator, now).err());
        let root_location = || self.root_location.freshness(now, self.settings.transform_ttl).err();
        let incomplete = self.incomplete_world.clone().or_else(|| self.world_updates.overdue(now));
        let silent = |evaluator: &StateEvaluator| evaluator.revision.stale_world(now);
        let stale_world =
            evaluator.and_then(|evaluator| incomplete.or_else(|| silent(evaluator)).or_else(root_location));
        let robot_state = self.check_result.checked_state.clone().filter(|_| stale.is_none());
        let status = match (stale, &stale_world) {
            (Some(reason), _) => Status::Unknown(self.with_other_fault(reason)),
            (None, Some(reason)) if robot_state.is_some() => Status::Unknown(reason.clone()),
            (None, _) => self.check_result.status.clone(),
        };
        let motion_since_previous = self.between_states.take_latest();
        let (status, motion_since_previous) = with_motion(status, motion_since_previous);
        if status != Status::Free {
            self.speed_governor.stop();
        }
        let stamp = self
            .contributions
            .stamp()
            .or(self.transform_joints.stamp())
            .or(messages.last().map(|last| last.stamp));
        let since_reception = messages.last().map_or(0.0, |last| last.since_reception(now));
        let of_revision = evaluator.iter().flat_map(|evaluator| &evaluator.revision.warnings);
        let of_model = (self.model_fault.as_ref().filter(|_| evaluator.is_some())).map(|fault| {
            format!("the last robot description was rejected, and the one before counts: {fault}")
        });
        let of_world = of_revision.chain(&self.world_faults);
        let of_model = of_model.into_iter().chain(self.unpositioned_warning(now));
        let of_contacts = self.contact_watch.remark().filter(|_| self.check_result.checked_state.is_some());
        let warnings = self.check_result.warnings.iter().chain(of_world).cloned().chain(of_model);
        let of_motion =
            evaluator.and_then(|evaluator| motion_since_previous.warning(&evaluator.revision.checker));
        let warnings = warnings.chain(of_contacts.map(str::to_owned)).chain(of_motion);
        let mut evaluation = Evaluation {
            checked_state: robot_state.clone().filter(|_| status.reason().is_none()),
            status,
            robot_state,
            is_swapping: self.is_swapping(),
            stale_world,
            motion_since_previous,
            history: ContactHistory::default(),
            speed_scale: self.speed_governor.share(),
            separation: self.speed_governor.separation(),
            left_out: self.check_result.left_out,
            stamp,
            age: stamp.map(|stamp| now.ros.map_or(since_reception, |ros| ros.seconds_since(stamp))),
            revision: evaluator.map(|evaluator| Arc::clone(&evaluator.revision)),
            warnings: warnings.collect(),
            expiry: self.expiry(now),
        };
        evaluation.history = self.contact_counter.add(&evaluation, now.steady, &self.settings);
        evaluation
    }

    /// Warning about a joint state without positions that was received recently.
    fn unpositioned_warning(&self, now: Now) -> Option<String> {
        let (at, names) = self.unpositioned.as_ref()?;
        let since_reception = now.steady.saturating_sub(*at).as_secs_f64();
        (since_reception <= self.settings.stale_after).then(|| {
            let names = quoted_list(names);
            format!("a joint state that names {names} gives no positions: it is skipped, with its velocities")
        })
    }

    /// Adds the earlier fault to a stale joint state that could not be evaluated when it was fresh.
    fn with_other_fault(&self, reason: Reason) -> Reason {
        match (reason, self.check_result.status.reason()) {
            (Reason::Stale { joints, age, stale_after, .. }, Some(other))
                if !matches!(other, Reason::Stale { .. } | Reason::FutureStamp { .. }) =>
            {
                Reason::Stale { joints, age, stale_after, also: Some(Box::new(other.clone())) }
            }
            (reason, _) => reason,
        }
    }
}

/// The status with the motion since the previous state: a proven contact makes a free state COLLIDING.
fn with_motion(status: Status, motion: MotionSincePrevious) -> (Status, MotionSincePrevious) {
    match status {
        Status::Free if motion.passed_through().is_some() => (Status::Colliding, motion),
        Status::Unknown(_) => (status, motion.while_unknown()),
        Status::Free | Status::Colliding => (status, motion),
    }
}
