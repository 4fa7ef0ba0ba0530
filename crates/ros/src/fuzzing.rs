//! Entry points for the targets in `fuzz/`: untrusted bytes are decoded and applied as in the node, without a network.
//! Not part of the public interface.

use std::collections::BTreeMap;
use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant};

use clearance_checker::Workspace;
use clearance_monitor::{Evaluation, JointStateHistory, Monitor, Now, SourceId, Time};
use clearance_motion::ContinuousDirection;
use clearance_robot::{MeshFiles, RobotModel};
use clearance_scene::{MeshModel, Scene, TransformTree};
use ros2_interfaces_jazzy_serde::moveit_msgs::srv::GetStateValidityRequest;

use crate::dds::cdr;
use crate::loading::loader::Loader;
use crate::loading::loader_inputs::Pass;
use crate::messages::clearance_srvs::{
    CheckMotionRequest, CheckMotionsRequest, CheckTrajectoryRequest, FindFreeStateRequest,
};
use crate::messages::collision_state::collision_state;
use crate::messages::joint_state::joint_state_input;
use crate::monitor_events::monitor_event::MonitorEvent;
use crate::parameters::parameter_set::Parameters;
use crate::parameters::parameter_store::ParameterStore;
use crate::recording::step::SceneSource;
use crate::scene::cloud_inbox::CloudMessage;
use crate::scene::command_conversion::{
    attached_command, object_command, octomap_command, scene_command, states_command, world_command,
};
use crate::scene::loader_command::LoaderCommand;
use crate::scene::scene_command::SceneCommand;
use crate::scene::scene_update_context::{SceneUpdateContext, robots_at_stamps};
use crate::scene::transform_messages::note_transforms;
use crate::services::motion_batches::evaluate_motions;
use crate::services::motion_requests::{evaluate_motion, evaluate_trajectory};
use crate::services::parameter_services::changes;
use crate::services::recovery_requests::search_free_state;
use crate::services::state_requests::{evaluate_distances, evaluate_states};
use crate::services::state_validity::{ValidityContext, state_validity};
pub use clearance_view::respond_in_memory;

/// Longest time (s) of a check, whatever the request asks for.
const CHECK_TIME: f64 = 0.2;

/// The topic of clouds.
const CLOUDS: &str = "points";

/// Messages that the node decodes, in the order of the first byte of an input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MessageKind {
    Description,
    Semantic,
    JointState,
    Transforms,
    FixedTransforms,
    CollisionObject,
    AttachedCollisionObject,
    PlanningSceneWorld,
    PlanningScene,
    Octomap,
    PointCloud,
    CheckMotion,
    CheckTrajectory,
    CheckStates,
    GetDistances,
    GetStateValidity,
    SetParameters,
    FindFreeState,
    CheckMotions,
    ObstacleStates,
}

impl MessageKind {
    pub const ALL: [Self; 20] = [
        Self::Description,
        Self::Semantic,
        Self::JointState,
        Self::Transforms,
        Self::FixedTransforms,
        Self::CollisionObject,
        Self::AttachedCollisionObject,
        Self::PlanningSceneWorld,
        Self::PlanningScene,
        Self::Octomap,
        Self::PointCloud,
        Self::CheckMotion,
        Self::CheckTrajectory,
        Self::CheckStates,
        Self::GetDistances,
        Self::GetStateValidity,
        Self::SetParameters,
        Self::FindFreeState,
        Self::CheckMotions,
        Self::ObstacleStates,
    ];
}

/// A node without a network: loader, monitor and services on one thread.
#[expect(missing_debug_implementations, reason = "its parts have none")]
pub struct OfflineNode {
    parameters: ParameterStore,
    monitor: Monitor,
    loader: Loader,
    transforms: TransformTree,
    joint_state_history: JointStateHistory,
    evaluation: Option<Evaluation>,
    workspace: Option<Workspace>,
    milliseconds: u64,
}

impl OfflineNode {
    /// Without a robot, the first description gives one.
    pub fn new(robot: Option<RobotModel>) -> Result<Self, String> {
        let parameters = Parameters { point_cloud_topics: vec![CLOUDS.to_owned()], ..Parameters::default() };
        let mut monitor = Monitor::new(parameters.monitor_settings(), || Duration::ZERO);
        let nothing_around = Box::new(|_: &RobotModel| Ok(Scene::default()));
        let mut loader = Loader::new(MeshFiles::default(), nothing_around, MeshModel::Surface);
        let start = Now { ros: None, steady: Duration::ZERO };
        if let Some(robot) = robot {
            monitor.set_checker(loader.load_given(robot, &SceneUpdateContext::first(&parameters, start))?);
        }
        Ok(Self {
            parameters: ParameterStore::new(parameters, Box::new(|_| {})),
            monitor,
            loader,
            transforms: TransformTree::default(),
            joint_state_history: JointStateHistory::default(),
            evaluation: None,
            workspace: None,
            milliseconds: 1000,
        })
    }

    /// Decodes and applies one message; then the current state is evaluated and encoded.
    ///
    /// # Errors
    /// When the bytes are no such message.
    pub fn receive(&mut self, kind: MessageKind, bytes: &[u8]) -> Result<(), String> {
        self.milliseconds += 10;
        let now = self.now();
        let scene = |door, message| scene_command(door, message, false, now);
        match kind {
            MessageKind::Description => self.process(LoaderCommand::Description(text(bytes)?)),
            MessageKind::Semantic => self.process(LoaderCommand::Semantic(text(bytes)?)),
            MessageKind::JointState => {
                let input = joint_state_input(cdr::decode(bytes)?, SourceId([7; 16]));
                self.evaluation = Some(self.monitor.on_joint_state(input, now));
                self.monitor.prepare();
            }
            MessageKind::Transforms | MessageKind::FixedTransforms => {
                let fixed = kind == MessageKind::FixedTransforms;
                drop(note_transforms(&mut self.transforms, cdr::decode(bytes)?, now.ros, fixed));
                self.monitor.note_transforms(&self.transforms);
                self.process(LoaderCommand::Frames);
            }
            MessageKind::CollisionObject => self.change_scene(object_command(&cdr::decode(bytes)?)),
            MessageKind::AttachedCollisionObject => self.change_scene(attached_command(&cdr::decode(bytes)?)),
            MessageKind::ObstacleStates => self.change_scene(states_command(&cdr::decode(bytes)?, now)),
            MessageKind::PlanningSceneWorld => {
                self.change_scene(world_command(cdr::decode(bytes)?, false, now));
            }
            MessageKind::PlanningScene => {
                self.change_scene(scene(SceneSource::PlanningScene, cdr::decode(bytes)?));
            }
            MessageKind::Octomap => {
                self.change_scene(octomap_command(SceneSource::OctomapFull, cdr::decode(bytes)?, false, now));
            }
            MessageKind::PointCloud => {
                let cloud = CloudMessage {
                    cloud: Arc::new(cdr::decode(bytes)?),
                    received_at: now,
                    since: Instant::now(),
                    is_shared: false,
                };
                self.pass(vec![LoaderCommand::Clouds], BTreeMap::from([(CLOUDS.to_owned(), cloud)]));
            }
            MessageKind::SetParameters => {
                self.parameters.set_each(&changes(&cdr::decode(bytes)?));
                self.monitor.set_settings(self.parameters.get().monitor_settings());
                self.process(LoaderCommand::Parameters);
            }
            MessageKind::CheckMotion
            | MessageKind::CheckMotions
            | MessageKind::CheckTrajectory
            | MessageKind::CheckStates
            | MessageKind::GetDistances
            | MessageKind::GetStateValidity
            | MessageKind::FindFreeState => self.respond(kind, bytes)?,
        }
        let evaluation = self.monitor.on_heartbeat(self.now());
        self.joint_state_history.note(&evaluation, now.ros);
        let encoded = cdr::encode(&collision_state(&evaluation));
        self.evaluation = Some(evaluation);
        encoded.map(drop)
    }

    fn respond(&mut self, kind: MessageKind, bytes: &[u8]) -> Result<(), String> {
        let (evaluation, workspace) = (self.evaluation.as_ref(), &mut self.workspace);
        match kind {
            MessageKind::CheckMotion => {
                let mut request: CheckMotionRequest = cdr::decode(bytes)?;
                limit_time(&mut request.terms.timeout);
                let response =
                    evaluate_motion(&request, ContinuousDirection::Shortest, evaluation, workspace);
                cdr::encode(&response.response).map(drop)
            }
            MessageKind::CheckTrajectory => {
                let mut request: CheckTrajectoryRequest = cdr::decode(bytes)?;
                limit_time(&mut request.terms.timeout);
                let response = evaluate_trajectory(&request, None, evaluation, workspace);
                cdr::encode(&response.response).map(drop)
            }
            MessageKind::CheckMotions => {
                let mut request: CheckMotionsRequest = cdr::decode(bytes)?;
                limit_time(&mut request.timeout);
                cdr::encode(&evaluate_motions(&request, evaluation, workspace)).map(drop)
            }
            MessageKind::CheckStates => {
                cdr::encode(&evaluate_states(&cdr::decode(bytes)?, evaluation, workspace)).map(drop)
            }
            MessageKind::GetDistances => {
                cdr::encode(&evaluate_distances(&cdr::decode(bytes)?, evaluation, workspace)).map(drop)
            }
            MessageKind::FindFreeState => {
                let mut request: FindFreeStateRequest = cdr::decode(bytes)?;
                limit_time(&mut request.timeout);
                cdr::encode(&search_free_state(&request, evaluation, workspace)).map(drop)
            }
            MessageKind::GetStateValidity => self.respond_validity(&cdr::decode(bytes)?),
            topic => unreachable!("{topic:?} is not a request"),
        }
    }

    fn respond_validity(&self, request: &GetStateValidityRequest) -> Result<(), String> {
        let scene = self.loader.current_scene();
        let scene = scene.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let scene = scene.ok_or("there is no robot")?;
        let (evaluation, transforms) = (self.evaluation.as_ref(), &self.transforms);
        let context = ValidityContext { scene: &scene, evaluation, transforms, now: self.now() };
        cdr::encode(&state_validity(request, &context)?.response).map(drop)
    }

    fn now(&self) -> Now {
        let steady = Duration::from_millis(self.milliseconds);
        let nanoseconds = i64::try_from(steady.as_nanos()).unwrap_or(i64::MAX);
        Now { ros: Some(Time::from_nanoseconds(nanoseconds)), steady }
    }

    fn change_scene(&mut self, command: SceneCommand) {
        self.process(LoaderCommand::Scene(Box::new(command)));
    }

    fn process(&mut self, command: LoaderCommand) {
        self.pass(vec![command], BTreeMap::new());
    }

    fn pass(&mut self, commands: Vec<LoaderCommand>, clouds: BTreeMap<String, CloudMessage>) {
        let update_context = SceneUpdateContext {
            now: self.now(),
            parameters: self.parameters.get(),
            transforms: self.transforms.clone(),
            evaluation: self.evaluation.clone(),
            robots_at_stamps: robots_at_stamps(
                &clouds,
                &self.joint_state_history,
                self.parameters.get().stale_after,
            ),
        };
        let monitor = &mut self.monitor;
        self.loader.process(Pass { update_context, commands, clouds }, |event| match event {
            MonitorEvent::Checker(revision) => monitor.set_checker(revision),
            MonitorEvent::ModelSwap => monitor.note_model_swap(),
            MonitorEvent::ModelFault(fault) => monitor.note_model_fault(fault),
            MonitorEvent::DescriptionsProcessed(descriptions) => {
                monitor.note_processed_descriptions(descriptions);
            }
            MonitorEvent::World { faults, incomplete, .. } => monitor.note_world_faults(faults, incomplete),
            MonitorEvent::WorldUpdate(update) => update.apply_to(monitor),
            _ => {}
        });
    }
}

fn text(bytes: &[u8]) -> Result<String, String> {
    let message: ros2_interfaces_jazzy_serde::std_msgs::msg::String = cdr::decode(bytes)?;
    Ok(message.data)
}

/// Requests may ask for minutes; fuzzing runs thousands of them.
fn limit_time(timeout: &mut f64) {
    if *timeout == 0.0 || *timeout > CHECK_TIME {
        *timeout = CHECK_TIME;
    }
}
