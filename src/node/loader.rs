//! From robot descriptions to checkers, on a thread of its own: the monitor goes on with the old model meanwhile.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};

use smol::channel::{Receiver, Sender};

use super::monitor_loop::Event;
use super::parameter_services::ParameterStore;
use crate::checker::{AllowedCollisionMatrix, CollisionChecker, MeshModel, Settings};
use crate::monitor::Revision;
use crate::robot::{MeshFiles, RobotModel, RobotText};
use crate::world::World;

/// What there is around a robot, and which contacts are allowed. Poses in scene files refer to a robot, so each new
/// robot needs them anew.
pub type Surroundings =
    Box<dyn Fn(&RobotModel) -> Result<(World, Option<AllowedCollisionMatrix>), String> + Send>;

/// What may change what is checked.
pub enum Order {
    /// A URDF came on `robot_description`.
    Description(String),
    /// An SRDF came on `robot_description_semantic`.
    Semantic(String),
    /// A parameter changed.
    Parameters,
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
    subject: Option<Subject>,
    /// Counts the robots that were taken.
    model_revision: u64,
    current: CurrentRobot,
}

/// A robot and what is around it.
struct Subject {
    robot: Arc<RobotModel>,
    world: World,
    allowed: Option<AllowedCollisionMatrix>,
}

/// How much has to be built anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Change {
    Nothing,
    Settings,
    Robot,
}

impl Loader {
    #[must_use]
    pub fn new(
        mesh_files: MeshFiles,
        surroundings: Surroundings,
        mesh_model: MeshModel,
        parameters: ParameterStore,
    ) -> Self {
        Self {
            mesh_files,
            surroundings,
            mesh_model,
            parameters,
            robot_is_given: false,
            description: None,
            semantic: None,
            subject: None,
            model_revision: 0,
            current: CurrentRobot::default(),
        }
    }

    #[must_use]
    pub fn current_robot(&self) -> CurrentRobot {
        Arc::clone(&self.current)
    }

    /// The checker of a robot from the command line; from now on descriptions on topics are not heeded.
    pub fn take_given(&mut self, robot: RobotModel) -> Result<Arc<Revision>, String> {
        self.robot_is_given = true;
        self.take(robot)
    }

    /// Follows orders until there is no one left to give them.
    pub fn follow(mut self, orders: &Receiver<Order>, events: &Sender<Event>) {
        while let Ok(order) = orders.recv_blocking() {
            let mut change = self.note(order);
            // a robot's URDF and SRDF often come together: build once for both
            while let Ok(order) = orders.try_recv() {
                change = change.max(self.note(order));
            }
            let built = match change {
                Change::Nothing => Ok(None),
                Change::Settings => self.rebuild(),
                Change::Robot => guarded(|| self.reload()),
            };
            let event = match built {
                Ok(None) => continue,
                Ok(Some(revision)) => Event::Checker(revision),
                Err(fault) => {
                    log::error!("the robot model was refused: {fault}");
                    Event::ModelFault(fault)
                }
            };
            if events.send_blocking(event).is_err() {
                return;
            }
        }
    }

    fn note(&mut self, order: Order) -> Change {
        let (known, text, topic) = match order {
            Order::Parameters => return Change::Settings,
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

    /// The same robot with other settings.
    fn rebuild(&mut self) -> Result<Option<Arc<Revision>>, String> {
        let Some(subject) = &self.subject else {
            return Ok(None);
        };
        self.build(subject, self.model_revision).map(Some)
    }

    fn take(&mut self, robot: RobotModel) -> Result<Arc<Revision>, String> {
        for warning in robot.warnings() {
            log::warn!("{warning}");
        }
        let (world, allowed) = (self.surroundings)(&robot)?;
        let subject = Subject { robot: Arc::new(robot), world, allowed };
        let revision = self.build(&subject, self.model_revision + 1)?;
        log::info!(
            "robot '{}': {} links, {} positions, {} pairs to check",
            subject.robot.name(),
            subject.robot.links().len(),
            subject.robot.position_names().len(),
            revision.checker.pairs().len(),
        );
        self.model_revision = revision.model;
        *self.current.lock().unwrap_or_else(PoisonError::into_inner) = Some(Arc::clone(&subject.robot));
        self.subject = Some(subject);
        Ok(revision)
    }

    fn build(&self, subject: &Subject, model: u64) -> Result<Arc<Revision>, String> {
        let parameters = self.parameters.get();
        let settings = Settings {
            padding: parameters.padding,
            pad_self: parameters.pad_self,
            mesh_model: self.mesh_model,
            ..Settings::default()
        };
        let robot = Arc::clone(&subject.robot);
        let checker =
            CollisionChecker::with_matrix(robot, &subject.world, settings, subject.allowed.as_ref())
                .map_err(|error| error.to_string())?;
        // the world comes from files once, or is empty for ever
        let world = u64::from(!subject.world.is_empty());
        Ok(Arc::new(Revision { checker, model, world }))
    }
}

const DESCRIPTION: &str = "robot_description";
const SEMANTIC: &str = "robot_description_semantic";

/// A fault that names the topic, if its place in the text does not.
fn named(fault: &str) -> String {
    if fault.starts_with(DESCRIPTION) { fault.to_owned() } else { format!("{DESCRIPTION}: {fault}") }
}

/// A description is a stranger's text: what it breaks must not take the node with it.
fn guarded<T>(build: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(build))
        .unwrap_or_else(|_| Err(format!("{DESCRIPTION}: reading it failed inside the program")))
}
