//! Continuous check of the motion between two successive evaluated states.
//!
//! The motion is the straight line in joint space. Continuous joints, and the rotation of planar joints, go the short
//! way; mimic joints follow their leaders; floating joints rotate by the shortest path. Around it lies a tube: each
//! position may deviate by the noise of its encoder, plus `a dt² / 8`, the largest deviation of a motion with
//! accelerations up to `a` from the straight line through its ends. Floating joints have no tube.
//!
//! Most motions need no search. If the travel of the bodies is less than the distances at both ends allow, no pair can
//! touch in between: a distance that is `d0` at the start and `d1` at the end is at least `(d0 + d1 - travel) / 2` on
//! the way. Only other motions are searched, with a limit on the number of evaluations.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use clearance_checker::{
    CollisionChecker, CollisionReport, MotionOptions, MotionVerdict, PairKind, UndecidedReason, Workspace,
};
use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, without_whole_turns};
use clearance_motion::{MotionSegment, floating};
use clearance_proximity::Effort;
use clearance_robot::{Configuration, LinkPoses, RobotModel};
use clearance_scene::BodyId;

use super::distance_bounds::DistanceBounds;
use super::motion_since_previous::{GapReason, MotionSincePrevious, NoMotion, Passage};
use super::obstacle_motion::ObstacleMotion;
use super::obstacle_shift::{KnownMotion, ObstacleShift, Surroundings};
use super::pose_history::LargestDisplacement;
use super::transform_stamps::TransformStamps;
use super::unevaluated_states::{PartialState, TolerantLine, UnevaluatedStates};
use super::{CheckedState, LeftOut, MonitorSettings, Time};

/// Motion (m) within an interval below which it may stay undecided.
const TOLERANCE: f64 = 1e-5;

/// Maximum number of evaluations of a pair in an interval, plus a number per pair.
const EVALUATIONS: u64 = 500;
const EVALUATIONS_PER_PAIR: u64 = 10;

/// Rounding (m) of the bounds on distances and travel.
const ROUNDING: f64 = 1e-9;

/// The previous evaluated state, and the result for the current one.
#[derive(Debug)]
pub(super) struct BetweenStates {
    previous: Option<PreviousState>,
    /// Why there is no previous state.
    missing: NoMotion,
    /// By position: whether values that differ by a full turn are equivalent.
    turns: Vec<bool>,
    /// Its own workspace, so that its motions do not overwrite the data that speeds up the stream of states.
    workspace: Option<Workspace>,
    /// Joint states since the previous one that were not evaluated.
    unevaluated_states: UnevaluatedStates,
    /// Result of the last check, until it is published.
    latest: Option<MotionSincePrevious>,
}

/// A state as the start of the next motion.
#[derive(Debug)]
struct PreviousState {
    state: Arc<CheckedState>,
    time: StateTime,
    bounds: DistanceBounds,
    /// Whether its report is about the current world.
    is_of_current_world: bool,
    /// Whether the deadline left none of its pairs open.
    is_decided: bool,
}

/// Times of a state.
#[derive(Clone, Debug)]
pub(super) struct StateTime {
    /// Stamp of the state.
    pub stamp: Time,
    /// Time of its evaluation (steady clock).
    pub at: Duration,
    /// Stamps of the transforms that positions are from.
    pub transforms: TransformStamps,
    /// Longest time (s) between the stamp and those of the transforms.
    pub spread_of_transforms: f64,
}

/// The state at the end of a motion.
pub(super) struct CurrentState<'c> {
    pub checker: &'c CollisionChecker,
    pub configuration: &'c Configuration,
    pub poses: &'c LinkPoses,
    pub time: &'c StateTime,
    /// By position: the stamp of its message; `None` for positions from `tf`.
    pub measured: &'c [Option<Time>],
    pub report: &'c CollisionReport,
    pub bounds: DistanceBounds,
    /// Motion of the obstacles and the root.
    pub known_motion: KnownMotion<'c>,
    /// Displacements of tracked obstacles since the previous state, by name.
    pub obstacle_displacements: &'c BTreeMap<String, LargestDisplacement>,
    /// Difference (s) between the times of measurement of the joints.
    pub spread: f64,
    pub settings: &'c MonitorSettings,
    pub effort: &'c Effort,
    /// The part to leave out, regardless of the time.
    pub fixed: Option<LeftOut>,
}

impl Default for BetweenStates {
    fn default() -> Self {
        let (previous, missing, turns) = (None, NoMotion::FirstState, Vec::new());
        Self {
            previous,
            missing,
            turns,
            workspace: None,
            unevaluated_states: UnevaluatedStates::default(),
            latest: None,
        }
    }
}

impl BetweenStates {
    /// The clock was set back: the next state is not compared with earlier ones.
    pub fn note_clock_set_back(&mut self) {
        if self.previous.take().is_some() {
            self.missing = NoMotion::ClockSetBack;
        }
    }

    /// A joint state with these positions is not evaluated; `None` if it is not valid.
    pub fn note_passed_over(&mut self, state: Option<PartialState>) {
        if self.previous.is_some() {
            self.unevaluated_states.add(state);
        }
    }

    /// Positions from `tf` were received, in this order; `None` if they are not known.
    pub fn note_transforms(&mut self, states: Option<Vec<PartialState>>) {
        if self.previous.is_some() {
            self.unevaluated_states.add_transforms(states);
        }
    }

    /// The world was replaced, with the same robot.
    pub fn note_world_changed(&mut self) {
        if let Some(previous) = &mut self.previous {
            previous.is_of_current_world = false;
        }
    }

    /// Result of the last check, once.
    pub fn take_latest(&mut self) -> MotionSincePrevious {
        self.latest.take().unwrap_or_default()
    }

    /// Checks the motion from the previous state. Returns the part that the deadline left open.
    pub fn check(&mut self, current: &CurrentState) -> LeftOut {
        let mut result = match self.motion_to(current) {
            Ok(motion) => self.decide(&motion, current),
            Err(no_motion) => MotionSincePrevious::NotChecked(no_motion),
        };
        let is_over = current.effort.is_over() || current.fixed == Some(LeftOut::PassageExtent);
        let left_out = match &mut result {
            // the contact may not be the first one
            MotionSincePrevious::PassedThrough(passage) if is_over => {
                passage.t = [0.0, 1.0];
                LeftOut::PassageExtent
            }
            MotionSincePrevious::NotProven {
                why: GapReason::Undecided(UndecidedReason::Deadline), ..
            } => LeftOut::MotionSincePrevious,
            _ => LeftOut::Nothing,
        };
        self.latest = Some(result);
        left_out
    }

    /// Makes this state the start of the next motion. Returns whether it is a new one, not the last one evaluated again.
    pub fn keep(
        &mut self,
        state: &Arc<CheckedState>,
        time: StateTime,
        bounds: DistanceBounds,
        settings: &MonitorSettings,
        fixed: Option<LeftOut>,
    ) -> bool {
        let is_decided = state.report.undecided.is_empty() && fixed != Some(LeftOut::Pairs);
        self.missing = NoMotion::FirstState;
        self.unevaluated_states.clear();
        // a state that is evaluated again keeps its times
        let same = self.previous.take().filter(|previous| {
            let is_same_time =
                previous.time.stamp == time.stamp && previous.time.transforms == time.transforms;
            is_same(&previous.state, state) && is_same_time
        });
        let is_new = same.is_none();
        self.previous = settings.check_between_states.then(|| {
            let time = same.map_or(time, |previous| previous.time);
            PreviousState { state: Arc::clone(state), time, bounds, is_of_current_world: true, is_decided }
        });
        is_new
    }

    /// The motion from the previous state, or why there is none.
    fn motion_to(&mut self, current: &CurrentState) -> Result<Motion, NoMotion> {
        if !current.settings.check_between_states {
            return Err(NoMotion::Off);
        }
        let previous = self.previous.as_ref().ok_or(self.missing)?;
        let (state, settings) = (&previous.state, current.settings);
        let is_same_time =
            state.measured == current.measured && previous.time.transforms == current.time.transforms;
        let is_same = is_same_time && state.configuration == *current.configuration;
        if is_same && self.unevaluated_states.is_empty() {
            return Err(NoMotion::NoNewState);
        }
        let duration = longest_interval(previous, current);
        let since = duration.greater(current.time.at.saturating_sub(previous.time.at).as_secs_f64());
        if since > settings.stale_after {
            return Err(NoMotion::Pause { since });
        }
        let robot = current.checker.robot();
        if self.turns.len() != robot.position_names().len() {
            self.turns = robot.whole_turns();
        }
        let to = current.configuration.positions();
        let from = state.configuration.positions().iter().zip(to).zip(&self.turns);
        let from =
            from.map(|((&from, &to), &turns)| if turns { to - without_whole_turns(to - from) } else { from });
        let tube = settings.joint_noise + settings.between_states_acceleration * duration * duration / 8.0;
        Ok(Motion { from: from.collect(), tube: tube_of(robot, tube), duration })
    }

    fn decide(&mut self, motion: &Motion, current: &CurrentState) -> MotionSincePrevious {
        let found = self.decide_on_line(motion, current);
        if found != MotionSincePrevious::ProvenFree || self.is_line_enough(motion, current) {
            return found;
        }
        let stamps = [
            self.previous.as_ref().map_or(current.time.stamp, |previous| previous.time.stamp),
            current.time.stamp,
        ];
        let gap = Some(Passage { pair: None, t: [0.0, 1.0], stamps });
        MotionSincePrevious::NotProven { why: GapReason::PassedOver, gap }
    }

    /// Whether a proof about the straight line covers the joint states that were not evaluated: they lie within its tube, or are so near
    /// that the distances at both ends prove the way through them.
    fn is_line_enough(&self, motion: &Motion, current: &CurrentState) -> bool {
        let to = current.configuration.positions();
        let line = TolerantLine { from: &motion.from, to, tube: &motion.tube, turns: &self.turns };
        if self.unevaluated_states.are_within(line) {
            return true;
        }
        let Some(previous) = &self.previous else { return true };
        let travel = self.unevaluated_states.travel(current.checker, line);
        let reach = MotionReach { travel, ..motion.reach(current) };
        let shift = obstacle_shift(previous, current, motion, &reach).largest(current.checker);
        PairKind::ALL.iter().all(|kind| is_proven_by_distances(*kind, previous, current, &reach, shift))
    }

    /// The same for the straight line.
    fn decide_on_line(&mut self, motion: &Motion, current: &CurrentState) -> MotionSincePrevious {
        let Some(previous) = &self.previous else { return MotionSincePrevious::default() };
        let stamps = [previous.time.stamp, current.time.stamp];
        let unproven = |why: GapReason, pair, t| MotionSincePrevious::NotProven {
            why,
            gap: Some(Passage { pair, t, stamps }),
        };
        let late = || unproven(GapReason::Undecided(UndecidedReason::Deadline), None, [0.0, 1.0]);
        if !current.is_decided() {
            return late();
        }
        let reach = motion.reach(current);
        let obstacles = obstacle_shift(previous, current, motion, &reach);
        let shift = obstacles.largest(current.checker);
        let [self_pairs, world_pairs] =
            PairKind::ALL.map(|kind| is_proven_by_distances(kind, previous, current, &reach, shift));
        if self_pairs && world_pairs {
            return MotionSincePrevious::ProvenFree;
        }
        let touching = previous.touching();
        if !touching.is_empty() && !current.report.colliding_pairs.is_empty() {
            return MotionSincePrevious::NotProven { why: GapReason::StateCollides, gap: None };
        }
        if current.fixed >= Some(LeftOut::MotionSincePrevious) || current.effort.is_over() {
            return late();
        }
        // the latest contact is searched where the motion begins with one
        let is_reversed = !touching.is_empty();
        let ends = if is_reversed { touching } else { &current.report.colliding_pairs };
        let Some(segment) = motion.segment(current, is_reversed) else {
            return unproven(GapReason::Undecided(UndecidedReason::Overflow), None, [0.0, 1.0]);
        };
        let workspace = self.workspace.get_or_insert_with(|| current.checker.workspace());
        let moving = Some(&obstacles).filter(|_| shift > 0.0 && !world_pairs);
        let (verdict, may_have_moved) = search_beside(moving, &segment, current, workspace);
        let forward = |[first, second]: [f64; 2]| {
            if is_reversed { [1.0 - second, 1.0 - first] } else { [first, second] }
        };
        let is_own = |pair: &(BodyId, BodyId)| ends.contains(pair);
        let own = MotionSincePrevious::NotProven { why: GapReason::StateCollides, gap: None };
        let is_cut_off = current.effort.is_over();
        // where the first contact decides what is reported, another one that was found in time does not
        let any_will_do = ends.is_empty() && moving.is_none() && previous.is_known();
        match verdict {
            MotionVerdict::Free => MotionSincePrevious::ProvenFree,
            MotionVerdict::Contact { .. } if is_cut_off && !any_will_do => late(),
            // the search may have been cut off anywhere
            MotionVerdict::Undecided { .. } if is_cut_off => late(),
            MotionVerdict::Contact { pair, .. } if is_own(&pair) => own,
            // it may touch at any time after the first
            MotionVerdict::Contact { t, pair, .. } if may_have_moved.is_some() => {
                unproven(may_have_moved.unwrap_or(GapReason::StateCollides), Some(pair), forward([t[0], 1.0]))
            }
            // the previous state may touch
            MotionVerdict::Contact { t, pair, .. } if t[0] <= 0.0 && !previous.is_known() => {
                if previous.is_decided { unproven(GapReason::WorldChanged, Some(pair), t) } else { late() }
            }
            MotionVerdict::Contact { t, pair, .. } => {
                let t = forward(t);
                MotionSincePrevious::PassedThrough(Passage { pair: Some(pair), t, stamps })
            }
            MotionVerdict::Undecided { pair: Some(pair), .. } if is_own(&pair) => own,
            MotionVerdict::Undecided { t, pair, reason, .. } => {
                let why = may_have_moved.unwrap_or(GapReason::Undecided(reason));
                unproven(why, pair, forward(t))
            }
        }
    }
}

impl PreviousState {
    /// Whether its report says what touches in it: it is complete, and about the current world.
    fn is_known(&self) -> bool {
        self.is_of_current_world && self.is_decided
    }

    /// The pairs that touch in this state, as far as they are known.
    fn touching(&self) -> &[(BodyId, BodyId)] {
        if self.is_known() { &self.state.report.colliding_pairs } else { &[] }
    }
}

impl CurrentState<'_> {
    /// Whether the deadline left no pair open.
    fn is_decided(&self) -> bool {
        self.report.undecided.is_empty() && self.fixed != Some(LeftOut::Pairs)
    }
}

/// A motion to the current state.
struct Motion {
    /// Positions at its start, in the same turn as those at its end.
    from: Vec<f64>,
    /// By position: tolerance (rad, m); empty without tolerances.
    tube: Vec<f64>,
    /// Longest time (s) that a joint took.
    duration: f64,
}

/// Bounds (m) on the change of any distance.
struct MotionReach {
    /// Along the straight line.
    travel: f64,
    /// Within the tube.
    tube: f64,
}

impl Motion {
    fn reach(&self, current: &CurrentState) -> MotionReach {
        let to = current.configuration.positions();
        let beside = |q: &[f64], sign: f64| -> Vec<f64> {
            q.iter().zip(&self.tube).map(|(q, tube)| q + sign * tube).collect()
        };
        // both sides of the tube, at both ends: the bound exists only in a range of the positions
        let tube = if self.tube.is_empty() {
            0.0
        } else {
            let across = |q: &[f64]| current.checker.travel(&beside(q, -1.0), &beside(q, 1.0));
            0.5 * across(&self.from).greater(across(to))
        };
        MotionReach { travel: current.checker.travel(&self.from, to), tube }
    }

    /// The motion with its tube; `None` if its positions are too large to compute with.
    fn segment(&self, current: &CurrentState, is_reversed: bool) -> Option<MotionSegment> {
        let robot = current.checker.robot();
        let from = robot.configuration(&self.from).ok()?;
        let to = current.configuration;
        let segment = if is_reversed {
            MotionSegment::straight(robot, to, &from)
        } else {
            MotionSegment::straight(robot, &from, to)
        };
        if self.tube.is_empty() { Some(segment) } else { segment.with_tube(robot, self.tube.clone()).ok() }
    }
}

/// Whether the distances at the ends are so large that no pair of a kind can touch in between.
fn is_proven_by_distances(
    kind: PairKind,
    previous: &PreviousState,
    current: &CurrentState,
    reach: &MotionReach,
    obstacle_shift: f64,
) -> bool {
    let margin = match kind {
        PairKind::SelfPair => 0.0,
        PairKind::WorldPair => obstacle_shift,
    };
    if !current.checker.checks(kind) {
        return true;
    }
    let loss = reach.tube + margin + CONTACT_DISTANCE + ROUNDING;
    let [start, end] = [previous.bounds, current.bounds].map(|bounds| bounds.of_kind(kind));
    // distances in another world, or of some pairs, prove nothing
    let excess = if previous.is_known() { 0.5 * (start + end - reach.travel) } else { end - reach.travel };
    excess > loss
}

/// Possible motion of the obstacles while the joints move.
fn obstacle_shift(
    previous: &PreviousState,
    current: &CurrentState,
    motion: &Motion,
    reach: &MotionReach,
) -> ObstacleShift {
    let state = &previous.state;
    let before = KnownMotion {
        frames: &state.obstacle_motions,
        tracked: &state.tracked_obstacles,
        stamp: previous.time.stamp,
        ..current.known_motion
    };
    let mut frames = before.frames.iter().chain(current.known_motion.frames);
    // where the root stands, no radius matters
    let radius = if frames.all(ObstacleMotion::rests) {
        0.0
    } else {
        current.checker.extent(current.poses) + reach.travel + reach.tube
    };
    let surroundings = Surroundings {
        checker: current.checker,
        poses: current.poses,
        settings: current.settings,
        radius,
        duration: motion.duration.greater(current.spread),
        obstacle_displacements: current.obstacle_displacements,
    };
    ObstacleShift::between([before, current.known_motion], &surroundings)
}

/// Searches for a contact beside all places where obstacles may have been. Also returns why, if there is one only because
/// obstacles may have moved.
fn search_beside(
    obstacles: Option<&ObstacleShift>,
    segment: &MotionSegment,
    current: &CurrentState,
    workspace: &mut Workspace,
) -> (MotionVerdict, Option<GapReason>) {
    let Some(obstacles) = obstacles else { return (search(segment, current, workspace), None) };
    let why = |verdict: &MotionVerdict| match *verdict {
        MotionVerdict::Contact { pair, .. } | MotionVerdict::Undecided { pair: Some(pair), .. } => {
            obstacles.why(current.checker, pair)
        }
        _ => None,
    };
    let Some(uncertainty) = obstacles.uncertainty() else {
        let distance = [0.0, f64::INFINITY];
        let nothing =
            MotionVerdict::Undecided { t: [0.0, 1.0], pair: None, distance, reason: UndecidedReason::Tube };
        return (nothing, Some(obstacles.why_unbounded()));
    };
    let verdict = search(&segment.clone().with_uncertainty(uncertainty), current, workspace);
    let may_have_moved = why(&verdict);
    if may_have_moved.is_some() || matches!(verdict, MotionVerdict::Contact { .. }) {
        // what does not move by itself is passed through where it is
        let standing = search(segment, current, workspace);
        if matches!(standing, MotionVerdict::Contact { .. }) && why(&standing).is_none() {
            return (standing, None);
        }
    }
    (verdict, may_have_moved)
}

fn search(segment: &MotionSegment, current: &CurrentState, workspace: &mut Workspace) -> MotionVerdict {
    let options = MotionOptions {
        tolerance: TOLERANCE,
        deadline: current.effort.deadline,
        budget: EVALUATIONS + EVALUATIONS_PER_PAIR * current.checker.pairs().len() as u64,
        ..MotionOptions::default()
    };
    current.checker.check_motion_with(segment, &options, workspace).verdict
}

/// The longest time (s) between two measurements of a joint, also of those whose positions come from `tf`.
fn longest_interval(previous: &PreviousState, current: &CurrentState) -> f64 {
    let ends = previous.state.measured.iter().zip(current.measured);
    // the time between the evaluations, where a position has come from `tf` at one end only
    let between = || current.time.at.saturating_sub(previous.time.at).as_secs_f64();
    let of_transforms =
        current.time.transforms.longest_interval(&previous.time.transforms).unwrap_or_else(between);
    let intervals = ends.map(|ends| match ends {
        (Some(before), Some(now)) => now.seconds_since(*before).abs(),
        _ => of_transforms,
    });
    intervals.fold(0.0, f64::greater)
}

/// The same tolerance (rad, m) for each position, but none for floating joints; empty without tolerance.
fn tube_of(robot: &RobotModel, tolerance: f64) -> Vec<f64> {
    if tolerance <= 0.0 {
        return Vec::new();
    }
    let mut tube = vec![tolerance; robot.position_names().len()];
    for (_, first) in floating(robot) {
        tube[first..first + 7].fill(0.0);
    }
    tube
}

fn is_same(one: &CheckedState, other: &CheckedState) -> bool {
    one.measured == other.measured && one.configuration == other.configuration
}
