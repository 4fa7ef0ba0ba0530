//! A scene as Python objects, for pickles; all numbers keep their bits.

use std::collections::HashMap;
use std::sync::Arc;

use clearance::geometry::math::{Point, UnitVector, Vector};
use clearance::geometry::{Cube, Plane, PointCloud, Primitive, Shape, TriangleMesh, Voxels};
use clearance::scene::{
    AllowedCollisionMatrix, AttachedObject, MatrixEntries, Obstacle, ObstacleShape, Scene,
};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::error::error;
use crate::poses::{EXACT_SLACK, exact, from_exact};
use crate::shapes::primitive;

/// Kind, numbers, and the bytes of what may be large.
type ShapeState<'py> = (String, Vec<f64>, Bound<'py, PyBytes>, Bound<'py, PyBytes>);
/// Pose in the object, and shape.
type PlacedState<'py> = ([f64; 7], ShapeState<'py>);
type Subframes = Vec<(String, [f64; 7])>;
type ObstacleState<'py> = (String, [f64; 7], Vec<PlacedState<'py>>, Subframes);
/// Obstacle at its pose in the link, link, and links that may touch it.
type AttachedState<'py> = (ObstacleState<'py>, String, Vec<String>);
/// Names with rows, and names with defaults.
type MatrixState = (Vec<String>, Vec<Vec<bool>>, Vec<String>, Vec<bool>);

/// A scene: obstacles, attached objects, matrix, paddings and scales of links.
#[derive(IntoPyObject, FromPyObject)]
pub struct SceneState<'py>(
    Vec<ObstacleState<'py>>,
    Vec<AttachedState<'py>>,
    Option<MatrixState>,
    HashMap<String, f64>,
    HashMap<String, f64>,
);

impl<'py> SceneState<'py> {
    /// The state of a scene.
    pub fn new(py: Python<'py>, scene: &Scene) -> Self {
        let obstacles = scene.world.obstacles().map(|obstacle| obstacle_state(py, obstacle)).collect();
        let attached = scene.world.attached().iter().map(|object| {
            let obstacle = Obstacle {
                name: object.name.clone(),
                pose_ro: object.pose_lo,
                shapes: Arc::clone(&object.shapes),
                subframes: object.subframes.clone(),
            };
            (obstacle_state(py, &obstacle), object.link.clone(), object.touch_links.clone())
        });
        let matrix = scene.matrix.as_ref().map(|matrix| {
            let MatrixEntries { entry_names, entry_values, default_entry_names, default_entry_values } =
                matrix.to_entries();
            (entry_names, entry_values, default_entry_names, default_entry_values)
        });
        Self(obstacles, attached.collect(), matrix, scene.link_padding.clone(), scene.link_scale.clone())
    }

    /// The scene of this state.
    pub fn scene(self) -> PyResult<Scene> {
        let Self(obstacles, attached, matrix, link_padding, link_scale) = self;
        let mut scene = Scene::default();
        (scene.link_padding, scene.link_scale) = (link_padding, link_scale);
        for state in obstacles {
            scene.world.add(obstacle(state)?).map_err(error)?;
        }
        for (state, link, touch_links) in attached {
            let Obstacle { name, pose_ro, shapes, subframes } = obstacle(state)?;
            let object = AttachedObject { name, link, pose_lo: pose_ro, shapes, subframes, touch_links };
            scene.world.attach(object).map_err(error)?;
        }
        if let Some((entry_names, entry_values, default_entry_names, default_entry_values)) = matrix {
            let entries =
                MatrixEntries { entry_names, entry_values, default_entry_names, default_entry_values };
            scene.matrix = Some(AllowedCollisionMatrix::from_entries(&entries).map_err(error)?);
        }
        Ok(scene)
    }
}

fn obstacle_state<'py>(py: Python<'py>, obstacle: &Obstacle) -> ObstacleState<'py> {
    let shapes =
        obstacle.shapes.iter().map(|placed| (exact(&placed.pose_os), shape_state(py, &placed.shape)));
    let subframes = obstacle.subframes.iter().map(|(name, pose)| (name.clone(), exact(pose)));
    (obstacle.name.clone(), exact(&obstacle.pose_ro), shapes.collect(), subframes.collect())
}

fn obstacle((name, pose, shapes, subframes): ObstacleState<'_>) -> PyResult<Obstacle> {
    let shapes = shapes
        .into_iter()
        .map(|(pose, state)| Ok(ObstacleShape { pose_os: from_exact(pose)?, shape: shape(state)? }));
    let shapes = shapes.collect::<PyResult<Vec<_>>>()?;
    let subframes = subframes.into_iter().map(|(name, pose)| Ok((name, from_exact(pose)?)));
    let subframes = subframes.collect::<PyResult<_>>()?;
    Ok(Obstacle { pose_ro: from_exact(pose)?, subframes, ..Obstacle::new(name, shapes) })
}

fn shape_state<'py>(py: Python<'py>, shape: &Shape) -> ShapeState<'py> {
    let (mut numbers, mut first, mut second) = (Vec::new(), Vec::new(), Vec::new());
    match shape {
        Shape::Primitive(Primitive::Box { half_extents }) => numbers.extend(half_extents),
        Shape::Primitive(Primitive::Sphere { radius }) => numbers.push(*radius),
        Shape::Primitive(
            Primitive::Cylinder { radius, half_length }
            | Primitive::Cone { radius, half_length }
            | Primitive::Capsule { radius, half_length },
        ) => numbers.extend([radius, half_length]),
        Shape::Plane(plane) => numbers.extend(plane.normal.iter().chain([&plane.offset])),
        Shape::Mesh(mesh) => {
            first.extend(mesh.vertices().iter().flat_map(|p| [p.x, p.y, p.z]).flat_map(f64::to_le_bytes));
            second.extend(mesh.triangles().iter().flatten().flat_map(|i| i.to_le_bytes()));
        }
        Shape::Points(cloud) => {
            numbers.push(cloud.radius());
            first.extend(cloud.points().iter().flatten().flat_map(|c| c.to_le_bytes()));
        }
        Shape::Voxels(voxels) => {
            let cubes = voxels.cubes().iter();
            first.extend(
                cubes
                    .flat_map(|cube| {
                        let [x, y, z] = cube.centre;
                        [x, y, z, cube.half_edge]
                    })
                    .flat_map(f32::to_le_bytes),
            );
        }
    }
    (shape.kind().to_owned(), numbers, PyBytes::new(py, &first), PyBytes::new(py, &second))
}

fn shape((kind, numbers, first, second): ShapeState<'_>) -> PyResult<Shape> {
    let (first, second) = (first.as_bytes(), second.as_bytes());
    match (kind.as_str(), numbers.as_slice()) {
        ("box", &[x, y, z]) => primitive(Primitive::cuboid([2.0 * x, 2.0 * y, 2.0 * z])),
        ("sphere", &[radius]) => primitive(Primitive::sphere(radius)),
        ("cylinder", &[radius, half_length]) => primitive(Primitive::cylinder(radius, 2.0 * half_length)),
        ("cone", &[radius, half_length]) => primitive(Primitive::cone(radius, 2.0 * half_length)),
        ("capsule", &[radius, half_length]) => primitive(Primitive::capsule(radius, 2.0 * half_length)),
        ("plane", &[x, y, z, offset]) => {
            // for the check only: it would round the normal again
            Plane::from_coefficients([x, y, z, offset]).map_err(error)?;
            let normal = Vector::new(x, y, z);
            if (normal.norm() - 1.0).abs() > EXACT_SLACK {
                return Err(error(format!(
                    "the normal of a plane has length {}, but must have 1",
                    normal.norm()
                )));
            }
            let normal = UnitVector::new_unchecked(normal);
            Ok(Shape::Plane(Plane { normal, offset }))
        }
        ("mesh", []) => {
            let vertices = fields(first, f64::from_le_bytes)?.into_iter().map(|p: [f64; 3]| Point::from(p));
            let mesh = TriangleMesh::new(vertices.collect(), fields(second, u32::from_le_bytes)?);
            mesh.map(|mesh| Shape::Mesh(Arc::new(mesh))).map_err(error)
        }
        ("points", &[radius]) => {
            let cloud = PointCloud::new(fields(first, f32::from_le_bytes)?, radius).map_err(error)?;
            Ok(Shape::Points(Arc::new(cloud)))
        }
        ("voxels", []) => {
            let cubes = fields(first, f32::from_le_bytes)?.into_iter();
            let cubes = cubes.map(|[x, y, z, half_edge]| Cube { centre: [x, y, z], half_edge });
            Ok(Shape::Voxels(Arc::new(Voxels::new(cubes.collect()).map_err(error)?)))
        }
        _ => Err(error(format!("this pickle has a shape '{kind}' that this version does not read"))),
    }
}

/// Records of `N` numbers of `SIZE` bytes each.
fn fields<T, const SIZE: usize, const N: usize>(
    bytes: &[u8],
    number: impl Fn([u8; SIZE]) -> T,
) -> PyResult<Vec<[T; N]>> {
    let records = bytes.chunks_exact(SIZE * N);
    if !records.remainder().is_empty() {
        return Err(error(format!("{} bytes are no records of {} bytes", bytes.len(), SIZE * N)));
    }
    let record = |record: &[u8]| {
        std::array::from_fn(|i| {
            let mut field = [0; SIZE];
            field.copy_from_slice(&record[i * SIZE..(i + 1) * SIZE]);
            number(field)
        })
    };
    Ok(records.map(record).collect())
}
