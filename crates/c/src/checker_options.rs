//! C struct of the options of a checker, its defaults, and its conversion to settings.

use std::collections::HashMap;
use std::ffi::{c_char, c_int};
use std::ptr;
use std::sync::Arc;

use clearance::robot::RobotModel;
use clearance::scene::{AllowedCollisionMatrix, MeshModel, Scene, Settings, VolumeSelection};
use clearance_bindings::{JointSpace, PairSelection};

use crate::arguments::Arguments;
use crate::status::{Failure, Outcome};
use crate::structs::{clearance_named_value, clearance_pair, named_values};

/// Options of a checker. Start with `clearance_checker_options_default`: options of zeros are rejected, because they check
/// nothing. Flags are 0 or 1. Arrays are copied.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct clearance_checker_options {
    /// Group of the SRDF whose positions are those of a state, in the order of the robot, which `clearance_checker_joint_name` gives;
    /// null for all joints of the robot. A mimic joint of the group has no position; without its leader in the group, it stays in place.
    pub group: *const c_char,
    /// Positions (rad, m) of joints outside of the group; the others are at their defaults: 0, or the middle of limits that exclude 0.
    pub fixed: *const clearance_named_value,
    /// Number of fixed positions.
    pub fixed_count: usize,
    /// Safety distance (m) of all links against obstacles.
    pub padding: f64,
    /// Safety distances (m) of individual links, each once, instead of `padding`.
    pub link_padding: *const clearance_named_value,
    /// Number of link paddings.
    pub link_padding_count: usize,
    /// Scale factors of individual links.
    pub link_scale: *const clearance_named_value,
    /// Number of link scales.
    pub link_scale_count: usize,
    /// Safety distances (m) of individual objects, in addition to that of the links. Objects that the world of
    /// `clearance_checker_with_world` does not have lose theirs, also in checkers that are made from that one.
    pub object_padding: *const clearance_named_value,
    /// Number of object paddings.
    pub object_padding_count: usize,
    /// Scale factors of individual objects.
    pub object_scale: *const clearance_named_value,
    /// Number of object scales.
    pub object_scale_count: usize,
    /// Pairs that may touch, besides those that the world's file or else the SRDF allows.
    pub allowed_collisions: *const clearance_pair,
    /// Number of these pairs.
    pub allowed_collision_count: usize,
    /// Pairs that are checked, whatever the world's file or the SRDF allows. Not an attached object and a link that holds or may touch it,
    /// two objects that one link holds, or two obstacles: these cannot be checked.
    pub checked_collisions: *const clearance_pair,
    /// Number of these pairs.
    pub checked_collision_count: usize,
    /// Padding applies between links, too. Default 0.
    pub pad_self: c_int,
    /// Links are checked against links. Default 1.
    pub check_self: c_int,
    /// Links are checked against obstacles. Default 1.
    pub check_world: c_int,
    /// A closed mesh includes its inside; otherwise meshes are surfaces. Default 0.
    pub solid_meshes: c_int,
}

impl Default for clearance_checker_options {
    fn default() -> Self {
        Self {
            group: ptr::null(),
            fixed: ptr::null(),
            fixed_count: 0,
            padding: 0.0,
            link_padding: ptr::null(),
            link_padding_count: 0,
            link_scale: ptr::null(),
            link_scale_count: 0,
            object_padding: ptr::null(),
            object_padding_count: 0,
            object_scale: ptr::null(),
            object_scale_count: 0,
            allowed_collisions: ptr::null(),
            allowed_collision_count: 0,
            checked_collisions: ptr::null(),
            checked_collision_count: 0,
            pad_self: 0,
            check_self: 1,
            check_world: 1,
            solid_meshes: 0,
        }
    }
}

/// Options without group, fixed positions, paddings and pairs, that check everything.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_checker_options_default() -> clearance_checker_options {
    clearance_checker_options::default()
}

/// Options of a checker, read.
#[derive(Clone, Debug)]
pub struct CheckSettings {
    settings: Settings,
    group: Option<String>,
    fixed: Vec<(String, f64)>,
    pairs: PairSelection,
}

impl CheckSettings {
    /// Reads options; null is the default.
    pub fn read(arguments: Arguments<'_>, options: *const clearance_checker_options) -> Outcome<Self> {
        let given = arguments.object_or_none(options, "options")?.copied().unwrap_or_default();
        if given.check_self == 0 && given.check_world == 0 {
            return Err(Failure::rejected(
                "check_self and check_world of the options are 0, so that nothing is checked: start with \
                 clearance_checker_options_default",
            ));
        }
        let by_name = |values, count, what: &str| -> Outcome<HashMap<String, f64>> {
            let mut read = HashMap::new();
            for (name, value) in named_values(arguments, values, count, what)? {
                if read.insert(name.clone(), value).is_some() {
                    return Err(Failure::rejected(format!("{what}: '{name}' is given twice: give it once")));
                }
            }
            Ok(read)
        };
        let settings = Settings {
            padding: given.padding,
            link_padding: by_name(given.link_padding, given.link_padding_count, "link_padding")?,
            link_scale: by_name(given.link_scale, given.link_scale_count, "link_scale")?,
            object_padding: by_name(given.object_padding, given.object_padding_count, "object_padding")?,
            object_scale: by_name(given.object_scale, given.object_scale_count, "object_scale")?,
            pad_self: given.pad_self != 0,
            check_self: given.check_self != 0,
            check_world: given.check_world != 0,
            mesh_model: if given.solid_meshes == 0 { MeshModel::Surface } else { MeshModel::Solid },
            volumes: VolumeSelection::default(),
        };
        let pairs = |pairs, count, what| pairs_of_names(arguments, pairs, count, what);
        Ok(Self {
            settings,
            group: arguments.text_or_none(given.group, "group")?.map(str::to_owned),
            fixed: named_values(arguments, given.fixed, given.fixed_count, "fixed")?,
            pairs: PairSelection {
                allowed: pairs(
                    given.allowed_collisions,
                    given.allowed_collision_count,
                    "allowed_collisions",
                )?,
                checked: pairs(
                    given.checked_collisions,
                    given.checked_collision_count,
                    "checked_collisions",
                )?,
            },
        })
    }

    /// The joints of a state.
    pub fn space(&self, robot: &Arc<RobotModel>) -> Outcome<JointSpace> {
        let space = JointSpace::of_group(Arc::clone(robot), self.group.as_deref(), &self.fixed);
        space.map_err(Failure::rejected)
    }

    /// Rejects names of the pairs and objects that neither the robot nor the scene has, and pairs that cannot be checked.
    pub fn check_names(&self, robot: &RobotModel, scene: &Scene) -> Outcome {
        self.pairs.check_names(&self.settings, robot, scene).map_err(Failure::rejected)
    }

    /// These options for another scene: without those of objects that it does not have.
    pub fn without_missing_objects(&self, robot: &RobotModel, scene: &Scene) -> Outcome<Self> {
        let mut kept = self.clone();
        kept.pairs.remove_missing_objects(&mut kept.settings, robot, scene);
        kept.check_names(robot, scene)?;
        Ok(kept)
    }

    /// The matrix that selects the pairs; none if this is up to the SRDF.
    pub fn matrix(&self, robot: &RobotModel, scene: &Scene) -> Option<AllowedCollisionMatrix> {
        self.pairs.matrix(robot, scene)
    }

    /// The settings of the library in a scene.
    pub fn in_scene(&self, scene: &Scene) -> Settings {
        self.settings.clone().with_scene(scene)
    }
}

fn pairs_of_names(
    arguments: Arguments<'_>,
    pairs: *const clearance_pair,
    count: usize,
    what: &str,
) -> Outcome<Vec<(String, String)>> {
    let pairs = arguments.array(pairs, count, what)?.iter().enumerate();
    let named = pairs.map(|(i, pair)| {
        let name = |text, side| Ok(arguments.text(text, &format!("{what}[{i}].{side}"))?.to_owned());
        Ok((name(pair.a, "a")?, name(pair.b, "b")?))
    });
    named.collect()
}
