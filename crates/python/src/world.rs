//! Class `World`: obstacles around a robot, read from a file, or added by shape, moved and removed.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clearance::geometry::{Primitive, Shape};
use clearance::robot::{MeshFiles, RobotModel};
use clearance::scene::{Obstacle, Scene, SceneLoader, WorldFileKind};
use clearance_bindings::why_no_obstacle;
use clearance_files::input_files::{self, WORLD_LIMIT};
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::arrays::{Numbers, array};
use crate::error::{error, warn};
use crate::robot::Robot;
use crate::world_state::SceneState;
use crate::{options, pickles, poses, shapes};

/// The robot of a file that is read without one: its only link is the root, in the frame `world`.
const NO_ROBOT: &str = "<robot name='not given'><link name='world'/></robot>";

/// Obstacles around a robot, by name; lengths in metres.
///
/// Poses are in the frame of the robot's root link. `pose` is a homogeneous matrix of shape (4, 4), a position of shape (3,), or a
/// tuple `(position, quaternion)` with the quaternion in the order x, y, z, w; by default the obstacle is at the root frame.
///
/// Methods that add something raise `Error` if the name is taken or the shape is invalid, and then change nothing. A checker keeps a copy
/// of its world: later changes need `Checker.with_world`.
#[pyclass(module = "clearance")]
#[derive(Debug, Default)]
pub struct World {
    pub scene: Scene,
}

impl World {
    fn add(&mut self, name: &str, shape: Shape, pose: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let obstacle = Obstacle::of_shape(name, poses::read(pose)?, shape);
        self.scene.world.add(obstacle).map(|_| ()).map_err(error)
    }

    fn obstacle(&self, name: &str) -> PyResult<&Obstacle> {
        let unknown = || error(why_no_obstacle(&self.scene, name));
        self.scene.world.obstacle_by_name(name).map(AsRef::as_ref).ok_or_else(unknown)
    }
}

#[pymethods]
impl World {
    /// A world without obstacles.
    #[new]
    fn new() -> Self {
        Self::default()
    }

    /// Reads obstacles, attached objects and allowed collisions of a file: the YAML of a MoveIt planning scene, MoveIt's `.scene` text, an
    /// octree (`.bt`, `.ot`), or a cloud (PCD, PLY).
    ///
    /// `robot` gives the frames of its links and resolves the links of attached objects. Without it, the only frame is `world`, the
    /// robot's root. `point_radius` (m) is the radius of the balls around the points of a cloud. Unknown space of an octree counts as
    /// occupied with `unknown_is_occupied=True`. Meshes are searched beside the file, and where those of the robot are.
    ///
    /// Unusual content causes warnings of the class `InputWarning`. Raises `Error` for every fault of the file.
    #[staticmethod]
    #[pyo3(signature = (path, robot=None, *, point_radius=None, unknown_is_occupied=false))]
    fn from_file(
        py: Python<'_>,
        path: PathBuf,
        robot: Option<&Bound<'_, Robot>>,
        #[pyo3(from_py_with = options::point_radius)] point_radius: Option<f64>,
        unknown_is_occupied: bool,
    ) -> PyResult<Self> {
        let mut loader = SceneLoader::default();
        loader.unknown_is_occupied = unknown_is_occupied;
        let parts = robot.map(|robot| (robot.get().model.clone(), robot.get().sources.mesh_files()));
        let loader = py.detach(|| {
            if let Some((model, files)) = parts {
                return read(loader, &path, point_radius, &model, &files);
            }
            let none = RobotModel::from_urdf(NO_ROBOT, &MeshFiles::default()).map_err(|e| e.to_string())?;
            let files = MeshFiles::default().with_environment();
            read(loader, &path, point_radius, &none, &files).map_err(|why| {
                format!("{why} (the file was read without a robot: robot=... gives the frames of its links)")
            })
        });
        let loader = loader.map_err(error)?;
        warn(py, &loader.warnings)?;
        Ok(Self { scene: loader.into_scene() })
    }

    /// Adds a box with edges `size` (x, y, z), centred at `pose`.
    #[pyo3(signature = (name, size, pose=None))]
    fn add_box(
        &mut self,
        name: &str,
        size: &Bound<'_, PyAny>,
        pose: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let size = Numbers::new(size, "size")?.fixed("size", "must be (3,): the edges along x, y and z")?;
        self.add(name, shapes::primitive(Primitive::cuboid(size))?, pose)
    }

    /// Adds a sphere, centred at `pose`.
    #[pyo3(signature = (name, radius, pose=None))]
    fn add_sphere(
        &mut self,
        name: &str,
        #[pyo3(from_py_with = options::radius)] radius: f64,
        pose: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        self.add(name, shapes::primitive(Primitive::sphere(radius))?, pose)
    }

    /// Adds a cylinder along z, centred at `pose`.
    #[pyo3(signature = (name, radius, length, pose=None))]
    fn add_cylinder(
        &mut self,
        name: &str,
        #[pyo3(from_py_with = options::radius)] radius: f64,
        #[pyo3(from_py_with = options::length_of_shape)] length: f64,
        pose: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        self.add(name, shapes::primitive(Primitive::cylinder(radius, length))?, pose)
    }

    /// Adds a capsule along z, centred at `pose`; `length` does not include its half spheres.
    #[pyo3(signature = (name, radius, length, pose=None))]
    fn add_capsule(
        &mut self,
        name: &str,
        #[pyo3(from_py_with = options::radius)] radius: f64,
        #[pyo3(from_py_with = options::length_of_shape)] length: f64,
        pose: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        self.add(name, shapes::primitive(Primitive::capsule(radius, length))?, pose)
    }

    /// Adds a cone along z, centred at half its `length` at `pose`; its tip is at the positive end.
    #[pyo3(signature = (name, radius, length, pose=None))]
    fn add_cone(
        &mut self,
        name: &str,
        #[pyo3(from_py_with = options::radius)] radius: f64,
        #[pyo3(from_py_with = options::length_of_shape)] length: f64,
        pose: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        self.add(name, shapes::primitive(Primitive::cone(radius, length))?, pose)
    }

    /// Adds the plane of all points p with `normal · p = offset`, in the frame at `pose`; `normal` has any length above 0.
    /// Its signed distance (m) from the origin of that frame is `offset / |normal|`.
    ///
    /// A plane is a surface without inside: a robot wholly on either side does not touch it.
    #[pyo3(signature = (name, normal, offset=0.0, pose=None))]
    fn add_plane(
        &mut self,
        name: &str,
        normal: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = options::offset)] offset: f64,
        pose: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let normal = Numbers::new(normal, "normal")?.fixed("normal", "must be (3,)")?;
        self.add(name, shapes::plane(normal, offset)?, pose)
    }

    /// Adds a triangle mesh: `vertices` of shape (N, 3), and `faces` of shape (M, 3) with indices of vertices.
    #[pyo3(signature = (name, vertices, faces, pose=None))]
    fn add_mesh(
        &mut self,
        name: &str,
        vertices: &Bound<'_, PyAny>,
        faces: &Bound<'_, PyAny>,
        pose: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        self.add(name, shapes::mesh(vertices, faces)?, pose)
    }

    /// Adds a mesh file (STL, OBJ, COLLADA, PLY, glTF); `scale` is a factor, or one for each axis.
    #[pyo3(signature = (name, path, pose=None, scale=None))]
    fn add_mesh_file(
        &mut self,
        py: Python<'_>,
        name: &str,
        path: PathBuf,
        pose: Option<&Bound<'_, PyAny>>,
        scale: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let (shape, remarks) = shapes::mesh_file(&path, shapes::scale(scale)?)?;
        self.add(name, shape, pose)?;
        warn(py, remarks)
    }

    /// Adds solid balls of one `radius` around points `xyz` of shape (N, 3), in the frame at `pose`.
    ///
    /// Points are kept as 32-bit floats; the radius grows by the largest rounding, so that nothing is lost.
    #[pyo3(signature = (name, xyz, radius, pose=None))]
    fn add_points(
        &mut self,
        name: &str,
        xyz: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = options::radius)] radius: f64,
        pose: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        self.add(name, shapes::points(xyz, radius)?, pose)
    }

    /// Adds solid cubes of one `edge` length around `centres` of shape (N, 3), along the axes of the frame at `pose`.
    #[pyo3(signature = (name, centres, edge, pose=None))]
    fn add_voxels(
        &mut self,
        name: &str,
        centres: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = options::edge)] edge: f64,
        pose: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        self.add(name, shapes::voxels(centres, edge)?, pose)
    }

    /// Removes an obstacle.
    fn remove(&mut self, name: &str) -> PyResult<()> {
        self.obstacle(name)?;
        self.scene.world.remove(name).map(|_| ()).map_err(error)
    }

    /// Moves an obstacle to a pose in the root frame.
    #[pyo3(name = "move")]
    fn move_to(&mut self, name: &str, pose: &Bound<'_, PyAny>) -> PyResult<()> {
        self.obstacle(name)?;
        self.scene.world.move_to(name, poses::read(Some(pose))?).map_err(error)
    }

    /// Pose of an obstacle in the root frame, shape (4, 4).
    fn pose<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        array(py, poses::matrix(&self.obstacle(name)?.pose_ro).to_vec(), &[4, 4])
    }

    /// Names of all obstacles.
    #[getter]
    fn names(&self) -> Vec<String> {
        self.scene.world.obstacles().map(|obstacle| obstacle.name.clone()).collect()
    }

    /// Attached objects: the name of the link of each, by its name. `Checker.attach` adds them, and files may contain some.
    #[getter]
    fn attached(&self) -> BTreeMap<String, String> {
        let objects = self.scene.world.attached().iter();
        objects.map(|object| (object.name.clone(), object.link.clone())).collect()
    }

    /// A copy, which shares the shapes.
    fn copy(&self) -> Self {
        Self { scene: self.scene.clone() }
    }

    fn __copy__(&self) -> Self {
        self.copy()
    }

    fn __deepcopy__(&self, _memo: &Bound<'_, PyAny>) -> Self {
        self.copy()
    }

    fn __len__(&self) -> usize {
        self.scene.world.len()
    }

    fn __contains__(&self, name: &str) -> bool {
        self.scene.world.id(name).is_some()
    }

    fn __repr__(&self) -> String {
        let (obstacles, attached) = (self.scene.world.len(), self.scene.world.attached().len());
        format!("<clearance.World: {obstacles} obstacles, {attached} attached objects>")
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let state = (SceneState::new(py, &self.scene),);
        pickles::reduced(py, "_restore_world", state.into_pyobject(py)?)
    }
}

/// The world of a pickle.
#[pyfunction]
#[pyo3(name = "_restore_world", signature = (*state))]
pub fn restore_world(state: &Bound<'_, PyTuple>) -> PyResult<World> {
    pickles::restored("World", state, |(scene,): (SceneState<'_>,)| Ok(World { scene: scene.scene()? }))
}

fn read(
    mut loader: SceneLoader,
    path: &Path,
    point_radius: Option<f64>,
    robot: &RobotModel,
    files: &MeshFiles,
) -> Result<SceneLoader, String> {
    let bytes = input_files::read(path, WORLD_LIMIT).map_err(|e| e.to_string())?;
    let kind = WorldFileKind::of(&bytes, path);
    let without_effect =
        |option, of| Err(format!("{}: {option} has no effect: the file is no {of}", path.display()));
    match (kind == WorldFileKind::Cloud, point_radius) {
        (true, None) => return Err(format!("{}: a cloud needs point_radius=... (m)", path.display())),
        (false, Some(_)) => return without_effect("point_radius", "cloud"),
        _ => {}
    }
    if loader.unknown_is_occupied && kind != WorldFileKind::Octomap {
        return without_effect("unknown_is_occupied", "octree");
    }
    let files = files.clone().with_folder(path.parent().unwrap_or(Path::new(".")));
    loader.read_file(&bytes, path, point_radius, robot, &files).map_err(|e| e.to_string())?;
    Ok(loader)
}
