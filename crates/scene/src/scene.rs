//! The scene that messages change: world, allowed collisions, paddings, frames and sensed obstacles.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;

use clearance_geometry::math::Pose;
use clearance_robot::RobotModel;

use super::anchor::Anchor;
use super::{AllowedCollisionMatrix, FileOctree, Obstacle, ObstacleTwist, World};

/// Everything around a robot that messages can change. Copies share their content.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Obstacles and attached objects.
    pub world: World,
    /// Replaces the SRDF's matrix, if present.
    pub matrix: Option<AllowedCollisionMatrix>,
    /// Paddings (m) of individual links. Those of links that the robot does not have are kept for a later robot.
    pub link_padding: HashMap<String, f64>,
    /// Scale factors of individual links, kept in the same way.
    pub link_scale: HashMap<String, f64>,
    /// Types of objects, by name: database and key of `object_recognition_msgs/ObjectType`. Not used by any check.
    pub kinds: BTreeMap<String, [String; 2]>,
    /// Poses of frames in the root frame.
    pub fixed_frames: BTreeMap<String, Pose>,
    /// By name of an obstacle: its anchor, the world-fixed pose that it keeps while the robot moves.
    pub(super) anchors: BTreeMap<String, Anchor>,
    /// Anchors of fixed frames.
    pub(super) frame_anchors: BTreeMap<String, Anchor>,
    /// By name of an obstacle: its velocity, which may be zero, if a message with its pose gave one. Any other change of its pose removes it.
    pub(super) twists: BTreeMap<String, ObstacleTwist>,
    /// By name of an obstacle: its poses in the root frame after each of its states, oldest first, since they were last taken.
    pub(super) state_poses: BTreeMap<String, Vec<Pose>>,
    /// Obstacles from sensors: only the sensor that added them removes them.
    pub sensed: BTreeSet<String>,
    /// The octomap, if it is that of a file.
    pub(super) file_octree: Option<Arc<FileOctree>>,
}

/// Parts of a scene that were dropped or are in doubt after a change of the robot.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DroppedParts {
    /// Descriptions of objects that are no longer in the scene, neither attached nor as obstacles.
    pub dropped: Vec<String>,
    /// Warnings about parts that stay, but may have a different effect.
    pub warnings: Vec<String>,
}

impl Scene {
    /// A scene with a world and no other content.
    #[must_use]
    pub fn new(world: World) -> Self {
        Self { world, ..Self::default() }
    }

    /// The same scene without its frames and anchors.
    #[must_use]
    pub(super) fn without_frames(self) -> Self {
        let (fixed_frames, anchors, frame_anchors) = Default::default();
        Self { fixed_frames, anchors, frame_anchors, ..self }
    }

    /// Sets the obstacle that a sensor sees now, under the name of its topic. Messages cannot remove it.
    ///
    /// # Errors
    /// If something else has this name: it stays as it is.
    pub fn set_sensed(&mut self, name: &str, obstacle: Option<Obstacle>) -> Result<(), String> {
        let has_object = self.world.id(name).is_some() || self.world.attached_by_name(name).is_some();
        if has_object && !self.is_sensed(name) {
            let message = "the scene has an object with the name of this topic: give the object another one";
            return Err(message.to_owned());
        }
        let Some(obstacle) = obstacle else {
            self.remove_sensed(name);
            return Ok(());
        };
        self.world.replace(obstacle).map_err(|error| error.to_string())?;
        self.anchors.remove(name);
        self.sensed.insert(name.to_owned());
        Ok(())
    }

    /// Removes the obstacle that a sensor saw; an object of this name stays.
    pub fn remove_sensed(&mut self, name: &str) {
        if self.sensed.remove(name) {
            self.anchors.remove(name);
            let _ = self.world.remove(name);
        }
    }

    /// True if this obstacle comes from a sensor.
    #[must_use]
    pub fn is_sensed(&self, name: &str) -> bool {
        self.sensed.contains(name)
    }

    /// The octree of a world file, while it is the octomap of this scene.
    #[must_use]
    pub fn file_octree(&self) -> Option<&FileOctree> {
        self.file_octree.as_deref()
    }

    /// Removes the objects that do not fit another robot; returns a description of the parts that do not fit.
    ///
    /// Paddings and scales of links that this robot lacks have no effect, but hold again for a robot that has these links.
    pub fn adapt_to_robot(&mut self, robot: &RobotModel) -> DroppedParts {
        let DroppedParts { mut dropped, mut warnings } = DroppedParts::default();
        let gone: Vec<_> =
            self.world.attached().iter().filter(|o| robot.link_by_name(&o.link).is_none()).cloned().collect();
        for object in gone {
            let (name, link) = (&object.name, &object.link);
            dropped.push(format!("object '{name}' is dropped: the robot has no link '{link}' any more"));
            let _ = self.world.drop_attached(name);
        }
        for (what, by_link) in [("link_padding", &self.link_padding), ("link_scale", &self.link_scale)] {
            let unknown = by_link.keys().filter(|link| robot.link_by_name(link).is_none());
            let mut unknown: Vec<&String> = unknown.collect();
            unknown.sort();
            warnings.extend(unknown.into_iter().map(|link| {
                format!(
                    "{what} of '{link}' has no effect: the robot has no such link; it is kept for a robot that has \
                     one"
                )
            }));
        }
        for object in self.world.obstacles().filter(|o| robot.link_by_name(&o.name).is_some()) {
            warnings.push(format!(
                "object '{}' has the name of a link: entries of the matrix hold for the link alone",
                object.name
            ));
        }
        DroppedParts { dropped, warnings }
    }
}
