//! C interface of the collision checker: creation, attached objects, joints, limits, states and pairs.

use std::collections::HashMap;
use std::ffi::{CString, c_char};
use std::ptr;
use std::sync::Arc;

use clearance::CollisionChecker;
use clearance::robot::{Configuration, RobotModel};
use clearance::scene::{AttachedId, AttachedObject, BodyId, Scene};
use clearance_bindings::{JointSpace, why_no_obstacle};

use crate::arguments::Arguments;
use crate::checker_options::{CheckSettings, clearance_checker_options};
use crate::robot::{clearance_robot, link_pose};
use crate::rows;
use crate::status::{Failure, Outcome, call, call_for, clearance_status};
use crate::structs::{
    clearance_named_value, clearance_pair, clearance_pose, clearance_state, named_values, texts,
};
use crate::texts::{Names, c_text};
use crate::world::clearance_world;

/// Checks states and motions of a robot in a world. Immutable: any number of threads may use it, each with its own
/// `clearance_workspace`. Queries on one state or motion take no lock.
///
/// States have all positions of the robot, or with `clearance_checker_options.group` those of the group, in the order of
/// `clearance_checker_joint_name`. Joint limits are not checked.
#[derive(Debug)]
pub struct clearance_checker {
    pub(crate) checker: CollisionChecker,
    pub(crate) space: Arc<JointSpace>,
    scene: Scene,
    settings: CheckSettings,
    joints: Names,
    bodies: HashMap<BodyId, CString>,
    pairs: Vec<(BodyId, BodyId)>,
    warnings: Names,
}

/// Warning of a checker that checks nothing.
const NO_PAIRS: &str = "the checker has no pair of bodies to check, so that every state counts as free: the robot or the world has no \
                        collision geometry, or the options allow all pairs";

impl clearance_checker {
    fn new(checker: CollisionChecker, space: Arc<JointSpace>, scene: Scene, settings: CheckSettings) -> Self {
        let joints = Names::new(space.names().iter().map(String::as_str));
        let bodies = body_names(&checker, &scene);
        let list = checker.pairs();
        let world = list.world_pairs().map(|(part, obstacle)| (part, BodyId::Obstacle(obstacle)));
        let pairs: Vec<_> = list.self_pairs().iter().copied().chain(world).collect();
        let warnings = Names::new(pairs.is_empty().then_some(NO_PAIRS));
        Self { checker, space, scene, settings, joints, bodies, pairs, warnings }
    }

    /// The same checker in another scene; hierarchies that do not change are shared.
    fn in_scene(&self, scene: Scene) -> Outcome<Self> {
        let settings = self.settings.without_missing_objects(self.model(), &scene)?;
        let (matrix, in_scene) = (settings.matrix(self.model(), &scene), settings.in_scene(&scene));
        let checker = self.checker.with_world(&scene.world, in_scene, matrix.as_ref());
        let checker = checker.map_err(Failure::rejected)?;
        Ok(Self::new(checker, Arc::clone(&self.space), scene, settings))
    }

    /// The robot.
    pub fn model(&self) -> &Arc<RobotModel> {
        self.space.robot()
    }

    /// Names of two bodies, valid as long as this checker.
    pub fn pair(&self, (a, b): (BodyId, BodyId)) -> clearance_pair {
        let name = |body| self.bodies.get(&body).map_or(ptr::null(), |name| name.as_ptr());
        clearance_pair { a: name(a), b: name(b) }
    }

    /// Reads a state, called `name`.
    pub fn read(
        &self,
        arguments: Arguments<'_>,
        state: clearance_state,
        name: &str,
    ) -> Outcome<Configuration> {
        let row = arguments.array(state.positions, state.n, name)?;
        rows::read(&self.space, row, &|| name.to_owned())
    }
}

fn body_names(checker: &CollisionChecker, scene: &Scene) -> HashMap<BodyId, CString> {
    let links = checker.robot().link_ids().map(BodyId::Link);
    let attached = (0..).map(|i| BodyId::Attached(AttachedId(i))).take(scene.world.attached().len());
    let obstacles = scene.world.ids().map(BodyId::Obstacle);
    links.chain(attached).chain(obstacles).map(|body| (body, c_text(checker.body_name(body)))).collect()
}

/// Makes a checker. A null `world` is empty, null `options` are the defaults. Takes the time to build hierarchies of all meshes.
///
/// Rejected: an unknown group, unknown names of links and objects, names that are given twice, paddings and scales out of their range,
/// and pairs of `checked_collisions` that cannot be checked. A checker that has no pair of bodies to check has a warning
/// (`clearance_checker_warning`).
#[unsafe(no_mangle)]
pub extern "C" fn clearance_checker_new(
    robot: *const clearance_robot,
    world: *const clearance_world,
    options: *const clearance_checker_options,
    checker: *mut *mut clearance_checker,
) -> clearance_status {
    call(|arguments| {
        let model = &arguments.object(robot, "robot")?.model;
        let world = arguments.object_or_none(world, "world")?;
        let scene = world.map(|world| world.scene.clone()).unwrap_or_default();
        let settings = CheckSettings::read(arguments, options)?;
        settings.check_names(model, &scene)?;
        let space = settings.space(model)?;
        let (matrix, in_scene) = (settings.matrix(model, &scene), settings.in_scene(&scene));
        let built = CollisionChecker::with_matrix(Arc::clone(model), &scene.world, in_scene, matrix.as_ref());
        let built = built.map_err(Failure::rejected)?;
        let made = clearance_checker::new(built, Arc::new(space), scene, settings);
        arguments.write_handle(checker, made, "checker")
    })
}

/// Makes the same checker for another world. Hierarchies of links and of obstacles that do not change are shared.
///
/// Paddings, scales and pairs of objects that the world does not have are dropped, also in checkers that are made from that one. Links hold
/// what is attached in that world, and nothing else. Rejected: a world in which a pair of `checked_collisions` cannot be checked.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_checker_with_world(
    checker: *const clearance_checker,
    world: *const clearance_world,
    with_world: *mut *mut clearance_checker,
) -> clearance_status {
    call(|arguments| {
        let checker = arguments.object(checker, "checker")?;
        let scene = arguments.object(world, "world")?.scene.clone();
        arguments.write_handle(with_world, checker.in_scene(scene)?, "with_world")
    })
}

/// How a link holds an obstacle.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct clearance_grasp {
    /// Name of the obstacle.
    pub object: *const c_char,
    /// Name of the link.
    pub link: *const c_char,
    /// Pose of the object in the frame of the link; if it is null, `state` determines it.
    pub pose: *const clearance_pose,
    /// State in which the link grasps the object where it is; not used if there is a pose.
    pub state: clearance_state,
    /// Links that may touch the object, besides `link`.
    pub touch_links: *const *const c_char,
    /// Number of these links.
    pub touch_link_count: usize,
}

/// Makes a checker in which an obstacle is attached to a link and moves with it.
///
/// Rejected: unknown names, and a pair of `checked_collisions` that cannot be checked any more, such as the object and this link.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_checker_attach(
    checker: *const clearance_checker,
    grasp: *const clearance_grasp,
    attached: *mut *mut clearance_checker,
) -> clearance_status {
    call(|arguments| {
        let checker = arguments.object(checker, "checker")?;
        let grasp = arguments.object(grasp, "grasp")?;
        let mut scene = checker.scene.clone();
        scene.world.attach(grasped(arguments, checker, grasp)?).map_err(Failure::rejected)?;
        arguments.write_handle(attached, checker.in_scene(scene)?, "attached")
    })
}

fn grasped(
    arguments: Arguments<'_>,
    checker: &clearance_checker,
    grasp: &clearance_grasp,
) -> Outcome<AttachedObject> {
    let (name, link) =
        (arguments.text(grasp.object, "grasp.object")?, arguments.text(grasp.link, "grasp.link")?);
    let obstacle = checker.scene.world.obstacle_by_name(name);
    let obstacle = obstacle.ok_or_else(|| Failure::rejected(why_no_obstacle(&checker.scene, name)))?;
    let has_pose = !grasp.pose.is_null();
    let q = if has_pose {
        checker.space.rest().clone()
    } else {
        checker.read(arguments, grasp.state, "grasp.state")?
    };
    let pose_rl = link_pose(checker.model(), link, &q)?;
    let touch_links = texts(arguments, grasp.touch_links, grasp.touch_link_count, "grasp.touch_links")?;
    for touched in &touch_links {
        link_pose(checker.model(), touched, &q)?;
    }
    let mut object = AttachedObject::grasped(obstacle, link, &pose_rl, touch_links);
    if has_pose {
        object.pose_lo = clearance_pose::read(arguments, grasp.pose, "grasp.pose")?;
    }
    Ok(object)
}

/// Makes a checker in which the attached object `name` is an obstacle, where it is in `state`.
///
/// Rejected: an object that is not attached, and a pair of `checked_collisions` that cannot be checked any more: of two obstacles.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_checker_detach(
    checker: *const clearance_checker,
    name: *const c_char,
    state: clearance_state,
    detached: *mut *mut clearance_checker,
) -> clearance_status {
    call(|arguments| {
        let checker = arguments.object(checker, "checker")?;
        let name = arguments.text(name, "name")?;
        let mut scene = checker.scene.clone();
        let object = scene.world.attached_by_name(name);
        let object = object.ok_or_else(|| Failure::rejected(format!("no object '{name}' is attached")))?;
        let pose_rl = link_pose(checker.model(), &object.link, &checker.read(arguments, state, "state")?)?;
        scene.world.detach(name, &pose_rl).map_err(Failure::rejected)?;
        arguments.write_handle(detached, checker.in_scene(scene)?, "detached")
    })
}

/// Frees a checker; null is ignored. Names of pairs in results were valid until here.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_checker_free(checker: *mut clearance_checker) {
    call(|arguments| arguments.release(checker, "checker"));
}

/// Makes a copy of the checker's world.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_checker_world(
    checker: *const clearance_checker,
    world: *mut *mut clearance_world,
) -> clearance_status {
    call(|arguments| {
        let scene = arguments.object(checker, "checker")?.scene.clone();
        arguments.write_handle(world, clearance_world::of_scene(scene), "world")
    })
}

/// Number of warnings about the checker, such as one that has no pair of bodies to check. Those of the robot and of the world are separate.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_checker_warning_count(checker: *const clearance_checker) -> usize {
    call_for(0, |arguments| Ok(arguments.object(checker, "checker")?.warnings.len()))
}

/// Text of a warning, valid as long as the checker; null beyond the last.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_checker_warning(
    checker: *const clearance_checker,
    index: usize,
) -> *const c_char {
    call_for(ptr::null(), |arguments| Ok(arguments.object(checker, "checker")?.warnings.get(index)))
}

/// Number of positions of a state.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_checker_joint_count(checker: *const clearance_checker) -> usize {
    call_for(0, |arguments| Ok(arguments.object(checker, "checker")?.joints.len()))
}

/// Name of a position of a state, valid as long as the checker; null beyond the last.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_checker_joint_name(
    checker: *const clearance_checker,
    index: usize,
) -> *const c_char {
    call_for(ptr::null(), |arguments| Ok(arguments.object(checker, "checker")?.joints.get(index)))
}

/// True if a whole turn of a position changes nothing: a continuous joint without mimic joints that it moves elsewhere. False beyond the
/// last.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_checker_joint_is_continuous(
    checker: *const clearance_checker,
    index: usize,
) -> bool {
    call_for(false, |arguments| {
        let checker = arguments.object(checker, "checker")?;
        let turns = checker.space.select(&checker.model().whole_turns());
        Ok(turns.get(index).copied().unwrap_or(false))
    })
}

/// Writes the `n` lower and `n` upper limits of a state (rad, m), also of the joints that mimic these; infinite without limit.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_checker_limits(
    checker: *const clearance_checker,
    lower: *mut f64,
    upper: *mut f64,
    n: usize,
) -> clearance_status {
    call(|arguments| {
        let checker = arguments.object(checker, "checker")?;
        let ranges = checker.model().position_ranges();
        let side =
            |k: usize| checker.space.select(&ranges.iter().map(|range| range[k]).collect::<Vec<f64>>());
        arguments.write_array(lower, n, &side(0), "lower")?;
        arguments.write_array(upper, n, &side(1), "upper")
    })
}

/// Writes a state of `n` positions with `count` joints set by name (rad, m); the others are at their defaults.
///
/// Rejected: unknown names, and joints outside of the group.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_checker_state(
    checker: *const clearance_checker,
    values: *const clearance_named_value,
    count: usize,
    positions: *mut f64,
    n: usize,
) -> clearance_status {
    call(|arguments| {
        let space = &arguments.object(checker, "checker")?.space;
        let values = named_values(arguments, values, count, "values")?;
        let given = values.iter().map(|(name, value)| (name.as_str(), *value));
        let q = space.robot().configuration_over(space.rest(), given).map_err(Failure::rejected)?;
        check_outside(space, &q)?;
        arguments.write_array(positions, n, &space.select(q.positions()), "positions")
    })
}

/// Rejects configurations whose positions outside of the group are not the fixed ones.
fn check_outside(space: &JointSpace, q: &Configuration) -> Outcome {
    let values = q.positions().iter().zip(space.rest().positions());
    let mut moved =
        space.robot().position_names().iter().zip(values).filter(|(_, (value, rest))| value != rest);
    match moved.find(|(name, _)| !space.names().contains(name)) {
        Some((name, _)) => Err(Failure::rejected(format!(
            "joint '{name}' is not among the joints of the checker ({}): give its value as fixed",
            space.names().join(", ")
        ))),
        None => Ok(()),
    }
}

/// Writes the `count` positions of the whole robot for a state of the checker.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_checker_expand(
    checker: *const clearance_checker,
    state: clearance_state,
    positions: *mut f64,
    count: usize,
) -> clearance_status {
    call(|arguments| {
        let q = arguments.object(checker, "checker")?.read(arguments, state, "state")?;
        arguments.write_array(positions, count, q.positions(), "positions")
    })
}

/// Number of pairs of bodies that are checked.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_checker_pair_count(checker: *const clearance_checker) -> usize {
    call_for(0, |arguments| Ok(arguments.object(checker, "checker")?.pairs.len()))
}

/// Names of a pair of bodies that is checked, valid as long as the checker; null beyond the last.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_checker_pair(checker: *const clearance_checker, index: usize) -> clearance_pair {
    call_for(clearance_pair::NONE, |arguments| {
        let checker = arguments.object(checker, "checker")?;
        Ok(checker.pairs.get(index).map_or(clearance_pair::NONE, |&pair| checker.pair(pair)))
    })
}
