//! Evaluates one joint state with the current robot and world.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use clearance_checker::{CollisionChecker, CollisionReport, PairDistance, PairKind, Question, Workspace};
use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::Extremes;
use clearance_proximity::Effort;
use clearance_robot::{Configuration, LinkPoses};

use super::between_states::{BetweenStates, CurrentState, StateTime};
use super::check_budget::CheckBudget;
use super::distance_bounds::DistanceBounds;
use super::joint_state_merger::{JointStateMerger, MergedState};
use super::look_ahead::{LookAheadEvaluator, LookAheadInput, limits_without_effect, obstacles_may_move};
use super::obstacle_motion::ObstacleMotion;
use super::obstacle_shift::KnownMotion;
use super::past_states::PastStates;
use super::pose_history::LargestDisplacement;
use super::slowdown_range::{MovingState, slowdown_range};
use super::speed::speeds_without_effect;
use super::state_contacts::ContactQuery;
use super::{CheckedState, LeftOut, MonitorSettings, PlacedAt, Reason, Revision, Status, TrackedObstacles};

/// Time since any fixed moment. It is read before and after each check.
pub type Stopwatch = fn() -> Duration;

/// The robot and world to check, with the data that the checks need.
#[derive(Debug)]
pub(super) struct StateEvaluator {
    pub revision: Arc<Revision>,
    /// Whether any link of the robot has collision geometry.
    pub has_geometry: bool,
    pub joint_state_merger: JointStateMerger,
    pub workspace: Workspace,
    pub look_ahead: LookAheadEvaluator,
}

/// Input of one evaluation.
pub(super) struct EvaluationInput<'i> {
    pub merged: MergedState,
    pub placed_at: Vec<PlacedAt>,
    pub obstacle_motions: Vec<ObstacleMotion>,
    /// Displacements of tracked obstacles since the last motion began, by name.
    pub obstacle_displacements: BTreeMap<String, LargestDisplacement>,
    /// Time for which the obstacles have not been moved to follow `tf`.
    pub obstacle_lag: Duration,
    /// A frame of obstacles in which nothing shows whether the root moves.
    pub unwatched_frame: Option<&'i str>,
    pub settings: &'i MonitorSettings,
    pub check_budget: &'i CheckBudget,
    pub time: StateTime,
    pub between_states: &'i mut BetweenStates,
    pub past_states: &'i mut PastStates,
    /// The part to leave out, regardless of the time; `None`: the deadline decides.
    pub fixed: Option<LeftOut>,
    pub stopwatch: Stopwatch,
}

/// An evaluation without its age.
#[derive(Debug)]
pub(super) struct CheckResult {
    pub status: Status,
    pub checked_state: Option<Arc<CheckedState>>,
    pub left_out: LeftOut,
    pub warnings: Vec<String>,
    /// Whether the next motion starts at this state: it is not one that was evaluated again.
    pub starts_motion: bool,
}

impl CheckResult {
    pub fn unknown(reason: Reason) -> Self {
        let (status, left_out) = (Status::Unknown(reason), LeftOut::Nothing);
        Self { status, checked_state: None, left_out, warnings: Vec::new(), starts_motion: false }
    }
}

impl StateEvaluator {
    /// Checks a complete joint state.
    pub fn evaluate(&mut self, input: EvaluationInput) -> CheckResult {
        let EvaluationInput { merged, placed_at, obstacle_motions, settings, check_budget, time, .. } = input;
        let EvaluationInput { between_states, fixed, stopwatch, obstacle_lag, unwatched_frame, .. } = input;
        let EvaluationInput { obstacle_displacements, past_states, .. } = input;
        let MergedState { configuration, velocities, rates, are_of_joints, measured, spread, mut warnings } =
            merged;
        if settings.look_ahead_horizon > 0.0 {
            past_states.note(time.stamp, configuration.positions(), self.joint_state_merger.turns());
        }
        let checker = &self.revision.checker;
        let started = stopwatch();
        let mut poses = LinkPoses::new(checker.robot());
        checker.robot().forward_kinematics(&configuration, &mut poses);
        let of_all = spread.greater(time.spread_of_transforms);
        let tracked_obstacles = TrackedObstacles::of_state(&self.revision, time.stamp, of_all, settings);
        let moving = MovingState {
            configuration: &configuration,
            poses: &poses,
            rates: rates.as_deref(),
            obstacle_motions: &obstacle_motions,
            tracked_obstacles: &tracked_obstacles,
            spread: of_all,
        };
        let slowdown_range = slowdown_range(checker, &moving, settings);
        let effort = effort(settings, check_budget, slowdown_range, fixed);
        let limits = [settings.influence_distance.greater(slowdown_range), settings.distance_limit];
        let Surveyed { mut report, bounds, is_exact } =
            survey(checker, &configuration, limits, &effort, fixed, &mut self.workspace);
        let approaching_pairs = take_approaching_pairs(&mut report, settings);
        let mut left_out = fixed.unwrap_or_default().max(left_out_of(&report));
        let left_out_between = between_states.check(&CurrentState {
            checker,
            configuration: &configuration,
            poses: &poses,
            time: &time,
            measured: &measured,
            report: &report,
            bounds,
            known_motion: KnownMotion::new(&obstacle_motions, &tracked_obstacles, time.stamp, obstacle_lag),
            obstacle_displacements: &obstacle_displacements,
            spread: of_all,
            settings,
            effort: &effort,
            fixed,
        });
        left_out = left_out.max(left_out_between);
        let ahead = LookAheadInput {
            configuration: &configuration,
            velocities: velocities.as_deref(),
            spread,
            report: &report,
            poses: &poses,
            obstacle_motions: &obstacle_motions,
            tracked_obstacles: &tracked_obstacles,
            past_states,
            stamp: time.stamp,
            obstacle_lag: obstacle_lag.as_secs_f64(),
            unwatched_frame,
            is_late: left_out > LeftOut::Contacts || effort.is_over(),
        };
        left_out = left_out.max(ahead.left_out(settings));
        let (look_ahead, of_look_ahead) = self.look_ahead.look_in_time(checker, &ahead, settings);
        warnings.extend(limits_without_effect(checker, settings));
        warnings.extend(of_look_ahead);
        warnings.extend(speeds_without_effect(checker, settings));
        let contacts = ContactQuery {
            checker,
            configuration: &configuration,
            report: &report,
            per_pair: settings.contacts_per_pair,
            effort: &effort,
            left_out,
        };
        let contacts = contacts.search(&mut self.workspace);
        left_out = left_out.max(contacts.left_out());
        warnings.extend(contacts.warning);
        let compute_time = stopwatch().saturating_sub(started);
        let status = status_of(&report, checker, settings, fixed);
        let checked_state = Arc::new(CheckedState {
            report,
            approaching_pairs,
            contacts: contacts.found,
            configuration,
            poses,
            look_ahead,
            obstacles_may_move: look_ahead.is_some()
                && (tracked_obstacles.any_moves() || obstacles_may_move(checker, settings)),
            velocities,
            rates: rates.filter(|_| are_of_joints),
            measured,
            placed_at,
            spread: of_all,
            obstacle_motions,
            tracked_obstacles,
            slowdown_range,
            is_exact,
            is_hurried: !is_exact && effort.exact_cost > 0,
            compute_time,
        });
        let starts_motion = between_states.keep(&checked_state, time, bounds, settings, fixed);
        CheckResult { status, checked_state: Some(checked_state), left_out, warnings, starts_motion }
    }
}

/// Distances of a state.
struct Surveyed {
    report: CollisionReport,
    bounds: DistanceBounds,
    /// Whether all distances are exact; otherwise they are lower bounds.
    is_exact: bool,
}

/// Checks a state up to an influence distance and a limit of the least distances (m).
fn survey(
    checker: &CollisionChecker,
    configuration: &Configuration,
    limits: [f64; 2],
    effort: &Effort,
    fixed: Option<LeftOut>,
    workspace: &mut Workspace,
) -> Surveyed {
    let [influence_distance, limit] = limits;
    let question = Question::Survey { influence_distance, limit };
    let mut report = checker.check_with(configuration, question, effort, workspace);
    if fixed == Some(LeftOut::FartherDistance) {
        leave_farther_distance_open(&mut report, checker);
    }
    let is_exact = report.is_exact();
    report.use_lower_bounds();
    Surveyed { bounds: DistanceBounds::of(&report, checker, limits), report, is_exact }
}

/// Removes the pairs beyond the reporting distance, which only the speed scale needs.
fn take_approaching_pairs(report: &mut CollisionReport, settings: &MonitorSettings) -> Vec<PairDistance> {
    let reported = settings.influence_distance.greater(settings.speed.reach());
    let pairs = std::mem::take(&mut report.pair_distances).into_iter();
    let (near, approaching) = pairs.partition(|pair| pair.distance <= reported);
    report.pair_distances = near;
    approaching
}

/// The part of the distances that the deadline left out.
fn left_out_of(report: &CollisionReport) -> LeftOut {
    if !report.undecided.is_empty() {
        LeftOut::Pairs
    } else if report.unfinished.is_some() {
        LeftOut::FartherDistance
    } else {
        LeftOut::Nothing
    }
}

/// The search options of a check; without a deadline if it is fixed what is left out.
fn effort(
    settings: &MonitorSettings,
    check_budget: &CheckBudget,
    slowdown_range: f64,
    fixed: Option<LeftOut>,
) -> Effort {
    let effort = if fixed.is_some() { settings.unhurried_effort() } else { settings.effort() };
    // the approach rate follows from the nearest points, so these have to be exact; longer distances do not affect the speed
    let exact_within = if slowdown_range > 0.0 { slowdown_range + CONTACT_DISTANCE } else { 0.0 };
    Effort { exact_within, ..check_budget.limit(effort, settings.exact_distance_share) }
}

/// Makes the report what it was in the run whose deadline left the farther least distance open: of the kind of pairs
/// that has none within the influence distance.
fn leave_farther_distance_open(report: &mut CollisionReport, checker: &CollisionChecker) {
    let is_near = |kind| report.pair_distances.iter().any(|pair| pair.kind() == kind);
    report.unfinished = PairKind::ALL.into_iter().find(|kind| checker.checks(*kind) && !is_near(*kind));
    match report.unfinished {
        Some(PairKind::SelfPair) => report.nearest_self = None,
        Some(PairKind::WorldPair) => report.nearest_world = None,
        None => {}
    }
}

/// A colliding pair decides the status even if other pairs are undecided. With any undecided pair, the least distance
/// is unknown.
fn status_of(
    report: &CollisionReport,
    checker: &CollisionChecker,
    settings: &MonitorSettings,
    fixed: Option<LeftOut>,
) -> Status {
    if fixed == Some(LeftOut::Pairs) {
        let (deadline, pair) = (settings.check_deadline, Default::default());
        return Status::Unknown(Reason::Deadline { deadline, open: 0, pair });
    }
    if report.self_collision || report.world_collision {
        return Status::Colliding;
    }
    let open: BTreeSet<_> = report.undecided.iter().map(|pair| (pair.a, pair.b)).collect();
    match open.first() {
        None => Status::Free,
        Some(&(a, b)) => Status::Unknown(Reason::Deadline {
            deadline: settings.check_deadline,
            open: open.len(),
            pair: [a, b].map(|body| checker.body_name(body).to_owned()),
        }),
    }
}
