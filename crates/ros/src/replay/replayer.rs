//! Replay of a recording: runs the same loader and the same monitor on the recorded events, in the recorded order.

use std::collections::{BTreeMap, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use clearance_monitor::{Evaluation, JointStateHistory, Monitor, Now, Time};
use clearance_robot::{MeshFiles, RobotModel};
use clearance_scene::MeshModel;
use serde_json::{Map, Value as Json};

use crate::loading::loader::{Loader, Surroundings};
use crate::loading::loader_inputs::Pass;
use crate::monitor_events::monitor_event::MonitorEvent;
use crate::monitor_events::world_update::WorldUpdate;
use crate::parameters::parameter_set::Parameters;
use crate::recording::mcap_file::{Entry, ReadError, RecordingFile};
use crate::recording::step::{
    Clocks, CloudStep, Late, RecordStep, RecordedCommand, RecordedMonitorEvent, parameters_from_json,
};
use crate::replay::difference::{ComparedHistory, StepResult, difference};
use crate::replay::step_messages::{StepMessages, read_command};
use crate::scene::cloud_inbox::CloudMessage;
use crate::scene::scene_update_context::{SceneUpdateContext, robots_at_stamps};
use crate::scene::transform_messages::note_transforms;

/// Robot and meshes that the command line makes from an archive.
pub struct Prepared {
    pub robot: Option<RobotModel>,
    pub mesh_files: MeshFiles,
    pub surroundings: Surroundings,
    pub mesh_model: MeshModel,
}

impl std::fmt::Debug for Prepared {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Prepared").field("robot", &self.robot).finish_non_exhaustive()
    }
}

/// Result of a replay.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Outcome {
    /// Number of results that are equal to the recorded ones.
    pub same: u64,
    /// Those among them that lacked pairs at their deadline. For these, only the status FREE and the speed scale are
    /// compared.
    pub late: u64,
    /// The first result that differs; the replay stops there.
    pub difference: Option<Difference>,
    /// Number of steps that the recorder lost. The replay stops there, since their content is unknown.
    pub lost: Option<u64>,
    /// Whether the file ends before the end of the run.
    pub cut_off: bool,
    /// Version of the program that recorded it.
    pub version: String,
}

/// A result that differs from the recorded one.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Difference {
    /// Number of the result, counted from 1.
    pub answer: u64,
    /// Time of the result (ns since 1970).
    pub time: u64,
    /// Name of the first field that differs.
    pub field: String,
    pub recorded: String,
    pub replayed: String,
}

/// Replays a recording, up to the first result that differs.
pub fn replay(path: &Path, prepared: Prepared) -> Result<Outcome, ReadError> {
    let mut file = RecordingFile::open(path)?;
    let mut prepared = Some(prepared);
    let mut run: Option<Replay> = None;
    let mut has_ended = false;
    let mut outcome = Outcome::default();
    while let Some(entry) = file.next()? {
        let Entry::RecordStep { step, messages, itself } = entry else { continue };
        if has_ended {
            return Err(file.error(format!(
                "holds steps of a second run (from {} on) after the end of the first one: split the file there, and \
                 replay each part",
                itself.time()
            )));
        }
        match (*step, &mut run) {
            (RecordStep::Started { parameters, version, rate_outlasts_pause, .. }, None) => {
                let parameters = parameters_from_json(&parameters).map_err(|why| file.error(why))?;
                let prepared = prepared.take().ok_or_else(|| file.error("begins twice"))?;
                let run = run.insert(Replay::new(prepared, &parameters).map_err(|why| file.error(why))?);
                if !rate_outlasts_pause {
                    run.monitor.forget_rate_in_pauses();
                }
                outcome.version = version;
            }
            (RecordStep::Lost { steps }, _) => {
                outcome.lost = Some(steps);
                return Ok(outcome);
            }
            (RecordStep::Ended { .. }, _) => has_ended = true,
            (_, None) => return Err(file.error("does not begin with the start of a node")),
            (step, Some(run)) => {
                let mut messages = StepMessages::new(messages);
                let time = itself.log_time;
                let done = run.follow(step, &mut messages).map_err(|why| file.error(why))?;
                match done {
                    StepResult::Nothing => {}
                    StepResult::Same(late) => {
                        outcome.same += 1;
                        outcome.late += u64::from(late == Late::Pairs);
                    }
                    StepResult::Differs { field, recorded, replayed } => {
                        let answer = outcome.same + 1;
                        outcome.difference = Some(Difference { answer, time, field, recorded, replayed });
                        return Ok(outcome);
                    }
                }
            }
        }
    }
    outcome.cut_off = !has_ended && file.is_cut_off();
    Ok(outcome)
}

/// The node without its network: monitor, loader and transforms.
struct Replay {
    monitor: Monitor,
    loader: Loader,
    /// Events that the loader sent and the monitor has not processed yet.
    loader_events: VecDeque<MonitorEvent>,
    transforms: clearance_scene::TransformTree,
    evaluation: Option<Evaluation>,
    joint_state_history: JointStateHistory,
    /// Whether a state was evaluated.
    has_checked_state: bool,
    history: ComparedHistory,
}

impl Replay {
    fn new(prepared: Prepared, parameters: &Parameters) -> Result<Self, String> {
        let Prepared { robot, mesh_files, surroundings, mesh_model } = prepared;
        let mut monitor = Monitor::new(parameters.monitor_settings(), || Duration::ZERO);
        let mut loader = Loader::new(mesh_files, surroundings, mesh_model);
        if let Some(robot) = robot {
            let update_context =
                SceneUpdateContext::first(parameters, Now { ros: None, steady: Duration::ZERO });
            monitor.set_checker(loader.load_given(robot, &update_context)?);
        }
        let transforms = clearance_scene::TransformTree::default();
        Ok(Self {
            monitor,
            loader,
            loader_events: VecDeque::new(),
            transforms,
            evaluation: None,
            joint_state_history: JointStateHistory::default(),
            has_checked_state: false,
            history: ComparedHistory::ALL,
        })
    }

    fn follow(&mut self, step: RecordStep, messages: &mut StepMessages) -> Result<StepResult, String> {
        match step {
            RecordStep::Pass { now, parameters, commands, clouds } => {
                let pass = self.pass(now, &parameters, commands, clouds, messages)?;
                self.loader.process(pass, |event| self.loader_events.push_back(event));
            }
            RecordStep::MonitorEvent(event) => return Ok(self.process_event(&event)),
            RecordStep::Parameters(parameters) => {
                self.monitor.set_settings(parameters_from_json(&parameters)?.monitor_settings());
            }
            RecordStep::Transforms { now, fixed } => {
                let now = now.map(Time::from_nanoseconds);
                drop(note_transforms(&mut self.transforms, messages.next("a transform")?, now, fixed));
            }
            RecordStep::Enabled(enabled) => self.monitor.set_enabled(enabled),
            RecordStep::TransformsRead => self.monitor.note_transforms(&self.transforms),
            RecordStep::JointStateReceived { now, source } => {
                let (input, now) = (messages.joint_state(&source)?, Now::from(now));
                self.joint_state_history.note_received(&input, &self.monitor, now.ros);
                self.monitor.receive(input, now);
            }
            RecordStep::JointState { now, source, late } => {
                self.monitor.leave_out(late.into());
                let now = Now::from(now);
                let evaluation = self.monitor.on_joint_state(messages.joint_state(&source)?, now);
                self.monitor.prepare();
                self.joint_state_history.note(&evaluation, now.ros);
                return self.compare(evaluation, late, messages);
            }
            RecordStep::Heartbeat { now, late } => {
                self.monitor.leave_out(late.into());
                let now = Now::from(now);
                let evaluation = self.monitor.on_heartbeat(now);
                self.joint_state_history.note(&evaluation, now.ros);
                return self.compare(evaluation, late, messages);
            }
            RecordStep::Started { .. } => return Err("begins twice".to_owned()),
            RecordStep::Mesh { .. }
            | RecordStep::Clock
            | RecordStep::Lost { .. }
            | RecordStep::Ended { .. } => {}
        }
        Ok(StepResult::Nothing)
    }

    fn pass(
        &self,
        now: Clocks,
        parameters: &Map<String, Json>,
        commands: Vec<RecordedCommand>,
        clouds: Vec<CloudStep>,
        messages: &mut StepMessages,
    ) -> Result<Pass, String> {
        let commands =
            commands.into_iter().map(|command| read_command(command, messages)).collect::<Result<_, _>>()?;
        let mut read = BTreeMap::new();
        for CloudStep { topic, received_at, is_shared } in clouds {
            let cloud = Arc::new(messages.next("a cloud")?);
            let (received_at, since) = (received_at.into(), Instant::now());
            read.insert(topic, CloudMessage { cloud, received_at, since, is_shared });
        }
        let parameters = parameters_from_json(parameters)?;
        let robots_at_stamps = robots_at_stamps(&read, &self.joint_state_history, parameters.stale_after);
        let update_context = SceneUpdateContext {
            now: now.into(),
            parameters,
            transforms: self.transforms.clone(),
            evaluation: self.evaluation.clone(),
            robots_at_stamps,
        };
        Ok(Pass { update_context, commands, clouds: read })
    }

    /// Has the monitor process the loader's next event, which must be equal to the recorded one.
    fn process_event(&mut self, recorded: &RecordedMonitorEvent) -> StepResult {
        let differs = |replayed: String| StepResult::Differs {
            field: "what the loader made of its orders".to_owned(),
            recorded: format!("{recorded:?}"),
            replayed,
        };
        if *recorded == RecordedMonitorEvent::Described {
            self.monitor.note_description();
            return StepResult::Nothing;
        }
        if let RecordedMonitorEvent::Memory { used, limit } = *recorded {
            self.monitor.note_memory(used, limit);
            return StepResult::Nothing;
        }
        if let RecordedMonitorEvent::WorldUpdate(
            update @ (WorldUpdate::Received { .. } | WorldUpdate::Withdrawn),
        ) = *recorded
        {
            update.apply_to(&mut self.monitor);
            return StepResult::Nothing;
        }
        self.process_unrecorded_events(recorded);
        match (recorded, self.loader_events.pop_front()) {
            (RecordedMonitorEvent::Checker, Some(MonitorEvent::Checker(revision))) => {
                self.monitor.set_checker(revision);
            }
            (RecordedMonitorEvent::ModelSwap, Some(MonitorEvent::ModelSwap)) => {
                self.monitor.note_model_swap();
            }
            (RecordedMonitorEvent::Heeded, Some(MonitorEvent::DescriptionsProcessed(descriptions))) => {
                self.monitor.note_processed_descriptions(descriptions);
            }
            // the text contains folder names of the recording machine, so it is not compared
            (RecordedMonitorEvent::ModelFault(fault), Some(MonitorEvent::ModelFault(_))) => {
                self.monitor.note_model_fault(fault.clone());
            }
            (RecordedMonitorEvent::WorldUpdate(recorded), Some(MonitorEvent::WorldUpdate(update)))
                if *recorded == update =>
            {
                update.apply_to(&mut self.monitor);
            }
            (RecordedMonitorEvent::World, Some(MonitorEvent::World { faults, incomplete, .. })) => {
                self.monitor.note_world_faults(faults, incomplete);
            }
            (_, Some(MonitorEvent::ModelFault(fault))) => return differs(format!("ModelFault: {fault}")),
            (_, Some(MonitorEvent::Checker(_))) => return differs("Checker".to_owned()),
            (_, Some(MonitorEvent::ModelSwap)) => return differs("ModelSwap".to_owned()),
            (_, Some(MonitorEvent::World { .. })) => return differs("World".to_owned()),
            (_, Some(MonitorEvent::DescriptionsProcessed(_))) => return differs("Heeded".to_owned()),
            (_, Some(MonitorEvent::WorldUpdate(update))) => return differs(format!("{update:?}")),
            // the loader never sends these
            (
                _,
                Some(
                    MonitorEvent::Parameters(_)
                    | MonitorEvent::Enabled(..)
                    | MonitorEvent::PublishNow(_)
                    | MonitorEvent::DescriptionReceived
                    | MonitorEvent::Memory { .. }
                    | MonitorEvent::Stop,
                )
                | None,
            ) => {
                return differs("nothing".to_owned());
            }
        }
        StepResult::Nothing
    }

    /// Applies events that recordings of older versions do not contain.
    fn process_unrecorded_events(&mut self, recorded: &RecordedMonitorEvent) {
        loop {
            match self.loader_events.front() {
                Some(MonitorEvent::DescriptionsProcessed(descriptions))
                    if *recorded != RecordedMonitorEvent::Heeded =>
                {
                    self.monitor.note_processed_descriptions(*descriptions);
                }
                Some(MonitorEvent::WorldUpdate(update))
                    if !matches!(recorded, RecordedMonitorEvent::WorldUpdate(_)) =>
                {
                    update.apply_to(&mut self.monitor);
                }
                _ => return,
            }
            self.loader_events.pop_front();
        }
    }

    fn compare(
        &mut self,
        evaluation: Evaluation,
        late: Late,
        messages: &mut StepMessages,
    ) -> Result<StepResult, String> {
        // a part of a recording lacks the state from which the motion to its first state was checked
        let is_compared = self.has_checked_state || !messages.are_of_part();
        self.has_checked_state |= evaluation.checked_state.is_some();
        // a result that the deadline cut off may have had other contacts or distances
        let is_complete = !messages.are_of_part() && late < Late::PassageExtent;
        self.history.since_start &= is_complete;
        self.history.since_heartbeat &= is_complete;
        let difference =
            if is_compared { difference(&evaluation, late, self.history, messages)? } else { None };
        self.history.since_heartbeat |= evaluation.history.is_heartbeat && is_complete;
        self.evaluation = Some(evaluation);
        Ok(difference.unwrap_or(StepResult::Same(late)))
    }
}

/// Path of a command-line argument as it is stored in a recording.
#[must_use]
pub fn recorded_path(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let folder = folder.canonicalize().or_else(|_| std::path::absolute(folder));
    match (folder, path.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => path.to_owned(),
    }
}
