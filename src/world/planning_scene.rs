//! Obstacles from the YAML of a `moveit_msgs/PlanningScene`, or of its `world` alone.

use super::scene_text::{
    FaceText, KindText, MatrixEntries, MeshText, ObjectText, OperationText, PoseText, PrimitiveText,
    SceneText,
};
use super::{Obstacle, ObstacleShape, World};
use crate::geometry::{Primitive, Shape, TriangleMesh};
use crate::math::{Point, Pose, Vector};
use crate::robot::{LinkPoses, MeshFiles, RobotModel, VirtualJoint};

/// What a scene file holds: obstacles in the robot's root frame, and its allowed collision matrix if it has one.
#[derive(Clone, Debug, Default)]
pub struct PlanningScene {
    pub obstacles: Vec<Obstacle>,
    pub allowed: Option<MatrixEntries>,
    /// What was odd but accepted.
    pub warnings: Vec<String>,
}

/// A fault in a scene file, with the object and field concerned.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneError {
    pub file: String,
    pub object: Option<String>,
    pub message: String,
}

impl std::fmt::Display for SceneError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.object {
            Some(id) => write!(f, "{}: object '{id}': {}", self.file, self.message),
            None => write!(f, "{}: {}", self.file, self.message),
        }
    }
}

impl std::error::Error for SceneError {}

impl PlanningScene {
    /// Reads a scene. Frames are the root link, links fixed to it, and the parent frame of a fixed virtual joint; mesh
    /// resources are looked up by `files`.
    pub fn from_yaml(
        text: &str,
        file: &str,
        robot: &RobotModel,
        files: &MeshFiles,
    ) -> Result<Self, SceneError> {
        let fault =
            |object: Option<String>, message: String| SceneError { file: file.to_owned(), object, message };
        let scene: SceneText = serde_saphyr::from_str_with_options(text, yaml_limits())
            .map_err(|e| fault(None, e.to_string()))?;
        refuse_unsupported(&scene).map_err(|message| fault(None, message))?;
        let found = scene.world.is_some() || scene.collision_objects.is_some();
        if !found && scene.allowed_collision_matrix.is_none() {
            return Err(fault(None, "no planning scene: expected 'world' or 'collision_objects'".to_owned()));
        }
        let mut read = Self {
            allowed: (scene.allowed_collision_matrix).filter(|m| *m != MatrixEntries::default()),
            ..Self::default()
        };
        let frames = Frames::new(robot);
        let objects = (scene.world.into_iter())
            .flat_map(|w| w.collision_objects)
            .chain(scene.collision_objects.into_iter().flatten());
        for object in objects {
            let name = Some(object.id.clone());
            let obstacle = obstacle(object, &frames, files, &mut read.warnings)
                .map_err(|message| fault(name, message))?;
            read.obstacles.push(obstacle);
        }
        read.warn_of_strange_names(file, robot);
        if read.obstacles.is_empty() {
            read.warnings.push(format!("{file}: the scene has no objects"));
        }
        Ok(read)
    }

    /// Names in the matrix that nothing bears: perhaps misspelled, perhaps of objects that come later.
    fn warn_of_strange_names(&mut self, file: &str, robot: &RobotModel) {
        let Some(matrix) = &self.allowed else { return };
        for name in matrix.entry_names.iter().chain(&matrix.default_entry_names) {
            let known = robot.link_by_name(name).is_some() || self.obstacles.iter().any(|o| o.name == *name);
            if !known {
                self.warnings.push(format!("{file}: allowed_collision_matrix: nothing is named '{name}'"));
            }
        }
    }

    /// The scene's obstacles as a world; names must differ.
    pub fn into_world(self) -> Result<World, super::WorldError> {
        let mut world = World::default();
        for obstacle in self.obstacles {
            world.add(obstacle)?;
        }
        Ok(world)
    }
}

/// Limits that admit large inline meshes but no text that expands without end.
fn yaml_limits() -> serde_saphyr::Options {
    const LARGEST_COUNT: usize = 20_000_000;
    serde_saphyr::options! {
        // else the keys y and n of a position or a normal are booleans
        strict_booleans: true,
        budget: serde_saphyr::budget! {
            max_events: LARGEST_COUNT,
            max_nodes: LARGEST_COUNT,
            max_total_scalar_bytes: 16 * LARGEST_COUNT,
        },
    }
}

/// What a scene may hold that is not checked yet must not be dropped in silence.
fn refuse_unsupported(scene: &SceneText) -> Result<(), String> {
    let attached =
        (scene.robot_state.as_ref()).is_some_and(|state| !state.attached_collision_objects.is_empty());
    if attached {
        return Err("robot_state.attached_collision_objects are not supported: \
                    give them as collision_objects, or remove them"
            .to_owned());
    }
    if let Some(padded) = scene.link_padding.iter().find(|l| l.padding != 0.0) {
        return Err(format!(
            "link_padding of '{}' is not supported: remove it, and give a padding for all links",
            padded.link_name
        ));
    }
    if let Some(scaled) = scene.link_scale.iter().find(|l| l.scale != 1.0) {
        return Err(format!("link_scale of '{}' is not supported: remove it", scaled.link_name));
    }
    let of_world = scene.world.as_ref().and_then(|w| w.octomap.as_ref());
    let octomap = (of_world.or(scene.octomap.as_ref())).and_then(|o| o.octomap.as_ref());
    if octomap.is_some_and(|o| !o.data.is_empty()) {
        return Err("world.octomap is not supported: remove it".to_owned());
    }
    Ok(())
}

/// Frames that stand still against the robot's root.
struct Frames<'r> {
    robot: &'r RobotModel,
    poses: LinkPoses,
}

impl<'r> Frames<'r> {
    fn new(robot: &'r RobotModel) -> Self {
        let mut poses = LinkPoses::new(robot);
        robot.forward_kinematics(&robot.default_configuration(), &mut poses);
        Self { robot, poses }
    }

    fn pose(&self, frame: &str, warnings: &mut Vec<String>) -> Result<Pose, String> {
        let frame = frame.trim_start_matches('/');
        if frame.is_empty() {
            return Ok(Pose::identity());
        }
        let root = self.robot.root();
        if let Some(kind) = self.virtual_joint_from(frame) {
            if kind != "fixed" {
                warnings.push(format!(
                    "frame '{frame}': the {kind} virtual joint is taken at zero, so that it is the root frame"
                ));
            }
            return Ok(Pose::identity());
        }
        match self.robot.link_by_name(frame) {
            Some(link) if self.robot.same_rigid_body(link, root) => Ok(*self.poses.pose(link)),
            Some(_) => Err(format!(
                "header.frame_id: link '{frame}' moves; give the pose in '{}'",
                self.robot.link(root).name
            )),
            None => Err(format!(
                "header.frame_id: unknown frame '{frame}'; the root frame is '{}'",
                self.robot.link(root).name
            )),
        }
    }

    /// The kind of the SRDF's virtual joint that ties the root to `frame`.
    fn virtual_joint_from(&self, frame: &str) -> Option<&str> {
        let mut joints = self.robot.srdf()?.virtual_joints.iter();
        let ties = |j: &&VirtualJoint| j.parent_frame == frame && j.child_link == self.robot.root();
        joints.find(ties).map(|j| j.kind.as_str())
    }
}

fn obstacle(
    object: ObjectText,
    frames: &Frames,
    files: &MeshFiles,
    warnings: &mut Vec<String>,
) -> Result<Obstacle, String> {
    refuse_unusable(&object, frames.robot)?;
    let pose_rf = frames.pose(&object.header.frame_id, warnings)?;
    let pose_fo = (object.pose.as_ref()).map_or(Ok(Pose::identity()), |p| p.pose("pose"))?;
    let pose_ro = pose_rf * pose_fo;
    let mut shapes = Vec::new();
    for (i, primitive) in object.primitives.iter().enumerate() {
        let pose_os = placed(&object.primitive_poses, i, "primitive_poses")?;
        shapes.push(ObstacleShape {
            pose_os,
            shape: Shape::Primitive(solid(primitive).map_err(|e| format!("primitives[{i}]: {e}"))?),
        });
    }
    for (i, mesh) in object.meshes.iter().enumerate() {
        let pose_os = placed(&object.mesh_poses, i, "mesh_poses")?;
        let shape = surface(mesh, files, warnings).map_err(|e| format!("meshes[{i}]: {e}"))?;
        shapes.push(ObstacleShape { pose_os, shape });
    }
    if shapes.is_empty() {
        return Err("no shapes: give primitives or meshes".to_owned());
    }
    Ok(Obstacle { pose_ro, ..Obstacle::new(object.id, shapes) })
}

fn refuse_unusable(object: &ObjectText, robot: &RobotModel) -> Result<(), String> {
    if object.id.is_empty() {
        return Err("id is missing or empty".to_owned());
    }
    if robot.link_by_name(&object.id).is_some() {
        return Err(format!("id: the robot has a link '{}'; give the object another name", object.id));
    }
    if !object.planes.is_empty() {
        return Err("planes are not supported: use a large box".to_owned());
    }
    let adds = match &object.operation {
        None | Some(OperationText::Number(0)) => true,
        Some(OperationText::Number(_)) => false,
        Some(OperationText::Name(name)) => name.eq_ignore_ascii_case("add"),
    };
    let same = |shapes: usize, poses: usize, field: &str| {
        let one_pose_each = poses == shapes || poses == 0;
        (one_pose_each.then_some(())).ok_or_else(|| format!("{field}: {poses} poses for {shapes} shapes"))
    };
    same(object.primitives.len(), object.primitive_poses.len(), "primitive_poses")?;
    same(object.meshes.len(), object.mesh_poses.len(), "mesh_poses")?;
    (adds.then_some(())).ok_or_else(|| "operation: a scene file can only add objects".to_owned())
}

/// The pose of shape `i` in the object; the object's own when none are given.
fn placed(poses: &[PoseText], i: usize, field: &str) -> Result<Pose, String> {
    poses.get(i).map_or(Ok(Pose::identity()), |p| p.pose(&format!("{field}[{i}]")))
}

/// A `shape_msgs/SolidPrimitive`: by name, or by its constants BOX 1, SPHERE 2, CYLINDER 3, CONE 4.
fn solid(text: &PrimitiveText) -> Result<Primitive, String> {
    let name = match &text.kind {
        KindText::Number(1) => "box".to_owned(),
        KindText::Number(2) => "sphere".to_owned(),
        KindText::Number(3) => "cylinder".to_owned(),
        KindText::Number(4) => "cone".to_owned(),
        KindText::Number(other) => other.to_string(),
        KindText::Name(name) => name.to_ascii_lowercase(),
    };
    let made = match (name.as_str(), &text.dimensions[..]) {
        ("box", &[x, y, z]) => Primitive::cuboid([x, y, z]),
        ("sphere", &[radius]) => Primitive::sphere(radius),
        ("cylinder", &[height, radius]) => Primitive::cylinder(radius, height),
        ("box" | "sphere" | "cylinder", given) => {
            return Err(format!(
                "dimensions: {name} takes {}, but {} numbers are given",
                dimensions_of(&name),
                given.len()
            ));
        }
        _ => {
            return Err(format!("type '{name}' is not supported: box, sphere and cylinder are"));
        }
    };
    made.map_err(|e| format!("dimensions: {e}"))
}

fn dimensions_of(name: &str) -> &'static str {
    match name {
        "box" => "three (x, y, z)",
        "sphere" => "one (radius)",
        _ => "two (height, radius)",
    }
}

fn surface(mesh: &MeshText, files: &MeshFiles, warnings: &mut Vec<String>) -> Result<Shape, String> {
    let inline = !(mesh.triangles.is_empty() && mesh.vertices.is_empty());
    match (&mesh.resource, inline, mesh.dimensions) {
        (Some(_), true, _) => return Err("give a resource, or triangles and vertices, not both".to_owned()),
        (None, _, Some(_)) => return Err("dimensions: only a resource can be scaled".to_owned()),
        _ => {}
    }
    if let Some(uri) = &mesh.resource {
        let scale = Vector::from(mesh.dimensions.unwrap_or([1.0; 3]));
        let loaded = files.load(uri, scale).map_err(|e| format!("resource: {e}"))?;
        warnings.extend(loaded.remarks);
        return Ok(Shape::Mesh(loaded.mesh));
    }
    let vertices = (mesh.vertices.iter()).map(|v| Point::from(v.numbers()));
    let triangles = mesh.triangles.iter().map(|face| match face {
        FaceText::List(corners) | FaceText::Map { vertex_indices: corners } => *corners,
    });
    TriangleMesh::new(vertices.collect(), triangles.collect())
        .map(|m| Shape::Mesh(m.into()))
        .map_err(|e| e.to_string())
}
