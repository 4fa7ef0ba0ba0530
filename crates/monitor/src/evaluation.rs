//! Everything the node says about one joint state.

use std::sync::Arc;
use std::time::Duration;

use clearance_checker::{CollisionChecker, CollisionReport, LookAhead, PairDistance};
use clearance_geometry::math::Extremes;
use clearance_robot::{Configuration, LinkPoses};
use clearance_scene::AnchorFrames;

use super::drift::Drift;
use super::{Now, Reason, Status, Time, WorldSource};

/// A checker, and which one it is.
#[derive(Debug)]
pub struct Revision {
    pub checker: CollisionChecker,
    /// Counts the robot models taken since the start; the first is 1.
    pub model: u64,
    /// Counts the changes of the world since the start.
    pub world: u64,
    /// Who has to see the world for it to count as known.
    pub sources: Vec<WorldSource>,
    /// Why the world was known to be incomplete when this was built, if it was.
    pub incomplete: Option<Reason>,
    /// What has to be known about the world beside that.
    pub warnings: Vec<String>,
    /// The frames that obstacles stand in.
    pub grounds: AnchorFrames,
    /// When obstacles were where `tf` had them, by the steady clock; `None`: when this comes into force.
    pub placed_at: Option<Duration>,
}

impl Revision {
    /// Of a world that only messages and files change.
    #[must_use]
    pub fn new(checker: CollisionChecker, model: u64, world: u64) -> Self {
        Self {
            checker,
            model,
            world,
            sources: Vec::new(),
            incomplete: None,
            warnings: Vec::new(),
            grounds: AnchorFrames::default(),
            placed_at: None,
        }
    }

    /// Whether there is anything of the robot that could touch something.
    #[must_use]
    pub fn has_geometry(&self) -> bool {
        self.checker.robot().links().iter().any(|link| !link.collisions.is_empty())
    }

    /// Why the world is not known now, if it is not.
    #[must_use]
    pub fn stale_world(&self, now: Now) -> Option<Reason> {
        self.sources.iter().find_map(|source| source.freshness(now).err())
    }

    /// The frame of all poses and points: the robot's root link.
    #[must_use]
    pub fn frame(&self) -> &str {
        let robot = self.checker.robot();
        &robot.link(robot.root()).name
    }
}

/// What a check found.
#[derive(Clone, Debug)]
pub struct CheckedState {
    pub report: CollisionReport,
    /// Pairs beyond those that are told, which may come near before the robot has slowed down.
    pub coming: Vec<PairDistance>,
    /// What was checked.
    pub configuration: Configuration,
    /// Where the links were.
    pub poses: LinkPoses,
    /// What is certain about the time after the joint state's stamp, if it was asked for and the velocities are known.
    pub look_ahead: Option<LookAhead>,
    /// Rates of the positions (rad/s, m/s), if all are known.
    pub velocities: Option<Vec<f64>>,
    /// The same, where only some of several drivers give them by what the others said before.
    pub rates: Option<Vec<f64>>,
    /// By position: the stamp of the joint state that tells it; none of what `tf` places.
    pub measured: Vec<Option<Time>>,
    /// How what the world stands in moves past the robot's root: as many as frames are watched.
    pub drifts: Vec<Drift>,
    /// The distance (m) up to which pairs may slow the robot down.
    pub slows_within: f64,
    /// Whether all distances are exact, not lower bounds within a tolerance.
    pub is_exact: bool,
    /// Whether they are not because joint states came too fast.
    pub is_hurried: bool,
    /// Wall time that the check took.
    pub compute_time: Duration,
}

/// What the deadline left out of an answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum LeftOut {
    #[default]
    Nothing,
    /// The time to contact.
    LookAhead,
    /// Some pairs.
    Pairs,
}

/// What is known about the robot now. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Evaluation {
    pub status: Status,
    /// Stamp of the joint state that this is about, if there was one.
    pub stamp: Option<Time>,
    /// How old that joint state is (s).
    pub age: Option<f64>,
    /// Present exactly when the status is FREE or COLLIDING.
    pub checked_state: Option<Arc<CheckedState>>,
    /// The same, also when only the world around the robot has become stale: where the robot is, is still known.
    pub placement: Option<Arc<CheckedState>>,
    /// The share of its speed that the robot may have, in [0, 1]; 0 unless the status is FREE.
    pub speed_scale: f64,
    pub left_out: LeftOut,
    /// Whether another robot is being built, so that this one counts no more, whatever else is the matter.
    pub is_swapping: bool,
    /// Why the world is not known or known to be incomplete, if it is so, whatever else is the matter.
    pub stale_world: Option<Reason>,
    /// The robot and world that were checked, or would be.
    pub revision: Option<Arc<Revision>>,
    /// What did not prevent the evaluation and should be known.
    pub warnings: Arc<[String]>,
    /// How long what is known holds, if nothing more comes.
    pub expiry: Expiry,
}

/// When what was known is known no longer, by the steady clock; `None`: never.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Expiry {
    /// When the evaluation was said.
    pub said_at: Duration,
    /// Of where the robot is.
    pub of_robot: Option<Duration>,
    /// Of where obstacles are.
    pub of_world: Option<Duration>,
}

impl Evaluation {
    /// As it holds at `now`, while the monitor is busy with the next one.
    #[must_use]
    pub fn aged(mut self, now: Now) -> Self {
        let is_over = |end: Option<Duration>| end.is_some_and(|end| now.steady >= end);
        let since = now.steady.saturating_sub(self.expiry.said_at).as_secs_f64();
        let overdue = Reason::Overdue { since };
        self.age = self.age.map(|age| age + since);
        if self.placement.is_some() && is_over(self.expiry.of_robot) {
            self.placement = None;
            self.know_nothing(overdue.clone());
        }
        if self.stale_world.is_none() && is_over(self.expiry.of_world) {
            self.stale_world = Some(overdue.clone());
            self.know_nothing(overdue);
        }
        self
    }

    /// With something else that should be known, if there is anything.
    #[must_use]
    pub fn with_warning(mut self, warning: Option<String>) -> Self {
        if warning.is_some() {
            self.warnings = self.warnings.iter().cloned().chain(warning).collect();
        }
        self
    }

    fn know_nothing(&mut self, why: Reason) {
        self.checked_state = None;
        self.speed_scale = 0.0;
        if self.status.reason().is_none() {
            self.status = Status::Unknown(why);
        }
    }

    /// The least distance (m): NaN when nothing is known, infinite when nothing is within the distance limit.
    #[must_use]
    pub fn distance(&self) -> f64 {
        match &self.checked_state {
            None => f64::NAN,
            Some(checked_state) => {
                (checked_state.report.nearest.as_ref()).map_or(f64::INFINITY, |nearest| nearest.distance)
            }
        }
    }

    /// The first pair that touches, or else the nearest with its distance, in words; `None` if nothing is known, or nothing near.
    #[must_use]
    pub fn foremost(&self) -> Option<String> {
        let report = &self.checked_state.as_ref()?.report;
        let checker = &self.revision.as_ref()?.checker;
        let names = |a, b| format!("{} and {}", checker.body_name(a), checker.body_name(b));
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

    /// How long from now on (s) it is certain that nothing touches: 0 when something does, or nothing is known.
    #[must_use]
    pub fn time_to_contact(&self) -> f64 {
        let look_ahead = self.checked_state.as_ref().and_then(|checked_state| checked_state.look_ahead);
        // a stamp in the future gives no time on top
        look_ahead.map_or(0.0, |ahead| {
            (ahead.free_for - self.age.unwrap_or(f64::INFINITY).greater(0.0)).greater(0.0)
        })
    }
}
