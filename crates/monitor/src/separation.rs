//! Result of speed and separation monitoring for one state: the pair that requests the lowest speed.

use clearance_geometry::math::Extremes;
use clearance_scene::BodyId;

use super::separation_settings::SeparationSettings;

/// Separation of the pair that requests the lowest speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Separation {
    /// The two bodies; `None`: no monitored pair is within the range of the monitoring.
    pub bodies: Option<(BodyId, BodyId)>,
    /// Distance (m); infinite without a pair.
    pub distance: f64,
    /// Rate (m/s) at which the motion of the robot reduces the distance; negative: it grows. `None`: unknown.
    pub approach_speed: Option<f64>,
    /// Largest rate (m/s) that is allowed.
    pub allowed_speed: f64,
    /// Protective separation distance (m) at the approach speed, or at the largest one if it is unknown.
    pub protective_distance: f64,
    /// Share of the speed that the pair requests, in [0, 1].
    pub share: f64,
}

impl Separation {
    /// No monitored pair is within the range.
    pub(super) fn out_of_range(settings: &SeparationSettings) -> Self {
        Self {
            bodies: None,
            distance: f64::INFINITY,
            approach_speed: None,
            allowed_speed: settings.robot_speed,
            protective_distance: settings.protective_distance(settings.robot_speed),
            share: 1.0,
        }
    }

    /// A pair at a distance (m), with the rates (m/s) at which the robot brings its nearest points together, and at most
    /// any of its points, if they are known.
    pub(super) fn of_pair(
        settings: &SeparationSettings,
        bodies: (BodyId, BodyId),
        distance: f64,
        [approach_speed, largest]: [Option<f64>; 2],
    ) -> Self {
        let speed = approach_speed.unwrap_or(settings.robot_speed);
        Self {
            bodies: Some(bodies),
            distance,
            approach_speed,
            allowed_speed: settings.allowed_speed(distance),
            protective_distance: settings.protective_distance(speed.greater(0.0)),
            share: settings.share(distance, approach_speed, largest),
        }
    }

    /// The one of two that requests the lower share; of equal ones, the nearer one.
    pub(super) fn lower(self, other: Self) -> Self {
        let key = |separation: &Self| (separation.share, separation.distance);
        if key(&other) < key(&self) { other } else { self }
    }
}
