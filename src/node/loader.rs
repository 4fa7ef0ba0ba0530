//! From robot descriptions and what is heard about the world to checkers, on a thread of its own: the monitor goes on with the old
//! model and world meanwhile.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};

use futures_lite::future;
use smol::Timer;
use smol::channel::{Receiver, Sender};

use super::clock::RosClock;
use super::monitor_loop::Event;
use super::parameter_services::ParameterStore;
use super::parameters::Parameters;
use super::scene::Monitored;
use super::scene_keeper::{CurrentScene, SceneInForce, SceneKeeper, SceneOrder};
use crate::checker::{CollisionChecker, MeshModel, Settings};
use crate::monitor::Revision;
use crate::monitor::scene::PlanningSceneState;
use crate::robot::{MeshFiles, RobotModel, RobotText};

/// What files say there is around a robot. Poses in scene files refer to a robot, so each new robot needs them anew.
pub type Surroundings = Box<dyn Fn(&RobotModel) -> Result<PlanningSceneState, String> + Send>;

/// What may change what is checked.
pub enum Order {
    /// A URDF came on `robot_description`.
    Description(String),
    /// An SRDF came on `robot_description_semantic`.
    Semantic(String),
    /// A parameter changed.
    Parameters,
    /// A message about the world.
    Scene(Box<SceneOrder>),
    /// Some topic has a new cloud.
    Clouds,
}

/// The robot in use, for those who want to move it.
pub type CurrentRobot = Arc<Mutex<Option<Arc<RobotModel>>>>;

/// Builds checkers and hands them to the monitor.
pub struct Loader {
    mesh_files: MeshFiles,
    surroundings: Surroundings,
    mesh_model: MeshModel,
    parameters: ParameterStore,
    /// The robot was given on the command line, which wins over topics.
    robot_is_given: bool,
    /// The last texts that came, so that the same ones again cost nothing.
    description: Option<String>,
    semantic: Option<String>,
    robot: Option<Arc<RobotModel>>,
    keeper: SceneKeeper,
    clock: Arc<RosClock>,
    /// Counts the robots that were taken.
    model_revision: u64,
    /// Counts the changes of the world.
    world_revision: u64,
    current: CurrentRobot,
    scene: CurrentScene,
    monitored: Option<Monitored>,
}

/// How much has to be built anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Change {
    Nothing,
    Settings,
    World,
    Robot,
}

impl Loader {
    #[must_use]
    pub fn new(
        (mesh_files, surroundings, mesh_model): (MeshFiles, Surroundings, MeshModel),
        parameters: ParameterStore,
        keeper: SceneKeeper,
        clock: Arc<RosClock>,
    ) -> Self {
        Self {
            mesh_files,
            surroundings,
            mesh_model,
            parameters,
            robot_is_given: false,
            description: None,
            semantic: None,
            robot: None,
            keeper,
            clock,
            model_revision: 0,
            world_revision: 0,
            current: CurrentRobot::default(),
            scene: CurrentScene::default(),
            monitored: None,
        }
    }

    #[must_use]
    pub fn current_robot(&self) -> CurrentRobot {
        Arc::clone(&self.current)
    }

    #[must_use]
    pub fn current_scene(&self) -> CurrentScene {
        Arc::clone(&self.scene)
    }

    /// From now on every change of the scene is told.
    pub fn tell_on(&mut self, mut monitored: Monitored) {
        if let Some(scene) = lock(&self.scene).as_ref() {
            monitored.tell(scene);
        }
        self.monitored = Some(monitored);
    }

    /// The checker of a robot from the command line; from now on descriptions on topics are not heeded.
    pub fn take_given(&mut self, robot: RobotModel) -> Result<Arc<Revision>, String> {
        self.robot_is_given = true;
        self.take(robot)
    }

    /// Follows orders until there is no one left to give them.
    pub fn follow(mut self, orders: &Receiver<Order>, events: &Sender<Event>) {
        while let Some(first) = self.await_change(orders) {
            let mut is_new_robot = first == Change::Robot;
            let mut rest = if is_new_robot { Change::Nothing } else { first };
            // a robot's URDF and SRDF often come together, and objects by the dozen: build once for all
            while let Ok(order) = orders.try_recv() {
                match self.note(order) {
                    Change::Robot => is_new_robot = true,
                    other => rest = rest.max(other),
                }
            }
            rest = rest.max(self.look_at_the_world());
            let (built, refused) = self.build_anew(is_new_robot, rest);
            let world = Event::World(self.keeper.note_in_use(), self.keeper.faults());
            let told =
                built.map(Event::Checker).into_iter().chain(refused.map(Event::ModelFault)).chain([world]);
            for event in told {
                if events.send_blocking(event).is_err() {
                    return;
                }
            }
            self.keeper.answer();
            if let (Some(monitored), Some(scene)) = (&mut self.monitored, lock(&self.scene).as_ref()) {
                monitored.tell(scene);
            }
        }
    }

    /// Builds what changed, and tells what was refused: a robot that is takes no other change with it.
    fn build_anew(&mut self, is_new_robot: bool, rest: Change) -> (Option<Arc<Revision>>, Option<String>) {
        let mut refused = None;
        if is_new_robot {
            match guarded(DESCRIPTION, || self.reload()) {
                Ok(built) => return (built, None),
                Err(fault) => refused = Some(fault),
            }
        }
        let built = if rest == Change::Nothing { Ok(None) } else { self.rebuild(rest) };
        let built = built.unwrap_or_else(|fault| {
            refused.get_or_insert(fault);
            None
        });
        if let Some(fault) = &refused {
            log::error!("the robot model was refused: {fault}");
        }
        (built, refused)
    }

    /// What the next order changes, or the time that passes without one; `None` when there will be none.
    fn await_change(&mut self, orders: &Receiver<Order>) -> Option<Change> {
        let parameters = self.parameters.get();
        let due = self.keeper.time_to_drop(self.clock.read(), &parameters);
        let order = smol::block_on(future::or(async { orders.recv().await.map(Some) }, async {
            match due {
                Some(due) => drop(Timer::after(due).await),
                None => future::pending().await,
            }
            Ok(None)
        }));
        match order.ok()? {
            Some(order) => Some(self.note(order)),
            None => Some(Change::Nothing),
        }
    }

    /// New clouds are taken, and what is too old is dropped.
    fn look_at_the_world(&mut self) -> Change {
        let Some(robot) = self.robot.clone() else {
            return Change::Nothing;
        };
        let parameters = self.parameters.get();
        let seen = guarded_scene(|| self.keeper.see(&robot, &parameters));
        let dropped = self.keeper.drop_stale(self.clock.read(), &parameters);
        if seen || dropped { Change::World } else { Change::Nothing }
    }

    fn note(&mut self, order: Order) -> Change {
        let (known, text, topic) = match order {
            Order::Parameters => return Change::Settings,
            Order::Clouds => return Change::Nothing,
            Order::Scene(order) => return self.note_scene(*order),
            Order::Description(text) => (&mut self.description, text, DESCRIPTION),
            Order::Semantic(text) => (&mut self.semantic, text, SEMANTIC),
        };
        if self.robot_is_given {
            log::info!("{topic} is not heeded: the robot was given on the command line");
            return Change::Nothing;
        }
        if known.as_ref() == Some(&text) {
            return Change::Nothing;
        }
        *known = Some(text);
        Change::Robot
    }

    fn note_scene(&mut self, order: SceneOrder) -> Change {
        let Some(robot) = self.robot.clone() else {
            self.keeper.wait(order);
            return Change::Nothing;
        };
        let parameters = self.parameters.get();
        let changed = guarded_scene(|| self.keeper.apply(order, &robot, &parameters));
        if changed { Change::World } else { Change::Nothing }
    }

    /// The robot that the last texts describe.
    fn reload(&mut self) -> Result<Option<Arc<Revision>>, String> {
        let Some(description) = &self.description else {
            return Ok(None);
        };
        let text = RobotText {
            urdf: description,
            urdf_name: Some(DESCRIPTION),
            srdf: self.semantic.as_deref(),
            srdf_name: Some(SEMANTIC),
        };
        let load = |text: &RobotText| {
            RobotModel::from_text(text, &self.mesh_files).map_err(|error| named(&error.to_string()))
        };
        let mut robot = load(&text)?;
        if let Some(srdf) = robot.srdf().filter(|srdf| srdf.robot_name != robot.name()) {
            // left over from the robot that was described before: its pairs would be nonsense here
            log::warn!("{SEMANTIC} is of robot '{}', not of '{}': not heeded", srdf.robot_name, robot.name());
            robot = load(&RobotText { srdf: None, ..text })?;
        }
        self.take(robot).map(Some)
    }

    /// The same robot with other settings, or in another world.
    fn rebuild(&mut self, change: Change) -> Result<Option<Arc<Revision>>, String> {
        let Some(robot) = self.robot.clone() else {
            return Ok(None);
        };
        let world = self.world_revision + u64::from(change == Change::World);
        let built = guarded("the world", || self.build(&robot, self.model_revision, world));
        if let (Err(fault), Some(scene)) = (&built, lock(&self.scene).as_ref()) {
            log::error!("the world stays as it was: {fault}");
            self.keeper.go_back(&scene.scene, fault);
            return Ok(None);
        }
        built.map(Some)
    }

    fn take(&mut self, robot: RobotModel) -> Result<Arc<Revision>, String> {
        for warning in robot.warnings() {
            log::warn!("{warning}");
        }
        let robot = Arc::new(robot);
        let before = self.keeper.state.clone();
        let mut world = self.world_revision;
        if self.keeper.is_untouched() {
            // poses in files refer to a robot: each needs them anew
            self.keeper.state = (self.surroundings)(&robot)?;
            world = world.max(u64::from(!self.keeper.state.world.is_empty()));
        } else {
            self.keeper.fit_to(&robot);
        }
        let parameters = self.parameters.get();
        for order in self.keeper.awaited() {
            let changed = guarded_scene(|| self.keeper.apply(order, &robot, &parameters));
            world += u64::from(changed);
        }
        let revision = match self.build(&robot, self.model_revision + 1, world) {
            Ok(revision) => revision,
            Err(fault) => {
                // the robot before stays, in its scene
                self.keeper.state = before;
                return Err(fault);
            }
        };
        log::info!(
            "robot '{}': {} links, {} positions, {} pairs to check",
            robot.name(),
            robot.links().len(),
            robot.position_names().len(),
            revision.checker.pairs().len(),
        );
        *lock(&self.current) = Some(Arc::clone(&robot));
        self.robot = Some(robot);
        Ok(revision)
    }

    /// A checker of the scene as it is now, which is in force from now on.
    fn build(&mut self, robot: &Arc<RobotModel>, model: u64, world: u64) -> Result<Arc<Revision>, String> {
        let parameters = self.parameters.get();
        let scene = &self.keeper.state;
        let before = lock(&self.scene).clone();
        let known = before.as_ref().map(|before| &before.revision.checker);
        let checker = checker_of(robot, scene, self.mesh_model, &parameters, known)?;
        let revision = Arc::new(Revision {
            checker,
            model,
            world,
            sources: self.keeper.sources(&parameters),
            warnings: self.keeper.warnings(),
        });
        (self.model_revision, self.world_revision) = (model, world);
        *lock(&self.scene) = Some(Arc::new(SceneInForce {
            revision: Arc::clone(&revision),
            scene: scene.clone(),
            octomap: self.keeper.octomap.clone(),
            mesh_model: self.mesh_model,
            parameters,
        }));
        Ok(revision)
    }
}

/// A checker of a robot in a scene; what a known one of the same robot has in common with it is shared.
pub fn checker_of(
    robot: &Arc<RobotModel>,
    scene: &PlanningSceneState,
    mesh_model: MeshModel,
    parameters: &Parameters,
    known: Option<&CollisionChecker>,
) -> Result<CollisionChecker, String> {
    let settings = Settings {
        padding: parameters.padding,
        link_padding: scene.link_padding.clone(),
        link_scale: scene.link_scale.clone(),
        pad_self: parameters.pad_self,
        mesh_model,
        ..Settings::default()
    };
    let matrix = scene.matrix.as_ref();
    let built = match known.filter(|known| Arc::ptr_eq(known.robot(), robot)) {
        Some(known) => known.with_world(&scene.world, settings, matrix),
        None => CollisionChecker::with_matrix(Arc::clone(robot), &scene.world, settings, matrix),
    };
    built.map_err(|error| error.to_string())
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    // the guarded values are valid between any two statements
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A message is a stranger's: what it breaks must not take the node with it.
fn guarded_scene(change: impl FnOnce() -> bool) -> bool {
    catch_unwind(AssertUnwindSafe(change)).unwrap_or_else(|_| {
        log::error!("a change of the world failed inside the program; the world may lack it");
        true
    })
}

const DESCRIPTION: &str = "robot_description";
const SEMANTIC: &str = "robot_description_semantic";

/// A fault that names the topic, if its place in the text does not.
fn named(fault: &str) -> String {
    if fault.starts_with(DESCRIPTION) { fault.to_owned() } else { format!("{DESCRIPTION}: {fault}") }
}

/// A description is a stranger's text: what it breaks must not take the node with it.
fn guarded<T>(what: &str, build: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(build))
        .unwrap_or_else(|_| Err(format!("{what}: reading it failed inside the program")))
}
