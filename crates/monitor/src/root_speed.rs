//! How far the root may move after a state: obstacles are displaced by it in the root frame.
//!
//! Distances between the robot and obstacles change at most by the way of the robot's points in the obstacles' frame. With
//! the speed v and the angular speed w of the root at the state, and its largest accelerations a and b, a point that stays
//! within the distance R of the root goes at most (v + w R) t + ½ (a + b R) t² in a time t.

use clearance_checker::CollisionChecker;
use clearance_geometry::math::Extremes;
use clearance_motion::SpeedLimit;
use clearance_robot::LinkPoses;

use super::Time;
use super::obstacle_motion::ObstacleMotion;

/// Motion of the root that is possible after a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RootSpeed {
    /// Limit of the speed and acceleration of any point of the robot by the motion of the root.
    pub limit: SpeedLimit,
    /// Time (s) by which its pose may be older than the state.
    pub latency: f64,
}

/// Possible motions of the joints until a time.
pub(super) struct JointRanges<'j> {
    /// Positions at the state.
    pub positions: &'j [f64],
    /// Velocities, by position.
    pub velocities: &'j [f64],
    /// Largest accelerations, by position.
    pub accelerations: &'j [f64],
    /// The time (s).
    pub horizon: f64,
}

impl RootSpeed {
    /// From the motion that `tf` shows of the root in each frame of obstacles, and its largest accelerations (m/s²,
    /// rad/s²), at the stamp of a state; `None` if nothing places the root. The error is the frame in which the speed of the root is not known yet.
    pub fn new(
        motions: &[ObstacleMotion],
        accelerations: [f64; 2],
        radius: f64,
        stamp: Time,
    ) -> Result<Option<Self>, &str> {
        let moving = || motions.iter().filter(|motion| motion.may_move());
        let mut speed = 0.0_f64;
        for motion in moving() {
            speed = speed.greater(motion.largest_speed(radius, accelerations).ok_or(&*motion.frame)?);
        }
        let turned = if accelerations[1] > 0.0 { accelerations[1] * radius } else { 0.0 };
        let limit = SpeedLimit { speed, acceleration: accelerations[0] + turned };
        let latency = moving().map(|motion| motion.age(stamp)).fold(0.0, f64::greater);
        Ok(moving().next().map(|_| Self { limit, latency }))
    }
}

impl JointRanges<'_> {
    /// Upper bound (m) on the distance of any point of the robot from its root.
    pub fn extent(&self, checker: &CollisionChecker, poses: &LinkPoses) -> f64 {
        let farthest = |i: usize| {
            let way = self.velocities[i].abs() + 0.5 * self.accelerations[i] * self.horizon;
            way * self.horizon
        };
        let later: Vec<f64> = (0..self.positions.len()).map(|i| self.positions[i] + farthest(i)).collect();
        let by_travel = checker.extent(poses) + checker.travel(self.positions, &later);
        let range_of = |i: usize| Some(self.positions[i] - farthest(i)..=self.positions[i] + farthest(i));
        by_travel.lesser(checker.largest_extent(range_of))
    }
}
