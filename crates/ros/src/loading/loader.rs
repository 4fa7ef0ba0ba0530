//! Builds checkers from robot descriptions and scene messages, on a separate thread. Meanwhile, the monitor uses the previous model and
//! world.

use clearance_monitor::Revision;
use clearance_robot::{MeshFiles, RobotModel, RobotText};
use clearance_scene::MeshModel;
use clearance_scene::Scene;
use futures_lite::future;
use smol::Timer;
use smol::channel::Receiver;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};

use crate::loading::loader_inputs::{LoaderInputs, Pass};
use crate::loading::logged_meshes::LoggedMeshes;
use crate::monitor_events::monitor_event::MonitorEvent;
use crate::monitor_events::world_update::WorldUpdate;
use crate::parameters::parameter_set::Parameters;
use crate::scene::active_scene::CurrentRobot;
use crate::scene::active_scene::{ActiveScene, CurrentScene};
use crate::scene::cloud_inbox::CloudMessage;
use crate::scene::loader_command::LoaderCommand;
use crate::scene::loader_scene::LoaderScene;
use crate::scene::scene_checker::{checker_of, solid_meshes, warnings_of};
use crate::scene::scene_command::SceneCommand;
use crate::scene::scene_update_context::SceneUpdateContext;
use crate::scene::shared_state::SharedState;
use crate::threading::mailbox;
use crate::topics::link_volumes::LinkVolumes;
use crate::topics::monitored_scene::MonitoredScene;

/// Reads the obstacles around a robot from scene files. Their poses refer to the robot, so they are read again for each new robot.
pub type Surroundings = Box<dyn Fn(&RobotModel) -> Result<Scene, String> + Send>;

/// Waits until the monitor has published its evaluation of all earlier events; returns whether the monitor still exists.
fn heeded(events: &mailbox::Sender<MonitorEvent>) -> bool {
    let (said, is_said) = mailbox::bounded(1);
    events.send(MonitorEvent::PublishNow(said)).is_ok() && future::block_on(is_said.receive()).is_some()
}

/// Builds checkers and hands them to the monitor.
pub struct Loader {
    mesh_files: MeshFiles,
    surroundings: Surroundings,
    mesh_model: MeshModel,
    logged_meshes: LoggedMeshes,
    /// Robot from the command line. It has priority over the topics.
    given: Option<RobotModel>,
    /// Prefixes of the robot's joint names and link names.
    prefixes: [String; 2],
    /// The last description texts. A repeated identical text needs no work.
    description: Option<String>,
    semantic: Option<String>,
    robot: Option<Arc<RobotModel>>,
    keeper: LoaderScene,
    /// Point clouds that were received before a robot was loaded.
    clouds: BTreeMap<String, CloudMessage>,
    /// Number of received texts that differ from the previous text of their topic.
    texts: u64,
    /// Number of accepted robots.
    model_revision: u64,
    /// Number of changes of the world.
    world_revision: u64,
    current: CurrentRobot,
    scene: CurrentScene,
    monitored: Option<MonitoredScene>,
    volumes: Option<LinkVolumes>,
    /// Level of the bounding volume hierarchies to show, counted from their roots; `None` if they are not shown.
    shown_level: Option<usize>,
}

/// The parts that must be rebuilt.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Change {
    Nothing,
    Settings,
    World,
    Robot,
}

impl Loader {
    #[must_use]
    pub fn new((mesh_files, surroundings, mesh_model): (MeshFiles, Surroundings, MeshModel)) -> Self {
        Self {
            mesh_files,
            surroundings,
            mesh_model,
            logged_meshes: LoggedMeshes::default(),
            given: None,
            prefixes: Default::default(),
            description: None,
            semantic: None,
            robot: None,
            keeper: LoaderScene::default(),
            clouds: BTreeMap::new(),
            texts: 0,
            model_revision: 0,
            world_revision: 0,
            current: CurrentRobot::default(),
            scene: CurrentScene::default(),
            monitored: None,
            volumes: None,
            shown_level: None,
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

    /// From now on, publishes every change of the scene.
    pub fn tell_on(&mut self, monitored: MonitoredScene, volumes: LinkVolumes) {
        (self.monitored, self.volumes) = (Some(monitored), Some(volumes));
        self.tell();
    }

    fn tell(&mut self) {
        let Some(scene) = lock(&self.scene).clone() else {
            return;
        };
        if let Some(monitored) = &mut self.monitored {
            monitored.tell(&scene);
        }
        if let Some(volumes) = &mut self.volumes {
            volumes.show(&scene.revision.checker, self.shown_level);
        }
    }

    /// Builds the checker of a robot from the command line. From now on, descriptions on topics are ignored.
    pub fn take_given(
        &mut self,
        robot: RobotModel,
        update_context: &SceneUpdateContext,
    ) -> Result<Arc<Revision>, String> {
        self.shown_level = update_context.parameters.shown_level();
        self.given = Some(robot.clone());
        self.take(robot, update_context)
    }

    /// Carries out commands until all senders are gone.
    pub fn follow(
        mut self,
        commands: &Receiver<LoaderCommand>,
        events: &mailbox::Sender<MonitorEvent>,
        inputs: &LoaderInputs,
    ) {
        self.watch_frames(inputs);
        while let Some(mut together) = self.await_commands(commands, inputs) {
            // URDF and SRDF often arrive together, and objects in large numbers: rebuild once for all of them
            while let Ok(command) = commands.try_recv() {
                together.push(command);
            }
            let mut is_heard = true;
            self.carry_out(inputs.begin(together), |event| {
                inputs.note_meshes();
                is_heard &= events.send(event).is_ok();
            });
            if !is_heard {
                return;
            }
            self.watch_frames(inputs);
            if self.keeper.is_asked() && !heeded(events) {
                return;
            }
            self.keeper.answer();
            self.tell();
        }
    }

    /// Carries out a group of commands and sends the resulting events to the monitor.
    pub fn carry_out(&mut self, pass: Pass, mut tell: impl FnMut(MonitorEvent)) {
        let Pass { update_context, commands, clouds } = pass;
        let texts = self.texts;
        self.keeper.ask(&update_context.parameters.planning_scene_service);
        let (mut is_new_robot, mut change) = (false, self.follow_frames(&update_context));
        let updates = commands.iter().filter(|command| matches!(command, LoaderCommand::Scene(_))).count();
        for command in commands {
            match self.note(command, &update_context) {
                Change::Robot => is_new_robot = true,
                other => change = change.max(other),
            }
        }
        self.shown_level = update_context.parameters.shown_level();
        change = change.max(self.look_at_the_world(clouds, &update_context));
        let is_described = self.description.is_some() || self.given.is_some();
        if is_new_robot && is_described {
            tell(MonitorEvent::ModelSwap);
        }
        let (built, refused) = self.build_anew(is_new_robot, change, &update_context);
        if self.texts > texts {
            tell(MonitorEvent::DescriptionsProcessed(self.texts));
        }
        if updates > 0 {
            tell(MonitorEvent::WorldUpdate(WorldUpdate::Completing(updates)));
        }
        if let Some(revision) = built {
            tell(MonitorEvent::Checker(revision));
        }
        if let Some(fault) = refused {
            tell(MonitorEvent::ModelFault(fault));
        }
        let incomplete = self.keeper.incomplete(&update_context.parameters);
        tell(MonitorEvent::World {
            clouds: self.keeper.note_in_use(),
            faults: self.keeper.faults(),
            incomplete,
        });
    }

    /// Rebuilds the changed parts and returns the error if something was rejected. A new robot includes all other changes.
    fn build_anew(
        &mut self,
        is_new_robot: bool,
        rest: Change,
        update_context: &SceneUpdateContext,
    ) -> (Option<Arc<Revision>>, Option<String>) {
        let mut refused = None;
        if is_new_robot {
            match guarded(DESCRIPTION, || self.reload(update_context)) {
                Ok(built) => return (built, None),
                Err(fault) => refused = Some(fault),
            }
        }
        let built = if rest == Change::Nothing { Ok(None) } else { self.rebuild(rest, update_context) };
        let built = built.unwrap_or_else(|fault| {
            refused.get_or_insert(fault);
            None
        });
        if let Some(fault) = &refused {
            log::error!("the robot model was refused: {fault}");
        }
        (built, refused)
    }

    /// Waits for the next command. Returns no command after a timeout, and `None` when no more commands can arrive.
    fn await_commands(
        &mut self,
        commands: &Receiver<LoaderCommand>,
        inputs: &LoaderInputs,
    ) -> Option<Vec<LoaderCommand>> {
        let SharedState { transforms, grounds, store, clock, .. } = &inputs.shared;
        // transforms that arrived during the last pass were compared with the earlier poses of the obstacles
        let tree = lock(transforms);
        if lock(grounds).are_elsewhere(&tree) {
            return Some(vec![LoaderCommand::Frames]);
        }
        drop(tree);
        let due = self.keeper.time_to_drop(clock.read(), &store.get());
        let command = smol::block_on(future::or(async { commands.recv().await.map(Some) }, async {
            match due {
                Some(due) => drop(Timer::after(due).await),
                None => future::pending().await,
            }
            Ok(None)
        }));
        Some(command.ok()?.into_iter().collect())
    }

    /// Moves the obstacles to the current poses of their frames.
    fn follow_frames(&mut self, update_context: &SceneUpdateContext) -> Change {
        let Some(robot) = self.robot.clone() else {
            return Change::Nothing;
        };
        let moved = guarded_scene(&mut self.keeper, |keeper| keeper.follow_frames(&robot, update_context));
        if moved { Change::World } else { Change::Nothing }
    }

    /// Sets the frames to watch, in which a movement requires new poses of obstacles.
    fn watch_frames(&self, inputs: &LoaderInputs) {
        let grounds = self.robot.as_ref().map(|robot| self.keeper.state.grounds(robot));
        *lock(&inputs.shared.grounds) = grounds.unwrap_or_default();
    }

    /// Adds new point clouds and removes expired ones.
    fn look_at_the_world(
        &mut self,
        clouds: BTreeMap<String, CloudMessage>,
        update_context: &SceneUpdateContext,
    ) -> Change {
        self.clouds.extend(clouds);
        let Some(robot) = self.robot.clone() else {
            return Change::Nothing;
        };
        let clouds = std::mem::take(&mut self.clouds);
        let seen = guarded_scene(&mut self.keeper, |keeper| keeper.see(clouds, &robot, update_context));
        let dropped = self.keeper.drop_stale(update_context.now, &update_context.parameters);
        if seen || dropped { Change::World } else { Change::Nothing }
    }

    fn note(&mut self, command: LoaderCommand, update_context: &SceneUpdateContext) -> Change {
        let (known, text, topic) = match command {
            LoaderCommand::Parameters if self.prefixes == prefixes(&update_context.parameters) => {
                return Change::Settings;
            }
            LoaderCommand::Parameters => return Change::Robot,
            LoaderCommand::Clouds | LoaderCommand::Display | LoaderCommand::Frames => return Change::Nothing,
            LoaderCommand::Scene(command) => return self.note_scene(*command, update_context),
            LoaderCommand::Description(text) => (&mut self.description, text, DESCRIPTION),
            LoaderCommand::Semantic(text) => (&mut self.semantic, text, SEMANTIC),
        };
        if self.given.is_some() {
            log::info!("{topic} is not heeded: the robot was given on the command line");
            return Change::Nothing;
        }
        if known.as_ref() == Some(&text) {
            return Change::Nothing;
        }
        *known = Some(text);
        self.texts += 1;
        Change::Robot
    }

    fn note_scene(&mut self, command: SceneCommand, update_context: &SceneUpdateContext) -> Change {
        let Some(robot) = self.robot.clone() else {
            self.keeper.wait(command);
            return Change::Nothing;
        };
        let changed = guarded_scene(&mut self.keeper, |keeper| keeper.apply(command, &robot, update_context));
        if changed { Change::World } else { Change::Nothing }
    }

    /// Loads the robot from the last texts.
    fn reload(&mut self, update_context: &SceneUpdateContext) -> Result<Option<Arc<Revision>>, String> {
        if let Some(robot) = self.given.clone() {
            return self.take(robot, update_context).map(Some);
        }
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
            // this SRDF belongs to the previous robot: its pairs are meaningless for this one
            log::warn!("{SEMANTIC} is of robot '{}', not of '{}': not heeded", srdf.robot_name, robot.name());
            robot = load(&RobotText { srdf: None, ..text })?;
        }
        self.take(robot, update_context).map(Some)
    }

    /// Rebuilds the checker of the same robot with other settings or in another world.
    fn rebuild(
        &mut self,
        change: Change,
        update_context: &SceneUpdateContext,
    ) -> Result<Option<Arc<Revision>>, String> {
        let Some(robot) = self.robot.clone() else {
            return Ok(None);
        };
        let world = self.world_revision + u64::from(change == Change::World);
        let built = guarded("the world", || self.build(&robot, (self.model_revision, world), update_context));
        if let (Err(fault), Some(scene)) = (&built, lock(&self.scene).as_ref()) {
            log::error!("the world stays as it was: {fault}");
            self.keeper.go_back(&scene.scene, fault);
            return Ok(None);
        }
        built.map(Some)
    }

    fn take(
        &mut self,
        robot: RobotModel,
        update_context: &SceneUpdateContext,
    ) -> Result<Arc<Revision>, String> {
        for warning in robot.warnings() {
            log::warn!("{warning}");
        }
        self.prefixes = prefixes(&update_context.parameters);
        self.keeper.release_robot();
        let robot = Arc::new(robot.with_prefixes(&self.prefixes[0], &self.prefixes[1]));
        let before = self.keeper.state.clone();
        let mut world = self.world_revision;
        if self.keeper.is_untouched() {
            // poses in scene files refer to a robot: each new robot needs them again
            self.keeper.begin_with((self.surroundings)(&robot)?, &robot, update_context);
            world = world.max(u64::from(!self.keeper.state.world.is_empty()));
        } else {
            self.keeper.fit_to(&robot);
        }
        self.keeper.follow_frames(&robot, update_context);
        let mut awaited = Vec::new();
        for command in self.keeper.awaited() {
            awaited.push(command.source);
            let changed =
                guarded_scene(&mut self.keeper, |keeper| keeper.apply(command, &robot, update_context));
            world += u64::from(changed);
        }
        let revision = match self.build(&robot, (self.model_revision + 1, world), update_context) {
            Ok(revision) => revision,
            Err(fault) => {
                // the previous robot stays in use, in its scene
                self.keeper.stay_in(before);
                self.keeper.note_in_vain(&awaited);
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

    /// Builds a checker of the current scene, and makes this scene the active one.
    fn build(
        &mut self,
        robot: &Arc<RobotModel>,
        (model, world): (u64, u64),
        SceneUpdateContext { now, parameters, .. }: &SceneUpdateContext,
    ) -> Result<Arc<Revision>, String> {
        let scene = &self.keeper.state;
        let before = lock(&self.scene).clone();
        let known = before.as_ref().map(|before| &before.revision.checker);
        let checker = checker_of(robot, scene, self.mesh_model, parameters, known)?;
        let meshes = solid_meshes(&checker);
        self.logged_meshes.log(&meshes);
        let mut warnings = self.keeper.warnings();
        warnings.extend(scene.names_without_effect(robot).into_iter().chain(warnings_of(&checker, &meshes)));
        let revision = Arc::new(Revision {
            checker,
            model,
            world,
            sources: self.keeper.sources(parameters),
            incomplete: self.keeper.incomplete(parameters),
            warnings,
            grounds: scene.grounds(robot),
            placed_at: Some(now.steady),
        });
        (self.model_revision, self.world_revision) = (model, world);
        *lock(&self.scene) = Some(Arc::new(ActiveScene {
            revision: Arc::clone(&revision),
            scene: scene.clone(),
            octomap: self.keeper.octomap.clone(),
            mesh_model: self.mesh_model,
            parameters: parameters.clone(),
        }));
        Ok(revision)
    }
}

/// Prefixes of the joint names and the link names.
fn prefixes(parameters: &Parameters) -> [String; 2] {
    [parameters.joint_prefix.clone(), parameters.link_prefix.clone()]
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    // the guarded values are valid between any two statements, so a poisoned lock is safe to use
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Applies an untrusted scene message. A panic in it must not end the node.
fn guarded_scene(keeper: &mut LoaderScene, change: impl FnOnce(&mut LoaderScene) -> bool) -> bool {
    catch_unwind(AssertUnwindSafe(|| change(keeper))).unwrap_or_else(|_| {
        const FAULT: &str = "a change of the world failed inside the program; the world may lack it";
        log::error!("{FAULT}");
        keeper.note_failure(FAULT);
        true
    })
}

const DESCRIPTION: &str = "robot_description";
const SEMANTIC: &str = "robot_description_semantic";

/// Error text with the name of the topic, if its position in the text does not contain it.
fn named(fault: &str) -> String {
    if fault.starts_with(DESCRIPTION) { fault.to_owned() } else { format!("{DESCRIPTION}: {fault}") }
}

/// Builds from an untrusted description. A panic in it must not end the node.
fn guarded<T>(what: &str, build: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(build))
        .unwrap_or_else(|_| Err(format!("{what}: reading it failed inside the program")))
}

#[cfg(test)]
mod tests;
