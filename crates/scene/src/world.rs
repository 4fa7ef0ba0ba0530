//! The world: obstacles and attached objects, and the operations that change them.

use std::collections::HashMap;
use std::sync::Arc;

use clearance_geometry::math::Pose;
use clearance_robot::check_name_length;

use super::{AttachedId, AttachedObject, Obstacle, ObstacleId, ObstacleShape};

/// Obstacles and attached objects. Copies share their content; a change affects only the objects it names.
#[derive(Clone, Debug, Default)]
pub struct World {
    /// By id; a removed obstacle leaves a gap, which the next new one fills.
    places: Vec<Option<Arc<Obstacle>>>,
    gaps: Vec<u32>,
    names: HashMap<Arc<str>, ObstacleId>,
    attached: Vec<Arc<AttachedObject>>,
}

#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "the message of each variant describes it and its fields")]
pub enum WorldError {
    #[error("object '{0}' is given twice")]
    Duplicate(String),
    #[error("object '{0}' has no shapes")]
    NoShapes(String),
    #[error("there is no object '{0}'")]
    Unknown(String),
    #[error("no object '{0}' is attached")]
    NotAttached(String),
    #[error("{0}")]
    LongName(String),
    #[error("the world has more obstacles than 32 bits can number")]
    TooMany,
}

/// Names of an object and of its subframes.
fn check_names(name: &str, subframes: &[(String, Pose)]) -> Result<(), WorldError> {
    let mut names = subframes.iter().map(|(subframe, _)| subframe.as_str()).chain([name]);
    names.try_for_each(check_name_length).map_err(WorldError::LongName)
}

impl World {
    /// Adds an obstacle; its name must differ from those of all other obstacles and attached objects.
    pub fn add(&mut self, obstacle: Obstacle) -> Result<ObstacleId, WorldError> {
        if obstacle.shapes.is_empty() {
            return Err(WorldError::NoShapes(obstacle.name));
        }
        check_names(&obstacle.name, &obstacle.subframes)?;
        if self.id(&obstacle.name).is_some() || self.attached_by_name(&obstacle.name).is_some() {
            return Err(WorldError::Duplicate(obstacle.name));
        }
        let place = if let Some(gap) = self.gaps.pop() {
            gap
        } else {
            self.places.push(None);
            u32::try_from(self.places.len() - 1).map_err(|_| WorldError::TooMany)?
        };
        self.names.insert(obstacle.name.as_str().into(), ObstacleId(place));
        self.places[place as usize] = Some(Arc::new(obstacle));
        Ok(ObstacleId(place))
    }

    /// Adds an obstacle, or replaces the one with its name.
    pub fn replace(&mut self, obstacle: Obstacle) -> Result<ObstacleId, WorldError> {
        if obstacle.shapes.is_empty() {
            return Err(WorldError::NoShapes(obstacle.name));
        }
        check_names(&obstacle.name, &obstacle.subframes)?;
        match self.id(&obstacle.name) {
            Some(id) => {
                self.places[id.0 as usize] = Some(Arc::new(obstacle));
                Ok(id)
            }
            None => self.add(obstacle),
        }
    }

    /// Appends shapes, in the frame of the obstacle.
    pub fn append(
        &mut self,
        name: &str,
        shapes: impl IntoIterator<Item = ObstacleShape>,
    ) -> Result<(), WorldError> {
        let obstacle = self.obstacle_mut(name)?;
        obstacle.shapes = obstacle.shapes.iter().cloned().chain(shapes).collect();
        Ok(())
    }

    /// Moves an obstacle with its shapes.
    pub fn move_to(&mut self, name: &str, pose_ro: Pose) -> Result<(), WorldError> {
        self.obstacle_mut(name)?.pose_ro = pose_ro;
        Ok(())
    }

    /// Removes an obstacle.
    pub fn remove(&mut self, name: &str) -> Result<Arc<Obstacle>, WorldError> {
        let id = self.names.remove(name).ok_or_else(|| WorldError::Unknown(name.to_owned()))?;
        self.gaps.push(id.0);
        self.places[id.0 as usize].take().ok_or_else(|| WorldError::Unknown(name.to_owned()))
    }

    /// Removes all obstacles; attached objects stay.
    pub fn clear(&mut self) {
        *self = Self { attached: std::mem::take(&mut self.attached), ..Self::default() };
    }

    /// Attaches an object, and removes an obstacle or attached object of the same name.
    pub fn attach(&mut self, object: AttachedObject) -> Result<(), WorldError> {
        if object.shapes.is_empty() {
            return Err(WorldError::NoShapes(object.name));
        }
        check_names(&object.name, &object.subframes)?;
        // from here on the name refers to the new object
        let _ = self.remove(&object.name);
        match self.attached.iter_mut().find(|other| other.name == object.name) {
            Some(other) => *other = Arc::new(object),
            None => self.attached.push(Arc::new(object)),
        }
        Ok(())
    }

    /// Removes an attached object; it does not become an obstacle.
    pub fn drop_attached(&mut self, name: &str) -> Result<Arc<AttachedObject>, WorldError> {
        let place = self.attached.iter().position(|object| object.name == name);
        place.map(|i| self.attached.remove(i)).ok_or_else(|| WorldError::NotAttached(name.to_owned()))
    }

    /// Makes an attached object an obstacle at its present pose; `pose_rl` is the pose of its link in the root frame.
    pub fn detach(&mut self, name: &str, pose_rl: &Pose) -> Result<ObstacleId, WorldError> {
        let object = self.drop_attached(name)?;
        self.add(object.released(pose_rl))
    }

    /// All obstacles, in the order of their ids.
    pub fn obstacles(&self) -> impl Iterator<Item = &Obstacle> {
        self.places.iter().flatten().map(AsRef::as_ref)
    }

    /// The ids of all obstacles, ascending.
    pub fn ids(&self) -> impl Iterator<Item = ObstacleId> {
        let numbered = (0..).map(ObstacleId).zip(&self.places);
        numbered.filter_map(|(id, place)| place.is_some().then_some(id))
    }

    /// Number of obstacles.
    #[must_use]
    pub fn len(&self) -> usize {
        self.places.len() - self.gaps.len()
    }

    /// True if there is neither an obstacle nor an attached object.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0 && self.attached.is_empty()
    }

    /// The id of the obstacle with this name.
    #[must_use]
    pub fn id(&self, name: &str) -> Option<ObstacleId> {
        self.names.get(name).copied()
    }

    /// # Panics
    /// If there is no obstacle with this id in this world.
    #[must_use]
    pub fn obstacle(&self, id: ObstacleId) -> &Arc<Obstacle> {
        self.places[id.0 as usize].as_ref().expect("the id is of an obstacle of this world")
    }

    /// The obstacle with this name.
    #[must_use]
    pub fn obstacle_by_name(&self, name: &str) -> Option<&Arc<Obstacle>> {
        Some(self.obstacle(self.id(name)?))
    }

    /// Number of places; all ids are smaller.
    #[must_use]
    pub fn place_count(&self) -> usize {
        self.places.len()
    }

    /// The obstacle at a place; `None` at a gap.
    #[must_use]
    pub fn place(&self, id: ObstacleId) -> Option<&Arc<Obstacle>> {
        self.places.get(id.0 as usize)?.as_ref()
    }

    /// All attached objects, in the order of their ids.
    #[must_use]
    pub fn attached(&self) -> &[Arc<AttachedObject>] {
        &self.attached
    }

    /// The attached object with this name.
    #[must_use]
    pub fn attached_by_name(&self, name: &str) -> Option<&Arc<AttachedObject>> {
        self.attached.iter().find(|object| object.name == name)
    }

    /// # Panics
    /// If there is no attached object with this id in this world.
    #[must_use]
    pub fn attached_object(&self, id: AttachedId) -> &Arc<AttachedObject> {
        &self.attached[id.0 as usize]
    }

    fn obstacle_mut(&mut self, name: &str) -> Result<&mut Obstacle, WorldError> {
        let id = self.id(name).ok_or_else(|| WorldError::Unknown(name.to_owned()))?;
        let place = self.places[id.0 as usize].as_mut().expect("names are of obstacles");
        Ok(Arc::make_mut(place))
    }
}
