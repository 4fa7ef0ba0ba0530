//! Changes of a scene, as messages and files describe them: numbers are checked, frames are still names.

use std::borrow::Cow;
use std::collections::HashMap;

use clearance_geometry::Shape;
use clearance_geometry::math::Pose;
use clearance_robot::{check_name_length, quoted};

use crate::{MatrixEntries, ObstacleShape};

/// What to do with an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    /// It takes the place of one of its name.
    Add,
    /// Its shapes are added to those of the object of its name, if there is one, in the frame of that object. An obstacle keeps its pose and
    /// gets the change's subframes instead of its own; an attached object gets the change's pose, if one is given, and more subframes.
    Append,
    /// Only its pose changes.
    Move,
    Remove,
}

/// A change of one obstacle: `moveit_msgs/CollisionObject`.
#[derive(Clone, Debug)]
pub struct ObjectChange {
    /// Empty, for [`Operation::Remove`]: all objects.
    pub id: String,
    pub operation: Operation,
    /// The frame of its pose; the robot's root frame when it is empty.
    pub frame: String,
    /// Pose of the object in that frame.
    pub pose_fo: Pose,
    /// With poses in the frame of the object.
    pub shapes: Vec<ObstacleShape>,
    /// For [`Operation::Move`]: where in the object its shapes are from now on; they stay where they are if none is given.
    pub shape_poses: Vec<Pose>,
    pub subframes: Vec<(String, Pose)>,
    /// What it is: database and key of `object_recognition_msgs/ObjectType`, or nothing.
    pub kind: [String; 2],
}

impl Operation {
    /// By its constant in `moveit_msgs/CollisionObject`.
    #[must_use]
    pub fn from_number(number: i64) -> Option<Self> {
        match number {
            0 => Some(Self::Add),
            1 => Some(Self::Remove),
            2 => Some(Self::Append),
            3 => Some(Self::Move),
            _ => None,
        }
    }
}

impl ObjectChange {
    /// A change of the object `id` that needs no more than its name.
    #[must_use]
    pub fn named(id: impl Into<String>, operation: Operation) -> Self {
        Self {
            id: id.into(),
            operation,
            frame: String::new(),
            pose_fo: Pose::identity(),
            shapes: Vec::new(),
            shape_poses: Vec::new(),
            subframes: Vec::new(),
            kind: Default::default(),
        }
    }

    /// Whether an object that is extended keeps its pose.
    pub(super) fn keeps_pose(&self) -> bool {
        self.operation == Operation::Append && self.pose_fo == Pose::identity()
    }

    /// Names are checked before anything quotes or keeps them.
    fn check_name_lengths(&self) -> Result<(), String> {
        let fields = [("id", &self.id), ("header.frame_id", &self.frame)];
        let subframes = self.subframes.iter().map(|(name, _)| ("subframe_names", name));
        fields.into_iter().chain(subframes).try_for_each(check_field)
    }

    /// A subframe that is given twice, at two places.
    pub(super) fn contradicted_subframe(&self) -> Option<&str> {
        let mut first: HashMap<&str, &Pose> = HashMap::new();
        let mut subframes = self.subframes.iter();
        subframes
            .find(|(name, pose)| *first.entry(name).or_insert(pose) != pose)
            .map(|(name, _)| name.as_str())
    }

    /// Names of a length that can be kept, and no contradictions.
    pub(super) fn check(&self) -> Result<(), String> {
        self.check_name_lengths()?;
        self.contradicted_subframe().map_or(Ok(()), |name| {
            Err(format!("subframe_names: {} is given twice, at two places", quoted(name)))
        })
    }

    /// As in `MoveIt`, if an object of its name is not there yet: the only pose that is given is that of the object.
    pub(super) fn as_new(&self) -> Cow<'_, Self> {
        let [only] = self.shapes.as_slice() else { return Cow::Borrowed(self) };
        if self.pose_fo != Pose::identity() {
            return Cow::Borrowed(self);
        }
        let shape = ObstacleShape { pose_os: Pose::identity(), ..only.clone() };
        Cow::Owned(Self { pose_fo: only.pose_os, shapes: vec![shape], ..self.clone() })
    }
}

/// A change of what the robot holds: `moveit_msgs/AttachedCollisionObject`.
#[derive(Clone, Debug)]
pub struct AttachedChange {
    /// Empty, for [`Operation::Remove`]: whichever link holds it.
    pub link: String,
    pub object: ObjectChange,
    pub touch_links: Vec<String>,
}

impl AttachedChange {
    pub(super) fn check(&self) -> Result<(), String> {
        self.object.check()?;
        let touched = self.touch_links.iter().map(|name| ("touch_links", name));
        touched.chain([("link_name", &self.link)]).try_for_each(check_field)
    }
}

fn check_field((field, name): (&'static str, &String)) -> Result<(), String> {
    check_name_length(name).map_err(|excess| format!("{field}: {excess}"))
}

/// Where an octomap stands; without a shape everything in it is free.
#[derive(Clone, Debug)]
pub struct OctomapPlacement {
    pub frame: String,
    pub pose_fo: Pose,
    pub shape: Option<Shape>,
    /// Whether it tells nothing of any place: no leaf at all, neither occupied nor free.
    pub is_blank: bool,
}

/// All obstacles anew: `moveit_msgs/PlanningSceneWorld`.
#[derive(Clone, Debug, Default)]
pub struct WorldChange {
    pub objects: Vec<ObjectChange>,
    pub octomap: Option<OctomapPlacement>,
}

/// One of `fixed_frame_transforms`.
///
/// `MoveIt` writes the pose of `header.frame_id` in the planning frame, which is the `child_frame_id`; anybody else writes the pose of
/// `child_frame_id` in `header.frame_id`, as in `tf`. [`Scene::apply`](super::Scene::apply) tells them apart by the planning frame.
#[derive(Clone, Debug)]
pub struct FixedFrame {
    /// `child_frame_id`
    pub name: String,
    /// `header.frame_id`
    pub parent: String,
    pub pose_pf: Pose,
}

/// What a scene says about the robot; joint positions come from joint states alone.
#[derive(Clone, Debug, Default)]
pub struct RobotStateChange {
    pub is_diff: bool,
    /// Whether it gives positions of joints.
    pub names_joints: bool,
    pub attached: Vec<AttachedChange>,
}

/// A scene or a difference to one: `moveit_msgs/PlanningScene`.
#[derive(Clone, Debug, Default)]
pub struct SceneChange {
    pub robot_model_name: String,
    pub is_diff: bool,
    pub fixed_frames: Vec<FixedFrame>,
    /// Names of frames whose transforms could not be read: their earlier poses hold no longer.
    pub unreadable_frames: Vec<String>,
    pub robot_state: RobotStateChange,
    pub matrix: MatrixEntries,
    /// Paddings (m) by link.
    pub link_padding: Vec<(String, f64)>,
    pub link_scale: Vec<(String, f64)>,
    pub world: WorldChange,
    /// Whether the octomap stays though this is a whole scene: who was asked knows of none.
    pub keeps_octomap: bool,
}

impl SceneUpdate {
    /// Whether it says all that there is, not what changes.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        match self {
            Self::World(_) => true,
            Self::Scene(scene) => !scene.is_diff,
            Self::Object(_) | Self::Attached(_) | Self::Octomap(_) => false,
        }
    }

    /// Whether it says all of what links hold.
    #[must_use]
    pub fn is_whole_of_robot(&self) -> bool {
        matches!(self, Self::Scene(scene) if !scene.is_diff && !scene.robot_state.is_diff)
    }

    /// Whether it says what octomap there is, or that there is none.
    #[must_use]
    pub fn changes_octomap(&self) -> bool {
        match self {
            Self::Octomap(_) | Self::World(_) => true,
            Self::Scene(scene) => !(scene.is_diff || scene.keeps_octomap) || scene.world.octomap.is_some(),
            Self::Object(_) | Self::Attached(_) => false,
        }
    }

    /// Whether it brings an octomap that tells of any place.
    #[must_use]
    pub fn shows_room(&self) -> bool {
        let octomap = match self {
            Self::Octomap(octomap) => octomap.as_ref(),
            Self::World(world) => world.octomap.as_ref(),
            Self::Scene(scene) => scene.world.octomap.as_ref(),
            Self::Object(_) | Self::Attached(_) => None,
        };
        octomap.is_some_and(|octomap| !octomap.is_blank)
    }

    /// Whether it says something of objects, or of what the robot makes of them: not of an octomap or the robot's joints alone, which are told
    /// again and again.
    #[must_use]
    pub fn tells_of_objects(&self) -> bool {
        match self {
            Self::Object(_) | Self::Attached(_) | Self::World(_) => true,
            Self::Octomap(_) => false,
            Self::Scene(scene) => {
                let SceneChange {
                    is_diff,
                    fixed_frames,
                    unreadable_frames,
                    robot_state,
                    matrix,
                    link_padding,
                    link_scale,
                    world,
                    ..
                } = scene.as_ref();
                let MatrixEntries { entry_names, default_entry_names, .. } = matrix;
                let is_silent = (fixed_frames.is_empty() && unreadable_frames.is_empty())
                    && robot_state.attached.is_empty()
                    && (robot_state.is_diff || !robot_state.names_joints)
                    && (entry_names.is_empty() && default_entry_names.is_empty())
                    && (link_padding.is_empty() && link_scale.is_empty())
                    && world.objects.is_empty();
                !(*is_diff && is_silent)
            }
        }
    }
}

/// Whatever may change a scene.
#[derive(Clone, Debug)]
pub enum SceneUpdate {
    Object(Box<ObjectChange>),
    Attached(Box<AttachedChange>),
    World(Box<WorldChange>),
    Scene(Box<SceneChange>),
    /// An octomap by itself; `None` takes it away.
    Octomap(Option<OctomapPlacement>),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_robots_joints_and_octomaps_tell_nothing_of_objects() {
        let update = |scene: SceneChange| SceneUpdate::Scene(Box::new(scene));
        let diff = || SceneChange { is_diff: true, ..SceneChange::default() };
        let robot_state = RobotStateChange { is_diff: true, names_joints: true, attached: Vec::new() };
        let map =
            OctomapPlacement { frame: String::new(), pose_fo: Pose::identity(), shape: None, is_blank: true };
        let world = WorldChange { objects: Vec::new(), octomap: Some(map.clone()) };
        let silent = [
            update(SceneChange { robot_state, ..diff() }),
            update(SceneChange { world, ..diff() }),
            SceneUpdate::Octomap(Some(map)),
        ];
        assert!(!silent.iter().any(SceneUpdate::tells_of_objects), "{silent:?}");
        let objects = vec![ObjectChange::named("a", Operation::Remove)];
        let world = WorldChange { objects, octomap: None };
        let padded = SceneChange { link_padding: vec![("link".to_owned(), 0.1)], ..diff() };
        let told = [update(SceneChange::default()), update(SceneChange { world, ..diff() }), update(padded)];
        assert!(told.iter().all(SceneUpdate::tells_of_objects), "{told:?}");
    }
}
