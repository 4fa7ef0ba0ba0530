//! Conversion of `moveit_msgs` about the world to scene changes. Numbers are validated here, names where the changes
//! are applied.

use clearance_geometry::Shape;
use clearance_geometry::math::Pose;
use clearance_robot::check_name_length;
use clearance_scene::{
    AttachedChange, FixedFrame, MatrixEntries, ObjectChange, ObstacleShape, Operation, RobotStateChange,
    SceneChange, SceneRejection, StatedPositions, WorldChange, mesh, plane, solid,
};
use ros2_interfaces_jazzy_serde::geometry_msgs::msg::{Pose as PoseMessage, TransformStamped};
use ros2_interfaces_jazzy_serde::moveit_msgs::msg::{
    AllowedCollisionMatrix, AttachedCollisionObject, CollisionObject, PlanningScene, PlanningSceneWorld,
    RobotState,
};
use ros2_interfaces_jazzy_serde::shape_msgs::msg::{Mesh, Plane, SolidPrimitive};

use crate::scene::octomap_messages::octomap_with_pose;
use crate::scene::transform_messages::pose;
use crate::scene::transform_messages::transform_pose;

/// Content of a message with several parts, and the parts that were rejected.
pub struct Converted<T> {
    pub change: T,
    pub rejections: Vec<SceneRejection>,
}

/// Converts a `moveit_msgs/CollisionObject`.
pub fn object_change(message: &CollisionObject) -> Result<ObjectChange, SceneRejection> {
    let reject = |why: String| SceneRejection::of(&message.id, why);
    let operation = Operation::from_number(message.operation.into()).ok_or_else(|| {
        let given = message.operation;
        reject(format!("operation is {given}, but must be ADD (0), REMOVE (1), APPEND (2) or MOVE (3)"))
    })?;
    let kind = [message.type_.db.clone(), message.type_.key.clone()];
    let mut change = ObjectChange { kind, ..ObjectChange::named(message.id.clone(), operation) };
    if operation == Operation::Remove {
        return Ok(change);
    }
    change.frame.clone_from(&message.header.frame_id);
    if operation == Operation::Move {
        let reject = |why| reject(why).of_pose();
        change.pose_fo = pose(&message.pose, "pose").map_err(reject)?;
        change.shape_poses = shape_poses(message).map_err(reject)?;
        change.shapes = bare_shapes(message).map_err(reject)?;
        return Ok(change);
    }
    change.pose_fo = pose(&message.pose, "pose").map_err(reject)?;
    change.shapes = shapes(message).map_err(reject)?;
    change.subframes = subframes(message).map_err(reject)?;
    Ok(change)
}

/// All shapes with their poses in the object frame: primitives, meshes, planes.
fn shapes(message: &CollisionObject) -> Result<Vec<ObstacleShape>, String> {
    let mut placed = Vec::new();
    let mut add = |field: &str, made: Vec<Result<Shape, String>>, poses: &[PoseMessage]| {
        if poses.len() > made.len() {
            let (given, of) = (poses.len(), made.len());
            return Err(format!("{field}_poses: {given} poses for {of} shapes"));
        }
        for (i, shape) in made.into_iter().enumerate() {
            let pose_os = match poses.get(i) {
                Some(given) => pose(given, &format!("{field}_poses[{i}]"))?,
                None => Pose::identity(),
            };
            let shape = shape.map_err(|why| format!("{field}[{i}]: {why}"))?;
            placed.push(ObstacleShape { pose_os, shape });
        }
        Ok(())
    };
    let primitives = message.primitives.iter().map(primitive).collect();
    add("primitive", primitives, &message.primitive_poses)?;
    add("mesh", message.meshes.iter().map(mesh_shape).collect(), &message.mesh_poses)?;
    let planes = message.planes.iter().map(|Plane { coef }| plane(*coef)).collect();
    add("plane", planes, &message.plane_poses)?;
    Ok(placed)
}

/// The poses of the shapes without the shapes, in the same order.
fn shape_poses(message: &CollisionObject) -> Result<Vec<Pose>, String> {
    let CollisionObject { primitive_poses, mesh_poses, plane_poses, .. } = message;
    let fields = [("primitive", primitive_poses), ("mesh", mesh_poses), ("plane", plane_poses)];
    let all = fields.into_iter().flat_map(|(field, poses)| poses.iter().enumerate().map(move |p| (field, p)));
    all.map(|(field, (i, given))| pose(given, &format!("{field}_poses[{i}]"))).collect()
}

/// The shapes of a message without their poses.
fn bare_shapes(message: &CollisionObject) -> Result<Vec<ObstacleShape>, String> {
    let bare = CollisionObject {
        primitive_poses: Vec::new(),
        mesh_poses: Vec::new(),
        plane_poses: Vec::new(),
        ..message.clone()
    };
    shapes(&bare)
}

fn primitive(message: &SolidPrimitive) -> Result<Shape, String> {
    solid(message.type_, &message.dimensions)
}

fn mesh_shape(message: &Mesh) -> Result<Shape, String> {
    let vertices = message.vertices.iter().map(|v| [v.x, v.y, v.z]).collect();
    mesh(vertices, message.triangles.iter().map(|t| t.vertex_indices).collect())
}

fn subframes(message: &CollisionObject) -> Result<Vec<(String, Pose)>, String> {
    let (names, poses) = (&message.subframe_names, &message.subframe_poses);
    if names.len() != poses.len() {
        return Err(format!("subframe_poses: {} poses for {} subframe_names", poses.len(), names.len()));
    }
    let place = |(i, (name, place)): (usize, (&String, &PoseMessage))| {
        Ok((name.clone(), pose(place, &format!("subframe_poses[{i}]"))?))
    };
    names.iter().zip(poses).enumerate().map(place).collect()
}

/// Converts a `moveit_msgs/AttachedCollisionObject`. The weight and the detach posture do not affect collisions.
pub fn attached_change(message: &AttachedCollisionObject) -> Result<AttachedChange, SceneRejection> {
    Ok(AttachedChange {
        link: message.link_name.clone(),
        object: object_change(&message.object).map_err(SceneRejection::of_attached)?,
        touch_links: message.touch_links.clone(),
    })
}

/// Converts a `moveit_msgs/PlanningSceneWorld`.
pub fn world_change(message: &PlanningSceneWorld, unknown_is_occupied: bool) -> Converted<WorldChange> {
    let (objects, mut rejections) = separated(message.collision_objects.iter().map(object_change));
    let octomap = octomap_with_pose(&message.octomap, unknown_is_occupied).unwrap_or_else(|rejection| {
        rejections.push(rejection);
        None
    });
    Converted { change: WorldChange { objects, octomap }, rejections }
}

/// Separates valid parts from rejected ones.
fn separated<T>(results: impl Iterator<Item = Result<T, SceneRejection>>) -> (Vec<T>, Vec<SceneRejection>) {
    let (mut right, mut rejections) = (Vec::new(), Vec::new());
    for result in results {
        match result {
            Ok(change) => right.push(change),
            Err(rejection) => rejections.push(rejection),
        }
    }
    (right, rejections)
}

/// Converts the attached objects of a `moveit_msgs/RobotState`.
pub fn robot_state_change(message: &RobotState) -> Converted<RobotStateChange> {
    let (attached, mut rejections) =
        separated(message.attached_collision_objects.iter().map(attached_change));
    let joints = &message.joint_state;
    let names_joints = !(joints.name.is_empty() && message.multi_dof_joint_state.joint_names.is_empty());
    let (count, names) = (joints.position.len(), joints.name.len());
    let fault = (count != names).then(|| format!("{count} positions for {names} names"));
    if let Some(fault) = &fault {
        rejections.push(SceneRejection::new(format!("robot_state.joint_state: {fault}")));
    }
    let positions = StatedPositions {
        single: joints.name.iter().cloned().zip(joints.position.iter().copied()).collect(),
        with_transforms: message.multi_dof_joint_state.joint_names.clone(),
        fault,
    };
    let change = RobotStateChange { is_diff: message.is_diff, names_joints, positions, attached };
    Converted { change, rejections }
}

/// Converts a `moveit_msgs/PlanningScene`. Colours do not affect collisions.
pub fn scene_change(message: &PlanningScene, unknown_is_occupied: bool) -> Converted<SceneChange> {
    let world = world_change(&message.world, unknown_is_occupied);
    let robot_state = robot_state_change(&message.robot_state);
    let (fixed_frames, mut rejections) = separated(message.fixed_frame_transforms.iter().map(fixed_frame));
    let unreadable = message.fixed_frame_transforms.iter().filter(|frame| fixed_frame(frame).is_err());
    let unreadable_frames =
        unreadable.flat_map(|f| [&f.child_frame_id, &f.header.frame_id]).cloned().collect();
    rejections.extend(robot_state.rejections);
    rejections.extend(world.rejections);
    let change = SceneChange {
        robot_model_name: message.robot_model_name.clone(),
        is_diff: message.is_diff,
        fixed_frames,
        unreadable_frames,
        robot_state: robot_state.change,
        matrix: entries(&message.allowed_collision_matrix),
        link_padding: message.link_padding.iter().map(|l| (l.link_name.clone(), l.padding)).collect(),
        link_scale: message.link_scale.iter().map(|l| (l.link_name.clone(), l.scale)).collect(),
        world: world.change,
        keeps_octomap: false,
    };
    Converted { change, rejections }
}

/// Whether a scene has objects without shapes, or a matrix without entries: a node publishes them in place of
/// those that are too large for a topic. They are rejected.
#[must_use]
pub fn lacks_content(message: &PlanningScene) -> bool {
    let has_no_shapes = |object: &CollisionObject| {
        object.primitives.is_empty() && object.meshes.is_empty() && object.planes.is_empty()
    };
    let attached = message.robot_state.attached_collision_objects.iter().map(|attached| &attached.object);
    let appended = attached.filter(|object| object.operation == CollisionObject::APPEND);
    let objects = message.world.collision_objects.iter();
    let added = objects.filter(|object| object.operation == CollisionObject::ADD);
    let matrix = &message.allowed_collision_matrix;
    appended.chain(added).any(has_no_shapes) || matrix.entry_values.len() < matrix.entry_names.len()
}

fn fixed_frame(message: &TransformStamped) -> Result<FixedFrame, SceneRejection> {
    (check_name_length(&message.child_frame_id))
        .map_err(|why| SceneRejection::new(format!("fixed_frame_transforms: {why}")))?;
    let pose_pf = transform_pose(&message.transform).map_err(|why| {
        let frame = &message.child_frame_id;
        SceneRejection::new(format!("fixed_frame_transforms: frame '{frame}': {why}"))
    })?;
    Ok(FixedFrame { name: message.child_frame_id.clone(), parent: message.header.frame_id.clone(), pose_pf })
}

fn entries(message: &AllowedCollisionMatrix) -> MatrixEntries {
    MatrixEntries {
        entry_names: message.entry_names.clone(),
        entry_values: message.entry_values.iter().map(|row| row.enabled.clone()).collect(),
        default_entry_names: message.default_entry_names.clone(),
        default_entry_values: message.default_entry_values.clone(),
    }
}
