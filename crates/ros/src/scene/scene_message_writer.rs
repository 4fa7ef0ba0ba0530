//! Conversion of the scene to `moveit_msgs`.

use clearance_geometry::math::{Extremes, Pose};
use clearance_geometry::{Primitive, Shape, TriangleMesh};
use clearance_robot::{Configuration, RobotModel};
use clearance_scene::AllowedCollisionMatrix as Matrix;
use clearance_scene::{AttachedObject, FileOctree, OCTOMAP, Obstacle, ObstacleShape, Scene};
use ros2_interfaces_jazzy_serde::geometry_msgs::msg::{
    Point as PointMessage, Quaternion, Transform, TransformStamped, Vector3,
};
use ros2_interfaces_jazzy_serde::moveit_msgs::msg::{
    AllowedCollisionEntry, AllowedCollisionMatrix, AttachedCollisionObject, CollisionObject, LinkPadding,
    LinkScale, PlanningScene, PlanningSceneComponents as Components, RobotState,
};
use ros2_interfaces_jazzy_serde::object_recognition_msgs::msg::ObjectType;
use ros2_interfaces_jazzy_serde::octomap_msgs::msg::{Octomap, OctomapWithPose};
use ros2_interfaces_jazzy_serde::sensor_msgs::msg::JointState;
use ros2_interfaces_jazzy_serde::shape_msgs::msg::{Mesh, MeshTriangle, Plane, SolidPrimitive};
use ros2_interfaces_jazzy_serde::std_msgs::msg::Header;

use crate::messages::time_and_geometry::pose_message;

/// Inputs of the conversion.
pub struct SceneMessages<'t> {
    pub robot: &'t RobotModel,
    pub scene: &'t Scene,
    /// Padding (m) of links that the scene does not name.
    pub padding: f64,
    /// Current configuration of the robot, if it is known.
    pub configuration: Option<&'t Configuration>,
    /// Octomap message as it was received; `None` also if the octomap is the octree of a world file.
    pub octomap: Option<&'t OctomapWithPose>,
}

/// The scene with the components that a client requests, as a bit set; all of them if it requests none.
#[must_use]
pub fn scene_message(writer: &SceneMessages, components: u32) -> PlanningScene {
    let wanted = |component: u32| components == 0 || components & component != 0;
    let mut message = PlanningScene::default();
    if wanted(Components::SCENE_SETTINGS) {
        writer.robot.name().clone_into(&mut message.robot_model_name);
    }
    if wanted(Components::TRANSFORMS) {
        message.fixed_frame_transforms = writer.fixed_frames();
    }
    if wanted(Components::ROBOT_STATE) || wanted(Components::ROBOT_STATE_ATTACHED_OBJECTS) {
        message.robot_state = writer.robot_state(wanted(Components::ROBOT_STATE_ATTACHED_OBJECTS));
    }
    if wanted(Components::ALLOWED_COLLISION_MATRIX) {
        message.allowed_collision_matrix = writer.matrix();
    }
    if wanted(Components::LINK_PADDING_AND_SCALING) {
        (message.link_padding, message.link_scale) = writer.link_sizes();
    }
    if wanted(Components::WORLD_OBJECT_GEOMETRY) {
        message.world.collision_objects = writer.objects().map(|o| writer.object_message(o)).collect();
    } else if wanted(Components::WORLD_OBJECT_NAMES) {
        let named = |o: &Obstacle| CollisionObject {
            id: o.name.clone(),
            type_: writer.kind(&o.name),
            ..CollisionObject::default()
        };
        message.world.collision_objects = writer.objects().map(named).collect();
    }
    if wanted(Components::OCTOMAP)
        && let Some(octomap) = writer.file_octomap().or_else(|| writer.octomap.cloned())
    {
        message.world.octomap = octomap;
    }
    message
}

impl SceneMessages<'_> {
    fn root(&self) -> &str {
        &self.robot.link(self.robot.root()).name
    }

    /// Obstacles that a `CollisionObject` message can represent.
    pub fn objects(&self) -> impl Iterator<Item = &Obstacle> {
        self.scene.world.obstacles().filter(|object| is_representable(object))
    }

    /// The octree of a world file, while it is the octomap.
    fn file_octomap(&self) -> Option<OctomapWithPose> {
        let FileOctree { resolution, data } = self.scene.file_octree()?;
        let obstacle = self.scene.world.obstacle_by_name(OCTOMAP)?;
        let header = Header { frame_id: self.root().to_owned(), ..Header::default() };
        let octomap = Octomap {
            header: header.clone(),
            binary: true,
            id: "OcTree".to_owned(),
            resolution: *resolution,
            data: data.iter().map(|byte| byte.cast_signed()).collect(),
        };
        Some(OctomapWithPose { header, origin: pose_message(&obstacle.pose_ro), octomap })
    }

    pub fn kind(&self, name: &str) -> ObjectType {
        let [db, key] = self.scene.kinds.get(name).cloned().unwrap_or_default();
        ObjectType { key, db }
    }

    pub fn object_message(&self, object: &Obstacle) -> CollisionObject {
        self.collision_object(&object.name, self.root(), &object.pose_ro, &object.shapes, &object.subframes)
    }

    /// The new pose of an object whose shapes are known.
    pub fn move_message(&self, object: &Obstacle) -> CollisionObject {
        CollisionObject {
            header: Header { frame_id: self.root().to_owned(), ..Header::default() },
            pose: pose_message(&object.pose_ro),
            id: object.name.clone(),
            operation: CollisionObject::MOVE,
            ..CollisionObject::default()
        }
    }

    pub fn attached_message(&self, object: &AttachedObject) -> AttachedCollisionObject {
        AttachedCollisionObject {
            link_name: object.link.clone(),
            object: self.collision_object(
                &object.name,
                &object.link,
                &object.pose_lo,
                &object.shapes,
                &object.subframes,
            ),
            touch_links: object.touch_links.clone(),
            ..AttachedCollisionObject::default()
        }
    }

    fn collision_object(
        &self,
        name: &str,
        frame: &str,
        pose: &Pose,
        shapes: &[ObstacleShape],
        subframes: &[(String, Pose)],
    ) -> CollisionObject {
        let mut message = CollisionObject {
            header: Header { frame_id: frame.to_owned(), ..Header::default() },
            pose: pose_message(pose),
            id: name.to_owned(),
            type_: self.kind(name),
            subframe_names: subframes.iter().map(|(name, _)| name.clone()).collect(),
            subframe_poses: subframes.iter().map(|(_, pose)| pose_message(pose)).collect(),
            operation: CollisionObject::ADD,
            ..CollisionObject::default()
        };
        for ObstacleShape { pose_os, shape } in shapes {
            let pose_os = pose_message(pose_os);
            match shape {
                Shape::Primitive(primitive) => {
                    message.primitives.push(primitive_message(primitive));
                    message.primitive_poses.push(pose_os);
                }
                Shape::Mesh(mesh) => {
                    message.meshes.push(mesh_message(mesh));
                    message.mesh_poses.push(pose_os);
                }
                Shape::Plane(plane) => {
                    let n = plane.normal;
                    message.planes.push(Plane { coef: [n.x, n.y, n.z, -plane.offset] });
                    message.plane_poses.push(pose_os);
                }
                // a scene message cannot represent them
                Shape::Points(_) | Shape::Voxels(_) => {}
            }
        }
        message
    }

    /// Fixed frames, and the planning frame in itself.
    pub fn fixed_frames(&self) -> Vec<TransformStamped> {
        let stamped = |name: &str, pose: &Pose| {
            // as in MoveIt, the header names the frame, and the child is the planning frame that it is placed in. If
            // the planning frame is not at the root, the frame is the child, as in tf
            match self.planning_frame() {
                Some(planning_frame) => transform_stamped(name, planning_frame, pose),
                None => transform_stamped(self.root(), name, pose),
            }
        };
        let own = stamped(self.planning_frame().unwrap_or(self.root()), &Pose::identity());
        let others = self.scene.fixed_frames.iter().map(|(name, pose)| stamped(name, pose));
        std::iter::once(own).chain(others).collect()
    }

    /// `MoveIt`'s planning frame, if it is at the root: the root itself without a virtual joint, or the parent of a
    /// fixed one.
    fn planning_frame(&self) -> Option<&str> {
        let mut joints = self.robot.srdf().into_iter().flat_map(|srdf| &srdf.virtual_joints);
        match joints.find(|joint| joint.child_link == self.robot.root()) {
            None => Some(self.root()),
            Some(joint) => (joint.kind == "fixed").then_some(&joint.parent_frame),
        }
    }

    fn robot_state(&self, with_attached: bool) -> RobotState {
        let mut message = RobotState {
            joint_state: JointState {
                header: Header { frame_id: self.root().to_owned(), ..Header::default() },
                ..JointState::default()
            },
            ..RobotState::default()
        };
        if let Some(q) = self.configuration {
            message.joint_state.name = self.robot.position_names().to_vec();
            message.joint_state.position = q.positions().to_vec();
        }
        if with_attached {
            let attached = self.scene.world.attached().iter();
            message.attached_collision_objects = attached.map(|o| self.attached_message(o)).collect();
        }
        message
    }

    /// Allowed collision matrix in use: from the scene, otherwise from the SRDF.
    pub fn matrix(&self) -> AllowedCollisionMatrix {
        let mut entries = match &self.scene.matrix {
            Some(matrix) => matrix.to_entries(),
            None => Matrix::of_robot(self.robot).to_entries(),
        };
        if entries.entry_names.is_empty() {
            // receivers ignore a matrix without names; an entry of a link with itself has no effect
            entries.entry_names.push(self.root().to_owned());
            entries.entry_values.push(vec![false]);
        }
        AllowedCollisionMatrix {
            entry_names: entries.entry_names,
            entry_values: (entries.entry_values.into_iter())
                .map(|enabled| AllowedCollisionEntry { enabled })
                .collect(),
            default_entry_names: entries.default_entry_names,
            default_entry_values: entries.default_entry_values,
        }
    }

    /// Padding and scale of every link: those of links without geometry hold for the objects that they carry.
    pub fn link_sizes(&self) -> (Vec<LinkPadding>, Vec<LinkScale>) {
        let Scene { link_padding, link_scale, .. } = self.scene;
        // as in the checks, the parameter is the least padding
        let padding = |name: &str| link_padding.get(name).copied().unwrap_or_default().greater(self.padding);
        let scale = |name: &str| link_scale.get(name).copied().unwrap_or(1.0);
        let links = || self.robot.links().iter().map(|link| &link.name);
        let paddings =
            links().map(|name| LinkPadding { link_name: name.clone(), padding: padding(name) }).collect();
        let scales = links().map(|name| LinkScale { link_name: name.clone(), scale: scale(name) }).collect();
        (paddings, scales)
    }
}

/// Whether a `CollisionObject` message can represent an obstacle. It has no points and no voxels.
#[must_use]
pub fn is_representable(obstacle: &Obstacle) -> bool {
    !obstacle.shapes.iter().any(|placed| matches!(placed.shape, Shape::Points(_) | Shape::Voxels(_)))
}

/// Entry of a fixed frame that is no longer there: a frame in itself.
#[must_use]
pub fn removed_frame(name: &str) -> TransformStamped {
    transform_stamped(name, name, &Pose::identity())
}

fn transform_stamped(frame: &str, child_frame: &str, pose: &Pose) -> TransformStamped {
    TransformStamped {
        header: Header { frame_id: frame.to_owned(), ..Header::default() },
        child_frame_id: child_frame.to_owned(),
        transform: transform_message(pose),
    }
}

fn primitive_message(primitive: &Primitive) -> SolidPrimitive {
    let solid = |type_, dimensions: &[f64]| SolidPrimitive {
        type_,
        dimensions: dimensions.to_vec(),
        ..Default::default()
    };
    match *primitive {
        Primitive::Box { half_extents: [x, y, z] } => {
            solid(SolidPrimitive::BOX, &[2.0 * x, 2.0 * y, 2.0 * z])
        }
        Primitive::Sphere { radius } => solid(SolidPrimitive::SPHERE, &[radius]),
        Primitive::Cylinder { radius, half_length } => {
            solid(SolidPrimitive::CYLINDER, &[2.0 * half_length, radius])
        }
        Primitive::Cone { radius, half_length } => solid(SolidPrimitive::CONE, &[2.0 * half_length, radius]),
        // messages have no capsule and never create one: the cylinder around it
        Primitive::Capsule { radius, half_length } => {
            solid(SolidPrimitive::CYLINDER, &[2.0 * (half_length + radius), radius])
        }
    }
}

fn mesh_message(mesh: &TriangleMesh) -> Mesh {
    Mesh {
        triangles: mesh.triangles().iter().map(|&vertex_indices| MeshTriangle { vertex_indices }).collect(),
        vertices: mesh.vertices().iter().map(|p| PointMessage { x: p.x, y: p.y, z: p.z }).collect(),
    }
}

fn transform_message(pose: &Pose) -> Transform {
    let p = &pose.translation;
    Transform { translation: Vector3 { x: p.x, y: p.y, z: p.z }, rotation: quaternion(pose) }
}

fn quaternion(pose: &Pose) -> Quaternion {
    let q = &pose.rotation.coords;
    Quaternion { x: q.x, y: q.y, z: q.z, w: q.w }
}
