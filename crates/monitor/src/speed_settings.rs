//! Settings of the speed scale, and the share of the speed that one pair requests.

use clearance_geometry::math::Extremes;

use super::separation_rules::SeparationRules;

/// Approach rates below this (m/s) count as at rest: velocities are noisy.
pub(super) const REST: f64 = 1e-3;

/// Slow-down and stop distance (m).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpeedDistances {
    /// Distance from which the robot is slowed down; 0: never, unless bodies touch.
    pub slowdown: f64,
    /// Distance from which it has to stop.
    pub stop: f64,
}

/// User settings of the speed scale.
#[derive(Clone, Debug, PartialEq)]
pub struct SpeedSettings {
    /// Distances between bodies of the robot.
    pub own: SpeedDistances,
    /// Distances between the robot and its surroundings.
    pub world: SpeedDistances,
    /// Time (s) for which an approach is assumed to continue at the same rate.
    pub reaction_time: f64,
    /// Number of states in a row after which the robot slows down.
    pub trigger_count: u32,
    /// Number of states in a row after which it speeds up.
    pub release_count: u32,
    /// Speed and separation monitoring of the obstacles, except for those that rest; `None`: off.
    pub separation: Option<SeparationRules>,
}

impl Default for SpeedSettings {
    fn default() -> Self {
        Self {
            own: SpeedDistances::default(),
            world: SpeedDistances::default(),
            reaction_time: 0.1,
            trigger_count: 1,
            release_count: 5,
            separation: None,
        }
    }
}

impl SpeedSettings {
    /// Distance (m) up to which pairs are reported: within it, pairs at rest may cause a reduction by their distance.
    #[must_use]
    pub(super) fn reach(&self) -> f64 {
        self.own.reach().greater(self.world.reach())
    }
}

impl SpeedDistances {
    /// Distance (m) beyond which a pair at rest causes no reduction.
    pub(super) fn reach(self) -> f64 {
        self.slowdown.greater(self.stop)
    }

    /// Share that a pair requests which the robot brings together at `rate` (m/s), if that is known. The other body moves
    /// by at most `obstacle_motion` (m) on its own in the reaction time.
    pub(super) fn share(
        self,
        distance: f64,
        rate: Option<f64>,
        reaction_time: f64,
        obstacle_motion: f64,
    ) -> f64 {
        let rate = rate.unwrap_or(0.0);
        let is_off = self.reach() == 0.0 && distance > 0.0;
        if is_off || rate < -REST {
            return 1.0;
        }
        let left = distance - rate.greater(0.0) * reaction_time - obstacle_motion;
        if left <= self.stop {
            0.0
        } else if left >= self.slowdown {
            1.0
        } else {
            (left - self.stop) / (self.slowdown - self.stop)
        }
    }
}
