//! Obstacle trajectory: motion with a constant twist, or through timed poses.

use clearance_geometry::math::{Point, Pose};
use clearance_scene::World;

use super::trajectory::Part;
use super::{MovingObstacle, Trajectory, TrajectoryError};

/// Motion of an obstacle of the world over the time of a [`Trajectory`] (s). For a motion without times, time goes from 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct ObstacleTrajectory {
    name: String,
    course: Course,
}

#[derive(Clone, Debug, PartialEq)]
enum Course {
    /// Motion in one unit of time, from 0 on; it continues at constant velocity.
    Even(MovingObstacle),
    /// One more time than pieces.
    Poses { times: Vec<f64>, pieces: Vec<MovingObstacle> },
}

/// Rotation (rad) between two poses above which the shortest direction is ambiguous.
const CLEAR_TURN: f64 = std::f64::consts::PI - 0.01;

/// Reason why poses are not a valid trajectory.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the message of each variant describes it and its fields")]
pub enum PosesError {
    #[error("two poses at least are needed, but there are {0}")]
    TooFew(usize),
    #[error("{poses} poses need as many times, but there are {times}")]
    TimeCount { times: usize, poses: usize },
    #[error("pose {pose}: its time {time} is negative, not finite, or not after that of the last pose")]
    Time { pose: usize, time: f64 },
    #[error(
        "pose {0} is half a turn from the last one, so that it is not clear which way round: give one in between"
    )]
    HalfTurn(usize),
}

impl ObstacleTrajectory {
    /// A constant twist without end: at time 0 the obstacle has its pose in the world. `linear` (m/s) is the velocity of `centre` (m, at
    /// time 0), `angular` (rad/s) an axis times a speed; all in the robot's root frame.
    #[must_use]
    pub fn even(name: &str, centre: Point, linear: [f64; 3], angular: [f64; 3]) -> Self {
        let name = name.to_owned();
        let unit =
            MovingObstacle { name: name.clone(), centre: centre.coords.into(), linear, angular, start: None };
        Self { name, course: Course::Even(unit) }
    }

    /// Through poses (robot's root frame) of any frame that moves with the obstacle, each at its time (s); at the first one the obstacle
    /// has its pose in the world. Between two poses the frame's origin moves on a straight line and the frame rotates at constant speed,
    /// by the shortest direction.
    pub fn through(name: &str, poses: &[(f64, Pose)]) -> Result<Self, PosesError> {
        let &[(_, first), _, ..] = poses else { return Err(PosesError::TooFew(poses.len())) };
        for (pose, &(time, _)) in poses.iter().enumerate() {
            let later = pose == 0 || time > poses[pose - 1].0;
            if !(later && time >= 0.0 && time.is_finite()) {
                return Err(PosesError::Time { pose, time });
            }
        }
        let (centre, back) = (Point::from(first.translation.vector), first.inverse());
        let pieces = poses.windows(2).enumerate().map(|(i, two)| {
            let [from, to] = [two[0].1, two[1].1];
            if from.rotation.angle_to(&to.rotation) > CLEAR_TURN {
                return Err(PosesError::HalfTurn(i + 1));
            }
            // at its first pose it has exactly its pose in the world, without rounding
            let start = if i == 0 { Pose::identity() } else { from * back };
            Ok(MovingObstacle::between(name, centre, &start, &(to * back)))
        });
        let pieces = pieces.collect::<Result<_, _>>()?;
        let times = poses.iter().map(|(time, _)| *time).collect();
        Ok(Self { name: name.to_owned(), course: Course::Poses { times, pieces } })
    }

    /// Name of the obstacle.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Times at which its velocity may change; none if it is constant.
    fn times(&self) -> &[f64] {
        match &self.course {
            Course::Even(_) => &[],
            Course::Poses { times, .. } => times,
        }
    }

    /// Its motion between two times, with none of its own times in between.
    fn between(&self, [from, to]: [f64; 2]) -> MovingObstacle {
        match &self.course {
            Course::Even(unit) => unit.part([from, to]),
            Course::Poses { times, pieces } => {
                let piece = times.partition_point(|time| *time <= from).clamp(1, pieces.len()) - 1;
                let [begin, end] = [times[piece], times[piece + 1]];
                pieces[piece].part([from, to].map(|time| (time - begin) / (end - begin)))
            }
        }
    }
}

impl Trajectory {
    /// Adds moving obstacles of `world`, with the same time. A segment during which an obstacle reaches one of its poses is split there:
    /// [`Self::origin`] gives the original segment.
    ///
    /// # Errors
    /// If several segments have no times, an obstacle's poses do not cover the whole time, or the world has no such obstacle.
    pub fn with_obstacles(
        self,
        world: &World,
        obstacles: &[ObstacleTrajectory],
    ) -> Result<Self, TrajectoryError> {
        let clock = self.clock()?;
        check_pieces(self.segments().len(), obstacles)?;
        for obstacle in obstacles {
            covers(obstacle, [clock[0], clock[clock.len() - 1]])?;
        }
        let (mut segments, mut parts, mut times) = (Vec::new(), Vec::new(), vec![clock[0]]);
        for (segment, motion) in self.segments().iter().enumerate() {
            let [from, to] = [clock[segment], clock[segment + 1]];
            let mut begin = from;
            for end in cuts(obstacles, [from, to]) {
                let t = [begin, end].map(|time| (time - from) / (to - from));
                let part = motion.part(t);
                let mut movers = part.obstacles().to_vec();
                movers.extend(obstacles.iter().map(|obstacle| obstacle.between([begin, end])));
                let part = part.with_obstacles(world, movers);
                segments.push(part.map_err(|error| TrajectoryError::Segment { segment, error })?);
                let [(segment, from), (_, to)] = t.map(|t| self.origin(segment, t));
                parts.push(Part { segment, t: [from, to] });
                times.push(end);
                begin = end;
            }
        }
        Ok(self.cut(segments, parts, times))
    }
}

/// Times (s) that differ by less are equal: those of ROS are in nanoseconds.
const SAME_TIME: f64 = 1e-9;

/// Most pieces of motions of obstacles in one trajectory.
const MOST_PIECES: usize = 200_000;

/// Rejects so many poses that they take too much memory.
fn check_pieces(segments: usize, obstacles: &[ObstacleTrajectory]) -> Result<(), TrajectoryError> {
    let poses: usize = obstacles.iter().map(|obstacle| obstacle.times().len()).sum();
    let pieces = (segments + poses).saturating_mul(obstacles.len());
    let most = MOST_PIECES;
    if pieces <= most { Ok(()) } else { Err(TrajectoryError::TooManyPieces { pieces, most }) }
}

/// Rejects poses that begin too late or end too early.
fn covers(obstacle: &ObstacleTrajectory, motion: [f64; 2]) -> Result<(), TrajectoryError> {
    let (Some(&from), Some(&to)) = (obstacle.times().first(), obstacle.times().last()) else { return Ok(()) };
    if from <= motion[0] + SAME_TIME && motion[1] <= to + SAME_TIME {
        return Ok(());
    }
    Err(TrajectoryError::ObstacleTimes { name: obstacle.name.clone(), poses: [from, to], motion })
}

/// Times at which an interval must be split, so that all obstacles move at constant velocity in each part: those in between, and its end.
fn cuts(obstacles: &[ObstacleTrajectory], [from, to]: [f64; 2]) -> Vec<f64> {
    let within = |obstacle: &ObstacleTrajectory| {
        let times = obstacle.times();
        let [begin, end] = [times.partition_point(|t| *t <= from), times.partition_point(|t| *t < to)];
        times[begin.min(end)..end].to_vec()
    };
    let mut cuts: Vec<f64> = obstacles.iter().flat_map(within).collect();
    cuts.push(to);
    cuts.sort_unstable_by(f64::total_cmp);
    cuts.dedup();
    cuts
}

#[cfg(test)]
mod tests;
