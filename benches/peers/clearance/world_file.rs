//! Reader of world files, and conversion of a point cloud to cubes.

use std::collections::BTreeSet;
use std::path::Path;

use clearance::geometry::math::{Point, Pose, Vector, pose_from_xyz_quaternion};
use clearance::geometry::{Cube, PointCloud, Primitive, Shape, Voxels};
use clearance::scene::Obstacle;
use clearance::{MeshFiles, World};
use serde_json::Value;

use crate::Outcome;

/// Edge of a cube (m) that stands for the points within: as wide as the balls of the shared cloud.
pub const CUBE: f64 = 0.02;

/// Reads `{"objects": [...]}`, with the `radius` of points beside it. Files are named from the folder of `file`; meshes may
/// lie beside that folder, too.
pub fn read(file: &Path) -> Outcome<World> {
    let content: Value = serde_json::from_slice(&std::fs::read(file)?)?;
    let folder = file.parent().ok_or("a world without a folder")?;
    let mut world = World::default();
    for object in content["objects"].as_array().ok_or("a world without objects")? {
        let shape = match text(object, "type")? {
            "mesh" => mesh(object, folder)?,
            "points" => points(object, number(&content, "radius")?, folder)?,
            kind => Shape::Primitive(primitive(kind, object)?),
        };
        world.add(Obstacle::of_shape(text(object, "id")?, pose(&object["pose"])?, shape))?;
    }
    Ok(world)
}

fn primitive(kind: &str, object: &Value) -> Outcome<Primitive> {
    Ok(match kind {
        "box" => Primitive::cuboid(numbers(&object["size"])?)?,
        "sphere" => Primitive::sphere(number(object, "radius")?)?,
        "cylinder" => Primitive::cylinder(number(object, "radius")?, number(object, "length")?)?,
        other => return Err(format!("no shape {other}").into()),
    })
}

fn mesh(object: &Value, folder: &Path) -> Outcome<Shape> {
    let beside = folder.parent().ok_or("a world without a folder")?;
    let name = text(object, "file")?.trim_start_matches("../");
    let scale = Vector::from(numbers::<3>(&object["scale"])?);
    Ok(Shape::Mesh(MeshFiles::under(beside).load(name, scale)?.mesh))
}

/// Raw little-endian coordinates.
fn points(object: &Value, radius: f64, folder: &Path) -> Outcome<Shape> {
    let bytes = std::fs::read(folder.join(text(object, "file")?))?;
    let coordinates: Vec<f32> =
        bytes.as_chunks::<4>().0.iter().map(|&four| f32::from_le_bytes(four)).collect();
    let points = coordinates.as_chunks::<3>().0.to_vec();
    Ok(Shape::Points(PointCloud::new(points, radius)?.into()))
}

fn pose(value: &Value) -> Outcome<Pose> {
    let (xyz, quaternion) = (numbers(&value["xyz"])?, numbers(&value["quat_xyzw"])?);
    Ok(pose_from_xyz_quaternion(xyz, quaternion).ok_or("a pose that is none")?)
}

fn text<'a>(value: &'a Value, field: &str) -> Outcome<&'a str> {
    Ok(value[field].as_str().ok_or_else(|| format!("no {field} in {value}"))?)
}

fn number(value: &Value, field: &str) -> Outcome<f64> {
    Ok(value[field].as_f64().ok_or_else(|| format!("no {field} in a world"))?)
}

fn numbers<const N: usize>(value: &Value) -> Outcome<[f64; N]> {
    let found: Vec<f64> = value.as_array().into_iter().flatten().filter_map(Value::as_f64).collect();
    Ok(found.try_into().map_err(|_| format!("{value} is not {N} numbers"))?)
}

/// The first cloud of a world, and its pose.
pub fn cloud(world: &World) -> Option<(Pose, &PointCloud)> {
    world.obstacles().flat_map(Obstacle::placed_shapes).find_map(|(pose, shape)| match shape {
        Shape::Points(cloud) => Some((pose, &**cloud)),
        _ => None,
    })
}

/// A world of the cubes that hold points of a cloud, along the axes of the root, as an octree has them.
#[allow(clippy::cast_possible_truncation)] // cubes are numbered, and their centres told, as OctoMap does it
pub fn cubes((pose, cloud): (Pose, &PointCloud)) -> Outcome<World> {
    let key = |p: &[f32; 3]| {
        let placed = pose * Point::from(p.map(f64::from));
        [placed.x, placed.y, placed.z].map(|c| (f64::from(c as f32) / CUBE).floor() as i32)
    };
    let keys: BTreeSet<[i32; 3]> = cloud.points().iter().map(key).collect();
    let cube = |key: [i32; 3]| Cube {
        centre: key.map(|k| ((f64::from(k) + 0.5) * CUBE) as f32),
        half_edge: (CUBE / 2.0) as f32,
    };
    let voxels = Voxels::new(keys.into_iter().map(cube).collect())?;
    let mut world = World::default();
    world.add(Obstacle::of_shape("cubes", Pose::identity(), Shape::Voxels(voxels.into())))?;
    Ok(world)
}
