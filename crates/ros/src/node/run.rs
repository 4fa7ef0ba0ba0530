//! Start and end of the node, its threads and the channels between them.

use std::sync::Arc;
use std::time::{Duration, Instant};

use clearance_monitor::Monitor;
use futures_lite::future;
use ros2_interfaces_jazzy_serde::sensor_msgs::msg::JointState;
use smol::channel::{self, Receiver, Sender};

use crate::clock::RosClock;
use crate::dds::middleware::Middleware;
use crate::dds::middleware_error::MiddlewareError;
use crate::dds::publisher::Publisher;
use crate::dds::quality::Quality;
use crate::dds::receive_thread_watch;
use crate::dds::type_name::TypeName;
use crate::loading::loader::Loader;
use crate::loading::loader_inputs::LoaderInputs;
use crate::monitor_events::current_evaluation::CurrentEvaluation;
use crate::monitor_events::monitor_event::MonitorEvent;
use crate::names::NODE_NAME;
use crate::names::{FullName, Names};
use crate::node::memory_limit::{Components, MemoryWatch, OutOfMemory};
use crate::node::monitor_loop::{MonitorLoop, OwnMotion, Report};
use crate::node::node_options::NodeOptions;
use crate::node::node_threads::{Part, StopSignal, run_together, until};
use crate::node::parameter_changes::on_change;
use crate::node::services_thread::{ServicesInputs, ServicesThread};
use crate::node::termination::hand_signals_to;
use crate::node_error::NodeError;
use crate::parameters::parameter_set::Parameters;
use crate::parameters::parameter_store::ParameterStore;
use crate::recording::recorded_event::CommandLineInputs;
use crate::recording::recorder::{RecordedNode, Recorder};
use crate::recording::recorder_handle::RecorderHandle;
use crate::scene::loader_command::LoaderCommand;
use crate::scene::scene_command_sender::SceneCommandSender;
use crate::scene::scene_update_context::SceneUpdateContext;
use crate::scene::shared_state::SharedState;
use crate::services::enable_service::EnableService;
use crate::services::motion_services::MotionServices;
use crate::services::scene_services::SceneServices;
use crate::services::state_services::StateServices;
use crate::threading::mailbox;
use crate::threading::thread_priority::ThreadPriority;
use crate::topics::demo_motion::Motion;
use crate::topics::evaluation_publishers::Publishers;
use crate::topics::link_volumes::LinkVolumes;
use crate::topics::monitored_scene::MonitoredScene;
use crate::topics::scene_topics::SceneTopics;
use crate::topics::{demo_motion, marker_topic, retreat_topic};

const JOINT_STATE: TypeName = TypeName::new("sensor_msgs", "JointState");

/// Error message when the threads of the network library have ended.
const RECEIVE_THREADS_ENDED: &str = "the threads of the network library have ended, as they do when the process was suspended (Ctrl-Z and fg, a debugger) or a packet was \
                    broken: start the node again";

/// Runs a node until SIGINT or SIGTERM.
pub fn run(options: NodeOptions) -> Result<(), NodeError> {
    let names = Names::new(NODE_NAME, &options.arguments.remaps)?;
    let (parameters, priority) = (options.parameters, options.announcement.priority());
    let clock = Arc::new(RosClock::new(parameters.use_sim_time));
    let (events, events_in) = mailbox::unbounded();
    let (commands, commands_in) = channel::unbounded();
    let [(changes, changes_in), (watch, watch_in)] = [channel::unbounded(), channel::unbounded()];
    let (stop, stopped) = channel::bounded(1);
    let end = StopSignal { events: events.clone(), commands: commands.clone(), stop };
    let on_change = on_change(parameters.clone(), Arc::clone(&clock), &end, [changes, watch]);
    let store = ParameterStore::new(parameters.clone(), on_change);

    let mut monitor = Monitor::new(parameters.monitor_settings(), stopwatch);
    let current = CurrentEvaluation::default();
    let has_given_robot = options.robot.is_some();
    let mut loader = Loader::new(options.mesh_files, options.surroundings, options.mesh_model);
    if let Some(robot) = options.robot {
        let update_context = SceneUpdateContext::first(&parameters, clock.read());
        monitor.set_checker(loader.load_given(robot, &update_context).map_err(NodeError::Input)?);
    }
    hand_signals_to(end.clone());
    let meshes = options.command_line.meshes.clone();
    let (recording, recorder) = record(&parameters, &names, options.command_line)?;
    let shared =
        SharedState::new(loader.current_scene(), store.clone(), Arc::clone(&clock), recording.clone());
    let inputs = LoaderInputs { shared: shared.clone(), evaluation: Arc::clone(&current), meshes };
    inputs.note_meshes();
    let current_robot = loader.current_robot();
    let components = Components { scene: loader.current_scene(), recording: recording.clone() };
    let memory = MemoryWatch::new(store.clone(), events.clone(), components);
    let out_of_memory = memory.out_of_memory();
    let domain = options.announcement.environment().domain;
    let middleware = Middleware::join(options.announcement, names.namespace(), names.node())?;
    let joint_states = names.resolve("joint_states")?;
    let motion = with_publisher(options.motion, &middleware, &joint_states)?;
    let (own_states, own_states_in) = mailbox::bounded(1);
    let (publishers, slow_topics) = open_publishers(&middleware, &names, &current, &clock, &stopped)?;
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
        publishers,
        current: Arc::clone(&current),
        joint_state_history: Arc::clone(&shared.joint_state_history),
        observer: options.observer,
        recording: recording.clone(),
        report: Report::default(),
    };
    loader.publish_on(MonitoredScene::open(&middleware, &names)?, LinkVolumes::open(&middleware, &names)?);
    let (scenes, validity_worker) =
        SceneServices::open(&middleware, &names, Arc::clone(&current), shared.clone())?;
    let sender = SceneCommandSender::new(shared, commands.clone(), events.clone());
    let topics = SceneTopics::open(&middleware, &names, sender, watch_in)?;
    let request_inputs = RequestInputs {
        current,
        store,
        recording,
        clock: Arc::clone(&clock),
        commands,
        events: end.events.clone(),
        has_given_robot,
        changes: changes_in,
    };
    let (services, request_workers) = open_services(&middleware, &names, request_inputs, &stopped)?;
    let mut parts = vec![
        Part::new("monitor", move || run_first(monitor_loop, priority)),
        Part::new("loader", move || loader.run(&commands_in, &events, &inputs)),
    ];
    parts.extend(motion.map(|(motion, publisher)| {
        task("motion", &stopped, async move || {
            demo_motion::play(&motion, &current_robot, &clock, &publisher, &own_states).await;
        })
    }));
    parts.push(task("memory", &stopped, async move || memory.run().await));
    parts.extend(slow_topics);
    parts.extend(request_workers);
    parts.push(worker("validity", &stopped, move || validity_worker.run()));
    parts.push(task("network", &stopped, receive_thread_watch::ended));
    let world = async move || future::zip(topics.receive(), scenes.serve(&topics.sender)).await;
    parts.push(task("world", &stopped, world));
    parts.push(task("services", &stopped, async move || Box::pin(services.run()).await));

    let node = names.full_node_name();
    options.on_start.into_iter().for_each(|on_start| on_start());
    log::info!("{node} listens to {joint_states} in domain {domain}");
    drop(options.startup);
    let fault = run_parts(parts, &end, recorder)?;
    leave(middleware, &out_of_memory, &node)?;
    fault.map_or(Ok(()), |fault| Err(NodeError::IncompleteRecording(fault)))
}

/// Runs all parts until they have ended, and completes the recording. Returns why it is incomplete, if it is.
fn run_parts(
    parts: Vec<Part>,
    end: &StopSignal,
    recorder: Option<Recorder>,
) -> Result<Option<String>, NodeError> {
    let ended = run_together(parts, end).map_err(NodeError::Internal);
    let fault = recorder.and_then(|recorder| recorder.finish().err());
    ended.map(|()| fault)
}

/// Announces the end of the node to its peers.
///
/// # Errors
/// When the node ended because of an error.
fn leave(middleware: Middleware, out_of_memory: &OutOfMemory, node: &str) -> Result<(), NodeError> {
    if receive_thread_watch::has_ended() {
        return Err(NodeError::Internal(RECEIVE_THREADS_ENDED.to_owned()));
    }
    middleware.leave();
    if let Some(why) = out_of_memory.get() {
        return Err(NodeError::OutOfMemory(why.clone()));
    }
    log::info!("{node} has ended");
    Ok(())
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
fn worker(name: &'static str, stopped: &Receiver<()>, work: impl FnOnce() + Send + 'static) -> Part {
    task(name, stopped, || smol::unblock(work))
}

/// Inputs of the services on the services thread.
struct RequestInputs {
    current: CurrentEvaluation,
    store: ParameterStore,
    recording: RecorderHandle,
    clock: Arc<RosClock>,
    commands: Sender<LoaderCommand>,
    events: mailbox::Sender<MonitorEvent>,
    /// Whether the robot was given on the command line.
    has_given_robot: bool,
    /// Receives a notice when a parameter changed.
    changes: Receiver<()>,
}

/// The services thread, and the parts that evaluate requests about motions and states.
fn open_services(
    middleware: &Middleware,
    names: &Names,
    inputs: RequestInputs,
    stopped: &Receiver<()>,
) -> Result<(ServicesThread, [Part; 2]), NodeError> {
    let RequestInputs { current, store, recording, clock, commands, events, has_given_robot, changes } =
        inputs;
    let (states, state_worker) =
        StateServices::open(middleware, names, Arc::clone(&current), Arc::clone(&clock))?;
    let (motions, motion_worker) =
        MotionServices::open(middleware, names, current, Arc::clone(&clock), store.clone())?;
    let enable = EnableService::open(middleware, names, events.clone())?;
    let inputs = ServicesInputs {
        store,
        recording,
        clock,
        motions,
        states,
        enable,
        commands,
        description_events: (!has_given_robot).then_some(events),
        changes,
    };
    let services = ServicesThread::open(middleware, names, inputs)?;
    let motion_worker = worker("motions", stopped, move || motion_worker.run());
    let state_worker = worker("states", stopped, move || state_worker.run());
    Ok((services, [motion_worker, state_worker]))
}

/// Publishers of the evaluations, and the parts that publish what takes longer than a check.
fn open_publishers(
    middleware: &Middleware,
    names: &Names,
    current: &CurrentEvaluation,
    clock: &Arc<RosClock>,
    stopped: &Receiver<()>,
) -> Result<(Publishers, [Part; 2]), MiddlewareError> {
    let (markers, marker_worker) = marker_topic::open(middleware, names)?;
    let (retreat, retreat_worker) =
        retreat_topic::open(middleware, names, Arc::clone(current), Arc::clone(clock))?;
    let publishers = Publishers::open(middleware, names, markers, retreat)?;
    let markers = Part::new("markers", move || marker_worker.run());
    Ok((publishers, [markers, worker("retreat", stopped, move || retreat_worker.run())]))
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
    inputs: CommandLineInputs,
) -> Result<(RecorderHandle, Option<Recorder>), NodeError> {
    let Some(settings) = parameters.recording() else {
        return Ok((RecorderHandle::default(), None));
    };
    let (recording, recorder) =
        Recorder::start(&settings, RecordedNode { names, inputs, parameters }).map_err(NodeError::Input)?;
    Ok((recording, Some(recorder)))
}

/// Time since the first call.
fn stopwatch() -> Duration {
    static START: std::sync::LazyLock<Instant> = std::sync::LazyLock::new(Instant::now);
    START.elapsed()
}
