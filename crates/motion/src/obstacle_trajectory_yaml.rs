//! Reader of moving obstacle files.

use clearance_files::yaml;
use clearance_geometry::Shape;
use clearance_geometry::constants::LARGEST_COORDINATE;
use clearance_geometry::math::{Point, Pose, pose_from_xyz_quaternion};
use clearance_scene::{Obstacle, World};
use serde::Deserialize;

use super::{ObstacleTrajectory, PosesError};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileText {
    moving_obstacles: Vec<ObstacleText>,
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
    #[error("moving_obstacles is empty")]
    Empty,
    #[error("obstacle '{0}' is to move, but the world has no such obstacle")]
    Unknown(String),
    #[error("obstacle '{0}': give linear or angular (and centre), or poses, but not both")]
    TwistOrPoses(String),
    #[error("obstacle '{0}' turns and has several shapes: give the centre that it turns about")]
    NoCentre(String),
    #[error("obstacle '{name}': {what} is not finite, larger than {LARGEST_COORDINATE:e}, or no rotation")]
    Number { name: String, what: String },
    #[error("obstacle '{name}': {error}")]
    Poses { name: String, error: PosesError },
}

impl ObstacleTrajectory {
    /// Reads YAML or JSON: `moving_obstacles`, a list of obstacles of `world` by `name`. Each has either a twist (`linear` in m/s,
    /// `angular` in rad/s, `centre` in m; missing values are zero, and a missing centre is the centre of the obstacle's only shape,
    /// unless that is a plane), or `poses`, each with a `time` (s), a `position` (m) and an `orientation` (x, y, z, w; the identity if
    /// missing). All are in the robot's root frame and in the trajectory's time, see [`Self::even`] and [`Self::through`].
    pub fn list_from_yaml(text: &str, world: &World) -> Result<Vec<Self>, ObstacleTextError> {
        let text: FileText = yaml::from_text(text).map_err(ObstacleTextError::Text)?;
        if text.moving_obstacles.is_empty() {
            return Err(ObstacleTextError::Empty);
        }
        text.moving_obstacles.into_iter().map(|o| o.read(world)).collect()
    }
}

impl ObstacleText {
    fn read(self, world: &World) -> Result<ObstacleTrajectory, ObstacleTextError> {
        let obstacle = world
            .obstacle_by_name(&self.name)
            .ok_or_else(|| ObstacleTextError::Unknown(self.name.clone()))?;
        let twist = self.linear.is_some() || self.angular.is_some();
        match &self.poses {
            Some(poses) if !twist && self.centre.is_none() => through(&self.name, poses),
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
    /// As [`Self::even`], for an obstacle of the world. Without a centre (m), its only shape turns about its own centre.
    ///
    /// # Errors
    /// If a number is not finite or too large, or a centre is needed: the obstacle turns, and it has several shapes or is a
    /// plane.
    pub fn of_twist(
        obstacle: &Obstacle,
        centre: Option<[f64; 3]>,
        linear: [f64; 3],
        angular: [f64; 3],
    ) -> Result<Self, ObstacleTextError> {
        let name = || obstacle.name.clone();
        let centre = match (centre, &*obstacle.shapes) {
            (Some(centre), _) => centre,
            (None, [shape]) if !matches!(shape.shape, Shape::Plane(_)) => {
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

fn through(name: &str, poses: &[PoseText]) -> Result<ObstacleTrajectory, ObstacleTextError> {
    let name = || name.to_owned();
    let pose = |(i, p): (usize, &PoseText)| {
        let pose = pose_from_xyz_quaternion(p.position, p.orientation);
        let number = || ObstacleTextError::Number { name: name(), what: format!("pose {i}") };
        Ok((p.time, pose.ok_or_else(number)?))
    };
    let poses = poses.iter().enumerate().map(pose).collect::<Result<Vec<(f64, Pose)>, _>>()?;
    ObstacleTrajectory::through(&name(), &poses)
        .map_err(|error| ObstacleTextError::Poses { name: name(), error })
}
