//! Construction of checkers: for a robot in a scene, and the same checker in a changed scene.

use std::collections::BTreeMap;
use std::sync::Arc;

use clearance::scene::{AttachedObject, Scene};
use clearance::{CollisionChecker, SettingsError};
use clearance_bindings::{JointSpace, why_no_obstacle};
use pyo3::prelude::*;

use super::Checker;
use crate::batches::run;
use crate::checker_core::CheckerCore;
use crate::error::{error, warn};
use crate::poses;
use crate::robot::Robot;
use crate::settings::CheckSettings;
use crate::state_queries::single;

/// How a link holds an obstacle: either `q` or `pose` is given.
pub(super) struct Grasp<'a, 'py> {
    /// State in which the link grasps the obstacle where it is.
    pub q: Option<&'a Bound<'py, PyAny>>,
    /// Pose of the obstacle in the frame of the link.
    pub pose: Option<&'a Bound<'py, PyAny>>,
    /// Links that may touch the object, besides the link that holds it.
    pub touch_links: Vec<String>,
}

impl Checker {
    /// A checker of a robot in a scene, for the joints of a group.
    pub(super) fn build(
        py: Python<'_>,
        robot: Py<Robot>,
        scene: Scene,
        settings: CheckSettings,
        (group, fixed): (Option<String>, BTreeMap<String, f64>),
    ) -> PyResult<Self> {
        let model = Arc::clone(&robot.get().model);
        let named: Vec<(String, f64)> = fixed.iter().map(|(name, value)| (name.clone(), *value)).collect();
        let space =
            Arc::new(JointSpace::of_group(Arc::clone(&model), group.as_deref(), &named).map_err(error)?);
        let matrix = settings.matrix(&model, &scene);
        let of_scene = settings.settings.clone().with_scene(&scene);
        // on threads of this process, which the library's own pool may not have after a fork
        let built = run(
            py,
            None,
            || {},
            |_| CollisionChecker::with_matrix(model, &scene.world, of_scene, matrix.as_ref()),
        )?;
        let core = CheckerCore::new(built.map_err(error)?, space);
        Ok(Self { core, robot, scene, settings, group, fixed })
    }

    /// The same checker in another scene; hierarchies that do not change are shared.
    pub(super) fn with_scene(&self, py: Python<'_>, scene: Scene) -> PyResult<Self> {
        let model = self.core.space.robot();
        let settings = self.settings.without_missing_objects(model, &scene)?;
        let matrix = settings.matrix(model, &scene);
        let of_scene = settings.settings.clone().with_scene(&scene);
        let built: Result<_, SettingsError> =
            run(py, None, || {}, |_| self.core.checker.with_world(&scene.world, of_scene, matrix.as_ref()))?;
        let core = CheckerCore::new(built.map_err(error)?, Arc::clone(&self.core.space));
        let (robot, group, fixed) = (self.robot.clone_ref(py), self.group.clone(), self.fixed.clone());
        Ok(Self { core, robot, scene, settings, group, fixed })
    }

    /// Warnings about attached objects that are not attached in another scene.
    pub(super) fn released_in(&self, scene: &Scene) -> Vec<String> {
        let held = self.scene.world.attached().iter();
        let released = held.filter(|object| scene.world.attached_by_name(&object.name).is_none());
        let text = |object: &Arc<AttachedObject>| {
            format!(
                "'{}' is not attached in the new world: link '{}' no longer holds it. To keep it, change a copy of the checker's 'world'; \
                 to release it, call 'detach'",
                object.name, object.link
            )
        };
        released.map(text).collect()
    }

    /// This checker, after a warning if it checks nothing.
    pub(super) fn warned(self, py: Python<'_>) -> PyResult<Self> {
        let text = "the checker has no pair of bodies to check, so that every state counts as free: the robot or the world has no \
                    collision geometry, or the settings allow all pairs";
        warn(py, self.core.checker.pairs().is_empty().then_some(text))?;
        Ok(self)
    }

    /// A checker in which an obstacle is attached to a link.
    pub(super) fn attached(
        &self,
        py: Python<'_>,
        name: &str,
        link: &str,
        Grasp { q, pose, touch_links }: Grasp<'_, '_>,
    ) -> PyResult<Self> {
        let robot = self.robot.get();
        let unknown = || error(why_no_obstacle(&self.scene, name));
        let obstacle = self.scene.world.obstacle_by_name(name).ok_or_else(unknown)?;
        let state = q.map_or_else(|| Ok(self.core.space.rest().clone()), |q| single(&self.core, q, "q"))?;
        let pose_rl = robot.link_pose(link, &state)?;
        for touched in &touch_links {
            robot.link_pose(touched, &state)?;
        }
        let mut object = AttachedObject::grasped(obstacle, link, &pose_rl, touch_links);
        match (q, pose) {
            (Some(_), None) => {}
            (None, Some(pose)) => object.pose_lo = poses::read(Some(pose))?,
            _ => {
                return Err(error(
                    "attach needs either q, the state of the grasp, or pose, in the frame of the link",
                ));
            }
        }
        let mut scene = self.scene.clone();
        scene.world.attach(object).map_err(error)?;
        self.with_scene(py, scene)?.warned(py)
    }

    /// A checker in which an attached object is an obstacle, where it is in a state.
    pub(super) fn detached(&self, py: Python<'_>, name: &str, q: &Bound<'_, PyAny>) -> PyResult<Self> {
        let mut scene = self.scene.clone();
        let unknown = || error(format!("no object '{name}' is attached"));
        let object = scene.world.attached_by_name(name).ok_or_else(unknown)?;
        let pose_rl = self.robot.get().link_pose(&object.link, &single(&self.core, q, "q")?)?;
        scene.world.detach(name, &pose_rl).map_err(error)?;
        self.with_scene(py, scene)?.warned(py)
    }
}
