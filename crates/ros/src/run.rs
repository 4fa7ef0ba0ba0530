//! Start and end of the node, its threads and the channels between them.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use clearance_monitor::Monitor;
use clearance_robot::{MeshFiles, RobotModel};
use clearance_scene::MeshModel;
use futures_lite::future;
use ros2_interfaces_jazzy_serde::sensor_msgs::msg::JointState;
use ros2_interfaces_jazzy_serde::std_msgs::msg::String as StringMessage;
use smol::channel::{self, Receiver, Sender};

use super::arguments::RosArguments;
use super::clock::RosClock;
use super::enable_service::EnableService;
use super::link_volumes::LinkVolumes;
use super::loader::{Loader, Surroundings};
use super::loader_inputs::LoaderInputs;
use super::logging::{self, Line};
use super::mailbox;
use super::marker_topic;
use super::memory_limit::{Components, MemoryWatch, OutOfMemory};
use super::middleware::{
    self, Announcement, MessageKind, Middleware, MiddlewareError, Publisher, Quality, Subscription,
};
use super::monitor_loop::{CurrentEvaluation, Event, MonitorLoop, Observer, OwnMotion, Report};
use super::motion::{self, Motion};
use super::motion_services::MotionServices;
use super::names::{FullName, NameError, Names};
use super::order::Order;
use super::parameter_files;
use super::parameter_services::{OnChange, ParameterServices, ParameterStore};
use super::parameters::Parameters;
use super::publishers::Publishers;
use super::recording::{Given, Recorder, RecorderHandle};
use super::scene::{Monitored, SceneServices, SceneTopics, Shared};
use super::scene_keeper::SceneUpdateContext;
use super::simulation_clock;
use super::startup::Startup;
use super::state_services::StateServices;
use super::termination::hand_signals_to;
use super::thread_priority::ThreadPriority;
use super::threads::{End, Part, run_together, until};

/// Name of the node, unless it is remapped.
pub const NODE_NAME: &str = "clearance";

/// Input of a node, determined before it starts.
pub struct NodeOptions {
    /// Started before any work that takes time.
    pub startup: Startup,
    /// DDS participant that the node's endpoints will belong to.
    pub announcement: Announcement,
    pub arguments: RosArguments,
    /// Initial parameters.
    pub parameters: Parameters,
    /// Robot model; if `None`, the model is received from `robot_description`.
    pub robot: Option<RobotModel>,
    /// Lookup of the meshes of a received robot description.
    pub mesh_files: MeshFiles,
    pub surroundings: Surroundings,
    pub mesh_model: MeshModel,
    /// Motion to publish on `joint_states`.
    pub motion: Option<Motion>,
    pub observer: Option<Observer>,
    /// Called once, after all input that can be rejected was read and the node has joined the network.
    pub on_start: Option<Box<dyn FnOnce() + Send>>,
    /// Input that a recording needs for its replay.
    pub given: Given,
}

impl std::fmt::Debug for NodeOptions {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("NodeOptions")
            .field("announcement", &self.announcement)
            .field("arguments", &self.arguments)
            .field("parameters", &self.parameters)
            .finish_non_exhaustive()
    }
}

/// Reason why a node did not start, or did not end normally.
#[derive(Debug, thiserror::Error)]
pub enum NodeError {
    /// Invalid user input.
    #[error("{0}")]
    Input(String),
    /// Error of the network or of this program.
    #[error("{0}")]
    Internal(String),
    /// The process exceeded its memory limit.
    #[error("{0}")]
    OutOfMemory(String),
}

fn input(error: impl std::fmt::Display) -> NodeError {
    NodeError::Input(error.to_string())
}

impl From<MiddlewareError> for NodeError {
    fn from(error: MiddlewareError) -> Self {
        Self::Internal(error.to_string())
    }
}

impl From<NameError> for NodeError {
    fn from(error: NameError) -> Self {
        input(error)
    }
}

const JOINT_STATE: MessageKind = MessageKind("sensor_msgs", "JointState");
const STRING: MessageKind = MessageKind("std_msgs", "String");

/// Error message when the threads of the network library have ended.
const DEAF: &str = "the threads of the network library have ended, as they do when the process was suspended (Ctrl-Z and fg, a debugger) or a packet was \
                    broken: start the node again";

/// Runs a node until SIGINT or SIGTERM.
pub fn run(options: NodeOptions) -> Result<(), NodeError> {
    let names = Names::new(NODE_NAME, &options.arguments.remaps)?;
    let (parameters, priority) = (options.parameters, options.announcement.priority());
    let clock = Arc::new(RosClock::new(parameters.use_sim_time));
    let (events, events_in) = mailbox::unbounded();
    let (orders, orders_in) = channel::unbounded();
    let [(changes, changes_in), (watch, watch_in)] = [channel::unbounded(), channel::unbounded()];
    let (stop, stopped) = channel::bounded(1);
    let end = End { events: events.clone(), orders: orders.clone(), stop };
    let on_change = on_change(parameters.clone(), Arc::clone(&clock), &end, [changes, watch]);
    let store = ParameterStore::new(parameters.clone(), on_change);

    let mut monitor = Monitor::new(parameters.monitor_settings(), stopwatch);
    let current = CurrentEvaluation::default();
    let is_given = options.robot.is_some();
    let mut loader = Loader::new((options.mesh_files, options.surroundings, options.mesh_model));
    if let Some(robot) = options.robot {
        let update_context = SceneUpdateContext::first(&parameters, clock.read());
        monitor.set_checker(loader.take_given(robot, &update_context).map_err(NodeError::Input)?);
    }
    hand_signals_to(end.clone());
    let meshes = options.given.meshes.clone();
    let (tape, recorder) = record(&parameters, &names, options.given)?;
    let shared = Shared::new(loader.current_scene(), store.clone(), Arc::clone(&clock), tape.clone());
    let inputs = LoaderInputs { shared: shared.clone(), evaluation: Arc::clone(&current), meshes };
    inputs.note_meshes();
    let current_robot = loader.current_robot();
    let components = Components { scene: loader.current_scene(), tape: tape.clone() };
    let memory = MemoryWatch::new(store.clone(), events.clone(), components);
    let out_of_memory = memory.out_of_memory();
    let domain = options.announcement.environment().domain;
    let middleware = Middleware::join(options.announcement, names.namespace(), names.node())?;
    let joint_states = names.resolve("joint_states")?;
    let motion = with_publisher(options.motion, &middleware, &joint_states)?;
    let (own_states, own_states_in) = mailbox::bounded(1);
    let (markers, marker_desk) = marker_topic::open(&middleware, &names)?;
    let monitor_loop = MonitorLoop {
        node: names.full_node_name(),
        monitor,
        parameters,
        clock: Arc::clone(&clock),
        joint_states: middleware.subscription(&joint_states, JOINT_STATE, Quality::BestEffort)?,
        transforms: Arc::clone(&shared.transforms),
        own_motion: OwnMotion {
            source: motion.as_ref().map(|(_, publisher)| publisher.source()),
            joint_states: own_states_in,
        },
        events: events_in,
        publishers: Publishers::open(&middleware, &names, markers)?,
        current: Arc::clone(&current),
        joint_state_history: Arc::clone(&shared.joint_state_history),
        observer: options.observer,
        tape: tape.clone(),
        report: Report::default(),
    };
    loader.tell_on(Monitored::open(&middleware, &names)?, LinkVolumes::open(&middleware, &names)?);
    let (scenes, validity_desk) =
        SceneServices::offer(&middleware, &names, Arc::clone(&current), shared.clone())?;
    let topics = SceneTopics::open(&middleware, &names, shared, (orders.clone(), events.clone()), watch_in)?;
    let (states, state_desk) =
        StateServices::offer(&middleware, &names, Arc::clone(&current), Arc::clone(&clock))?;
    let (motions, motion_desk) =
        MotionServices::offer(&middleware, &names, current, Arc::clone(&clock), store.clone())?;
    let small = (motions, states, EnableService::offer(&middleware, &names, end.events.clone())?);
    let ordering = (orders, (!is_given).then(|| end.events.clone()));
    let services =
        Services::open(&middleware, &names, (store, tape, Arc::clone(&clock), small), ordering, changes_in)?;
    let mut parts = vec![
        Part::new("monitor", move || run_first(monitor_loop, priority)),
        Part::new("markers", move || marker_desk.work()),
        Part::new("loader", move || loader.follow(&orders_in, &events, &inputs)),
    ];
    if let Some((motion, publisher)) = motion {
        let stopped = stopped.clone();
        parts.push(Part::new("motion", move || {
            let play = motion::play(&motion, &current_robot, &clock, &publisher, &own_states);
            smol::block_on(until(&stopped, play));
        }));
    }
    parts.push(task("memory", &stopped, async move || memory.work().await));
    parts.push(desk("motions", &stopped, move || motion_desk.work()));
    parts.push(desk("states", &stopped, move || state_desk.work()));
    parts.push(desk("validity", &stopped, move || validity_desk.work()));
    parts.push(task("network", &stopped, middleware::deafness));
    let world = async move || future::zip(topics.listen(), scenes.serve(&topics)).await;
    parts.push(task("world", &stopped, world));
    parts.push(task("services", &stopped, async move || Box::pin(services.serve()).await));

    let node = names.full_node_name();
    if let Some(on_start) = options.on_start {
        on_start();
    }
    log::info!("{node} listens to {joint_states} in domain {domain}");
    drop(options.startup);
    let ended = run_together(parts, &end).map_err(NodeError::Internal);
    if let Some(recorder) = recorder {
        recorder.finish();
    }
    ended?;
    leave(middleware, &out_of_memory)?;
    log::info!("{node} has ended");
    Ok(())
}

/// Announces the end of the node to its peers.
///
/// # Errors
/// When the node ended because of an error.
fn leave(middleware: Middleware, out_of_memory: &OutOfMemory) -> Result<(), NodeError> {
    if middleware::is_deaf() {
        return Err(NodeError::Internal(DEAF.to_owned()));
    }
    middleware.leave();
    out_of_memory.get().map_or(Ok(()), |why| Err(NodeError::OutOfMemory(why.clone())))
}

fn run_first(monitor_loop: MonitorLoop, priority: ThreadPriority) {
    if let Err(why) = priority.apply() {
        log::error!("the monitor's thread runs at no higher priority than others: {why}");
    }
    monitor_loop.run();
}

/// Part of the node that runs until it is stopped.
fn task<T>(
    name: &'static str,
    stopped: &Receiver<()>,
    work: impl AsyncFnOnce() -> T + Send + 'static,
) -> Part {
    let stopped = stopped.clone();
    Part::new(name, move || smol::block_on(until(&stopped, work())))
}

/// Part of the node that runs checks for requests. A check that takes hours does not delay the end of the node.
fn desk(name: &'static str, stopped: &Receiver<()>, work: impl FnOnce() + Send + 'static) -> Part {
    task(name, stopped, || smol::unblock(work))
}

/// Motion with its publisher.
fn with_publisher(
    motion: Option<Motion>,
    middleware: &Middleware,
    joint_states: &FullName,
) -> Result<Option<(Motion, Publisher<JointState>)>, MiddlewareError> {
    let published =
        |motion| Ok((motion, middleware.publisher(joint_states, JOINT_STATE, Quality::Reliable)?));
    motion.map(published).transpose()
}

/// Recorder and the handle to it, if the parameters turn recording on.
fn record(
    parameters: &Parameters,
    names: &Names,
    given: Given,
) -> Result<(RecorderHandle, Option<Recorder>), NodeError> {
    let Some(settings) = parameters.recording() else {
        return Ok((RecorderHandle::default(), None));
    };
    let (tape, recorder) = Recorder::start(&settings, names, given, parameters).map_err(NodeError::Input)?;
    Ok((tape, Some(recorder)))
}

/// Parameters from the files and the `-p` arguments.
///
/// # Errors
/// When a file cannot be read, or a value is not valid for its parameter.
pub fn initial_parameters(arguments: &RosArguments) -> Result<Parameters, NodeError> {
    for ignored in &arguments.ignored {
        log::warn!("{ignored} has no effect here");
    }
    let names = Names::new(NODE_NAME, &arguments.remaps)?;
    let (parameters, passed_over) =
        parameter_files::initial(Parameters::default(), &arguments.parameters, &names).map_err(input)?;
    for parameter in passed_over {
        log::warn!("passed over, for this node has no such parameter: {parameter}");
    }
    Ok(parameters)
}

/// Replaces the text of a description that cannot be decoded.
const UNREADABLE: &str = "(the message could not be decoded: is its text UTF-8?)";

/// Services that are neither urgent nor slow, on one thread: descriptions, parameters, simulated time, warnings about peers.
struct Services {
    middleware: Middleware,
    descriptions: Subscription<StringMessage>,
    semantics: Subscription<StringMessage>,
    parameters: ParameterServices,
    motions: MotionServices,
    states: StateServices,
    enable: EnableService,
    store: ParameterStore,
    tape: RecorderHandle,
    clock: Arc<RosClock>,
    clock_topic: FullName,
    orders: Sender<Order>,
    /// Queue of the monitor; `None` if the robot was given on the command line.
    heeds_descriptions: Option<mailbox::Sender<Event>>,
    changes: Receiver<()>,
    lines: mailbox::Receiver<Line>,
    /// Name of the node in the format of loggers.
    logger: String,
}

impl Services {
    fn open(
        middleware: &Middleware,
        names: &Names,
        (store, tape, clock, (motions, states, enable)): (
            ParameterStore,
            RecorderHandle,
            Arc<RosClock>,
            (MotionServices, StateServices, EnableService),
        ),
        (orders, heeds_descriptions): (Sender<Order>, Option<mailbox::Sender<Event>>),
        changes: Receiver<()>,
    ) -> Result<Self, NodeError> {
        let latched = |name| -> Result<_, NodeError> {
            Ok(middleware.subscription(&names.resolve(name)?, STRING, Quality::Latched)?)
        };
        Ok(Self {
            descriptions: latched("robot_description")?,
            semantics: latched("robot_description_semantic")?,
            parameters: ParameterServices::offer(middleware, names, store.clone(), Arc::clone(&clock))?,
            motions,
            states,
            enable,
            clock_topic: names.resolve("/clock")?,
            middleware: middleware.clone(),
            store,
            tape,
            clock,
            orders,
            heeds_descriptions,
            changes,
            lines: logging::listen(),
            logger: names.full_node_name().trim_start_matches('/').replace('/', "."),
        })
    }

    async fn serve(self) {
        let follow_clock = async {
            let Self { middleware, clock_topic, clock, store, tape, changes, .. } = &self;
            let followed = simulation_clock::follow(middleware, clock_topic, clock, (store, tape), changes);
            if let Err(error) = followed.await {
                log::error!("simulated time can not be followed: {error}");
            }
        };
        let descriptions = self.forward(&self.descriptions, Order::Description);
        let semantics = self.forward(&self.semantics, Order::Semantic);
        let listen = future::zip(future::zip(descriptions, semantics), follow_clock);
        let tell = async {
            while let Some(line) = self.lines.receive().await {
                self.middleware.tell(&self.logger, &line, self.clock.now().unwrap_or_default());
            }
        };
        let checks = future::zip(self.motions.serve(), self.states.serve());
        let serve = future::zip(self.parameters.serve(), checks);
        let serve = future::zip(future::zip(serve, self.enable.serve()), tell);
        let meet = Box::pin(self.middleware.meet_peers());
        future::zip(future::zip(listen, serve), meet).await;
    }

    /// Converts the descriptions on a topic to orders. The monitor is notified of a new one first, as the loader may be busy.
    async fn forward(&self, topic: &Subscription<StringMessage>, order: fn(String) -> Order) {
        let mut last = None;
        loop {
            // a message that cannot be decoded is rejected like any other invalid robot description
            let received = topic.next_or_unreadable().await.map(|(StringMessage { data }, _)| data);
            let text = received.unwrap_or_else(|_| UNREADABLE.to_owned());
            if last.as_ref() != Some(&text) {
                if let Some(events) = &self.heeds_descriptions {
                    // an error means that the receiver has ended
                    let _ = events.send(Event::Described);
                }
                last = Some(text.clone());
            }
            if self.orders.send(order(text)).await.is_err() {
                return;
            }
        }
    }
}

/// Callback that passes changed parameters to all parts that use them.
fn on_change(
    initial: Parameters,
    clock: Arc<RosClock>,
    End { events, orders, .. }: &End,
    changes: [Sender<()>; 2],
) -> OnChange {
    let (events, orders) = (events.clone(), orders.clone());
    let last = Mutex::new(initial);
    Box::new(move |parameters| {
        let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
        clock.use_sim_time(parameters.use_sim_time);
        // an error means that the receiver has ended
        let _ = events.send(Event::Parameters(Box::new(parameters.clone())));
        if what_is_built(&last) != what_is_built(parameters) {
            let _ = orders.try_send(Order::Parameters);
        }
        if last.link_volume_level != parameters.link_volume_level {
            let _ = orders.try_send(Order::Display);
        }
        for changes in &changes {
            let _ = changes.try_send(());
        }
        *last = parameters.clone();
    })
}

/// Parameters that require a rebuild of the checker, or a pass of the loader, when they change.
fn what_is_built(parameters: &Parameters) -> impl PartialEq + use<> {
    (
        (parameters.padding, parameters.pad_self, parameters.stale_source_policy),
        (parameters.joint_prefix.clone(), parameters.link_prefix.clone()),
        (parameters.point_cloud_ttl, parameters.octomap_ttl, parameters.point_cloud_topics.clone()),
        (parameters.require_planning_scene, parameters.planning_scene_service.clone()),
        (parameters.blind_cloud, parameters.rejected_obstacle, parameters.lost_messages),
    )
}

/// Time since the first call.
fn stopwatch() -> Duration {
    static START: std::sync::LazyLock<Instant> = std::sync::LazyLock::new(Instant::now);
    START.elapsed()
}
