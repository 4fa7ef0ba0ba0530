//! Obstacles: rigid objects with names and shapes.

use std::sync::Arc;

use clearance_geometry::Shape;
use clearance_geometry::math::Pose;

/// Name of the octomap obstacle, as in `MoveIt`.
pub const OCTOMAP: &str = "<octomap>";

/// Id of an obstacle in one `World`: its place in the list, which does not change until it is removed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ObstacleId(pub u32);

/// A rigid object around the robot, made of one or more shapes.
#[derive(Clone, Debug)]
pub struct Obstacle {
    /// Name of the obstacle.
    pub name: String,
    /// Pose of the obstacle in the robot's root frame.
    pub pose_ro: Pose,
    /// Shared by all copies, so that data built for the shapes is kept when the obstacle only moves.
    pub shapes: Arc<[ObstacleShape]>,
    /// Named frames on the obstacle, in its frame; they have no geometry.
    pub subframes: Vec<(String, Pose)>,
}

/// One shape of an obstacle or of an attached object.
#[derive(Clone, Debug)]
pub struct ObstacleShape {
    /// Pose of the shape in the frame of its object.
    pub pose_os: Pose,
    /// The shape, in its own frame.
    pub shape: Shape,
}

impl Obstacle {
    /// The same object with new poses of its shapes, one pose per shape. Unchanged if no pose is given; `None` if there are too many or
    /// too few.
    #[must_use]
    pub fn with_shapes_at(&self, poses: &[Pose]) -> Option<Self> {
        if poses.is_empty() {
            return Some(self.clone());
        }
        let place = |(s, pose_os): (&ObstacleShape, &Pose)| ObstacleShape {
            pose_os: *pose_os,
            shape: s.shape.clone(),
        };
        let shapes = self.shapes.iter().zip(poses).map(place).collect();
        (poses.len() == self.shapes.len()).then(|| Self { shapes, ..self.clone() })
    }

    /// An obstacle whose frame is the robot's root frame.
    #[must_use]
    pub fn new(name: impl Into<String>, shapes: impl Into<Arc<[ObstacleShape]>>) -> Self {
        Self { name: name.into(), pose_ro: Pose::identity(), shapes: shapes.into(), subframes: Vec::new() }
    }

    /// An obstacle with one shape; its frame is the frame of the shape.
    #[must_use]
    pub fn of_shape(name: impl Into<String>, pose_ro: Pose, shape: Shape) -> Self {
        let placed = ObstacleShape { pose_os: Pose::identity(), shape };
        Self { pose_ro, ..Self::new(name, vec![placed]) }
    }

    /// All shapes, with their poses in the root frame.
    pub fn placed_shapes(&self) -> impl Iterator<Item = (Pose, &Shape)> {
        self.shapes.iter().map(|placed| (self.pose_ro * placed.pose_os, &placed.shape))
    }
}
