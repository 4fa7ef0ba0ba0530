//! Data types of scene updates, as messages and files contain them: numbers are checked, frames are unresolved names.

use std::borrow::Cow;
use std::collections::HashMap;

use clearance_geometry::Shape;
use clearance_geometry::math::Pose;
use clearance_robot::{check_name_length, quoted};

use crate::{MatrixEntries, ObstacleShape, ObstacleStates};

/// Operation on an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    /// Adds the object, or replaces the object with its name.
    Add,
    /// Appends shapes to the object with its name, if there is one, in the frame of that object. An obstacle keeps its pose, and the
    /// change's subframes replace its own. An attached object gets the change's pose, if one is given, and additional subframes.
    Append,
    /// Changes only the pose.
    Move,
    /// Removes the object.
    Remove,
}

/// A change of one obstacle: `moveit_msgs/CollisionObject`.
#[derive(Clone, Debug)]
pub struct ObjectChange {
    /// Empty, for [`Operation::Remove`]: applies to all objects.
    pub id: String,
    /// The operation on the object.
    pub operation: Operation,
    /// The frame of its pose; if empty, the robot's root frame.
    pub frame: String,
    /// Pose of the object in that frame.
    pub pose_fo: Pose,
    /// Shapes with poses in the frame of the object.
    pub shapes: Vec<ObstacleShape>,
    /// For [`Operation::Move`]: the new poses of its shapes in the object's frame; they do not change if none is given.
    pub shape_poses: Vec<Pose>,
    /// Named frames on the object, in its frame.
    pub subframes: Vec<(String, Pose)>,
    /// Type of the object: database and key of `object_recognition_msgs/ObjectType`, or nothing.
    pub kind: [String; 2],
}

impl Operation {
    /// The operation for a constant of `moveit_msgs/CollisionObject`.
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
    /// A change of the object `id` that needs no other field.
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

    /// True if an object keeps its pose when shapes are appended.
    pub(super) fn keeps_pose(&self) -> bool {
        self.operation == Operation::Append && self.pose_fo == Pose::identity()
    }

    /// Checks the lengths of names, before they are quoted or stored.
    fn check_name_lengths(&self) -> Result<(), String> {
        let fields = [("id", &self.id), ("header.frame_id", &self.frame)];
        let subframes = self.subframes.iter().map(|(name, _)| ("subframe_names", name));
        fields.into_iter().chain(subframes).try_for_each(|(field, name)| check_field(field, name))
    }

    /// The name of a subframe that is given twice with different poses.
    pub(super) fn contradicted_subframe(&self) -> Option<&str> {
        let mut first: HashMap<&str, &Pose> = HashMap::new();
        let mut subframes = self.subframes.iter();
        subframes
            .find(|(name, pose)| *first.entry(name).or_insert(pose) != pose)
            .map(|(name, _)| name.as_str())
    }

    /// Checks that names are short enough to be stored, and that there are no contradictions.
    pub(super) fn check(&self) -> Result<(), String> {
        self.check_name_lengths()?;
        self.contradicted_subframe().map_or(Ok(()), |name| {
            Err(format!("subframe_names: {} is given twice, at two places", quoted(name)))
        })
    }

    /// As in `MoveIt`, if there is no object of its name yet: the only given pose becomes the pose of the object.
    pub(super) fn as_new(&self) -> Cow<'_, Self> {
        let [only] = self.shapes.as_slice() else { return Cow::Borrowed(self) };
        if self.pose_fo != Pose::identity() {
            return Cow::Borrowed(self);
        }
        let shape = ObstacleShape { pose_os: Pose::identity(), ..only.clone() };
        Cow::Owned(Self { pose_fo: only.pose_os, shapes: vec![shape], ..self.clone() })
    }
}

/// A change of an attached object: `moveit_msgs/AttachedCollisionObject`.
#[derive(Clone, Debug)]
pub struct AttachedChange {
    /// Empty, for [`Operation::Remove`]: any link that holds the object.
    pub link: String,
    /// The object and the operation on it.
    pub object: ObjectChange,
    /// Links that may touch the object.
    pub touch_links: Vec<String>,
}

impl AttachedChange {
    pub(super) fn check(&self) -> Result<(), String> {
        self.object.check()?;
        let touched = self.touch_links.iter().map(|name| ("touch_links", name));
        touched.chain([("link_name", &self.link)]).try_for_each(|(field, name)| check_field(field, name))
    }
}

fn check_field(field: &'static str, name: &str) -> Result<(), String> {
    check_name_length(name).map_err(|excess| format!("{field}: {excess}"))
}

/// An octomap with its frame and pose; without a shape, all of it is free.
#[derive(Clone, Debug)]
pub struct OctomapPlacement {
    /// The frame of its pose; if empty, the root frame.
    pub frame: String,
    /// Pose of the octomap in that frame.
    pub pose_fo: Pose,
    /// The occupied cells; `None` if there are none.
    pub shape: Option<Shape>,
    /// True if the octomap has no leaf at all, neither occupied nor free, and thus no information.
    pub is_blank: bool,
}

/// Replacement of all obstacles: `moveit_msgs/PlanningSceneWorld`.
#[derive(Clone, Debug, Default)]
pub struct WorldChange {
    /// The obstacles.
    pub objects: Vec<ObjectChange>,
    /// The octomap, if there is one.
    pub octomap: Option<OctomapPlacement>,
}

/// One entry of `fixed_frame_transforms`.
///
/// `MoveIt` writes the pose of `header.frame_id` in the planning frame, which is the `child_frame_id`. Other programs write the pose of
/// `child_frame_id` in `header.frame_id`, as in `tf`. `Scene::apply` distinguishes the two by the planning frame.
#[derive(Clone, Debug)]
pub struct FixedFrame {
    /// `child_frame_id`
    pub name: String,
    /// `header.frame_id`
    pub parent: String,
    /// Pose of the frame in its parent.
    pub pose_pf: Pose,
}

/// Joint positions of a robot state.
#[derive(Clone, Debug, Default)]
pub struct StatedPositions {
    /// Positions (rad, m), by name.
    pub single: Vec<(String, f64)>,
    /// Names of joints with several positions, which are given as transforms.
    pub with_transforms: Vec<String>,
    /// Why the positions cannot be read.
    pub fault: Option<String>,
}

/// The robot state of a scene. Its joint positions place the frames of the scene's objects, and nothing else.
#[derive(Clone, Debug, Default)]
pub struct RobotStateChange {
    /// True if attached objects that it does not name stay.
    pub is_diff: bool,
    /// True if it contains joint positions.
    pub names_joints: bool,
    /// Positions of joints: where the links are, in whose frames the scene has objects.
    pub positions: StatedPositions,
    /// Changes of attached objects, in order.
    pub attached: Vec<AttachedChange>,
}

/// A scene or a difference to one: `moveit_msgs/PlanningScene`.
#[derive(Clone, Debug, Default)]
pub struct SceneChange {
    /// Name of the robot that the scene is for; may be empty.
    pub robot_model_name: String,
    /// True if parts that it does not contain stay unchanged.
    pub is_diff: bool,
    /// Frames with fixed poses.
    pub fixed_frames: Vec<FixedFrame>,
    /// Names of frames whose transforms could not be read: their earlier poses become invalid.
    pub unreadable_frames: Vec<String>,
    /// Change of the robot state.
    pub robot_state: RobotStateChange,
    /// Entries of the allowed collision matrix.
    pub matrix: MatrixEntries,
    /// Paddings (m) by link.
    pub link_padding: Vec<(String, f64)>,
    /// Scale factors by link.
    pub link_scale: Vec<(String, f64)>,
    /// The obstacles.
    pub world: WorldChange,
    /// True if the octomap stays although this is a whole scene, because its source has no octomap.
    pub keeps_octomap: bool,
}

impl SceneUpdate {
    /// True if it replaces the whole world or scene, rather than changing a part.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        match self {
            Self::World(_) => true,
            Self::Scene(scene) => !scene.is_diff,
            Self::Object(_) | Self::Attached(_) | Self::States(_) | Self::Octomap(_) => false,
        }
    }

    /// True if it removes all objects of the world without their names.
    #[must_use]
    pub fn removes_all_objects(&self) -> bool {
        let is_of_all = |object: &ObjectChange| object.operation == Operation::Remove && object.id.is_empty();
        match self {
            Self::Object(object) => is_of_all(object),
            Self::Scene(scene) => scene.world.objects.iter().any(is_of_all),
            Self::World(_) | Self::Attached(_) | Self::States(_) | Self::Octomap(_) => false,
        }
    }

    /// True if it replaces all attached objects.
    #[must_use]
    pub fn is_whole_of_robot(&self) -> bool {
        matches!(self, Self::Scene(scene) if !scene.is_diff && !scene.robot_state.is_diff)
    }

    /// True if it sets or removes the octomap.
    #[must_use]
    pub fn changes_octomap(&self) -> bool {
        match self {
            Self::Octomap(_) | Self::World(_) => true,
            Self::Scene(scene) => !(scene.is_diff || scene.keeps_octomap) || scene.world.octomap.is_some(),
            Self::Object(_) | Self::Attached(_) | Self::States(_) => false,
        }
    }

    /// True if it contains an octomap with any known cell.
    #[must_use]
    pub fn has_known_cells(&self) -> bool {
        let octomap = match self {
            Self::Octomap(octomap) => octomap.as_ref(),
            Self::World(world) => world.octomap.as_ref(),
            Self::Scene(scene) => scene.world.octomap.as_ref(),
            Self::Object(_) | Self::Attached(_) | Self::States(_) => None,
        };
        octomap.is_some_and(|octomap| !octomap.is_blank)
    }

    /// True if it changes objects, or their handling by the robot. False for states of obstacles, an octomap or joint positions alone,
    /// which are sent repeatedly.
    #[must_use]
    pub fn changes_objects(&self) -> bool {
        match self {
            Self::Object(_) | Self::Attached(_) | Self::World(_) => true,
            Self::States(_) | Self::Octomap(_) => false,
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
                let is_unchanged = (fixed_frames.is_empty() && unreadable_frames.is_empty())
                    && robot_state.attached.is_empty()
                    && (robot_state.is_diff || !robot_state.names_joints)
                    && (entry_names.is_empty() && default_entry_names.is_empty())
                    && (link_padding.is_empty() && link_scale.is_empty())
                    && world.objects.is_empty();
                !(*is_diff && is_unchanged)
            }
        }
    }
}

/// Any update of a scene.
#[derive(Clone, Debug)]
pub enum SceneUpdate {
    /// A change of one obstacle.
    Object(Box<ObjectChange>),
    /// A change of one attached object.
    Attached(Box<AttachedChange>),
    /// Poses and velocities of obstacles.
    States(ObstacleStates),
    /// A replacement of all obstacles.
    World(Box<WorldChange>),
    /// A scene, or a difference to one.
    Scene(Box<SceneChange>),
    /// An octomap by itself; `None` removes it.
    Octomap(Option<OctomapPlacement>),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joint_positions_and_octomaps_change_no_objects() {
        let update = |scene: SceneChange| SceneUpdate::Scene(Box::new(scene));
        let diff = || SceneChange { is_diff: true, ..SceneChange::default() };
        let robot_state =
            RobotStateChange { is_diff: true, names_joints: true, ..RobotStateChange::default() };
        let map =
            OctomapPlacement { frame: String::new(), pose_fo: Pose::identity(), shape: None, is_blank: true };
        let world = WorldChange { objects: Vec::new(), octomap: Some(map.clone()) };
        let unchanged = [
            update(SceneChange { robot_state, ..diff() }),
            update(SceneChange { world, ..diff() }),
            SceneUpdate::Octomap(Some(map)),
        ];
        assert!(!unchanged.iter().any(SceneUpdate::changes_objects), "{unchanged:?}");
        let objects = vec![ObjectChange::named("a", Operation::Remove)];
        let world = WorldChange { objects, octomap: None };
        let padded = SceneChange { link_padding: vec![("link".to_owned(), 0.1)], ..diff() };
        let changing =
            [update(SceneChange::default()), update(SceneChange { world, ..diff() }), update(padded)];
        assert!(changing.iter().all(SceneUpdate::changes_objects), "{changing:?}");
    }
}
