//! Converts the YAML data of scene objects and attached objects to `ObjectChange` and `AttachedChange`.

use clearance_geometry::Shape;
use clearance_geometry::math::{Pose, Vector};
use clearance_robot::MeshFiles;

use super::text::{AttachedText, KindText, MeshText, ObjectText, OperationText, PoseText, PrimitiveText};
use crate::message_shapes::{mesh, placed_shapes, plane, solid, solid_type, supported_solids};
use crate::{AttachedChange, ObjectChange, Operation};

impl ObjectChange {
    /// Errors and remarks name the field.
    pub(super) fn from_text(
        text: ObjectText,
        files: &MeshFiles,
        remarks: &mut Vec<String>,
    ) -> Result<Self, String> {
        let pose_fo = text.pose.as_ref().map_or(Ok(Pose::identity()), |p| p.pose("pose"))?;
        let primitives = all(&text.primitives, "primitives", solid_of)?;
        let meshes = all(&text.meshes, "meshes", |m| surface_of(m, files, remarks))?;
        let planes = all(&text.planes, "planes", |p| plane(p.coef))?;
        let operation = text.operation.map_or(Ok(Operation::Add), operation_of)?;
        let (mut shapes, mut shape_poses) = (Vec::new(), Vec::new());
        for (kind, poses, field) in [
            (primitives, &text.primitive_poses, "primitive_poses"),
            (meshes, &text.mesh_poses, "mesh_poses"),
            (planes, &text.plane_poses, "plane_poses"),
        ] {
            let mut poses = poses_of(poses, field)?;
            if operation == Operation::Move {
                shape_poses.append(&mut poses);
            }
            shapes.extend(placed_shapes(kind, &poses, field, remarks)?);
        }
        let (names, places) = (text.subframe_names, poses_of(&text.subframe_poses, "subframe_poses")?);
        if names.len() != places.len() {
            return Err(format!("subframe_poses: {} poses for {} subframe_names", places.len(), names.len()));
        }
        Ok(Self {
            id: text.id,
            frame: text.header.frame_id,
            pose_fo,
            shapes,
            shape_poses,
            subframes: names.into_iter().zip(places).collect(),
            operation,
            kind: [text.kind.db, text.kind.key],
        })
    }
}

impl AttachedChange {
    pub(super) fn from_text(
        text: AttachedText,
        files: &MeshFiles,
        remarks: &mut Vec<String>,
    ) -> Result<Self, String> {
        Ok(Self {
            link: text.link_name,
            object: ObjectChange::from_text(text.object, files, remarks)?,
            touch_links: text.touch_links,
        })
    }
}

/// Shapes of one field; errors name the field.
fn all<T>(
    texts: &[T],
    field: &str,
    mut shape: impl FnMut(&T) -> Result<Shape, String>,
) -> Result<Vec<Shape>, String> {
    (texts.iter().enumerate())
        .map(|(i, text)| shape(text).map_err(|e| format!("{field}[{i}]: {e}")))
        .collect()
}

fn poses_of(texts: &[PoseText], field: &str) -> Result<Vec<Pose>, String> {
    texts.iter().enumerate().map(|(i, text)| text.pose(&format!("{field}[{i}]"))).collect()
}

/// The value of a `byte` field as `ros2 topic echo` writes it: a control character, as in "\0".
fn byte(text: &str) -> Option<i64> {
    let mut characters = text.chars();
    let only = characters.next().filter(|c| c.is_control() && characters.next().is_none())?;
    Some(i64::from(u32::from(only)))
}

fn operation_of(text: OperationText) -> Result<Operation, String> {
    let text = match text {
        OperationText::Name(name) => byte(&name).map_or(OperationText::Name(name), OperationText::Number),
        number @ OperationText::Number(_) => number,
    };
    let known = match &text {
        OperationText::Number(number) => Operation::from_number(*number),
        OperationText::Name(name) => match name.to_ascii_lowercase().as_str() {
            "add" => Some(Operation::Add),
            "remove" => Some(Operation::Remove),
            "append" => Some(Operation::Append),
            "move" => Some(Operation::Move),
            _ => None,
        },
    };
    known.ok_or_else(|| {
        let given = match text {
            OperationText::Number(number) => number.to_string(),
            OperationText::Name(name) => name,
        };
        format!("operation: '{given}' is none; add (0), remove (1), append (2) and move (3) are")
    })
}

fn solid_of(text: &PrimitiveText) -> Result<Shape, String> {
    let number = match &text.kind {
        KindText::Number(number) => *number,
        KindText::Name(name) => solid_type(name)
            .ok_or_else(|| format!("type '{name}' is not supported: {}", supported_solids()))?,
    };
    solid(number, &text.dimensions)
}

fn surface_of(text: &MeshText, files: &MeshFiles, remarks: &mut Vec<String>) -> Result<Shape, String> {
    let inline = !(text.triangles.is_empty() && text.vertices.is_empty());
    match (&text.resource, inline, text.dimensions) {
        (Some(_), true, _) => return Err("give a resource, or triangles and vertices, not both".to_owned()),
        (None, _, Some(_)) => return Err("dimensions: only a resource can be scaled".to_owned()),
        _ => {}
    }
    if let Some(uri) = &text.resource {
        let scale = Vector::from(text.dimensions.unwrap_or([1.0; 3]));
        let loaded = files.load(uri, scale).map_err(|e| format!("resource: {e}"))?;
        remarks.extend(loaded.remarks);
        return Ok(Shape::Mesh(loaded.mesh));
    }
    let vertices = text.vertices.iter().map(|v| v.numbers()).collect();
    mesh(vertices, text.triangles.iter().map(|face| face.corners()).collect())
}
