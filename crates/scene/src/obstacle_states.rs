//! Poses and velocities of tracked obstacles: data types, and their application to the scene.

use std::collections::{BTreeMap, HashSet};
use std::time::Duration;

use clearance_geometry::math::{Pose, Vector};
use clearance_robot::quoted;

use super::anchor::is_elsewhere;
use super::{ObjectChange, Operation, Scene, SceneContext, SceneRejection, Time};

/// Time (s) by which the stamp of a state may be later than the clock. A later one is of a clock that was set back.
const LARGEST_LEAD: f64 = 1.0;

/// Largest number of poses that are kept of one obstacle: more than a history of poses takes without being cut.
const MOST_POSES: usize = 2048;

/// Pose and velocity of an obstacle of the world: `clearance_msgs/ObstacleState`.
#[derive(Clone, Debug)]
pub struct ObstacleState {
    /// Name of the obstacle.
    pub id: String,
    /// The frame of its pose and velocity; if empty, the robot's root frame.
    pub frame: String,
    /// Pose of the obstacle in that frame.
    pub pose_fo: Pose,
    /// Velocity (m/s) of the obstacle's origin, along the axes of that frame.
    pub linear_f: Vector,
    /// Angular velocity (rad/s), along the axes of that frame.
    pub angular_f: Vector,
}

/// States of obstacles at one time.
#[derive(Clone, Debug)]
pub struct ObstacleStates {
    /// The time.
    pub stamp: Time,
    /// Time of reception (steady clock).
    pub received: Duration,
    /// One for each obstacle.
    pub states: Vec<ObstacleState>,
}

/// Velocity of an obstacle at the time of its pose. It is given in the obstacle's frame, so that it stays the same while
/// the robot moves among its obstacles.
#[derive(Clone, Debug, PartialEq)]
pub struct ObstacleTwist {
    /// Name of the obstacle.
    pub name: String,
    /// Velocity (m/s) of its origin.
    pub linear_o: Vector,
    /// Angular velocity (rad/s).
    pub angular_o: Vector,
    /// Time of the pose and the velocity.
    pub stamp: Time,
    /// Time of reception (steady clock).
    pub received: Duration,
}

impl ObstacleTwist {
    /// True if the obstacle moves.
    #[must_use]
    pub fn moves(&self) -> bool {
        [self.linear_o, self.angular_o] != [Vector::zeros(); 2]
    }
}

impl ObstacleState {
    /// The change that moves the obstacle to its pose.
    pub(super) fn change(&self) -> ObjectChange {
        let change = ObjectChange::named(self.id.clone(), Operation::Move);
        ObjectChange { frame: self.frame.clone(), pose_fo: self.pose_fo, ..change }
    }
}

impl Scene {
    /// Velocities of the obstacles with known ones, in the order of their names.
    pub fn obstacle_twists(&self) -> impl Iterator<Item = &ObstacleTwist> {
        self.twists.values().filter(|twist| self.world.id(&twist.name).is_some())
    }

    /// Poses, in the root frame, that states gave obstacles since the last call, by name, oldest first; at most 2048 of each.
    pub fn take_state_poses(&mut self) -> BTreeMap<String, Vec<Pose>> {
        std::mem::take(&mut self.state_poses)
    }

    /// Moves obstacles to their poses and notes their velocities. Returns one result for each state.
    pub(super) fn set_states(
        &mut self,
        given: &ObstacleStates,
        context: &SceneContext,
    ) -> Vec<Result<(), SceneRejection>> {
        let mut names = HashSet::new();
        let mut results = Vec::new();
        for state in &given.states {
            results.push(if names.insert(state.id.as_str()) {
                self.set_state(state, given, context)
            } else {
                let why = "a message gives it twice: give each obstacle once";
                Err(SceneRejection::of(&state.id, why).of_pose())
            });
        }
        results
    }

    fn set_state(
        &mut self,
        state: &ObstacleState,
        ObstacleStates { stamp, received, .. }: &ObstacleStates,
        context: &SceneContext,
    ) -> Result<(), SceneRejection> {
        let ObstacleState { id, pose_fo, linear_f, angular_f, .. } = state;
        self.check_is_obstacle(id)?;
        self.check_is_newest(id, *stamp, context.now)?;
        if !context.stands_still(&state.frame, self) {
            let frame = quoted(&state.frame);
            let why = format!(
                "header.frame_id: {frame} moves with the robot: give states in a frame that does not move with the robot"
            );
            return Err(SceneRejection::of(id, why).of_pose());
        }
        self.change_object(&state.change(), context, &mut Vec::new())?;
        let [linear_o, angular_o] = [linear_f, angular_f].map(|v| pose_fo.rotation.inverse() * v);
        let twist =
            ObstacleTwist { name: id.clone(), linear_o, angular_o, stamp: *stamp, received: *received };
        self.twists.insert(id.clone(), twist);
        if let Some(obstacle) = self.world.obstacle_by_name(id) {
            let poses = self.state_poses.entry(id.clone()).or_default();
            let is_new = poses.last().is_none_or(|last| is_elsewhere(last, &obstacle.pose_ro));
            if is_new && poses.len() < MOST_POSES {
                poses.push(obstacle.pose_ro);
            }
        }
        Ok(())
    }

    /// An older state than the last one, as of a second tracker, changes nothing, unless the clock was set back since the last one.
    fn check_is_newest(&self, id: &str, stamp: Time, now: Option<Time>) -> Result<(), SceneRejection> {
        let Some(known) = self.twists.get(id) else { return Ok(()) };
        let delay = known.stamp.seconds_since(stamp);
        if delay <= 0.0 || now.is_some_and(|now| now.seconds_since(known.stamp) < -LARGEST_LEAD) {
            return Ok(());
        }
        let why =
            format!("header.stamp is {delay:.3} s older than that of its last state: the state is dropped");
        Err(SceneRejection::of(id, why).without_gap())
    }

    fn check_is_obstacle(&self, id: &str) -> Result<(), SceneRejection> {
        if let Some(held) = self.world.attached_by_name(id) {
            let why =
                format!("it is attached to link '{}' and moves with it: its state is not used", held.link);
            return Err(SceneRejection::of(id, why).without_gap());
        }
        if !id.is_empty() && self.world.id(id).is_none() {
            let why = "the world has no such obstacle: add it, and then send its state";
            return Err(SceneRejection::of(id, why).of_pose());
        }
        Ok(())
    }
}
