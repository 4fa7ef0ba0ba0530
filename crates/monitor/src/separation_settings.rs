//! Settings and formulas of speed and separation monitoring: protective separation distance and allowed speed.
//!
//! After ISO/TS 15066:2016, 5.5.4, the protective separation distance of a robot that approaches at speed `v` is
//! `S_p = S_h + S_r + S_s + C + Z_d + Z_r`. A constant deceleration `a` after the reaction time `T` gives:
//!
//! - `S_h = v_h (T + v / a)`: motion of the person, at speed `v_h`, until the robot has stopped;
//! - `S_r = v T`: motion of the robot in the reaction time;
//! - `S_s = v² / (2 a)`: its stopping distance.
//!
//! This holds for one stop from a constant speed. A scale that falls all the time is different: `T` after a state, the
//! robot still slows down to the scale of earlier states, so that its speed in between exceeds the new one by up to
//! `a T`, and it moves farther by up to `a T² / 2`. The allowed speed at distance `d` is therefore the solution of
//! `S_p(v) + a T² / 2 = d`. With `m = C + Z_d + Z_r`, this is `(v + a T + v_h)² = v_h² + 2 a (d - m)`, or
//! `v = sqrt(v_h² + 2 a (d - m)) - v_h - a T`. `docs/operate/speed_and_separation.md` has the whole derivation.

use clearance_geometry::math::Extremes;

use super::speed_settings::REST;

/// Settings of speed and separation monitoring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeparationSettings {
    /// Speed (m/s) at which a person or another obstacle may approach, `v_h`.
    pub human_speed: f64,
    /// Largest speed (m/s) at which commands may move any point of the robot, before they are scaled; above 0.
    pub robot_speed: f64,
    /// Time (s) from a motion in the environment until the robot begins to brake, `T`; above 0.
    pub reaction_time: f64,
    /// Deceleration (m/s²) that the robot reaches in every state, `a`; above 0.
    pub deceleration: f64,
    /// Largest acceleration (m/s²) that commands may cause. 0: unknown; then motion away counts as rest.
    pub acceleration: f64,
    /// Intrusion distance and position uncertainties (m), `C + Z_d + Z_r`.
    pub margin: f64,
}

impl SeparationSettings {
    /// Protective separation distance (m) of a robot that approaches at this speed (m/s, not negative).
    #[must_use]
    pub fn protective_distance(&self, speed: f64) -> f64 {
        let stopping_time = speed / self.deceleration;
        let of_human = self.human_speed * (self.reaction_time + stopping_time);
        let of_robot = speed * self.reaction_time + speed * stopping_time / 2.0;
        of_human + of_robot + self.margin
    }

    /// Largest speed (m/s) at which the robot may approach at this distance (m), while the speed follows the distance.
    #[must_use]
    pub fn allowed_speed(&self, distance: f64) -> f64 {
        let left = (distance - self.margin).greater(0.0);
        let stoppable = (self.human_speed.powi(2) + 2.0 * self.deceleration * left).sqrt() - self.human_speed;
        (stoppable - self.deceleration * self.reaction_time).greater(0.0)
    }

    /// Distance (m) from which the robot may move at its full speed.
    #[must_use]
    pub fn range(&self) -> f64 {
        self.protective_distance(self.robot_speed) + self.deceleration * self.reaction_time.powi(2) / 2.0
    }

    /// Share of the speed that a pair requests. The robot brings its nearest points together at `rate` (m/s), and any of
    /// its points at most at `largest`, if they are known.
    ///
    /// The scale multiplies a command that is not known. It may be the largest speed in the direction of the other
    /// body, whatever the robot does now.
    #[must_use]
    pub fn share(&self, distance: f64, rate: Option<f64>, largest: Option<f64>) -> f64 {
        let allowed = self.allowed_speed(distance);
        if largest.is_some_and(|rate| self.moves_away(rate, allowed)) {
            return 1.0;
        }
        let commanded = self.robot_speed.greater(rate.unwrap_or(0.0));
        (allowed / commanded).lesser(1.0)
    }

    /// Whether all points of a pair move apart so fast that commands cannot make it approach faster than allowed before a lower
    /// scale takes effect.
    fn moves_away(&self, rate: f64, allowed: f64) -> bool {
        self.acceleration > 0.0 && rate < -REST && rate + self.acceleration * self.reaction_time <= allowed
    }
}

#[cfg(test)]
pub(super) mod tests;
