//! Obstacles with names, shapes and poses in the robot's root frame.

use std::collections::HashSet;

use crate::geometry::Shape;
use crate::math::Pose;

/// An obstacle of one [`World`]: its index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ObstacleId(pub u32);

/// A rigid thing in the robot's surroundings, made of one or more shapes.
#[derive(Clone, Debug)]
pub struct Obstacle {
    pub name: String,
    pub shapes: Vec<ObstacleShape>,
}

/// One shape of an obstacle.
#[derive(Clone, Debug)]
pub struct ObstacleShape {
    /// Pose of the shape in the robot's root frame.
    pub pose_rs: Pose,
    pub shape: Shape,
}

/// Everything that the robot can hit but itself.
#[derive(Clone, Debug, Default)]
pub struct World {
    obstacles: Vec<Obstacle>,
    names: HashSet<String>,
}

#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WorldError {
    #[error("object '{0}' is given twice")]
    Duplicate(String),
    #[error("object '{0}' has no shapes")]
    NoShapes(String),
    #[error("the world has more obstacles than 32 bits can number")]
    TooMany,
}

impl World {
    /// Adds an obstacle whose name no other has.
    pub fn add(&mut self, obstacle: Obstacle) -> Result<ObstacleId, WorldError> {
        if obstacle.shapes.is_empty() {
            return Err(WorldError::NoShapes(obstacle.name));
        }
        let id = u32::try_from(self.obstacles.len()).map_err(|_| WorldError::TooMany)?;
        if !self.names.insert(obstacle.name.clone()) {
            return Err(WorldError::Duplicate(obstacle.name));
        }
        self.obstacles.push(obstacle);
        Ok(ObstacleId(id))
    }

    #[must_use]
    pub fn obstacles(&self) -> &[Obstacle] {
        &self.obstacles
    }

    #[must_use]
    pub fn obstacle(&self, id: ObstacleId) -> &Obstacle {
        &self.obstacles[id.0 as usize]
    }

    pub fn ids(&self) -> impl Iterator<Item = ObstacleId> + use<> {
        (0..u32::try_from(self.obstacles.len()).unwrap_or(u32::MAX)).map(ObstacleId)
    }
}
