//! Data types: evaluation of the robot's state (status, distances, warnings, expiry), and the revision of its checker.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use clearance_checker::{CollisionChecker, CollisionReport, LookAhead, PairDistance, PairKind};
use clearance_geometry::math::{Extremes, Pose};
use clearance_robot::{Configuration, LinkPoses, quoted};
use clearance_scene::{AnchorFrames, ObstacleTwist};

use super::contact_counter::ContactHistory;
use super::motion_since_previous::{MotionSincePrevious, Passage};
use super::obstacle_motion::ObstacleMotion;
use super::state_contacts::ContactsOfPair;
use super::{Now, PlacedAt, Reason, Separation, Status, Time, TrackedObstacles, WorldSource};

/// A checker with its version numbers.
#[derive(Debug)]
pub struct Revision {
    /// Checks the robot in this world.
    pub checker: CollisionChecker,
    /// Number of the robot model, counted since the start; the first is 1.
    pub model: u64,
    /// Number of world changes since the start.
    pub world: u64,
    /// Sensors that have to be up to date for the world to count as known.
    pub sources: Vec<WorldSource>,
    /// Why the world was incomplete when this revision was built, if it was.
    pub incomplete: Option<Reason>,
    /// Further warnings about the world.
    pub warnings: Vec<String>,
    /// The frames that obstacles are placed in.
    pub anchor_frames: AnchorFrames,
    /// Time (steady clock) of the `tf` data that the obstacles were placed with; `None`: the time at which this
    /// revision is put into use.
    pub placed_at: Option<Duration>,
    /// Velocities of the obstacles with known ones, in the order of their names.
    pub obstacle_twists: Vec<ObstacleTwist>,
    /// Poses, in the root frame, that obstacles were given since the revision before, by name, oldest first.
    pub obstacle_poses: BTreeMap<String, Vec<Pose>>,
}

impl Revision {
    /// Creates a revision of a world without sensors.
    #[must_use]
    pub fn new(checker: CollisionChecker, model: u64, world: u64) -> Self {
        Self {
            checker,
            model,
            world,
            sources: Vec::new(),
            incomplete: None,
            warnings: Vec::new(),
            anchor_frames: AnchorFrames::default(),
            placed_at: None,
            obstacle_twists: Vec::new(),
            obstacle_poses: BTreeMap::new(),
        }
    }

    /// Pose of an obstacle in the root frame.
    pub(super) fn pose_of(&self, obstacle: &str) -> Option<Pose> {
        Some(self.checker.world().obstacle_by_name(obstacle)?.pose_ro)
    }

    /// Whether any link of the robot has collision geometry.
    #[must_use]
    pub fn has_geometry(&self) -> bool {
        self.checker.robot().links().iter().any(|link| !link.collisions.is_empty())
    }

    /// Why the world is out of date, if it is.
    #[must_use]
    pub fn stale_world(&self, now: Now) -> Option<Reason> {
        self.sources.iter().find_map(|source| source.freshness(now).err())
    }

    /// Frame of all poses and points: the robot's root link.
    #[must_use]
    pub fn frame(&self) -> &str {
        let robot = self.checker.robot();
        &robot.link(robot.root()).name
    }
}

/// Result of the check of one joint state.
#[derive(Clone, Debug)]
pub struct CheckedState {
    /// Pairs and distances.
    pub report: CollisionReport,
    /// Pairs beyond the reporting distance that may come near before the robot has slowed down.
    pub approaching_pairs: Vec<PairDistance>,
    /// Contacts of the colliding pairs, in their order; empty unless the settings request contacts.
    pub contacts: Vec<ContactsOfPair>,
    /// The configuration that was checked.
    pub configuration: Configuration,
    /// The link poses of that configuration.
    pub poses: LinkPoses,
    /// Proven time without contact after the joint state's stamp, if look-ahead is on and the velocities are known.
    pub look_ahead: Option<LookAhead>,
    /// Whether the look-ahead takes the motion of obstacles into account.
    pub obstacles_may_move: bool,
    /// Velocities of the positions (rad/s, m/s), if all are known.
    pub velocities: Option<Vec<f64>>,
    /// The same. If only some of several drivers publish velocities, the others are computed from successive positions.
    pub rates: Option<Vec<f64>>,
    /// By position: the stamp of the joint state that contains it; `None` for positions from `tf`.
    pub measured: Vec<Option<Time>>,
    /// The times of positions from `tf`.
    pub placed_at: Vec<PlacedAt>,
    /// Longest time (s) between the stamp and the measurement of a position.
    pub spread: f64,
    /// Motions of the obstacle frames relative to the robot's root, one for each tracked frame.
    pub obstacle_motions: Vec<ObstacleMotion>,
    /// Obstacles that move by themselves.
    pub tracked_obstacles: TrackedObstacles,
    /// Distance (m) up to which pairs may slow the robot down.
    pub slowdown_range: f64,
    /// Whether all distances are exact; otherwise they are lower bounds within a tolerance.
    pub is_exact: bool,
    /// Whether they are inexact because of the rate of the joint states.
    pub is_hurried: bool,
    /// Wall time of the check.
    pub compute_time: Duration,
}

/// The part of an evaluation that was left out because of the deadline.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum LeftOut {
    #[default]
    /// Everything was computed.
    Nothing,
    /// Contacts of some colliding pairs were not computed.
    Contacts,
    /// The time to contact, and contacts, were not computed.
    LookAhead,
    /// These, and where on the motion since the previous state the contact was.
    PassageExtent,
    /// These, and the check of the motion since the previous state was not finished.
    MotionSincePrevious,
    /// These, and the larger one of the least distances to itself and to the world, were not computed.
    FartherDistance,
    /// Some pairs were not checked.
    Pairs,
}

/// Current evaluation of the robot's state. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Evaluation {
    /// FREE, COLLIDING or UNKNOWN.
    pub status: Status,
    /// Stamp of the evaluated joint state, if there is one.
    pub stamp: Option<Time>,
    /// Age of that joint state (s).
    pub age: Option<f64>,
    /// Present exactly when the status is FREE or COLLIDING.
    pub checked_state: Option<Arc<CheckedState>>,
    /// The same, but also present if only the world has become stale: the robot's configuration is still known.
    pub robot_state: Option<Arc<CheckedState>>,
    /// Result of the check of the motion since the previous evaluated state. A contact that is proven makes this
    /// evaluation COLLIDING, but not the next one of the same state.
    pub motion_since_previous: MotionSincePrevious,
    /// Contacts counted since the start, and what happened since the last heartbeat message.
    pub history: ContactHistory,
    /// Allowed share of the robot's speed, in [0, 1]; 0 unless the status is FREE.
    pub speed_scale: f64,
    /// Separation of the pair that requests the lowest speed; `None` unless separation is monitored and the status is
    /// FREE.
    pub separation: Option<Separation>,
    /// The part that was left out because of the deadline.
    pub left_out: LeftOut,
    /// Whether another robot model is being built, so that this one is no longer valid. Independent of the status.
    pub is_swapping: bool,
    /// Why the world is unknown or incomplete, if it is. Independent of the status.
    pub stale_world: Option<Reason>,
    /// The robot and world of the check.
    pub revision: Option<Arc<Revision>>,
    /// Warnings: they do not prevent the evaluation.
    pub warnings: Arc<[String]>,
    /// Time until which the evaluation is valid without further messages.
    pub expiry: Expiry,
}

/// Times (steady clock) at which the evaluation expires; `None`: never.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Expiry {
    /// Time at which the evaluation was published.
    pub published_at: Duration,
    /// Expiry of the robot's configuration.
    pub of_robot: Option<Duration>,
    /// Expiry of the obstacles' positions.
    pub of_world: Option<Duration>,
}

impl Evaluation {
    /// The evaluation as it is valid at `now`, while the monitor is busy with the next one.
    #[must_use]
    pub fn aged(mut self, now: Now) -> Self {
        let is_over = |end: Option<Duration>| end.is_some_and(|end| now.steady >= end);
        let since = now.steady.saturating_sub(self.expiry.published_at).as_secs_f64();
        let overdue = Reason::Overdue { since };
        self.age = self.age.map(|age| age + since);
        if self.robot_state.is_some() && is_over(self.expiry.of_robot) {
            self.robot_state = None;
            self.invalidate(overdue.clone());
        }
        if self.stale_world.is_none() && is_over(self.expiry.of_world) {
            self.stale_world = Some(overdue.clone());
            self.invalidate(overdue);
        }
        self
    }

    /// Adds a warning, if there is one.
    #[must_use]
    pub fn with_warning(mut self, warning: Option<String>) -> Self {
        if warning.is_some() {
            self.warnings = self.warnings.iter().cloned().chain(warning).collect();
        }
        self
    }

    fn invalidate(&mut self, why: Reason) {
        self.checked_state = None;
        self.speed_scale = 0.0;
        self.separation = None;
        self.motion_since_previous = std::mem::take(&mut self.motion_since_previous).while_unknown();
        if self.status.reason().is_none() {
            self.status = Status::Unknown(why);
        }
    }

    /// The least distance (m): NaN when it is unknown, infinite when nothing is within the distance limit.
    #[must_use]
    pub fn distance(&self) -> f64 {
        match &self.checked_state {
            None => f64::NAN,
            Some(checked_state) => {
                (checked_state.report.nearest.as_ref()).map_or(f64::INFINITY, |nearest| nearest.distance)
            }
        }
    }

    /// The least distance (m) of the pairs of one kind: NaN when it is unknown, infinite when none is within the distance
    /// limit or checked.
    #[must_use]
    pub fn distance_of(&self, kind: PairKind) -> f64 {
        self.checked_state.as_ref().map_or(f64::NAN, |checked_state| checked_state.report.distance_of(kind))
    }

    /// The nearest pair of one kind, if it is known and within the distance limit.
    #[must_use]
    pub fn nearest_of(&self, kind: PairKind) -> Option<&PairDistance> {
        self.checked_state.as_ref()?.report.known_nearest_of(kind)
    }

    /// Description of the nearest pair of one kind: its distance and its bodies.
    #[must_use]
    pub fn least_distance(&self, kind: PairKind) -> Option<String> {
        let (nearest, checker) = (self.nearest_of(kind)?, &self.revision.as_ref()?.checker);
        let [a, b] = [nearest.a, nearest.b].map(|body| checker.body_name(body));
        Some(format!("{:.4} m, {a} and {b}", nearest.distance))
    }

    /// The proven contact since the previous state, if the status is COLLIDING because of it alone.
    #[must_use]
    pub fn contact_since_previous(&self) -> Option<&Passage> {
        let passage = self.motion_since_previous.passed_through()?;
        let report = &self.checked_state.as_ref()?.report;
        report.colliding_pairs.is_empty().then_some(passage)
    }

    /// Description of a contact since the previous state.
    #[must_use]
    pub fn passage_text(&self, passage: &Passage) -> Option<String> {
        let (checker, (a, b)) = (&self.revision.as_ref()?.checker, passage.pair?);
        let [a, b] = [a, b].map(|body| quoted(checker.body_name(body)));
        Some(format!("{a} and {b} touched between the previous state and this one"))
    }

    /// Description of the first colliding pair, otherwise of the nearest pair with its distance; `None` if none is
    /// known or near.
    #[must_use]
    pub fn foremost(&self) -> Option<String> {
        let report = &self.checked_state.as_ref()?.report;
        let checker = &self.revision.as_ref()?.checker;
        let names = |a, b| format!("{} and {}", checker.body_name(a), checker.body_name(b));
        if let Some(passage) = self.contact_since_previous() {
            return self.passage_text(passage);
        }
        if let Some(&(a, b)) = report.colliding_pairs.first() {
            let others = match report.colliding_pairs.len() - 1 {
                0 => String::new(),
                others => format!(", and {others} more"),
            };
            return Some(format!("{} touch{others}", names(a, b)));
        }
        let nearest = report.nearest.as_ref()?;
        Some(format!("nearest: {}, {:.4} m", names(nearest.a, nearest.b), nearest.distance))
    }

    /// Proven time (s) from now on without contact: 0 if something touches, or if it is unknown.
    #[must_use]
    pub fn time_to_contact(&self) -> f64 {
        let look_ahead = self.checked_state.as_ref().and_then(|checked_state| checked_state.look_ahead);
        // a stamp in the future adds no time
        look_ahead.map_or(0.0, |ahead| {
            (ahead.free_for - self.age.unwrap_or(f64::INFINITY).greater(0.0)).greater(0.0)
        })
    }
}
