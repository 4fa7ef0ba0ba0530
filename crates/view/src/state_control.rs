//! State of a view without a node: a program or a browser's sliders set it, and it is evaluated at once.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use clearance_checker::{CollisionChecker, CollisionReport, Question, Workspace};
use clearance_monitor::{
    CheckedState, ContactHistory, ContactsOfPair, Evaluation, Expiry, LeftOut, MonitorSettings,
    MotionSincePrevious, Revision, Status, TrackedObstacles,
};
use clearance_robot::{Configuration, ConfigurationError, JointKind, LinkPoses, RobotModel};
use serde::{Deserialize, Serialize};

use crate::latest_evaluation::EvaluationSlot;

/// Largest number of contacts of a pair.
const CONTACTS_PER_PAIR: usize = 3;

/// Largest number of colliding pairs whose contacts are computed.
const PAIRS_WITH_CONTACTS: usize = 50;

/// Number of evaluations per second that the view expects: a state stays valid until it is replaced.
const HEARTBEAT_RATE: f64 = 1e-9;

/// A slider of the page.
#[derive(Clone, Debug, Serialize)]
pub struct Slider {
    name: String,
    /// `rad` or `m`.
    unit: &'static str,
    lower: f64,
    upper: f64,
    /// Index of the position in a configuration.
    #[serde(skip)]
    position: usize,
}

/// Request of a browser: one slider moves.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SliderMove {
    /// Name of the slider. A page that was left open by another view has other names, or moves the same joint.
    joint: String,
    /// New position (rad, m).
    position: f64,
}

/// The state, and its evaluation.
#[derive(Debug)]
pub struct StateControl {
    revision: Arc<Revision>,
    sliders: Vec<Slider>,
    settings: MonitorSettings,
    slot: Arc<EvaluationSlot>,
    held: Mutex<Held>,
}

#[derive(Debug)]
struct Held {
    state: Configuration,
    workspace: Workspace,
}

impl StateControl {
    /// Evaluates a first state. `positions` are the indices of the positions that have a slider.
    pub fn new(
        checker: CollisionChecker,
        positions: &[usize],
        state: &[f64],
        slot: Arc<EvaluationSlot>,
    ) -> Result<Self, ConfigurationError> {
        let state = checker.robot().configuration(state)?;
        let sliders = sliders(checker.robot(), positions);
        let held = Mutex::new(Held { state: state.clone(), workspace: checker.workspace() });
        let settings = MonitorSettings { heartbeat_rate: HEARTBEAT_RATE, ..MonitorSettings::default() };
        let control = Self {
            revision: Arc::new(Revision::new(checker, new_number(), 1)),
            sliders,
            settings,
            slot,
            held,
        };
        control.evaluate(&mut control.held(), state);
        Ok(control)
    }

    pub fn sliders(&self) -> &[Slider] {
        &self.sliders
    }

    /// The current state of the robot.
    pub fn state(&self) -> Configuration {
        self.held().state.clone()
    }

    /// Sets all positions (rad, m) of the robot. Limits do not matter.
    pub fn set_state(&self, positions: &[f64]) -> Result<(), ConfigurationError> {
        let state = self.revision.checker.robot().configuration(positions)?;
        self.evaluate(&mut self.held(), state);
        Ok(())
    }

    /// Moves one slider, within its range. The request is not trusted.
    pub fn move_slider(&self, SliderMove { joint, position }: &SliderMove) -> Result<(), &'static str> {
        let named = self.sliders.iter().find(|slider| slider.name == *joint);
        let slider = named.ok_or("there is no such slider: reload the page")?;
        if !(slider.lower..=slider.upper).contains(position) {
            return Err("the position is beyond the range of the slider");
        }
        let mut held = self.held();
        let mut positions = held.state.positions().to_vec();
        positions[slider.position] = *position;
        let state = self.revision.checker.robot().configuration(&positions);
        self.evaluate(&mut held, state.map_err(|_| "the robot has no such state")?);
        Ok(())
    }

    /// Positions of the sliders in a configuration.
    pub fn slider_positions(&self, state: &Configuration) -> Vec<f64> {
        self.sliders.iter().map(|slider| state.positions()[slider.position]).collect()
    }

    fn held(&self) -> MutexGuard<'_, Held> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Evaluates a state and passes the result to the browsers.
    fn evaluate(&self, held: &mut Held, state: Configuration) {
        let robot = self.revision.checker.robot();
        let warnings = robot.outside_limits(state.positions()).map(|outside| outside.to_string()).collect();
        let checked = Arc::new(self.check(state.clone(), &mut held.workspace));
        held.state = state;
        let status = if checked.report.is_free() { Status::Free } else { Status::Colliding };
        let evaluation = Evaluation {
            speed_scale: if status.is_free() { 1.0 } else { 0.0 },
            separation: None,
            status,
            stamp: None,
            age: None,
            checked_state: Some(Arc::clone(&checked)),
            robot_state: Some(checked),
            left_out: LeftOut::Nothing,
            is_swapping: false,
            stale_world: None,
            motion_since_previous: MotionSincePrevious::default(),
            history: ContactHistory::default(),
            revision: Some(Arc::clone(&self.revision)),
            warnings,
            expiry: Expiry::default(),
        };
        self.slot.put(&evaluation, &self.settings);
    }

    fn check(&self, state: Configuration, workspace: &mut Workspace) -> CheckedState {
        let begin = Instant::now();
        let checker = &self.revision.checker;
        let mut poses = LinkPoses::new(checker.robot());
        checker.robot().forward_kinematics(&state, &mut poses);
        let MonitorSettings { influence_distance, distance_limit: limit, .. } = self.settings;
        let report = checker.check(&state, Question::Survey { influence_distance, limit }, workspace);
        CheckedState {
            contacts: contacts(checker, &state, &report, workspace),
            report,
            approaching_pairs: Vec::new(),
            measured: vec![None; state.positions().len()],
            placed_at: Vec::new(),
            configuration: state,
            poses,
            look_ahead: None,
            obstacles_may_move: false,
            velocities: None,
            rates: None,
            spread: 0.0,
            obstacle_motions: Vec::new(),
            tracked_obstacles: TrackedObstacles::default(),
            slowdown_range: 0.0,
            is_exact: true,
            is_hurried: false,
            compute_time: begin.elapsed(),
        }
    }
}

fn contacts(
    checker: &CollisionChecker,
    state: &Configuration,
    report: &CollisionReport,
    workspace: &mut Workspace,
) -> Vec<ContactsOfPair> {
    let pairs = report.colliding_pairs.iter().take(PAIRS_WITH_CONTACTS);
    let found = pairs.filter_map(|&bodies| {
        let contacts = checker.contacts(state, bodies, CONTACTS_PER_PAIR, workspace)?;
        Some(ContactsOfPair { bodies, contacts })
    });
    found.collect()
}

/// Number of a model that no other view has, so that a page that was left open loads the new robot: the time in microseconds.
fn new_number() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(since.as_micros()).unwrap_or(1).max(1)
}

/// Sliders of these positions. Floating joints have none: the numbers of their quaternions do not move alone.
fn sliders(robot: &RobotModel, positions: &[usize]) -> Vec<Slider> {
    let ranges = robot.sampling_ranges();
    let kinds = kinds(robot);
    let of_position = |&position: &usize| {
        let (kind, place) = kinds.get(position).copied().flatten()?;
        let turns = match kind {
            JointKind::Fixed | JointKind::Floating => return None,
            JointKind::Planar(_) => place == 2,
            JointKind::Revolute(_) | JointKind::Continuous(_) | JointKind::Prismatic(_) => kind.turns(),
        };
        let name = robot.position_names()[position].clone();
        let [lower, upper] = match kind {
            JointKind::Planar(_) if turns => [-std::f64::consts::PI, std::f64::consts::PI],
            JointKind::Planar(_) => [-1.0, 1.0],
            _ => ranges[position],
        };
        Some(Slider { name, unit: if turns { "rad" } else { "m" }, lower, upper, position })
    };
    positions.iter().filter_map(of_position).collect()
}

/// By position: the kind of its joint, and its place among the positions of the joint.
fn kinds(robot: &RobotModel) -> Vec<Option<(&JointKind, usize)>> {
    let mut kinds = vec![None; robot.position_names().len()];
    for joint in robot.joint_ids() {
        let Some(first) = robot.first_position(joint) else { continue };
        let kind = &robot.joint(joint).kind;
        for place in 0..kind.position_suffixes().len() {
            kinds[first + place] = Some((kind, place));
        }
    }
    kinds
}
