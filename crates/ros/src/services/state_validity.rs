//! Evaluates requests of `check_state_validity`, as defined by `moveit_msgs/GetStateValidity`. No I/O.

use clearance_checker::{CollisionChecker, Question};
use clearance_geometry::math::Pose;
use clearance_monitor::{CheckedState, Evaluation, Now, Reason};
use clearance_robot::quoted_list;
use clearance_robot::{Configuration, JointId, LinkId, LinkPoses, RobotModel};
use clearance_scene::AttachedId;
use clearance_scene::BodyId;
use clearance_scene::{
    Applied, AttachedChange, MultiDofJoint, ObjectChange, Operation, Scene, SceneContext, SceneRejection,
    SceneUpdate, TransformTree,
};
use ros2_interfaces_jazzy_serde::moveit_msgs::msg::{Constraints, RobotState};
use ros2_interfaces_jazzy_serde::moveit_msgs::srv::{GetStateValidityRequest, GetStateValidityResponse};
use ros2_interfaces_jazzy_serde::sensor_msgs::msg::MultiDOFJointState;
use std::collections::HashSet;
use std::sync::Arc;
use std::time::Instant;

use crate::scene::active_scene::ActiveScene;
use crate::scene::scene_checker::checker_of;
use crate::scene::scene_message_reader::robot_state_change;
use crate::scene::transform_messages::transform_pose;
use crate::services::request_context::undecided;
use crate::services::validity_contacts::{CONTACT_TIME, ContactsOfState};

/// Scene and evaluation that a query is evaluated against.
pub struct ValidityContext<'s> {
    pub scene: &'s ActiveScene,
    pub evaluation: Option<&'s Evaluation>,
    pub transforms: &'s TransformTree,
    pub now: Now,
}

/// A response, and a remark for the log: the type has no field for it.
#[derive(Debug)]
pub struct StateValidity {
    pub response: GetStateValidityResponse,
    pub remark: Option<String>,
}

/// Evaluates a query, or returns why the state cannot be evaluated.
pub fn state_validity(
    request: &GetStateValidityRequest,
    context: &ValidityContext,
) -> Result<StateValidity, String> {
    let ActiveScene { revision, scene, .. } = context.scene;
    let robot = revision.checker.robot();
    if let Some(reason) = unknown_world(context) {
        return Err(reason.to_string());
    }
    let group = links_of_group(robot, &request.group_name)?;
    let q = configuration(robot, &request.robot_state, context)?;
    let mut poses = LinkPoses::new(robot);
    robot.forward_kinematics(&q, &mut poses);
    let changed = with_request(&request.robot_state, scene, &poses, context)?;
    let built;
    let checker = match &changed {
        None => &revision.checker,
        Some(changed) => {
            let ActiveScene { mesh_model, parameters, .. } = context.scene;
            built = checker_of(robot, changed, *mesh_model, parameters, Some(&revision.checker))?;
            &built
        }
    };
    let mut workspace = checker.workspace();
    let report = checker.check(&q, Question::PairDistances { limit: 0.0 }, &mut workspace);
    let in_group = |body: BodyId| group.as_ref().is_none_or(|links| moves(checker, body, links));
    let colliding = report.colliding_pairs.iter().filter(|(a, b)| in_group(*a) || in_group(*b));
    let colliding: Vec<_> = colliding.copied().collect();
    let search = ContactsOfState { checker, q: &q, poses: &poses, now: context.now };
    let found = search.contacts(&colliding, Instant::now() + CONTACT_TIME, &mut workspace);
    let has_constraints = constraints_given(&request.constraints);
    let response = GetStateValidityResponse {
        valid: colliding.is_empty() && report.undecided.is_empty() && !has_constraints,
        contacts: found.messages,
        ..GetStateValidityResponse::default()
    };
    Ok(StateValidity { response, remark: found.remark })
}

/// Why the world around the robot is unknown, or which robot it is.
fn unknown_world(context: &ValidityContext) -> Option<Reason> {
    let ValidityContext { scene, evaluation, now, .. } = context;
    if evaluation.is_some_and(|evaluation| evaluation.is_swapping) {
        return Some(Reason::ModelSwap);
    }
    if !scene.revision.has_geometry() {
        return Some(Reason::NoGeometry);
    }
    let stale = evaluation.and_then(|evaluation| evaluation.stale_world.clone());
    // a scene that the monitor has not processed yet may be incomplete
    let evaluated = evaluation.and_then(|evaluation| evaluation.revision.as_ref());
    let is_evaluated = evaluated.is_some_and(|evaluated| Arc::ptr_eq(evaluated, &scene.revision));
    let incomplete = scene.revision.incomplete.clone().filter(|_| !is_evaluated);
    scene.revision.stale_world(*now).or(incomplete).or(stale)
}

/// Whether a request contains constraints.
pub fn constraints_given(constraints: &Constraints) -> bool {
    let Constraints { joint_constraints, position_constraints, orientation_constraints, .. } = constraints;
    !(joint_constraints.is_empty()
        && position_constraints.is_empty()
        && orientation_constraints.is_empty()
        && constraints.visibility_constraints.is_empty())
}

/// Links that a group moves: those below its joints; `None` for the whole robot.
fn links_of_group(robot: &RobotModel, name: &str) -> Result<Option<HashSet<LinkId>>, String> {
    if name.is_empty() {
        return Ok(None);
    }
    let groups = robot.srdf().map_or(&[][..], |srdf| &srdf.groups);
    let group = groups.iter().find(|group| group.name == name).ok_or_else(|| {
        let known: Vec<String> = groups.iter().map(|group| group.name.clone()).collect();
        let known = if known.is_empty() { "none".to_owned() } else { quoted_list(&known) };
        format!(
            "group_name: the robot has no group {}; the SRDF has {known}",
            quoted_list(&[name.to_owned()])
        )
    })?;
    // joints that mimic a joint of the group, or that one of its joints mimics, move with it
    let driver = |id: JointId| match robot.joint(id).mimic {
        Some(mimic) => (mimic.multiplier != 0.0).then_some(mimic.joint),
        None => Some(id),
    };
    let drivers: HashSet<JointId> = group.joints.iter().filter_map(|&id| driver(id)).collect();
    let mut links: HashSet<LinkId> = HashSet::new();
    for &id in robot.topological_order() {
        let joint = robot.joint(id);
        let moves = group.joints.contains(&id) || driver(id).is_some_and(|driver| drivers.contains(&driver));
        if moves || links.contains(&joint.parent) {
            links.insert(joint.child);
        }
    }
    if group.links.contains(&robot.root()) {
        links.insert(robot.root());
    }
    if links.is_empty() {
        // no pair of the group would be checked: nothing would be proven
        return Err(format!(
            "group_name: group {} has no joint and no link of the robot's URDF",
            quoted_list(&[name.to_owned()])
        ));
    }
    Ok(Some(links))
}

/// Whether a body moves with one of these links.
fn moves(checker: &CollisionChecker, body: BodyId, links: &HashSet<LinkId>) -> bool {
    match body {
        BodyId::Link(link) => links.contains(&link),
        BodyId::Attached(id) => carrier(checker, id).is_some_and(|link| links.contains(&link)),
        BodyId::Obstacle(_) => false,
    }
}

/// The link that carries an object.
pub fn carrier(checker: &CollisionChecker, id: AttachedId) -> Option<LinkId> {
    checker.robot().link_by_name(&checker.world().attached_object(id).link)
}

/// The positions of the request, merged into the current ones.
fn configuration(
    robot: &Arc<RobotModel>,
    state: &RobotState,
    context: &ValidityContext,
) -> Result<Configuration, String> {
    let given = &state.joint_state;
    if given.name.len() != given.position.len() {
        let (names, positions) = (given.name.len(), given.position.len());
        return Err(format!("robot_state.joint_state has {names} names and {positions} positions"));
    }
    let placed = placed_joints(robot, &state.multi_dof_joint_state)
        .map_err(|why| format!("robot_state.multi_dof_joint_state: {why}"))?;
    let field = if placed.is_empty() { "robot_state.joint_state" } else { "robot_state" };
    let reject = |error| format!("{field}: {error}");
    let single = given.name.iter().map(String::as_str).zip(given.position.iter().copied());
    let several = placed.iter().map(|(name, position)| (name.as_str(), *position));
    let (names, positions): (Vec<&str>, Vec<f64>) = single.chain(several).unzip();
    let named = robot.named_joints(names).map_err(reject)?;
    let default;
    let rest = if let Some(checked_state) = current_state(context) {
        &checked_state.configuration
    } else {
        let missing = undecided(robot, &named);
        if !missing.is_empty() {
            return Err(format!(
                "robot_state.joint_state has no position of {}, and no fresh joint state has it",
                quoted_list(&missing)
            ));
        }
        default = robot.default_configuration();
        &default
    };
    named.configuration(rest, &positions).map_err(reject)
}

/// Current configuration of the robot, if it is known.
fn current_state<'s>(context: &ValidityContext<'s>) -> Option<&'s CheckedState> {
    let evaluation = context.evaluation?;
    let same = evaluation.revision.as_ref()?.model == context.scene.revision.model;
    evaluation.robot_state.as_deref().filter(|_| same)
}

/// Positions of planar and floating joints, by name. The virtual joint, which places the root in the world, must be at
/// zero.
fn placed_joints(robot: &RobotModel, given: &MultiDOFJointState) -> Result<Vec<(String, f64)>, String> {
    let (names, transforms) = (&given.joint_names, &given.transforms);
    if names.len() != transforms.len() {
        return Err(format!("{} joint_names and {} transforms", names.len(), transforms.len()));
    }
    let mut placed = Vec::new();
    for (name, transform) in names.iter().zip(transforms) {
        let quoted = quoted_list(std::slice::from_ref(name));
        let pose = transform_pose(transform).map_err(|why| format!("{quoted}: {why}"))?;
        if MultiDofJoint::find(robot, name).is_only_virtual() {
            if pose != Pose::identity() {
                return Err(format!(
                    "virtual joint {quoted} can not be moved here: leave it out, or at zero"
                ));
            }
            continue;
        }
        let frame = &given.header.frame_id;
        if !robot.is_model_frame(frame) {
            let frame = quoted_list(std::slice::from_ref(frame));
            let root = &robot.link(robot.root()).name;
            return Err(format!("header.frame_id is {frame}, but must be '{root}' or empty"));
        }
        placed.extend(robot.positions_of_transform(name, &pose).map_err(|error| error.to_string())?);
    }
    Ok(placed)
}

/// An object that is added more than once: the second one would replace the first.
fn attached_twice(attached: &[AttachedChange]) -> Option<&str> {
    let mut added = HashSet::new();
    let objects = attached.iter().map(|change| &change.object);
    let mut adds = objects.filter(|object| object.operation == Operation::Add);
    adds.find(|object| !added.insert(&object.id)).map(|object| object.id.as_str())
}

/// The scene with the attached objects of the request; `None` if that changes nothing. As in `MoveIt`, a detached
/// object is removed, not put into the world.
fn with_request(
    state: &RobotState,
    scene: &Scene,
    poses: &LinkPoses,
    context: &ValidityContext,
) -> Result<Option<Scene>, String> {
    let named = |rejection: &SceneRejection| format!("robot_state.attached_collision_objects: {rejection}");
    let mut read = robot_state_change(state);
    if let Some(rejection) = read.rejections.first() {
        return Err(named(rejection));
    }
    if let Some(id) = attached_twice(&read.change.attached) {
        let id = id.escape_debug();
        return Err(format!(
            "robot_state.attached_collision_objects: object '{id}' is added twice, and only one could be checked"
        ));
    }
    let ActiveScene { revision, parameters, .. } = context.scene;
    let robot = revision.checker.robot();
    let (transforms, now) = (context.transforms, context.now.ros);
    let context_at = |poses| SceneContext::new(robot, poses, transforms, now, parameters.transform_ttl);
    let requested_context = context_at(Some(poses));
    // objects attached from the world are attached at the robot's current configuration
    let robot_state = current_state(context);
    let current_context = context_at(robot_state.map(|checked_state| &checked_state.poses));
    let (mut changed, mut applied) = (scene.clone(), Applied::default());
    let attached = std::mem::take(&mut read.change.attached);
    // operations that a complete state must not contain are rejected together with the rest of the state
    let is_diff = read.change.is_diff;
    let (possible, impossible): (Vec<_>, Vec<_>) =
        attached.into_iter().partition(|change| is_diff || change.object.operation == Operation::Add);
    read.change.attached = impossible;
    changed.change_robot_state(&read.change, true, &requested_context, &mut applied);
    for change in possible {
        let ObjectChange { operation, shapes, .. } = &change.object;
        if *operation == Operation::Remove {
            changed.let_go(&change, &requested_context).map_err(|rejection| named(&rejection))?;
            applied.changed = true;
            continue;
        }
        let scene_context = if shapes.is_empty() { &current_context } else { &requested_context };
        let applied_change = changed.apply(&SceneUpdate::Attached(Box::new(change)), scene_context);
        applied.changed |= applied_change.changed;
        applied.refusals.extend(applied_change.refusals);
    }
    match applied.refusals.first() {
        Some(rejection) => Err(named(rejection)),
        None => Ok(applied.changed.then_some(changed)),
    }
}

#[cfg(test)]
mod tests;
