//! Bounds on the motion of the root after a state: obstacles are displaced by it in the root frame.
//!
//! Distances between the robot and obstacles change at most by the way of the robot's points in the obstacles' frame.
//! With the speed v and the angular speed w of the root at the state, and its largest accelerations a and b, a point that
//! stays within the distance R of the root goes at most (v + w R) t + ½ (a + b R) t² in a time t.

use clearance_checker::CollisionChecker;
use clearance_geometry::math::Extremes;
use clearance_motion::SpeedLimit;
use clearance_robot::{LinkPoses, quoted};

use super::Time;
use super::look_ahead::LookAheadInput;
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
    /// The motion that is possible after a state, with largest accelerations (m/s², rad/s²) of the root, where 0 is
    /// unknown; `None` if the root stays. The error is why it is not known.
    pub fn after(
        input: &LookAheadInput,
        checker: &CollisionChecker,
        joints: &JointRanges,
        accelerations: [f64; 2],
    ) -> Result<Option<Self>, String> {
        let &LookAheadInput { obstacle_motions, poses, stamp, unwatched_frame, .. } = input;
        if accelerations.contains(&0.0) {
            let moving = obstacle_motions.iter().find(|obstacle_motion| !obstacle_motion.is_none());
            return moving.map_or(Ok(None), |ObstacleMotion { frame, .. }| {
                Err(format!(
                    "the robot's root moves in {}: set look_ahead_root_acceleration and \
                     look_ahead_root_angular_acceleration",
                    quoted(frame)
                ))
            });
        }
        if let Some(frame) = unwatched_frame {
            let frame = quoted(frame);
            return Err(format!(
                "the speed of the robot's root in {frame} is not known until tf publishes it again"
            ));
        }
        if obstacle_motions.is_empty() {
            return Ok(None);
        }
        let radius = joints.extent(checker, poses);
        if !radius.is_finite() {
            return Err(
                "the robot's root moves, and nothing bounds how far its prismatic joints reach".to_owned()
            );
        }
        Self::of_frames(obstacle_motions, accelerations, radius, stamp).map(Some)
    }

    /// From the motion that `tf` shows of the root in each frame of obstacles.
    fn of_frames(
        motions: &[ObstacleMotion],
        accelerations: [f64; 2],
        radius: f64,
        stamp: Time,
    ) -> Result<Self, String> {
        let mut fastest = Self { limit: SpeedLimit::default(), latency: 0.0 };
        for motion in motions {
            let speed = motion.largest_speed(radius, accelerations).ok_or_else(|| {
                let frame = quoted(&motion.frame);
                format!("the speed of the robot's root in {frame} is not known until tf publishes it again")
            })?;
            let SpeedLimit { speed: before, acceleration } = fastest.limit;
            fastest.limit = SpeedLimit {
                speed: speed.greater(before),
                acceleration: motion.largest_acceleration(radius, accelerations).greater(acceleration),
            };
            fastest.latency = fastest.latency.greater(motion.age(stamp));
        }
        Ok(fastest)
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
