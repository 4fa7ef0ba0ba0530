//! User settings of the monitor.

use std::sync::Arc;
use std::time::{Duration, Instant};

use clearance_motion::ObstacleLimits;
use clearance_proximity::Effort;
use clearance_scene::World;

use super::SpeedSettings;

/// Longer than any check takes.
const UNHURRIED: Duration = Duration::from_secs(86_400);

/// Settings that may change at any time.
#[derive(Clone, Debug, PartialEq)]
pub struct MonitorSettings {
    /// Lowest rate (Hz) at which evaluations are published.
    pub heartbeat_rate: f64,
    /// Age (s) beyond which a joint state is stale.
    pub stale_after: f64,
    /// Time limit (s) of one evaluation; 0: none.
    pub check_deadline: f64,
    /// Planar and floating joints whose positions come from `tf` instead of joint states.
    pub transform_joints: Vec<String>,
    /// Age (s) beyond which their transforms are stale.
    pub transform_ttl: f64,
    /// Prefix of the names of this robot's joints. Other names on the topic belong to other robots.
    pub joint_prefix: String,
    /// Whether the status is UNKNOWN while the report of a mimic joint disagrees with its leader; otherwise that is a
    /// warning.
    pub mimic_contradiction_is_unknown: bool,
    /// Distance (m) up to which every pair is reported.
    pub influence_distance: f64,
    /// Distance (m) beyond which the least distance is not computed.
    pub distance_limit: f64,
    /// Largest error (m) of a reported distance, which may only be too small; 0: exact.
    pub distance_absolute_tolerance: f64,
    /// The same as a share of the distance, in [0, 1); the larger of the two applies.
    pub distance_relative_tolerance: f64,
    /// Share of the time between joint states that exact distances may take, in [0, 1]. Beyond it, distances have a
    /// tolerance of a tenth or a millimetre. 0: no limit.
    pub exact_distance_share: f64,
    /// Largest number of contacts that are computed of each colliding pair; 0: none.
    pub contacts_per_pair: usize,
    /// Whether the motion from each evaluated state to the next one is checked.
    pub check_between_states: bool,
    /// Largest error (rad, m) of a reported joint position, in the check between states.
    pub joint_noise: f64,
    /// Largest acceleration (rad/s², m/s²) of the joints between two states; 0: they move along straight lines.
    pub between_states_acceleration: f64,
    /// When the robot has to be slower.
    pub speed: SpeedSettings,
    /// Horizon (s) of the time to contact; 0 switches it off.
    pub look_ahead_horizon: f64,
    /// Assumed acceleration limit (rad/s², m/s²) of joints without their own.
    pub look_ahead_acceleration: f64,
    /// Largest accelerations (m/s², rad/s²) of a root that moves; 0: not known.
    pub look_ahead_root_accelerations: [f64; 2],
    /// How fast obstacles may move after the evaluated state.
    pub obstacle_limits: Arc<ObstacleLimits>,
    /// Time (s) between the measurement of the obstacles' poses and the evaluated state.
    pub obstacle_latency: f64,
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
            contacts_per_pair: 0,
            check_between_states: true,
            joint_noise: 0.0,
            between_states_acceleration: 0.0,
            speed: SpeedSettings::default(),
            look_ahead_horizon: 0.0,
            look_ahead_acceleration: 10.0,
            look_ahead_root_accelerations: [0.0; 2],
            obstacle_limits: Arc::default(),
            obstacle_latency: 0.0,
        }
    }
}

impl MonitorSettings {
    /// Limits of one check that starts now.
    #[must_use]
    pub(super) fn effort(&self) -> Effort {
        let time = Duration::try_from_secs_f64(self.check_deadline).ok().filter(|time| !time.is_zero());
        self.effort_until(time.and_then(|time| Instant::now().checked_add(time)))
    }

    /// The same without a deadline, with the same algorithm.
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

    /// The limits of obstacles, if any of them may move.
    #[must_use]
    pub fn moving_obstacles(&self) -> Option<&Arc<ObstacleLimits>> {
        Some(&self.obstacle_limits).filter(|limits| !limits.is_zero())
    }

    /// Upper bound (m) on the motion of an obstacle on its own until the speed scale has an effect, for joints that were
    /// measured up to `spread` (s) after the stamp.
    pub(super) fn obstacle_motion(&self, obstacle: &str, spread: f64) -> f64 {
        let time = self.obstacle_latency + spread + self.speed.reaction_time;
        self.obstacle_limits.of(obstacle).displacement(time)
    }

    /// The same for all obstacles of a world.
    pub(super) fn largest_obstacle_motion(&self, world: &World, spread: f64) -> f64 {
        let time = self.obstacle_latency + spread + self.speed.reaction_time;
        let matters = self.speed.world.reach() > 0.0;
        self.moving_obstacles()
            .filter(|_| matters)
            .map_or(0.0, |limits| limits.largest_displacement(world, time))
    }

    /// Longest time between two published evaluations.
    #[must_use]
    pub fn heartbeat_period(&self) -> Duration {
        Duration::try_from_secs_f64(1.0 / self.heartbeat_rate).unwrap_or(Duration::from_secs(1))
    }
}
