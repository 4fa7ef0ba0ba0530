//! What a user decides about monitoring.

use std::time::{Duration, Instant};

use clearance_proximity::Effort;

use super::SpeedSettings;

/// Longer than any check.
const UNHURRIED: Duration = Duration::from_secs(86_400);

/// Choices that may change at any time.
#[derive(Clone, Debug, PartialEq)]
pub struct MonitorSettings {
    /// How often something is said at least (Hz).
    pub heartbeat_rate: f64,
    /// Age (s) beyond which a joint state says nothing about the robot any more.
    pub stale_after: f64,
    /// Time (s) that one answer may take; 0: as long as it takes.
    pub check_deadline: f64,
    /// Planar and floating joints whose positions `tf` tells, instead of joint states.
    pub transform_joints: Vec<String>,
    /// Age (s) beyond which a transform says nothing about them any more.
    pub transform_ttl: f64,
    /// What the names of this robot's joints begin with; others on the topic are other robots'.
    pub joint_prefix: String,
    /// Whether nothing is known while a mimic joint is reported elsewhere than where its leader takes it; otherwise that is a warning.
    pub mimic_contradiction_is_unknown: bool,
    /// Distance (m) up to which every pair is reported.
    pub influence_distance: f64,
    /// Distance (m) beyond which the least distance is not looked for.
    pub distance_limit: f64,
    /// By how much (m) a distance may be told too small, in place of exactly.
    pub distance_absolute_tolerance: f64,
    /// The same as a share of the distance, in [0, 1); the larger of the two counts.
    pub distance_relative_tolerance: f64,
    /// The share of the time between joint states that exact distances may take, in [0, 1]; beyond it they are told within a tenth
    /// or a millimetre. 0: they take what they take.
    pub exact_distance_share: f64,
    /// When the robot is to be slower.
    pub speed: SpeedSettings,
    /// How far ahead (s) it is looked for contacts; 0: not at all.
    pub look_ahead_horizon: f64,
    /// What joints without an acceleration limit of their own are thought to be capable of (rad/s², m/s²).
    pub look_ahead_acceleration: f64,
}

impl Default for MonitorSettings {
    fn default() -> Self {
        Self {
            heartbeat_rate: 10.0,
            stale_after: 0.5,
            check_deadline: 0.0,
            transform_joints: Vec::new(),
            joint_prefix: String::new(),
            mimic_contradiction_is_unknown: true,
            transform_ttl: 1.0,
            influence_distance: 0.1,
            distance_limit: 1.0,
            distance_absolute_tolerance: 0.0,
            distance_relative_tolerance: 0.0,
            exact_distance_share: 0.1,
            speed: SpeedSettings::default(),
            look_ahead_horizon: 0.0,
            look_ahead_acceleration: 10.0,
        }
    }
}

impl MonitorSettings {
    /// How much one check may take, from now on.
    #[must_use]
    pub(super) fn effort(&self) -> Effort {
        let time = Duration::try_from_secs_f64(self.check_deadline).ok().filter(|time| !time.is_zero());
        self.effort_until(time.and_then(|time| Instant::now().checked_add(time)))
    }

    /// The same for a check that may take as long as it does, done in the same way.
    #[must_use]
    pub(super) fn unhurried_effort(&self) -> Effort {
        let hurried = self.effort().deadline.is_some();
        self.effort_until(Instant::now().checked_add(UNHURRIED).filter(|_| hurried))
    }

    fn effort_until(&self, deadline: Option<Instant>) -> Effort {
        Effort {
            relative_tolerance: self.distance_relative_tolerance,
            absolute_tolerance: self.distance_absolute_tolerance,
            exact_within: 0.0,
            exact_cost: 0,
            deadline,
        }
    }

    /// Longest silence allowed between two evaluations.
    #[must_use]
    pub fn heartbeat_period(&self) -> Duration {
        Duration::try_from_secs_f64(1.0 / self.heartbeat_rate).unwrap_or(Duration::from_secs(1))
    }
}
