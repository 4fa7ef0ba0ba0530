//! From robot descriptions and what is heard about the world to checkers, on a thread of its own: the monitor goes on with the old
//! model and world meanwhile.

use clearance_checker::SolidMeshRemark;
use clearance_monitor::{Now, Revision};
use clearance_robot::{MeshFiles, RobotModel, RobotText};
use clearance_scene::MeshModel;
use clearance_scene::{Scene, TransformTree};
use futures_lite::future;
use smol::Timer;
use smol::channel::Receiver;
use std::collections::{BTreeMap, HashSet};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};

use super::checker_of_scene::{checker_of, solid_meshes, warnings_of};
use super::link_volumes::LinkVolumes;
use super::loader_inputs::{LoaderInputs, Pass, Places};
use super::mailbox;
use super::monitor_loop::{Event, WorldUpdate};
use super::order::Order;
use super::parameters::Parameters;
use super::scene::{CloudMessage, Monitored, Shared};
use super::scene_keeper::{CurrentScene, SceneInForce, SceneKeeper, SceneUpdateContext};
use super::scene_order::SceneOrder;

/// What files say there is around a robot. Poses in scene files refer to a robot, so each new robot needs them anew.
pub type Surroundings = Box<dyn Fn(&RobotModel) -> Result<Scene, String> + Send>;

/// Waits until the monitor has said what it makes of all that it was told; whether there is one.
fn heeded(events: &mailbox::Sender<Event>) -> bool {
    let (said, is_said) = mailbox::bounded(1);
    events.send(Event::Say(said)).is_ok() && future::block_on(is_said.receive()).is_some()
}

/// The robot in use, for those who want to move it.
pub type CurrentRobot = Arc<Mutex<Option<Arc<RobotModel>>>>;

/// Builds checkers and hands them to the monitor.
pub struct Loader {
    mesh_files: MeshFiles,
    surroundings: Surroundings,
    mesh_model: MeshModel,
    told_meshes: ToldMeshes,
    /// The robot that was given on the command line, which wins over topics.
    given: Option<RobotModel>,
    /// What the names of the robot's joints and links begin with.
    prefixes: [String; 2],
    /// The last texts that came, so that the same ones again cost nothing.
    description: Option<String>,
    semantic: Option<String>,
    robot: Option<Arc<RobotModel>>,
    keeper: SceneKeeper,
    /// Clouds that came before there was a robot.
    clouds: BTreeMap<String, CloudMessage>,
    /// Counts the texts that came, each another one than the last of its topic.
    texts: u64,
    /// Counts the robots that were taken.
    model_revision: u64,
    /// Counts the changes of the world.
    world_revision: u64,
    current: CurrentRobot,
    scene: CurrentScene,
    monitored: Option<Monitored>,
    volumes: Option<LinkVolumes>,
    /// How many steps below their roots hierarchies are shown, if they are.
    shown_level: Option<usize>,
}

/// Remarks on meshes that the log has: each once, and not more than a person reads.
#[derive(Default)]
struct ToldMeshes(HashSet<String>);

impl ToldMeshes {
    fn tell(&mut self, meshes: &[SolidMeshRemark]) {
        const MOST: usize = 1000;
        for text in meshes.iter().map(ToString::to_string) {
            if self.0.len() < MOST && self.0.insert(text.clone()) {
                log::warn!("{text}");
                if self.0.len() == MOST {
                    log::warn!("further remarks on solid meshes are not logged");
                }
            }
        }
    }
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
    pub fn new((mesh_files, surroundings, mesh_model): (MeshFiles, Surroundings, MeshModel)) -> Self {
        Self {
            mesh_files,
            surroundings,
            mesh_model,
            told_meshes: ToldMeshes::default(),
            given: None,
            prefixes: Default::default(),
            description: None,
            semantic: None,
            robot: None,
            keeper: SceneKeeper::default(),
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

    /// From now on every change of the scene is told.
    pub fn tell_on(&mut self, monitored: Monitored, volumes: LinkVolumes) {
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

    /// The checker of a robot from the command line; from now on descriptions on topics are not heeded.
    pub fn take_given(
        &mut self,
        robot: RobotModel,
        update_context: &SceneUpdateContext,
    ) -> Result<Arc<Revision>, String> {
        self.shown_level = update_context.parameters.shown_level();
        self.given = Some(robot.clone());
        self.take(robot, update_context)
    }

    /// Follows orders until there is no one left to give them.
    pub fn follow(
        mut self,
        orders: &Receiver<Order>,
        events: &mailbox::Sender<Event>,
        inputs: &LoaderInputs,
    ) {
        self.watch_frames(inputs);
        while let Some(mut together) = self.await_orders(orders, inputs) {
            // a robot's URDF and SRDF often come together, and objects by the dozen: build once for all
            while let Ok(order) = orders.try_recv() {
                together.push(order);
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

    /// Does what is asked for together, and tells what the monitor has to know of it.
    pub fn carry_out(&mut self, pass: Pass, mut tell: impl FnMut(Event)) {
        let Pass { update_context, orders, clouds } = pass;
        let texts = self.texts;
        self.keeper.ask(&update_context.parameters.planning_scene_service);
        let (mut is_new_robot, mut change) = (false, self.follow_frames(&update_context));
        let updates = orders.iter().filter(|order| matches!(order, Order::Scene(_))).count();
        for order in orders {
            match self.note(order, &update_context) {
                Change::Robot => is_new_robot = true,
                other => change = change.max(other),
            }
        }
        self.shown_level = update_context.parameters.shown_level();
        change = change.max(self.look_at_the_world(clouds, &update_context));
        let is_described = self.description.is_some() || self.given.is_some();
        if is_new_robot && is_described {
            tell(Event::ModelSwap);
        }
        let (built, refused) = self.build_anew(is_new_robot, change, &update_context);
        if self.texts > texts {
            tell(Event::Heeded(self.texts));
        }
        if updates > 0 {
            tell(Event::WorldUpdate(WorldUpdate::Completing(updates)));
        }
        if let Some(revision) = built {
            tell(Event::Checker(revision));
        }
        if let Some(fault) = refused {
            tell(Event::ModelFault(fault));
        }
        let incomplete = self.keeper.incomplete(&update_context.parameters);
        tell(Event::World(self.keeper.note_in_use(), self.keeper.faults(), incomplete));
    }

    /// Builds what changed, and tells what was refused: a robot that is takes no other change with it.
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

    /// The next order, or none when enough time passed without one; `None` when there will be none.
    fn await_orders(&mut self, orders: &Receiver<Order>, inputs: &LoaderInputs) -> Option<Vec<Order>> {
        let Shared { transforms, grounds, store, clock, .. } = &inputs.shared;
        // what tf said while the last orders were followed was compared with where obstacles were before
        let tree = lock(transforms);
        if lock(grounds).are_elsewhere(&tree) {
            return Some(vec![Order::Frames]);
        }
        drop(tree);
        let due = self.keeper.time_to_drop(clock.read(), &store.get());
        let order = smol::block_on(future::or(async { orders.recv().await.map(Some) }, async {
            match due {
                Some(due) => drop(Timer::after(due).await),
                None => future::pending().await,
            }
            Ok(None)
        }));
        Some(order.ok()?.into_iter().collect())
    }

    /// Obstacles are put where they belong.
    fn follow_frames(&mut self, update_context: &SceneUpdateContext) -> Change {
        let Some(robot) = self.robot.clone() else {
            return Change::Nothing;
        };
        let moved = guarded_scene(&mut self.keeper, |keeper| keeper.follow_frames(&robot, update_context));
        if moved { Change::World } else { Change::Nothing }
    }

    /// Says what has to be looked at to know whether obstacles are where they belong.
    fn watch_frames(&self, inputs: &LoaderInputs) {
        let grounds = self.robot.as_ref().map(|robot| self.keeper.state.grounds(robot));
        *lock(&inputs.shared.grounds) = grounds.unwrap_or_default();
    }

    /// New clouds are taken, and what is too old is dropped.
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

    fn note(&mut self, order: Order, update_context: &SceneUpdateContext) -> Change {
        let (known, text, topic) = match order {
            Order::Parameters if self.prefixes == prefixes(&update_context.parameters) => {
                return Change::Settings;
            }
            Order::Parameters => return Change::Robot,
            Order::Clouds | Order::Display | Order::Frames => return Change::Nothing,
            Order::Scene(order) => return self.note_scene(*order, update_context),
            Order::Description(text) => (&mut self.description, text, DESCRIPTION),
            Order::Semantic(text) => (&mut self.semantic, text, SEMANTIC),
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

    fn note_scene(&mut self, order: SceneOrder, update_context: &SceneUpdateContext) -> Change {
        let Some(robot) = self.robot.clone() else {
            self.keeper.wait(order);
            return Change::Nothing;
        };
        let changed = guarded_scene(&mut self.keeper, |keeper| keeper.apply(order, &robot, update_context));
        if changed { Change::World } else { Change::Nothing }
    }

    /// The robot that the last texts describe.
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
            // left over from the robot that was described before: its pairs would be nonsense here
            log::warn!("{SEMANTIC} is of robot '{}', not of '{}': not heeded", srdf.robot_name, robot.name());
            robot = load(&RobotText { srdf: None, ..text })?;
        }
        self.take(robot, update_context).map(Some)
    }

    /// The same robot with other settings, or in another world.
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
            // poses in files refer to a robot: each needs them anew
            self.keeper.begin_with((self.surroundings)(&robot)?, &robot, update_context);
            world = world.max(u64::from(!self.keeper.state.world.is_empty()));
        } else {
            self.keeper.fit_to(&robot);
        }
        self.keeper.follow_frames(&robot, update_context);
        let mut awaited = Vec::new();
        for order in self.keeper.awaited() {
            awaited.push(order.source);
            let changed =
                guarded_scene(&mut self.keeper, |keeper| keeper.apply(order, &robot, update_context));
            world += u64::from(changed);
        }
        let revision = match self.build(&robot, (self.model_revision + 1, world), update_context) {
            Ok(revision) => revision,
            Err(fault) => {
                // the robot before stays, in its scene
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

    /// A checker of the scene as it is now, which is in force from now on.
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
        self.told_meshes.tell(&meshes);
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
        *lock(&self.scene) = Some(Arc::new(SceneInForce {
            revision: Arc::clone(&revision),
            scene: scene.clone(),
            octomap: self.keeper.octomap.clone(),
            mesh_model: self.mesh_model,
            parameters: parameters.clone(),
        }));
        Ok(revision)
    }
}

impl SceneUpdateContext {
    /// Before anything is known but the parameters.
    #[must_use]
    pub fn first(parameters: &Parameters, now: Now) -> Self {
        Self {
            now,
            parameters: parameters.clone(),
            transforms: TransformTree::default(),
            evaluation: None,
            places: Places::default(),
        }
    }
}

/// What names of joints and of links begin with.
fn prefixes(parameters: &Parameters) -> [String; 2] {
    [parameters.joint_prefix.clone(), parameters.link_prefix.clone()]
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    // the guarded values are valid between any two statements
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A message is a stranger's: what it breaks must not take the node with it.
fn guarded_scene(keeper: &mut SceneKeeper, change: impl FnOnce(&mut SceneKeeper) -> bool) -> bool {
    catch_unwind(AssertUnwindSafe(|| change(keeper))).unwrap_or_else(|_| {
        const FAULT: &str = "a change of the world failed inside the program; the world may lack it";
        log::error!("{FAULT}");
        keeper.note_failure(FAULT);
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

#[cfg(test)]
mod tests;
