//! Motions of obstacles, known or within limits: YAML files, validation against the world (also for service requests), and trajectories
//! among them.

use std::sync::Arc;

use clearance_files::yaml;
use clearance_geometry::Shape;
use clearance_geometry::constants::LARGEST_COORDINATE;
use clearance_geometry::math::{Point, Pose, pose_from_xyz_quaternion};
use clearance_scene::{Obstacle, World};
use serde::Deserialize;

use super::{
    LimitError, ObstacleLimits, ObstacleTrajectory, PosesError, START_TOLERANCE, SpeedLimit, Trajectory,
    TrajectoryError,
};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileText {
    #[serde(default)]
    moving_obstacles: Vec<ObstacleText>,
    #[serde(default)]
    obstacle_limits: Vec<LimitText>,
    #[serde(default)]
    obstacle_latency: f64,
}

/// Without a name: the limit of all obstacles without one of their own.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LimitText {
    name: Option<String>,
    speed: f64,
    #[serde(default)]
    acceleration: f64,
}

/// Motions of obstacles from a file: those that are known, and limits of all others.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObstacleMotions {
    /// Obstacles whose motion is known.
    pub trajectories: Vec<ObstacleTrajectory>,
    /// How fast obstacles may move besides.
    pub limits: Arc<ObstacleLimits>,
    /// Time (s) by which the poses of the obstacles are older than the start of the trajectory.
    pub latency: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ObstacleText {
    name: String,
    linear: Option<[f64; 3]>,
    angular: Option<[f64; 3]>,
    centre: Option<[f64; 3]>,
    poses: Option<Vec<PoseText>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PoseText {
    time: f64,
    position: [f64; 3],
    #[serde(default = "no_turn")]
    orientation: [f64; 4],
}

fn no_turn() -> [f64; 4] {
    [0.0, 0.0, 0.0, 1.0]
}

/// Reason why a text does not describe the motion of obstacles.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the message of each variant describes it and its fields")]
pub enum ObstacleTextError {
    /// The message of the parser contains the location.
    #[error("{0}")]
    Text(String),
    #[error("moving_obstacles and obstacle_limits are empty")]
    Empty,
    #[error("obstacle_limits: {0}")]
    Limit(LimitError),
    #[error("obstacle_latency is {0} s, but must be finite and not negative")]
    Latency(f64),
    #[error("obstacle_latency belongs to obstacle_limits, and there are none")]
    LatencyWithoutLimits,
    #[error("obstacle '{0}' is to move, but the world has no such obstacle")]
    Unknown(String),
    #[error("obstacle '{0}': give linear or angular (and centre), or poses, but not both")]
    TwistOrPoses(String),
    #[error("obstacle '{0}' turns, and is not a single solid primitive: give the centre that it turns about")]
    NoCentre(String),
    #[error("obstacle '{name}': {what} is not finite, larger than {LARGEST_COORDINATE:e}, or no rotation")]
    Number { name: String, what: String },
    #[error("obstacle '{name}': {error}")]
    Poses { name: String, error: PosesError },
    #[error(
        "obstacle '{name}': its first pose is {first}, but the world has it at {world}, and nothing between the two would be \
         checked: make the pose in the world the first one, or correct the world"
    )]
    Start { name: String, first: String, world: String },
}

impl ObstacleMotions {
    /// Reads YAML or JSON. `moving_obstacles` is a list of obstacles of `world` by `name`. Each has either a twist (`linear` in m/s,
    /// `angular` in rad/s, `centre` in m; missing values are zero, and a missing centre is the centre of the obstacle's only shape, if
    /// that is a solid primitive), or `poses`, each with a `time` (s), a `position` (m) and an `orientation` (x, y, z, w; the identity if
    /// missing). All are in the robot's root frame and in the trajectory's time, see [`ObstacleTrajectory::even`] and
    /// [`ObstacleTrajectory::through`]. The first pose must be the one in the world, of the obstacle or of its only shape, within
    /// [`START_TOLERANCE`]. `obstacle_limits` is a list of limits: the `speed` (m/s) and the `acceleration`
    /// (m/s², 0 if missing) of the obstacle with this `name`, or of all others. `obstacle_latency` (s, 0 if missing) belongs
    /// to the limits.
    pub fn from_yaml(text: &str, world: &World) -> Result<Self, ObstacleTextError> {
        let text: FileText = yaml::from_text(text).map_err(ObstacleTextError::Text)?;
        if text.moving_obstacles.is_empty() && text.obstacle_limits.is_empty() {
            return Err(ObstacleTextError::Empty);
        }
        let latency = text.obstacle_latency;
        if !(latency.is_finite() && latency >= 0.0) {
            return Err(ObstacleTextError::Latency(latency));
        }
        if latency > 0.0 && text.obstacle_limits.is_empty() {
            return Err(ObstacleTextError::LatencyWithoutLimits);
        }
        let limits = text
            .obstacle_limits
            .into_iter()
            .map(|LimitText { name, speed, acceleration }| (name, SpeedLimit { speed, acceleration }));
        let limits = Arc::new(ObstacleLimits::from_list(limits).map_err(ObstacleTextError::Limit)?);
        let trajectories =
            text.moving_obstacles.into_iter().map(|o| o.read(world)).collect::<Result<_, _>>()?;
        Ok(Self { trajectories, limits, latency })
    }
}

impl Trajectory {
    /// The same trajectory among obstacles that move so. A single segment without times lasts from time 0 to 1.
    pub fn with_obstacle_motions(
        self,
        world: &World,
        motions: &ObstacleMotions,
    ) -> Result<Self, TrajectoryError> {
        let ObstacleMotions { trajectories, limits, latency } = motions;
        let has_limits = !limits.is_zero();
        let has_no_times = self.time(0, 0.0).is_none();
        let timed = if has_limits && has_no_times && self.segments().len() == 1 {
            self.with_times(vec![0.0, 1.0])?
        } else {
            self
        };
        let moved = timed.with_obstacles(world, trajectories)?;
        if has_limits { moved.with_obstacle_limits(world, limits, *latency) } else { Ok(moved) }
    }
}

impl ObstacleText {
    fn read(self, world: &World) -> Result<ObstacleTrajectory, ObstacleTextError> {
        let obstacle = world
            .obstacle_by_name(&self.name)
            .ok_or_else(|| ObstacleTextError::Unknown(self.name.clone()))?;
        let twist = self.linear.is_some() || self.angular.is_some();
        match &self.poses {
            Some(poses) if !twist && self.centre.is_none() => through(obstacle, poses),
            None if twist => self.even(obstacle),
            _ => Err(ObstacleTextError::TwistOrPoses(self.name)),
        }
    }

    fn even(&self, obstacle: &Obstacle) -> Result<ObstacleTrajectory, ObstacleTextError> {
        let [linear, angular] = [self.linear, self.angular].map(Option::unwrap_or_default);
        ObstacleTrajectory::of_twist(obstacle, self.centre, linear, angular)
    }
}

impl ObstacleTrajectory {
    /// As [`Self::even`], for an obstacle of the world. Without a centre (m), its only primitive turns about its own centre.
    ///
    /// # Errors
    /// If a number is not finite or too large, or a centre is needed: the obstacle turns, and is not a single primitive.
    pub fn of_twist(
        obstacle: &Obstacle,
        centre: Option<[f64; 3]>,
        linear: [f64; 3],
        angular: [f64; 3],
    ) -> Result<Self, ObstacleTextError> {
        let name = || obstacle.name.clone();
        let centre = match (centre, &*obstacle.shapes) {
            (Some(centre), _) => centre,
            (None, [shape]) if matches!(shape.shape, Shape::Primitive(_)) => {
                (obstacle.pose_ro * shape.pose_os).translation.vector.into()
            }
            // without rotation all points move alike
            (None, _) if angular == [0.0; 3] => [0.0; 3],
            (None, _) => return Err(ObstacleTextError::NoCentre(name())),
        };
        for (what, numbers) in [("linear", linear), ("angular", angular), ("centre", centre)] {
            if !numbers.iter().all(|x| x.abs() <= LARGEST_COORDINATE) {
                return Err(ObstacleTextError::Number { name: name(), what: what.to_owned() });
            }
        }
        Ok(Self::even(&obstacle.name, Point::from(centre), linear, angular))
    }
}

fn through(obstacle: &Obstacle, poses: &[PoseText]) -> Result<ObstacleTrajectory, ObstacleTextError> {
    let name = || obstacle.name.clone();
    let pose = |(i, p): (usize, &PoseText)| {
        let pose = pose_from_xyz_quaternion(p.position, p.orientation);
        let number = || ObstacleTextError::Number { name: name(), what: format!("pose {i}") };
        Ok((p.time, pose.ok_or_else(number)?))
    };
    let poses = poses.iter().enumerate().map(pose).collect::<Result<Vec<(f64, Pose)>, _>>()?;
    let trajectory = ObstacleTrajectory::through(&obstacle.name, &poses)
        .map_err(|error| ObstacleTextError::Poses { name: name(), error })?;
    match poses.first() {
        Some((_, first)) => check_start(obstacle, first).map(|()| trajectory),
        None => Ok(trajectory),
    }
}

/// Rejects a first pose that is not the one in the world: only differences of poses count, so that another motion would be checked.
fn check_start(obstacle: &Obstacle, first: &Pose) -> Result<(), ObstacleTextError> {
    let of_object = obstacle.pose_ro;
    let of_shape = match &*obstacle.shapes {
        [shape] => of_object * shape.pose_os,
        _ => of_object,
    };
    let is_first = |pose: &Pose| {
        let shift = (pose.translation.vector - first.translation.vector).norm();
        shift <= START_TOLERANCE && pose.rotation.angle_to(&first.rotation) <= START_TOLERANCE
    };
    if is_first(&of_object) || is_first(&of_shape) {
        return Ok(());
    }
    let [first, world] = [first, &of_shape].map(in_words);
    Err(ObstacleTextError::Start { name: obstacle.name.clone(), first, world })
}

/// Position (m) and orientation of a pose.
fn in_words(pose: &Pose) -> String {
    let p = pose.translation.vector;
    let q = pose.rotation.coords;
    format!("[{}, {}, {}] with the orientation [{}, {}, {}, {}]", p.x, p.y, p.z, q.x, q.y, q.z, q.w)
}

#[cfg(test)]
mod tests {
    use clearance_geometry::{Cube, PointCloud, Primitive, Voxels};

    use super::*;

    const TURN: [f64; 3] = [0.0, 0.0, 1.0];

    /// The centre of a mesh, cloud or octree is not the origin of its frame.
    #[test]
    fn only_a_single_primitive_turns_about_its_own_centre() {
        let at = Pose::translation(2.0, 0.0, 0.0);
        let points = PointCloud::new(vec![[2.0, 0.0, 0.0]], 0.1).unwrap();
        let cubes = Voxels::new(vec![Cube { centre: [2.0, 0.0, 0.0], half_edge: 0.1 }]).unwrap();
        for shape in [Shape::Points(Arc::new(points)), Shape::Voxels(Arc::new(cubes))] {
            let obstacle = Obstacle::of_shape("cart", at, shape);
            let without = ObstacleTrajectory::of_twist(&obstacle, None, [0.0; 3], TURN);
            assert!(matches!(without, Err(ObstacleTextError::NoCentre(name)) if name == "cart"));
            assert!(ObstacleTrajectory::of_twist(&obstacle, Some([2.0, 0.0, 0.0]), [0.0; 3], TURN).is_ok());
            assert!(ObstacleTrajectory::of_twist(&obstacle, None, TURN, [0.0; 3]).is_ok());
        }
        let ball = Obstacle::of_shape("ball", at, Shape::Primitive(Primitive::sphere(0.1).unwrap()));
        let of_ball = ObstacleTrajectory::of_twist(&ball, None, [0.0; 3], TURN).unwrap();
        let about_centre = ObstacleTrajectory::even("ball", Point::new(2.0, 0.0, 0.0), [0.0; 3], TURN);
        assert_eq!(of_ball, about_centre);
    }
}
