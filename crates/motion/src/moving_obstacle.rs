//! Moving obstacle with a constant twist.

use clearance_geometry::constants::LARGEST_COORDINATE;
use clearance_geometry::math::{Extremes, MatrixPose, Point, Pose, Rotation, Vector};
use serde::{Deserialize, Serialize};

/// Motion of an obstacle while t goes from 0 to 1: its pose is displaced by a translation of `linear` and a rotation about `centre`,
/// which is translated with it. At t = 0 it has its pose in the world. All in the robot's root frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MovingObstacle {
    /// Name of the obstacle.
    pub name: String,
    /// The point (m) that is only translated, at t = 0.
    pub centre: [f64; 3],
    /// Translation (m) from t = 0 to t = 1.
    pub linear: [f64; 3],
    /// Rotation (rad) from t = 0 to t = 1: an axis times an angle.
    pub angular: [f64; 3],
    /// A displacement that exists already at t = 0, before the rotation and the translation: position and quaternion (x, y, z, w).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<([f64; 3], [f64; 4])>,
}

/// The zero displacement: the obstacle's pose in the world.
pub(super) const NO_DISPLACEMENT: ([f64; 3], [f64; 4]) = ([0.0; 3], [0.0, 0.0, 0.0, 1.0]);

impl MovingObstacle {
    /// From one displacement to another, with constant translation and rotation, by the shortest direction; `centre` is a point of the
    /// obstacle at its pose in the world.
    #[must_use]
    pub fn between(name: &str, centre: Point, from: &Pose, to: &Pose) -> Self {
        let (start, end) = (from * centre, to * centre);
        let turn = (to.rotation * from.rotation.inverse()).scaled_axis();
        let q = from.rotation.coords;
        Self {
            name: name.to_owned(),
            centre: start.coords.into(),
            linear: (end - start).into(),
            angular: turn.into(),
            start: Some((from.translation.vector.into(), [q.x, q.y, q.z, q.w])),
        }
    }

    /// Displacement of the obstacle at t from its pose in the world.
    #[must_use]
    pub fn displacement(&self, t: f64) -> Pose {
        let centre = Vector::from(self.centre);
        let turn = Rotation::from_scaled_axis(Vector::from(self.angular) * t);
        let shift = centre + Vector::from(self.linear) * t - turn * centre;
        let moved = Pose::from_parts(shift.into(), turn);
        match self.start {
            Some((xyz, [x, y, z, w])) => {
                let rotation = Rotation::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
                moved * Pose::from_parts(xyz.into(), rotation)
            }
            None => moved,
        }
    }

    /// Its motion between two values of t, which may be beyond 1, as a motion of its own.
    #[must_use]
    pub fn part(&self, [from, to]: [f64; 2]) -> Self {
        let [centre, linear, angular] = [self.centre, self.linear, self.angular].map(Vector::from);
        let start = self.displacement(from);
        let q = start.rotation.coords;
        Self {
            name: self.name.clone(),
            centre: (centre + linear * from).into(),
            linear: (linear * (to - from)).into(),
            angular: (angular * (to - from)).into(),
            start: (from != 0.0 || self.start.is_some())
                .then(|| (start.translation.vector.into(), [q.x, q.y, q.z, q.w])),
        }
    }

    /// The displacement at t = 0 as it is written: position and quaternion, exact.
    pub(super) fn start_numbers(&self) -> ([f64; 3], [f64; 4]) {
        self.start.unwrap_or(NO_DISPLACEMENT)
    }

    /// True if it does not move.
    #[must_use]
    pub fn stands(&self) -> bool {
        self.linear == [0.0; 3] && self.angular == [0.0; 3]
    }

    /// [`Self::displacement`], as a matrix.
    #[must_use]
    pub fn matrix(&self, t: f64) -> MatrixPose {
        MatrixPose::from(&self.displacement(t))
    }

    /// Upper bound (m, rad) on the numbers that define it.
    #[must_use]
    pub fn size(&self) -> f64 {
        let start = self.start.map_or([0.0; 3], |(xyz, _)| xyz);
        let all = [self.centre, self.linear, self.angular, start];
        all.iter().flatten().map(|x| x.abs()).fold(0.0, f64::greater)
    }

    /// True if all numbers are in the range of the computation and the start is a valid pose.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        let finite = |v: &[f64]| v.iter().all(|x| x.abs() <= LARGEST_COORDINATE);
        finite(&self.centre)
            && finite(&self.linear)
            && finite(&self.angular)
            && self.start.is_none_or(|(xyz, q)| {
                let length = q.iter().map(|c| c * c).sum::<f64>().sqrt();
                finite(&xyz) && (length - 1.0).abs() < 1e-3
            })
    }
}
