//! Adds the moving obstacles of a motion request to its trajectory: known motions, and motion within limits. No I/O.

use std::sync::Arc;

use clearance_geometry::math::pose_from_xyz_quaternion;
use clearance_motion::{
    ObstacleLimits, ObstacleTextError, ObstacleTrajectory, PosesError, SpeedLimit, Trajectory,
};
use clearance_scene::World;

use crate::messages::clearance_msgs::{MovingObstacle, ObstacleLimit};
use crate::messages::clearance_srvs::MotionTerms;
use crate::services::request_fields::not_negative;
use crate::services::request_rejection::{RequestRejection, bad_request};

/// The trajectory with the obstacles that move in a request; without any, obstacles stand.
pub fn with_requested_obstacles(
    trajectory: Trajectory,
    terms: &MotionTerms,
    world: &World,
) -> Result<Trajectory, RequestRejection> {
    let trajectory = with_moving_obstacles(trajectory, &terms.moving_obstacles, world)?;
    with_obstacle_limits(trajectory, terms, world)
}

/// Adds motions that are known.
fn with_moving_obstacles(
    trajectory: Trajectory,
    obstacles: &[MovingObstacle],
    world: &World,
) -> Result<Trajectory, RequestRejection> {
    if obstacles.is_empty() {
        return Ok(trajectory);
    }
    needs_times("moving_obstacles", &trajectory)?;
    let rejected = |error: &dyn std::fmt::Display| bad_request(format!("moving_obstacles: {error}"));
    let read = |(i, obstacle): (usize, &MovingObstacle)| {
        let name = &obstacle.name;
        if obstacles[..i].iter().any(|before| before.name == *name) {
            return Err(rejected(&format!("'{name}' occurs twice")));
        }
        obstacle_trajectory(obstacle, world).map_err(|error| rejected(&error))
    };
    let obstacles = obstacles.iter().enumerate().map(read).collect::<Result<Vec<_>, _>>()?;
    trajectory.with_obstacles(world, &obstacles).map_err(|error| rejected(&error))
}

fn obstacle_trajectory(
    MovingObstacle { name, twist, centre, poses, times }: &MovingObstacle,
    world: &World,
) -> Result<ObstacleTrajectory, ObstacleTextError> {
    let known = world.obstacle_by_name(name).ok_or_else(|| ObstacleTextError::Unknown(name.clone()))?;
    let number = |what: String| ObstacleTextError::Number { name: name.clone(), what };
    let [linear, angular] = [&twist.linear, &twist.angular].map(|v| [v.x, v.y, v.z]);
    let moves = [linear, angular] != [[0.0; 3]; 2];
    let centre = match centre.as_slice() {
        [] => None,
        [centre] => Some([centre.x, centre.y, centre.z]),
        _ => return Err(number("centre, of which there are several,".to_owned())),
    };
    match poses.as_slice() {
        [] if moves && times.is_empty() => ObstacleTrajectory::of_twist(known, centre, linear, angular),
        poses if !poses.is_empty() && !moves && centre.is_none() => {
            if times.len() != poses.len() {
                let (times, poses) = (times.len(), poses.len());
                let error = PosesError::TimeCount { times, poses };
                return Err(ObstacleTextError::Poses { name: name.clone(), error });
            }
            let placed = poses.iter().zip(times).enumerate().map(|(i, (pose, time))| {
                let (p, q) = (&pose.position, &pose.orientation);
                let pose = pose_from_xyz_quaternion([p.x, p.y, p.z], [q.x, q.y, q.z, q.w]);
                Ok((*time, pose.ok_or_else(|| number(format!("pose {i}")))?))
            });
            ObstacleTrajectory::through(name, &placed.collect::<Result<Vec<_>, _>>()?)
                .map_err(|error| ObstacleTextError::Poses { name: name.clone(), error })
        }
        _ => Err(ObstacleTextError::TwistOrPoses(name.clone())),
    }
}

/// Lets obstacles move within limits, in addition to motions that are known.
fn with_obstacle_limits(
    trajectory: Trajectory,
    terms: &MotionTerms,
    world: &World,
) -> Result<Trajectory, RequestRejection> {
    let latency = terms.obstacle_latency;
    not_negative("obstacle_latency", "s", latency)?;
    if terms.obstacle_limits.is_empty() {
        if latency > 0.0 {
            return Err(bad_request("obstacle_latency belongs to obstacle_limits, and there are none"));
        }
        return Ok(trajectory);
    }
    needs_times("obstacle_limits", &trajectory)?;
    let rejected = |error: &dyn std::fmt::Display| bad_request(format!("obstacle_limits: {error}"));
    let limits = terms.obstacle_limits.iter().map(|ObstacleLimit { name, speed, acceleration }| {
        let name = Some(name.clone()).filter(|name| !name.is_empty());
        (name, SpeedLimit { speed: *speed, acceleration: *acceleration })
    });
    let limits = Arc::new(ObstacleLimits::from_list(limits).map_err(|error| rejected(&error))?);
    trajectory.with_obstacle_limits(world, &limits, latency).map_err(|error| rejected(&error))
}

/// Rejects motions without times.
fn needs_times(what: &str, trajectory: &Trajectory) -> Result<(), RequestRejection> {
    if trajectory.time(0, 0.0).is_some() {
        return Ok(());
    }
    Err(bad_request(format!(
        "{what} need times: give the motion a duration, or the points of the trajectory time_from_start"
    )))
}

#[cfg(test)]
mod tests;
