//! The scene around a robot.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use clearance_geometry::math::Pose;
use clearance_robot::RobotModel;

use super::anchors::Anchor;
use super::{AllowedCollisionMatrix, Obstacle, SceneContext, SceneRejection, SceneUpdate, World};

/// The name of the octomap among the obstacles, as in `MoveIt`.
pub const OCTOMAP: &str = "<octomap>";

/// Everything that messages can change about the surroundings of a robot. Copies share what they hold.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    pub world: World,
    /// Instead of what the SRDF says, if it is there.
    pub matrix: Option<AllowedCollisionMatrix>,
    /// Paddings (m) of single links.
    pub link_padding: HashMap<String, f64>,
    pub link_scale: HashMap<String, f64>,
    /// What objects are, by name: database and key of `object_recognition_msgs/ObjectType`. Nothing depends on it.
    pub kinds: BTreeMap<String, [String; 2]>,
    /// Poses of frames in the root frame.
    pub fixed_frames: BTreeMap<String, Pose>,
    /// By name of an obstacle: what it stands in while the robot moves in that.
    pub(super) anchors: BTreeMap<String, Anchor>,
    /// The same for fixed frames.
    pub(super) frame_anchors: BTreeMap<String, Anchor>,
    /// Obstacles that sensors see: only who saw them takes them away.
    pub sensed: BTreeSet<String>,
}

/// What became of a message.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Applied {
    /// Whether anything was done.
    pub changed: bool,
    /// What was odd but accepted.
    pub warnings: Vec<String>,
    /// Accepted settings without effect, such as a matrix entry that names nothing.
    pub ineffective: Vec<String>,
    /// What was not done.
    pub refusals: Vec<SceneRejection>,
}

/// Parts of a scene that were dropped or are in doubt after a change of the robot.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Unfit {
    /// Objects that are no longer in the scene, wherever they are.
    pub dropped: Vec<String>,
    pub warnings: Vec<String>,
}

impl Applied {
    pub(super) fn note(&mut self, result: Result<(), SceneRejection>) {
        match result {
            Ok(()) => self.changed = true,
            Err(refusal) => self.refusals.push(refusal),
        }
    }
}

impl Scene {
    /// A scene of a world alone.
    #[must_use]
    pub fn new(world: World) -> Self {
        Self { world, ..Self::default() }
    }

    /// The same without its frames, and without a memory of what obstacles stand in.
    #[must_use]
    pub(super) fn without_frames(self) -> Self {
        let (fixed_frames, anchors, frame_anchors) = Default::default();
        Self { fixed_frames, anchors, frame_anchors, ..self }
    }

    /// Applies what a message says: each object, each field or nothing of it. As in `MoveIt`, what is right comes into force even if
    /// something beside it is refused.
    pub fn apply(&mut self, update: &SceneUpdate, context: &SceneContext) -> Applied {
        let mut applied = Applied::default();
        match update {
            SceneUpdate::Object(object) => {
                let result = self.change_object(object, context, &mut applied.warnings);
                applied.note(result);
            }
            SceneUpdate::Attached(attached) => {
                let result = self.change_attached(attached, context, &mut applied.warnings);
                applied.note(result);
            }
            SceneUpdate::Octomap(octomap) => applied.note(self.set_octomap(octomap.as_ref(), context)),
            SceneUpdate::World(world) => self.replace_world((world, false), context, &mut applied),
            SceneUpdate::Scene(change) => self.change_scene(change, context, &mut applied),
        }
        applied
    }

    /// What a sensor sees now, under the name of its topic; nothing takes it away.
    pub fn set_sensed(&mut self, name: &str, seen: Option<Obstacle>) {
        self.anchors.remove(name);
        // a message never gets at this name, so whatever bears it was seen
        if let Some(Ok(_)) = seen.map(|obstacle| self.world.replace(obstacle)) {
            self.sensed.insert(name.to_owned());
        } else {
            self.sensed.remove(name);
            let _ = self.world.remove(name);
        }
    }

    /// Whether a sensor gave this obstacle.
    #[must_use]
    pub fn is_sensed(&self, name: &str) -> bool {
        self.sensed.contains(name)
    }

    /// Leaves out what another robot cannot have; gives what that was.
    pub fn fit_to(&mut self, robot: &RobotModel) -> Unfit {
        let Unfit { mut dropped, mut warnings } = Unfit::default();
        let gone: Vec<_> =
            self.world.attached().iter().filter(|o| robot.link_by_name(&o.link).is_none()).cloned().collect();
        for object in gone {
            let (name, link) = (&object.name, &object.link);
            dropped.push(format!("object '{name}' is dropped: the robot has no link '{link}' any more"));
            let _ = self.world.drop_attached(name);
        }
        for (what, by_link) in
            [("link_padding", &mut self.link_padding), ("link_scale", &mut self.link_scale)]
        {
            by_link.retain(|link, _| {
                let known = robot.link_by_name(link).is_some();
                if !known {
                    warnings
                        .push(format!("{what} of '{link}' is dropped: the robot has no such link any more"));
                }
                known
            });
        }
        for object in self.world.obstacles().filter(|o| robot.link_by_name(&o.name).is_some()) {
            warnings.push(format!(
                "object '{}' has the name of a link: entries about one hold for both",
                object.name
            ));
        }
        Unfit { dropped, warnings }
    }
}
