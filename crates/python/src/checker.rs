//! Class `Checker`: its properties, worlds and attached objects, and queries on states, motions and paths.

mod construction;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use clearance::robot::Configuration;
use clearance::scene::{BodyId, Scene};
use numpy::{PyArray1, PyArrayDyn};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use self::construction::Grasp;
use crate::arrays::{Rows, array};
use crate::checker_core::CheckerCore;
use crate::edge_queries::{self, EdgeArguments};
use crate::error::{error, warn};
use crate::memory::collected;
use crate::motion_options::{ClearanceSettings, MotionSettings};
use crate::options;
use crate::pickles;
use crate::planning::{self, PlanArguments};
use crate::recovery::{self, SearchLimits};
use crate::robot::Robot;
use crate::settings::CheckSettings;
use crate::state_queries;
use crate::trajectory_arrays::TrajectoryArrays;
use crate::view::View;
use crate::world::World;
use crate::world_state::SceneState;
use crate::{motion_distances, motion_queries};

/// Checks states and motions of a robot in a world. Immutable: any number of threads may share it.
///
/// `Checker(robot, world=None, *, group=None, fixed=None, padding=0.0, link_padding={}, link_scale={}, object_padding={}, object_scale={},
/// pad_self=False, check_self=True, check_world=True, mesh_model="surface", volumes="obb", allowed_collisions=[], checked_collisions=[])`
///
/// States `q` have all positions of the robot, in the order of `Robot.joint_names`, or with `group` those of a group of the SRDF, in the
/// order of `joint_names` of this class: that of the robot, without mimic joints. Joints outside of the group have the values of `fixed` (a
/// dict or other mapping by name; rad, m), or their defaults: 0, or the middle of limits that exclude 0. Mimic joints of the group whose
/// leader is outside follow it. Arrays of other types than C-contiguous float64 are converted.
///
/// - `padding` (m): safety distance of all links against obstacles, with `pad_self` also between links; `link_padding` by link.
/// - `link_scale`, `object_scale`: factors by name. `object_padding` (m): by obstacle, in addition to that of the links.
/// - `mesh_model`: "surface", or "solid", where a closed mesh includes its inside.
/// - `volumes`: kind of bounding volumes, "obb", "rss", "lss", "pss", "aabb", "kdop18" or "kios", also of links, as "obb,hand=rss".
///   Results are the same.
/// - `allowed_collisions`: pairs of names that may touch, besides those that the world's file or else the SRDF allows;
///   `checked_collisions`: pairs that are checked all the same. Pairs that cannot be checked, such as an attached object and the link that
///   holds it, raise `Error`, also in `with_world`, `attach` and `detach`.
///
/// Batches use all cores, or `num_threads`. They and checks of motions release the GIL, and end with KeyboardInterrupt on Ctrl-C.
/// Results do not depend on the number of threads. Wrong shapes raise ValueError, wrong types TypeError, and everything that the library
/// rejects raises `Error`, a ValueError: positions that are not finite, or unknown names. Joint limits are not checked.
#[pyclass(frozen, module = "clearance")]
#[derive(Debug)]
pub struct Checker {
    pub core: Arc<CheckerCore>,
    robot: Py<Robot>,
    scene: Scene,
    settings: CheckSettings,
    group: Option<String>,
    fixed: BTreeMap<String, f64>,
}

impl Checker {
    fn limits(&self, py: Python<'_>, name: &str) -> PyResult<Vec<f64>> {
        let whole: Vec<f64> = self.robot.bind(py).getattr(name)?.call_method0("tolist")?.extract()?;
        Ok(self.core.space.select(&whole))
    }

    fn configuration_of(&self, positions: &BTreeMap<String, f64>) -> PyResult<Configuration> {
        let space = &self.core.space;
        let given = positions.iter().map(|(name, value)| (name.as_str(), *value));
        let q = space.robot().configuration_over(space.rest(), given).map_err(error)?;
        let all =
            space.robot().position_names().iter().zip(q.positions().iter().zip(space.rest().positions()));
        let moved = all.filter(|(_, (value, rest))| value != rest).map(|(name, _)| name);
        match moved.into_iter().find(|name| !space.names().contains(name)) {
            Some(name) => {
                let group = self.group.as_deref().unwrap_or_default();
                Err(error(format!("joint '{name}' is not in group '{group}': give its value as fixed=...")))
            }
            None => Ok(q),
        }
    }
}

#[pymethods]
impl Checker {
    #[new]
    #[pyo3(
        signature = (robot, world=None, *, group=None, fixed=BTreeMap::new(), **settings),
        text_signature = "(robot, world=None, *, group=None, fixed=None, **settings)"
    )]
    fn new(
        py: Python<'_>,
        robot: Py<Robot>,
        world: Option<PyRef<'_, World>>,
        group: Option<String>,
        #[pyo3(from_py_with = options::fixed)] fixed: BTreeMap<String, f64>,
        settings: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let scene = world.map(|world| world.scene.clone()).unwrap_or_default();
        let settings = CheckSettings::new(settings)?;
        settings.check_names(&robot.get().model, &scene)?;
        Self::build(py, robot, scene, settings, (group, fixed))?.warned(py)
    }

    /// The robot.
    #[getter]
    fn robot(&self, py: Python<'_>) -> Py<Robot> {
        self.robot.clone_ref(py)
    }

    /// A copy of the world.
    #[getter]
    fn world(&self) -> World {
        World { scene: self.scene.clone() }
    }

    /// The settings, as keyword arguments of the class and of `verify`.
    #[getter]
    fn settings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.settings.keywords(py)
    }

    /// Name of the group, or None for all joints of the robot.
    #[getter]
    fn group(&self) -> Option<&str> {
        self.group.as_deref()
    }

    /// Names of the positions of a state `q`, in order.
    #[getter]
    fn joint_names(&self) -> Vec<String> {
        self.core.space.names().to_vec()
    }

    /// Lower limits (rad, m) of the positions, shape (n,).
    #[getter]
    fn lower<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(PyArray1::from_vec(py, self.limits(py, "lower")?))
    }

    /// Upper limits (rad, m) of the positions, shape (n,).
    #[getter]
    fn upper<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(PyArray1::from_vec(py, self.limits(py, "upper")?))
    }

    /// Names of the pairs of bodies that are checked.
    #[getter]
    fn pairs(&self) -> Vec<(String, String)> {
        let list = self.core.checker.pairs();
        let world = list.world_pairs().map(|(part, obstacle)| (part, BodyId::Obstacle(obstacle)));
        let all = list.self_pairs().iter().copied().chain(world);
        all.map(|(a, b)| crate::result_builder::names(&self.core.checker, a, b)).collect()
    }

    /// A state, shape (n,), with some joints set by name (rad, m); the others as `fixed` says, or at their defaults.
    #[pyo3(signature = (positions=BTreeMap::new()))]
    fn configuration<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = options::positions)] positions: BTreeMap<String, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let q = self.configuration_of(&positions)?;
        Ok(PyArray1::from_vec(py, self.core.space.select(q.positions())))
    }

    /// Positions of the whole robot, shape (..., N), for states `q` of shape (..., n).
    fn expand<'py>(&self, py: Python<'py>, q: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let space = &self.core.space;
        let rows = Rows::new(q, "q", space.names())?;
        let width = space.rest().positions().len();
        let mut values = collected([], rows.count().saturating_mul(width))?;
        for i in 0..rows.count() {
            let read = space.read(rows.table().row(i));
            values.extend(read.map_err(|why| error(format!("q{}: {why}", rows.place(i))))?.positions());
        }
        array(py, values, &[rows.leading(), &[width]].concat())
    }

    /// The same checker in another world. Hierarchies of links and of obstacles that do not change are shared.
    ///
    /// Paddings, scales and pairs of objects that the world does not have are dropped, also in checkers that are made from that one. Links
    /// hold what is attached in that world: for objects that are held no longer there is an `InputWarning`.
    fn with_world(&self, py: Python<'_>, world: PyRef<'_, World>) -> PyResult<Self> {
        let scene = world.scene.clone();
        drop(world);
        warn(py, self.released_in(&scene))?;
        self.with_scene(py, scene)?.warned(py)
    }

    /// A checker in which the obstacle `name` is attached to `link` and moves with it.
    ///
    /// Either `q` is the state, shape (n,), in which the link grasps the obstacle where it is, or `pose` is the pose of the obstacle in the
    /// frame of the link. `touch_links` may touch the object, besides `link`.
    #[pyo3(signature = (name, link, *, q=None, pose=None, touch_links=Vec::new()))]
    fn attach(
        &self,
        py: Python<'_>,
        name: &str,
        link: &str,
        q: Option<&Bound<'_, PyAny>>,
        pose: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = options::touch_links)] touch_links: Vec<String>,
    ) -> PyResult<Self> {
        self.attached(py, name, link, Grasp { q, pose, touch_links })
    }

    /// A checker in which the attached object `name` is an obstacle, where it is in the state `q` of shape (n,).
    fn detach(&self, py: Python<'_>, name: &str, q: &Bound<'_, PyAny>) -> PyResult<Self> {
        self.detached(py, name, q)
    }

    /// Whether states are free of collision: a bool for `q` of shape (n,), an array of shape (...) for (..., n).
    ///
    /// True is proven: every pair is apart, by more than the padding.
    #[pyo3(signature = (q, *, num_threads=None))]
    fn is_free<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = options::num_threads)] num_threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyAny>> {
        state_queries::is_free(py, &self.core, q, num_threads)
    }

    /// Least distances (m, padding subtracted) within the robot, and between robot and world: `Distances`, for `q` of shape (..., n).
    ///
    /// Distances above `max_distance` (m) are infinite. Bodies that touch have distance 0. With `gradients=True`, distances are signed,
    /// minus the penetration depth of bodies that overlap, and the derivatives with respect to `q` are added, as `clearance` has them.
    #[pyo3(signature = (q, max_distance=0.1, *, gradients=false, num_threads=None))]
    fn distance<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = options::max_distance)] max_distance: f64,
        gradients: bool,
        #[pyo3(from_py_with = options::num_threads)] num_threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyAny>> {
        state_queries::distance(py, &self.core, q, (max_distance, gradients), num_threads)
    }

    /// Full report on a state of shape (n,): `CollisionReport`, with all colliding pairs, their contacts, and the distances of all pairs up
    /// to `max_distance` (m). `max_contacts` is the number of contacts of each colliding pair; 0 for none.
    ///
    /// For `q` of shape (..., n), lists of reports of shape (...).
    #[pyo3(signature = (q, max_distance=0.1, *, max_contacts=1, num_threads=None))]
    fn check<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = options::max_distance)] max_distance: f64,
        #[pyo3(from_py_with = options::max_contacts)] max_contacts: usize,
        #[pyo3(from_py_with = options::num_threads)] num_threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyAny>> {
        state_queries::check(py, &self.core, q, (max_distance, max_contacts), num_threads)
    }

    /// Signed distances of all pairs up to `influence_distance` (m), with witness points, normals and derivatives: `Clearance`, for a state
    /// of shape (n,). For `q` of shape (..., n), lists of shape (...).
    #[pyo3(signature = (q, influence_distance, *, num_threads=None))]
    fn clearance<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = options::influence_distance)] influence_distance: f64,
        #[pyo3(from_py_with = options::num_threads)] num_threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyAny>> {
        state_queries::clearance(py, &self.core, q, influence_distance, num_threads)
    }

    /// Whether straight motions from `q0` to `q1` are proven free, for every point between their ends: a bool, or an array of shape (...)
    /// for (..., n). The two are broadcast to one shape.
    ///
    /// False: contact, or undecided. `check_edges` says which. Options are those of `check_motion`; `timeout` (s) is for the whole batch,
    /// and edges that are not checked in time are False.
    #[pyo3(signature = (q0, q1, *, num_threads=None, **options), text_signature = "($self, q0, q1, *, num_threads=None, **options)")]
    fn are_edges_free<'py>(
        &self,
        py: Python<'py>,
        q0: &Bound<'py, PyAny>,
        q1: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = options::num_threads)] num_threads: Option<usize>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let settings = MotionSettings::new(options)?;
        let arguments = EdgeArguments { ends: [q0, q1], settings, threads: num_threads };
        edge_queries::are_edges_free(py, &self.core, &arguments)
    }

    /// Verdicts of straight motions from `q0` to `q1` of shapes (..., n), which are broadcast to one shape: `EdgeReports`, with arrays of
    /// verdicts, reasons and fractions. Options are those of `check_motion`; `timeout` (s) is for the whole batch. Edges whose check has not
    /// begun in time are UNDECIDED with the reason UNCHECKED.
    #[pyo3(signature = (q0, q1, *, num_threads=None, **options), text_signature = "($self, q0, q1, *, num_threads=None, **options)")]
    fn check_edges<'py>(
        &self,
        py: Python<'py>,
        q0: &Bound<'py, PyAny>,
        q1: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = options::num_threads)] num_threads: Option<usize>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let settings = MotionSettings::new(options)?;
        let arguments = EdgeArguments { ends: [q0, q1], settings, threads: num_threads };
        edge_queries::check_edges(py, &self.core, &arguments)
    }

    /// Checks the straight motion from `q0` to `q1`, both of shape (n,): `MotionReport`. FREE is a proof for the whole motion.
    ///
    /// `certificate=True` adds the proof as a document. Its search differs: `t` of a contact may be another one than without it, and the
    /// verdict, too, if a distance is within `tolerance`. Both results are right. `tube` (rad, m; (n,), or one number for every joint of the
    /// robot, mimic joints included) is a tracking tolerance: the robot may be anywhere within it. Options: `tolerance=5e-4` (m), pairs that
    /// stay farther apart are always decided; `timeout=None` (s), infinity for none; `budget=10_000_000` evaluations of a pair;
    /// `any_contact=False`, True to end at any contact, not the earliest; `margin=0` (m), a pair that is not farther apart than this, besides
    /// its padding, counts as touching.
    #[pyo3(
        signature = (q0, q1, *, certificate=false, tube=None, **options),
        text_signature = "($self, q0, q1, *, certificate=False, tube=None, **options)"
    )]
    fn check_motion<'py>(
        &self,
        py: Python<'py>,
        q0: &Bound<'py, PyAny>,
        q1: &Bound<'py, PyAny>,
        certificate: bool,
        tube: Option<&Bound<'py, PyAny>>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let settings = MotionSettings::new(options)?;
        motion_queries::check_motion(py, &self.core, [q0, q1], (certificate, tube), &settings)
    }

    /// Checks a trajectory: `TrajectoryReport`. `times` (s) have shape (N,), or are None for a path without times; `positions` (rad, m),
    /// `velocities` and `accelerations` have shape (N, n).
    ///
    /// Between two points the motion is linear, cubic if there are velocities, quintic if there are accelerations, too, as in
    /// `trajectory_msgs/JointTrajectory`. With `shortest=True`, continuous joints go the shortest way. `deviation` (rad, m; a number or
    /// (n,)) is the largest deviation of the true motion from the motion between the points, for points that sample a line or an arc of
    /// a link: the proof holds for the true motion. One number is for the joints of `joint_names`; mimic joints follow. It adds to `tube`. Other arguments and options are those of `check_motion`.
    #[pyo3(
        signature = (times, positions, velocities=None, accelerations=None, *, shortest=false, certificate=false, tube=None, deviation=None, **options),
        text_signature = "($self, times, positions, velocities=None, accelerations=None, *, shortest=False, certificate=False, tube=None, deviation=None, **options)"
    )]
    #[allow(clippy::too_many_arguments)] // one for each keyword
    fn check_trajectory<'py>(
        &self,
        py: Python<'py>,
        times: Option<&Bound<'py, PyAny>>,
        positions: &Bound<'py, PyAny>,
        velocities: Option<&Bound<'py, PyAny>>,
        accelerations: Option<&Bound<'py, PyAny>>,
        shortest: bool,
        certificate: bool,
        tube: Option<&Bound<'py, PyAny>>,
        deviation: Option<&Bound<'py, PyAny>>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let settings = MotionSettings::new(options)?;
        let points = TrajectoryArrays { times, positions, velocities, accelerations, shortest };
        let tube = motion_queries::whole_tube(&self.core, tube, deviation)?;
        motion_queries::check_trajectory(py, &self.core, &points, (certificate, tube), &settings)
    }

    /// Proven bounds on the least distances along the straight motion from `q0` to `q1`, both of shape (n,): `MotionClearance`.
    ///
    /// `tube` is that of `check_motion`. Options: `absolute_tolerance=1e-3` (m) and `relative_tolerance=0.01`: the search ends when lower
    /// and upper bound differ by no more than the larger of the two; `max_distance` (m, infinite): larger distances do not matter;
    /// `timeout=None` (s); `budget=10_000_000` evaluations of a pair, and at most a million that wait.
    #[pyo3(
        signature = (q0, q1, *, tube=None, **options),
        text_signature = "($self, q0, q1, *, tube=None, **options)"
    )]
    fn clearance_along<'py>(
        &self,
        py: Python<'py>,
        q0: &Bound<'py, PyAny>,
        q1: &Bound<'py, PyAny>,
        tube: Option<&Bound<'py, PyAny>>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let settings = ClearanceSettings::new(options)?;
        motion_distances::along_motion(py, &self.core, [q0, q1], tube, &settings)
    }

    /// Proven bounds on the least distances along a trajectory: `MotionClearance`. The trajectory is given as for `check_trajectory`, the
    /// options are those of `clearance_along`.
    #[pyo3(
        signature = (times, positions, velocities=None, accelerations=None, *, shortest=false, tube=None, deviation=None, **options),
        text_signature = "($self, times, positions, velocities=None, accelerations=None, *, shortest=False, tube=None, deviation=None, **options)"
    )]
    #[allow(clippy::too_many_arguments)] // one for each keyword
    fn clearance_along_trajectory<'py>(
        &self,
        py: Python<'py>,
        times: Option<&Bound<'py, PyAny>>,
        positions: &Bound<'py, PyAny>,
        velocities: Option<&Bound<'py, PyAny>>,
        accelerations: Option<&Bound<'py, PyAny>>,
        shortest: bool,
        tube: Option<&Bound<'py, PyAny>>,
        deviation: Option<&Bound<'py, PyAny>>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let settings = ClearanceSettings::new(options)?;
        let points = TrajectoryArrays { times, positions, velocities, accelerations, shortest };
        let tube = motion_queries::whole_tube(&self.core, tube, deviation)?;
        motion_distances::along_trajectory(py, &self.core, &points, tube, &settings)
    }

    /// The first time at which a pair of bodies is not farther apart than `distance` (m), besides its padding, on the straight motion from
    /// `q0` to `q1`, both of shape (n,): `MotionReport`.
    ///
    /// FREE: all pairs are proven farther apart at all times. CONTACT: they are proven farther apart before the first t, and the pair is
    /// not at the second. Arguments and options are those of `check_motion`; for a trajectory, give `check_trajectory` a `margin`.
    #[pyo3(
        signature = (q0, q1, distance, *, tube=None, **options),
        text_signature = "($self, q0, q1, distance, *, tube=None, **options)"
    )]
    fn event_distance<'py>(
        &self,
        py: Python<'py>,
        q0: &Bound<'py, PyAny>,
        q1: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = options::event_distance)] distance: f64,
        tube: Option<&Bound<'py, PyAny>>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let has_margin = options.map_or(Ok(false), |options| options.contains("margin"))?;
        if has_margin {
            return Err(PyTypeError::new_err(
                "event_distance has no option 'margin': distance takes its place",
            ));
        }
        let settings = MotionSettings::new(options)?;
        motion_queries::event_distance(py, &self.core, [q0, q1], (distance, tube), &settings)
    }

    /// Searches a free state near `q`, of shape (n,): `FreeState`. Only the joints of the group move, without those in `locked`. Floating
    /// joints and passive joints of the SRDF never move, planar joints only with a group that has them.
    ///
    /// `max_distance`: Euclidean norm of all changes (rad, m). `clearance` (m): distance that the free state keeps from every collision.
    /// `max_checks` and `timeout` (s) limit the search. Nothing proves that no free state is nearer.
    #[pyo3(signature = (q, *, max_distance=0.5, clearance=0.0001, max_checks=30_000, timeout=None, locked=Vec::new()))]
    #[allow(clippy::too_many_arguments)] // one for each keyword
    fn find_free_state<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = options::search_distance)] max_distance: f64,
        #[pyo3(from_py_with = options::clearance)] clearance: f64,
        #[pyo3(from_py_with = options::max_checks)] max_checks: u64,
        #[pyo3(from_py_with = options::timeout)] timeout: Option<Instant>,
        #[pyo3(from_py_with = options::locked)] locked: Vec<String>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let limits = SearchLimits { max_distance, clearance, max_checks, deadline: timeout, locked };
        recovery::find_free_state(py, &self.core, q, limits)
    }

    /// Searches a path of straight edges from `start` to `goal`, both of shape (n,), whose edges are proven free: `Plan`.
    ///
    /// RRT-Connect with shortcuts. Only the joints of the group move, within their limits, without passive joints of the SRDF. `range`
    /// (rad, m): largest length of an edge of the search. `timeout` (s) and `max_edges` limit the search. Without `timeout`, the same seed
    /// gives the same path. Nothing is proven if no path is found. Raises `Error` for planar and floating joints, and for a start or goal
    /// beyond joint limits.
    ///
    /// `certificate=True` adds the proof of the whole path as a document. If the time ends before it is made, the path has none, and its
    /// reason is `found_without_certificate`.
    #[pyo3(signature = (start, goal, *, seed=1, timeout=None, max_edges=200_000, range=1.0, shortcuts=64, certificate=false))]
    #[allow(clippy::too_many_arguments)] // one for each keyword
    fn plan<'py>(
        &self,
        py: Python<'py>,
        start: &Bound<'py, PyAny>,
        goal: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = options::seed)] seed: u64,
        #[pyo3(from_py_with = options::timeout)] timeout: Option<Instant>,
        #[pyo3(from_py_with = options::max_edges)] max_edges: u64,
        #[pyo3(from_py_with = options::range)] range: f64,
        #[pyo3(from_py_with = options::shortcuts)] shortcuts: u32,
        certificate: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let arguments = PlanArguments { seed, deadline: timeout, max_edges, range, shortcuts, certificate };
        planning::plan(py, &self.core, [start, goal], &arguments)
    }

    /// Shows robot and world in a web browser, with one slider for each joint position of this class: `View`.
    ///
    /// The page evaluates each state: colliding pairs, contacts, distances. The server runs in a thread of its own until `View.close()`,
    /// or until the `View` is no longer referenced. Only this machine can open it.
    ///
    /// - `q`: the first state, shape (n,); without it, joints are at their defaults.
    /// - `port`: TCP port on 127.0.0.1; 0: any that is free.
    /// - `open_browser`: open the page in the web browser of this machine.
    ///
    /// Raises `Error` if the port is taken.
    #[pyo3(signature = (q=None, port=0, open_browser=false))]
    fn view(
        &self,
        py: Python<'_>,
        q: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = options::port)] port: u16,
        open_browser: bool,
    ) -> PyResult<View> {
        View::open(py, &self.core, q, port, open_browser)
    }

    fn __repr__(&self) -> String {
        let (robot, pairs) = (self.core.checker.robot().name(), self.core.checker.pairs().len());
        let group = self.group.as_ref().map_or_else(String::new, |group| format!(", group '{group}'"));
        format!(
            "<clearance.Checker of '{robot}'{group}: {} joint positions, {pairs} pairs>",
            self.core.space.names().len()
        )
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let scene = SceneState::new(py, &self.scene);
        let state = (self.robot.clone_ref(py), scene, self.settings.keywords(py)?, &self.group, &self.fixed);
        pickles::reduced(py, "_restore_checker", state.into_pyobject(py)?)
    }
}

type CheckerState<'py> =
    (Py<Robot>, SceneState<'py>, Bound<'py, PyDict>, Option<String>, BTreeMap<String, f64>);

/// The checker of a pickle.
#[pyfunction]
#[pyo3(name = "_restore_checker", signature = (*state))]
pub fn restore_checker(py: Python<'_>, state: &Bound<'_, PyTuple>) -> PyResult<Checker> {
    pickles::restored("Checker", state, |(robot, scene, settings, group, fixed): CheckerState<'_>| {
        Checker::build(py, robot, scene.scene()?, CheckSettings::new(Some(&settings))?, (group, fixed))
    })
}
