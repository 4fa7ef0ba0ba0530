//! Class `Robot`: a robot read from URDF and SRDF, its joints, limits, groups and forward kinematics.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use clearance::geometry::math::Pose;
use clearance::robot::{Configuration, GroupState, JointKind, LinkId, LinkPoses, Mimic, RobotModel};
use clearance_bindings::JointSpace;
use numpy::{PyArray1, PyArrayDyn, PyArrayMethods};
use pyo3::exceptions::{PyMemoryError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyTuple};

use crate::arrays::{Rows, array};
use crate::collision_matrix::{CollisionMatrix, MatrixArguments};
use crate::error::{error, warn};
use crate::memory::collected;
use crate::mesh_cover::{self, MeshCover};
use crate::robot_sources::{MeshBytes, RobotSources, Text};
use crate::shape_cover::{self, ShapeCover};
use crate::sphere_cover::{SearchArguments, SizeArguments, SphereCover, measure};
use crate::{options, pickles, poses};

/// A robot: links and joints from URDF, groups and allowed collisions from SRDF, with the meshes. Immutable.
///
/// Joint positions `q` are float64 arrays in the order of `joint_names` (rad, m). Mimic joints have no position of their own: they follow
/// their leaders. A floating joint `j` has seven positions, `j/trans_x j/trans_y j/trans_z j/rot_x j/rot_y j/rot_z j/rot_w`, a planar
/// one three, `j/x j/y j/theta`. All poses are in the frame of the root link, in metres.
///
/// A pickle contains the texts and the bytes of all mesh files, so that it is the same robot on every machine.
#[pyclass(frozen, module = "clearance")]
#[derive(Debug)]
pub struct Robot {
    pub model: Arc<RobotModel>,
    pub sources: Arc<RobotSources>,
    space: JointSpace,
}

impl Robot {
    fn new(model: RobotModel, sources: RobotSources) -> Self {
        let model = Arc::new(model);
        Self { space: JointSpace::whole(Arc::clone(&model)), model, sources: Arc::new(sources) }
    }

    /// By position: where it begins and how far it goes in random states; no length keeps the default.
    fn random_ranges(&self) -> Vec<[f64; 2]> {
        let ranges = self.model.sampling_ranges();
        let mut random: Vec<[f64; 2]> = self.space.rest().positions().iter().map(|q| [*q, 0.0]).collect();
        for id in self.model.joint_ids() {
            let is_single = self.model.joint(id).kind.position_suffixes().len() == 1;
            let Some(first) = self.model.first_position(id).filter(|_| is_single) else { continue };
            random[first] = [ranges[first][0], ranges[first][1] - ranges[first][0]];
        }
        random
    }

    fn link(&self, name: &str) -> PyResult<LinkId> {
        self.model.link_by_name(name).ok_or_else(|| {
            let names: Vec<&str> = self.model.links().iter().map(|link| link.name.as_str()).collect();
            error(format!("the robot has no link '{name}'; it has {}", names.join(", ")))
        })
    }

    /// Pose of a link in the root frame.
    pub fn link_pose(&self, link: &str, q: &Configuration) -> PyResult<Pose> {
        let (link, mut poses) = (self.link(link)?, LinkPoses::new(&self.model));
        self.model.forward_kinematics(q, &mut poses);
        Ok(*poses.pose(link))
    }
}

#[pymethods]
impl Robot {
    /// Reads a robot.
    ///
    /// `urdf` and `srdf` are paths or XML texts. A path that ends with `.xacro` is expanded with the Python package `xacro`, with
    /// `xacro_args` as its arguments. `package://NAME/path` is searched in `package_paths`, then beside the URDF and in its parents, then
    /// in `AMENT_PREFIX_PATH` and `ROS_PACKAGE_PATH`.
    ///
    /// Unusual input that is accepted causes warnings of the class `InputWarning`. Raises `Error` for every fault of the input.
    #[staticmethod]
    #[pyo3(signature = (urdf, srdf=None, package_paths=Vec::new(), *, xacro_args=None))]
    fn from_urdf(
        py: Python<'_>,
        urdf: &Bound<'_, PyAny>,
        srdf: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = options::package_paths)] package_paths: Vec<PathBuf>,
        xacro_args: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let mut sources = RobotSources::read(urdf, srdf, package_paths, xacro_args)?;
        let model = py.detach(|| sources.load());
        let model = model.map_err(error)?;
        warn(py, model.warnings())?;
        Ok(Self::new(model, sources))
    }

    /// Name of the robot in the URDF.
    #[getter]
    fn name(&self) -> &str {
        self.model.name()
    }

    /// Names of the positions of a state `q`, in order: all joints that move by themselves.
    #[getter]
    fn joint_names(&self) -> Vec<String> {
        self.model.position_names().to_vec()
    }

    /// Lower limits (rad, m), shape (n,), also of the joints that mimic these; minus infinity without limit. Collisions are checked beyond
    /// limits, too.
    #[getter]
    fn lower<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_vec(py, self.model.position_ranges().into_iter().map(|[lower, _]| lower).collect())
    }

    /// Upper limits (rad, m), shape (n,), also of the joints that mimic these; infinity without limit.
    #[getter]
    fn upper<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_vec(py, self.model.position_ranges().into_iter().map(|[_, upper]| upper).collect())
    }

    /// Types of the joints that move, by name: `revolute`, `continuous`, `prismatic`, `planar` or `floating`; also of mimic joints.
    #[getter]
    fn joint_types(&self) -> BTreeMap<String, &'static str> {
        let moving = self.model.joint_ids().map(|id| self.model.joint(id));
        moving.filter_map(|joint| Some((joint.name.clone(), type_of(&joint.kind)?))).collect()
    }

    /// Mimic joints by name: the joint that each follows, multiplier and offset (rad, m).
    #[getter]
    fn mimics(&self) -> BTreeMap<String, (String, f64, f64)> {
        let following = self.model.joint_ids().map(|id| self.model.joint(id)).filter_map(|joint| {
            let Mimic { joint: leader, multiplier, offset } = joint.mimic?;
            Some((joint.name.clone(), (self.model.joint(leader).name.clone(), multiplier, offset)))
        });
        following.collect()
    }

    /// Names of all links, in the order of the URDF.
    #[getter]
    fn link_names(&self) -> Vec<String> {
        self.model.links().iter().map(|link| link.name.clone()).collect()
    }

    /// Name of the root link, whose frame is the frame of all poses and points.
    #[getter]
    fn root_link(&self) -> String {
        self.model.link(self.model.root()).name.clone()
    }

    /// Groups of the SRDF: the names of the positions of each, in the order of `Checker(..., group=NAME)`.
    #[getter]
    fn groups(&self) -> BTreeMap<String, Vec<String>> {
        let groups = self.model.srdf().map_or(&[][..], |srdf| &srdf.groups);
        let names = |group: &str| {
            let space = JointSpace::of_group(Arc::clone(&self.model), Some(group), &[]);
            space.map_or_else(|_| Vec::new(), |space| space.names().to_vec())
        };
        groups.iter().map(|group| (group.name.clone(), names(&group.name))).collect()
    }

    /// Group states of the SRDF: the positions (rad, m) of each by joint. If several groups have states of one name, their names are
    /// `group/name`. A state with a faulty entry is left out; `warnings` names it.
    #[getter]
    fn group_states(&self) -> BTreeMap<String, BTreeMap<String, f64>> {
        let states = self.model.srdf().map_or(&[][..], |srdf| &srdf.group_states);
        let is_alone =
            |state: &GroupState| states.iter().filter(|other| other.name == state.name).count() == 1;
        let key = |state: &GroupState| {
            if is_alone(state) { state.name.clone() } else { format!("{}/{}", state.group, state.name) }
        };
        let sound = states.iter().filter(|state| state.fault.is_none());
        sound.map(|state| (key(state), state.positions.iter().cloned().collect())).collect()
    }

    /// Texts of the warnings about input that was accepted.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.model.warnings().iter().map(ToString::to_string).collect()
    }

    /// A state, shape (n,), with some joints set by name (rad, m).
    ///
    /// The others are at 0, or in the middle of limits that exclude 0. A mimic joint moves its leader. Raises `Error` for unknown names.
    #[pyo3(signature = (positions=BTreeMap::new()))]
    fn configuration<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = options::positions)] positions: BTreeMap<String, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let named = positions.iter().map(|(name, value)| (name.as_str(), *value));
        let q = self.model.configuration_from_names(named).map_err(error)?;
        Ok(PyArray1::from_slice(py, q.positions()))
    }

    /// Random states, uniform between the limits: shape (n,) for `size=None`, else (size, n).
    ///
    /// `rng` is a `numpy.random.Generator`, a seed, or None. Continuous joints are within half a turn; prismatic joints without limits are
    /// within half a metre. Planar and floating joints keep their default positions.
    #[pyo3(signature = (rng=None, size=None))]
    fn random<'py>(
        &self,
        py: Python<'py>,
        rng: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = options::size)] size: Option<usize>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let count = self.model.position_names().len();
        let shape = size.map_or_else(|| vec![count], |size| vec![size, count]);
        let generator = py.import("numpy.random")?.call_method1("default_rng", (rng,)).map_err(|why| {
            PyTypeError::new_err(format!("rng must be a numpy.random.Generator, a seed or None: {why}"))
        })?;
        let bytes = shape.iter().try_fold(size_of::<f64>(), |bytes, length| bytes.checked_mul(*length));
        if bytes.is_none_or(|bytes| isize::try_from(bytes).is_err()) {
            return Err(PyMemoryError::new_err(format!("no memory for random states of shape {shape:?}")));
        }
        let numbers = generator.call_method1("random", (PyTuple::new(py, &shape)?,))?;
        let states = numbers.cast_into::<PyArrayDyn<f64>>()?;
        let ranges = self.random_ranges();
        let mut values = states.readwrite();
        for row in values.as_slice_mut()?.chunks_exact_mut(count.max(1)) {
            for (value, [first, length]) in row.iter_mut().zip(&ranges) {
                *value = first + length * *value;
            }
        }
        drop(values);
        Ok(states)
    }

    /// Poses of links in the frame of the root link: a dict from link name to homogeneous matrices of shape (..., 4, 4), for `q` of shape
    /// (..., n). `links` are the names of the wanted links, by default all.
    #[pyo3(signature = (q, links=None))]
    fn forward_kinematics<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = options::links)] links: Option<Vec<String>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let rows = Rows::new(q, "q", self.space.names())?;
        let links = links.unwrap_or_else(|| self.link_names());
        let ids = links.iter().map(|name| self.link(name)).collect::<PyResult<Vec<_>>>()?;
        let (mut poses, mut row_memory) = (LinkPoses::new(&self.model), Vec::new());
        let mut state = self.space.rest().clone();
        let of_one = || collected([], rows.count().saturating_mul(16));
        let mut matrices = ids.iter().map(|_| of_one()).collect::<PyResult<Vec<Vec<f64>>>>()?;
        for i in 0..rows.count() {
            let read = self.space.read_into(rows.table().row(i), &mut row_memory, &mut state);
            read.map_err(|why| error(format!("q{}: {why}", rows.place(i))))?;
            self.model.forward_kinematics(&state, &mut poses);
            for (matrices, id) in matrices.iter_mut().zip(&ids) {
                matrices.extend(poses::matrix(poses.pose(*id)));
            }
        }
        let shape = [rows.leading(), &[4, 4]].concat();
        let result = PyDict::new(py);
        for (name, matrices) in links.iter().zip(matrices) {
            result.set_item(name, array(py, matrices, &shape)?)?;
        }
        Ok(result)
    }

    /// Decides for every pair of links with collision geometry whether it can collide within the joint limits: `CollisionMatrix`.
    ///
    /// The pairs that the SRDF disables are decided, too. `never` and `always` are proofs; the states of `sometimes` are checked; a pair is
    /// `undecided` if `timeout` (s) ended or `max_boxes` joint boxes (4 million by default) were not enough. Without `timeout`, the result
    /// is the same for any `num_threads`. Settings: `padding`, `pad_self`, `link_padding`, `link_scale` and `mesh_model`, as of `Checker`.
    #[pyo3(
        signature = (*, timeout=None, max_boxes=None, num_threads=None, **settings),
        text_signature = "($self, *, timeout=None, max_boxes=None, num_threads=None, **settings)"
    )]
    fn collision_matrix(
        &self,
        py: Python<'_>,
        #[pyo3(from_py_with = options::timeout)] timeout: Option<Instant>,
        #[pyo3(from_py_with = options::max_boxes)] max_boxes: Option<u64>,
        #[pyo3(from_py_with = options::num_threads)] num_threads: Option<usize>,
        settings: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<CollisionMatrix> {
        let arguments = MatrixArguments { deadline: timeout, max_boxes, num_threads };
        CollisionMatrix::compute(py, self, &arguments, settings)
    }

    /// Covers the links with spheres that are proven to contain them: `SphereCover`.
    ///
    /// The size is one of: `count`, at most so many spheres for each link; `total`, for the whole robot; `counts`, by name of the link;
    /// `excess` (m), few spheres that reach at most so far out. With `inner=True`, the spheres lie inside of the links, and `excess` is the
    /// depth of points that may be left out; there is no `total` of these. After `timeout` (s), the best spheres that are proven so far are
    /// returned, and `ended_by_time` is true. Without it, the result is the same for any `num_threads`. Raises `Error` if no cover with the
    /// excess is found.
    #[pyo3(signature = (*, count=None, total=None, excess=None, counts=None, inner=false, timeout=None, num_threads=None))]
    #[allow(clippy::too_many_arguments)] // one for each keyword
    fn sphere_cover(
        &self,
        py: Python<'_>,
        #[pyo3(from_py_with = options::sphere_count)] count: Option<usize>,
        #[pyo3(from_py_with = options::total)] total: Option<usize>,
        #[pyo3(from_py_with = options::excess)] excess: Option<f64>,
        #[pyo3(from_py_with = options::counts)] counts: Option<BTreeMap<String, usize>>,
        #[pyo3(from_py_with = options::inner)] inner: bool,
        #[pyo3(from_py_with = options::timeout)] timeout: Option<Instant>,
        #[pyo3(from_py_with = options::num_threads)] num_threads: Option<usize>,
    ) -> PyResult<SphereCover> {
        let size = SizeArguments { count, total, excess, counts };
        SphereCover::compute(py, self, &size, inner, &SearchArguments { deadline: timeout, num_threads })
    }

    /// Covers the links with capsules or oriented boxes that are proven to contain them: `ShapeCover`.
    ///
    /// `shape` is `capsules` or `boxes`; each link gets at most `count`. After `timeout` (s), the best shapes so far are returned, and
    /// `ended_by_time` is true. Without it, the result is the same for any `num_threads`.
    #[pyo3(signature = (shape, *, count, timeout=None, num_threads=None))]
    fn shape_cover(
        &self,
        py: Python<'_>,
        shape: &str,
        #[pyo3(from_py_with = options::shape_count)] count: usize,
        #[pyo3(from_py_with = options::timeout)] timeout: Option<Instant>,
        #[pyo3(from_py_with = options::num_threads)] num_threads: Option<usize>,
    ) -> PyResult<ShapeCover> {
        let (kind, search) = (shape_cover::kind(shape)?, SearchArguments { deadline: timeout, num_threads });
        ShapeCover::compute(py, self, kind, count, &search)
    }

    /// Simplifies the collision meshes, with a proven distance between each mesh and its simplified mesh: `MeshCover`.
    ///
    /// Give one of `count`, the largest number of triangles of a link, and `excess`, the largest distance (m) of a point of one surface from
    /// the other. Primitives are not changed. After `timeout` (s), the best meshes so far are returned, and `ended_by_time` is true. Without
    /// it, the result is the same for any `num_threads`.
    #[pyo3(signature = (*, count=None, excess=None, timeout=None, num_threads=None))]
    fn mesh_cover(
        &self,
        py: Python<'_>,
        #[pyo3(from_py_with = options::triangle_count)] count: Option<usize>,
        #[pyo3(from_py_with = options::excess)] excess: Option<f64>,
        #[pyo3(from_py_with = options::timeout)] timeout: Option<Instant>,
        #[pyo3(from_py_with = options::num_threads)] num_threads: Option<usize>,
    ) -> PyResult<MeshCover> {
        let size = mesh_cover::size(count, excess)?;
        MeshCover::compute(py, self, &size, &SearchArguments { deadline: timeout, num_threads })
    }

    /// Measures `spheres`, a robot with the same link names whose collision geometry is spheres, beside the collision geometry of this one:
    /// a tuple with one `MeasuredSpheres` for each link with collision geometry.
    ///
    /// After `timeout` (s), the bounds that are returned hold, and are wide.
    #[pyo3(signature = (spheres, *, timeout=None, num_threads=None))]
    fn measure_spheres<'py>(
        &self,
        py: Python<'py>,
        spheres: &Bound<'py, Robot>,
        #[pyo3(from_py_with = options::timeout)] timeout: Option<Instant>,
        #[pyo3(from_py_with = options::num_threads)] num_threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyTuple>> {
        measure(py, self, spheres.get(), &SearchArguments { deadline: timeout, num_threads })
    }

    fn __repr__(&self) -> String {
        let (name, links) = (self.model.name(), self.model.links().len());
        format!(
            "<clearance.Robot '{name}': {} joint positions, {links} links>",
            self.model.position_names().len()
        )
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let RobotSources { urdf, srdf, folder, package_paths, meshes } = &*self.sources;
        let mut files: BTreeMap<&PathBuf, Bound<'py, PyBytes>> = BTreeMap::new();
        let meshes = meshes.iter().map(|mesh| {
            let bytes = files.entry(&mesh.file).or_insert_with(|| PyBytes::new(py, &mesh.bytes)).clone();
            (mesh.folder.clone(), mesh.uri.clone(), mesh.file.clone(), bytes)
        });
        let meshes: Vec<_> = meshes.collect();
        let texts = [Some(urdf), srdf.as_ref()].map(|text| text.map(|text| (&text.text, &text.file)));
        let state = (texts[0], texts[1], folder, package_paths, meshes);
        pickles::reduced(py, "_restore_robot", state.into_pyobject(py)?)
    }
}

/// The name of a joint's type in the URDF; none if it does not move.
fn type_of(kind: &JointKind) -> Option<&'static str> {
    match kind {
        JointKind::Fixed => None,
        JointKind::Revolute(_) => Some("revolute"),
        JointKind::Continuous(_) => Some("continuous"),
        JointKind::Prismatic(_) => Some("prismatic"),
        JointKind::Floating => Some("floating"),
        JointKind::Planar(_) => Some("planar"),
    }
}

type TextState = (String, Option<String>);
type MeshState<'py> = (Option<PathBuf>, String, PathBuf, Bound<'py, PyBytes>);
/// URDF, SRDF, folder, package paths, meshes.
type RobotState<'py> = (TextState, Option<TextState>, Option<PathBuf>, Vec<PathBuf>, Vec<MeshState<'py>>);

/// The robot of a pickle.
#[pyfunction]
#[pyo3(name = "_restore_robot", signature = (*state))]
pub fn restore_robot(py: Python<'_>, state: &Bound<'_, PyTuple>) -> PyResult<Robot> {
    let text = |(text, file): TextState| Text { text, file };
    pickles::restored("Robot", state, |(urdf, srdf, folder, package_paths, meshes): RobotState<'_>| {
        let meshes = meshes.into_iter().map(|(folder, uri, file, bytes)| {
            let bytes = Arc::from(bytes.as_bytes());
            MeshBytes { folder, uri, file, bytes }
        });
        let meshes = meshes.collect();
        let sources = RobotSources { urdf: text(urdf), srdf: srdf.map(text), folder, package_paths, meshes };
        let model = py.detach(|| sources.restore()).map_err(error)?;
        Ok(Robot::new(model, sources))
    })
}
