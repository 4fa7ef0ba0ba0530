//! Builds checkers from robot descriptions and scene messages, on a separate thread. Meanwhile, the monitor uses the
//! previous model and world.

use clearance_monitor::Revision;
use clearance_robot::{MeshFiles, RobotModel, RobotText};
use clearance_scene::MeshModel;
use clearance_scene::Scene;
use futures_lite::future;
use smol::Timer;
use smol::channel::Receiver;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use crate::loading::guarded::{guarded, guarded_scene};
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
use crate::scene::scene_checker::{checker_of, solid_meshes, volumes_without_effect, warnings_of};
use crate::scene::scene_command::SceneCommand;
use crate::scene::scene_update_context::SceneUpdateContext;
use crate::scene::shared_state::SharedState;
use crate::threading::mailbox;
use crate::topics::link_volumes::LinkVolumes;
use crate::topics::monitored_scene::MonitoredScene;

/// Reads the obstacles around a robot from scene files. Their poses refer to the robot, so they are read again for each
/// new robot.
pub type Surroundings = Box<dyn Fn(&RobotModel) -> Result<Scene, String> + Send>;

/// Waits until the monitor has published its evaluation of all earlier events; returns whether the monitor still
/// exists.
fn await_publication(events: &mailbox::Sender<MonitorEvent>) -> bool {
    let (published, is_published) = mailbox::bounded(1);
    events.send(MonitorEvent::PublishNow(published)).is_ok()
        && future::block_on(is_published.receive()).is_some()
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
    scene: LoaderScene,
    /// Point clouds that were received before a robot was loaded.
    clouds: BTreeMap<String, CloudMessage>,
    /// Number of received texts that differ from the previous text of their topic.
    texts: u64,
    /// Number of accepted robots.
    model_revision: u64,
    /// Number of changes of the world.
    world_revision: u64,
    current: CurrentRobot,
    active_scene: CurrentScene,
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
    pub fn new(mesh_files: MeshFiles, surroundings: Surroundings, mesh_model: MeshModel) -> Self {
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
            scene: LoaderScene::default(),
            clouds: BTreeMap::new(),
            texts: 0,
            model_revision: 0,
            world_revision: 0,
            current: CurrentRobot::default(),
            active_scene: CurrentScene::default(),
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
        Arc::clone(&self.active_scene)
    }

    /// From now on, publishes every change of the scene.
    pub fn publish_on(&mut self, monitored: MonitoredScene, volumes: LinkVolumes) {
        (self.monitored, self.volumes) = (Some(monitored), Some(volumes));
        self.publish();
    }

    fn publish(&mut self) {
        let Some(scene) = lock(&self.active_scene).clone() else {
            return;
        };
        if let Some(monitored) = &mut self.monitored {
            monitored.publish(&scene);
        }
        if let Some(volumes) = &mut self.volumes {
            volumes.show(&scene.revision.checker, self.shown_level);
        }
    }

    /// Builds the checker of a robot from the command line. From now on, descriptions on topics are ignored.
    pub fn load_given(
        &mut self,
        robot: RobotModel,
        update_context: &SceneUpdateContext,
    ) -> Result<Arc<Revision>, String> {
        self.shown_level = update_context.parameters.shown_level();
        self.given = Some(robot.clone());
        self.use_robot(robot, update_context)
    }

    /// Carries out commands until all senders are gone.
    pub fn run(
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
            let mut has_monitor = true;
            self.process(inputs.begin(together), |event| {
                inputs.note_meshes();
                has_monitor &= events.send(event).is_ok();
            });
            if !has_monitor {
                return;
            }
            self.watch_frames(inputs);
            if self.scene.has_waiting_clients() && !await_publication(events) {
                return;
            }
            self.scene.respond();
            self.publish();
        }
    }

    /// Carries out a group of commands and sends the resulting events to the monitor.
    pub fn process(&mut self, pass: Pass, mut send: impl FnMut(MonitorEvent)) {
        let Pass { update_context, commands, clouds } = pass;
        let texts = self.texts;
        self.scene.set_required_service(&update_context.parameters.planning_scene_service);
        let (mut is_new_robot, mut change) = (false, self.follow_frames(&update_context));
        let update_count =
            commands.iter().filter(|command| matches!(command, LoaderCommand::Scene(_))).count();
        for command in commands {
            match self.apply(command, &update_context) {
                Change::Robot => is_new_robot = true,
                other => change = change.max(other),
            }
        }
        self.shown_level = update_context.parameters.shown_level();
        change = change.max(self.apply_clouds(clouds, &update_context));
        let is_described = self.description.is_some() || self.given.is_some();
        if is_new_robot && is_described {
            send(MonitorEvent::ModelSwap);
        }
        let (built, refused) = self.rebuild_changed(is_new_robot, change, &update_context);
        if self.texts > texts {
            send(MonitorEvent::DescriptionsProcessed(self.texts));
        }
        if update_count > 0 {
            send(MonitorEvent::WorldUpdate(WorldUpdate::Completing(update_count)));
        }
        if let Some(revision) = built {
            send(MonitorEvent::Checker(revision));
        }
        if let Some(fault) = refused {
            send(MonitorEvent::ModelFault(fault));
        }
        let incomplete = self.scene.incomplete(&update_context.parameters);
        send(MonitorEvent::World {
            clouds: self.scene.note_in_use(),
            faults: self.scene.faults(),
            incomplete,
        });
    }

    /// Rebuilds the changed parts and returns the error if something was rejected. A new robot includes all other
    /// changes.
    fn rebuild_changed(
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
            log::error!("the robot model was rejected: {fault}");
        }
        (built, refused)
    }

    /// Waits for the next command. Returns no command after a timeout, and `None` when no more commands can arrive.
    fn await_commands(
        &mut self,
        commands: &Receiver<LoaderCommand>,
        inputs: &LoaderInputs,
    ) -> Option<Vec<LoaderCommand>> {
        let SharedState { transforms, anchor_frames, store, clock, .. } = &inputs.shared;
        // transforms that arrived during the last pass were compared with the earlier poses of the obstacles
        let tree = lock(transforms);
        if lock(anchor_frames).are_elsewhere(&tree) {
            return Some(vec![LoaderCommand::Frames]);
        }
        drop(tree);
        let due = self.scene.time_to_drop(clock.read(), &store.get());
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
        let moved = guarded_scene(&mut self.scene, |scene| scene.follow_frames(&robot, update_context));
        if moved { Change::World } else { Change::Nothing }
    }

    /// Sets the frames to watch, in which a movement requires new poses of obstacles.
    fn watch_frames(&self, inputs: &LoaderInputs) {
        let anchor_frames = self.robot.as_ref().map(|robot| self.scene.state.anchor_frames(robot));
        *lock(&inputs.shared.anchor_frames) = anchor_frames.unwrap_or_default();
    }

    /// Adds new point clouds and removes expired ones.
    fn apply_clouds(
        &mut self,
        clouds: BTreeMap<String, CloudMessage>,
        update_context: &SceneUpdateContext,
    ) -> Change {
        self.clouds.extend(clouds);
        let Some(robot) = self.robot.clone() else {
            return Change::Nothing;
        };
        let clouds = std::mem::take(&mut self.clouds);
        let changed =
            guarded_scene(&mut self.scene, |scene| scene.apply_clouds(clouds, &robot, update_context));
        let dropped = self.scene.drop_stale(update_context.now, &update_context.parameters);
        if changed || dropped { Change::World } else { Change::Nothing }
    }

    fn apply(&mut self, command: LoaderCommand, update_context: &SceneUpdateContext) -> Change {
        let (known, text, topic) = match command {
            LoaderCommand::Parameters if self.prefixes == prefixes(&update_context.parameters) => {
                return Change::Settings;
            }
            LoaderCommand::Parameters => return Change::Robot,
            LoaderCommand::Clouds | LoaderCommand::Display | LoaderCommand::Frames => return Change::Nothing,
            LoaderCommand::Scene(command) => return self.apply_scene_command(*command, update_context),
            LoaderCommand::Description(text) => (&mut self.description, text, DESCRIPTION),
            LoaderCommand::Semantic(text) => (&mut self.semantic, text, SEMANTIC),
        };
        if self.given.is_some() {
            log::info!("{topic} is ignored: the robot was given on the command line");
            return Change::Nothing;
        }
        if known.as_ref() == Some(&text) {
            return Change::Nothing;
        }
        *known = Some(text);
        self.texts += 1;
        Change::Robot
    }

    fn apply_scene_command(&mut self, command: SceneCommand, update_context: &SceneUpdateContext) -> Change {
        let Some(robot) = self.robot.clone() else {
            self.scene.store(command);
            return Change::Nothing;
        };
        let changed = guarded_scene(&mut self.scene, |scene| scene.apply(command, &robot, update_context));
        if changed { Change::World } else { Change::Nothing }
    }

    /// Loads the robot from the last texts.
    fn reload(&mut self, update_context: &SceneUpdateContext) -> Result<Option<Arc<Revision>>, String> {
        if let Some(robot) = self.given.clone() {
            return self.use_robot(robot, update_context).map(Some);
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
            log::warn!(
                "{SEMANTIC} is of robot '{}', not of '{}': it is ignored",
                srdf.robot_name,
                robot.name()
            );
            robot = load(&RobotText { srdf: None, ..text })?;
        }
        self.use_robot(robot, update_context).map(Some)
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
        let built = guarded("the world", || self.build(&robot, self.model_revision, world, update_context));
        if let (Err(fault), Some(scene)) = (&built, lock(&self.active_scene).as_ref()) {
            log::error!("the world stays as it was: {fault}");
            self.scene.restore(&scene.scene, fault);
            return Ok(None);
        }
        built.map(Some)
    }

    fn use_robot(
        &mut self,
        robot: RobotModel,
        update_context: &SceneUpdateContext,
    ) -> Result<Arc<Revision>, String> {
        for warning in robot.warnings() {
            log::warn!("{warning}");
        }
        self.prefixes = prefixes(&update_context.parameters);
        self.scene.release_robot();
        let robot = Arc::new(robot.with_prefixes(&self.prefixes[0], &self.prefixes[1]));
        let before = self.scene.state.clone();
        let mut world = self.world_revision;
        if self.scene.is_unchanged() {
            // poses in scene files refer to a robot: each new robot needs them again
            self.scene.replace_scene((self.surroundings)(&robot)?, &robot, update_context);
            world = world.max(u64::from(!self.scene.state.world.is_empty()));
        } else {
            self.scene.adapt_to(&robot);
        }
        self.scene.follow_frames(&robot, update_context);
        let mut waiting = Vec::new();
        for command in self.scene.take_waiting() {
            waiting.push(command.source);
            let changed =
                guarded_scene(&mut self.scene, |scene| scene.apply(command, &robot, update_context));
            world += u64::from(changed);
        }
        let revision = match self.build(&robot, self.model_revision + 1, world, update_context) {
            Ok(revision) => revision,
            Err(fault) => {
                // the previous robot stays in use, in its scene
                self.scene.restore_scene(before);
                self.scene.count_as_lost(&waiting);
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
        model: u64,
        world: u64,
        SceneUpdateContext { now, parameters, .. }: &SceneUpdateContext,
    ) -> Result<Arc<Revision>, String> {
        let before = lock(&self.active_scene).clone();
        let known = before.as_ref().map(|before| &before.revision.checker);
        let checker = checker_of(robot, &self.scene.state, self.mesh_model, parameters, known)?;
        let obstacle_poses = self.scene.state.take_state_poses();
        let scene = &self.scene.state;
        let meshes = solid_meshes(&checker);
        self.logged_meshes.log(&meshes);
        let mut warnings = self.scene.warnings();
        warnings.extend(scene.names_without_effect(robot).into_iter().chain(warnings_of(&checker, &meshes)));
        warnings.extend(volumes_without_effect(robot, parameters));
        let revision = Arc::new(Revision {
            checker,
            model,
            world,
            sources: self.scene.sources(parameters),
            incomplete: self.scene.incomplete(parameters),
            warnings,
            anchor_frames: scene.anchor_frames(robot),
            placed_at: Some(now.steady),
            obstacle_twists: scene.obstacle_twists().cloned().collect(),
            obstacle_poses,
        });
        (self.model_revision, self.world_revision) = (model, world);
        *lock(&self.active_scene) = Some(Arc::new(ActiveScene {
            revision: Arc::clone(&revision),
            scene: scene.clone(),
            octomap: self.scene.octomap.clone(),
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

const DESCRIPTION: &str = "robot_description";
const SEMANTIC: &str = "robot_description_semantic";

/// Error text with the name of the topic, if its position in the text does not contain it.
fn named(fault: &str) -> String {
    if fault.starts_with(DESCRIPTION) { fault.to_owned() } else { format!("{DESCRIPTION}: {fault}") }
}

#[cfg(test)]
mod tests;
