//! Recorder: writes recorded events to an MCAP file on its own thread.

use std::collections::BTreeMap;
use std::fs::{File, Metadata, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use clearance_files::input_files::{self, MESH_LIMIT};
use clearance_monitor::{Now, SourceId};
use mcap::records::MessageHeader;
use mcap::{Attachment, Compression, WriteOptions};
use ros2_interfaces_jazzy_serde::sensor_msgs::msg::JointState;
use ros2_interfaces_jazzy_serde::std_msgs::msg::{Bool, Float64, String as StringMessage};
use serde::Serialize;

use crate::dds::cdr;
use crate::names::Names;
use crate::parameters::parameter_set::Parameters;
use crate::parameters::recording_settings::RecordingSettings;
use crate::recording::message_schemas::schema;
use crate::recording::recorded_event::{
    CommandLineInputs, OriginalMessage, RecordedCloud, RecordedEvaluation, RecordedEvent,
};
use crate::recording::recorder_handle::{Backlog, Item, RecorderHandle, system_time};
use crate::recording::step::{Clocks, CloudStep, RecordStep, RecordedCommand, parameters_to_json};
use crate::threading::mailbox;
use crate::threading::mailbox::Receiver;
use crate::threading::timed_wait::wait_at_most;

/// Largest number of events in the queue.
const LONGEST_QUEUE: usize = 20_000;

/// Flush period: a file that is cut off may lack this much at its end.
const FLUSH_PERIOD: Duration = Duration::from_secs(1);

/// Longest wait for an event before the limits are checked again.
const LONGEST_WAIT: Duration = Duration::from_millis(100);

/// Number of file names that are tried if a file exists already.
const TRIES: u32 = 10_000;

const MEGABYTE: f64 = 1e6;

/// The node whose inputs and outputs are recorded.
pub struct RecordedNode<'n> {
    pub names: &'n Names,
    pub inputs: CommandLineInputs,
    pub parameters: &'n Parameters,
}

/// Writes a recording until [`Recorder::finish`] or a limit.
#[derive(Debug)]
pub struct Recorder {
    /// Returns why the recording is incomplete, if it is.
    thread: JoinHandle<Result<(), String>>,
    backlog: Arc<Backlog>,
}

impl Recorder {
    /// Starts a new file. An existing file is left unchanged: a number is added to the name.
    ///
    /// # Errors
    /// When the file cannot be created.
    pub fn start(
        settings: &RecordingSettings,
        node: RecordedNode<'_>,
    ) -> Result<(RecorderHandle, Self), String> {
        let failed =
            |error: &dyn std::fmt::Display| format!("record_file: {}: {error}", settings.file.display());
        let (file, path) = create(&settings.file).map_err(|error| failed(&error))?;
        Self::write_to(file, path, settings, node).map_err(|error| failed(&with_causes(&*error)))
    }

    /// Starts to write to a file that was created.
    pub fn write_to(
        file: File,
        path: PathBuf,
        settings: &RecordingSettings,
        RecordedNode { names, inputs, parameters }: RecordedNode<'_>,
    ) -> Result<(RecorderHandle, Self), Box<dyn std::error::Error>> {
        let topics = Topics::new(names);
        let measured = file.try_clone()?;
        let mcap = mcap_writer(file)?;
        let (items, items_in) = mailbox::bounded(LONGEST_QUEUE);
        let backlog = Arc::new(Backlog::default());
        let recording = RecorderHandle::to(items, Arc::clone(&backlog));
        let ends = Arc::clone(&backlog);
        let mut writer =
            Writer { mcap, channels: BTreeMap::new(), topics, written: 0, lost_steps: 0, missing_file: None };
        let started = RecordStep::Started {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            node: names.full_node_name(),
            parameters: parameters_to_json(parameters),
            given: inputs.arguments,
            rate_outlasts_pause: true,
        };
        let limits =
            Limits { settings: settings.clone(), path: path.clone(), measured, began: Instant::now() };
        log::info!("recording to {}", path.display());
        let record = move || {
            let begun = inputs.files.iter().try_for_each(|file| writer.attach(file, file));
            let begun = begun.and_then(|()| writer.step(&started, system_time()));
            let written = begun.and_then(|()| follow(&mut writer, &items_in, &backlog, &limits));
            let ended_by = |error: &str| format!("recording to {} ended: {error}", path.display());
            if let Err(error) = &written {
                backlog.set_fault(Some(ended_by(error)));
            }
            // from here on the queue has no receiver: later events are discarded
            drop(items_in);
            let why = written.as_deref().unwrap_or("the recording failed").to_owned();
            let ended = writer.step(&RecordStep::Ended { why }, system_time());
            let gap = writer.gap();
            let finished = ended.and_then(|()| complete(writer.mcap));
            let fault = match (written.and_then(|why| finished.map(|()| why)), limits.removal().or(gap)) {
                (Ok(why), None) => {
                    log::info!("{} is complete: {why}", path.display());
                    return Ok(());
                }
                (Ok(_), Some(gap)) => format!("{} is incomplete: {gap}", path.display()),
                (Err(error), _) => ended_by(&error),
            };
            log::error!("{fault}");
            backlog.set_fault(Some(fault.clone()));
            Err(fault)
        };
        let thread = std::thread::Builder::new().name("recorder".to_owned()).spawn(record);
        Ok((recording, Self { thread: thread?, backlog: ends }))
    }

    #[cfg(test)]
    #[must_use]
    pub fn has_ended(&self) -> bool {
        self.thread.is_finished()
    }

    /// Writes the events that were recorded so far, and waits until they are written.
    ///
    /// # Errors
    /// When the recording is incomplete; the log has the reason, too.
    pub fn finish(self) -> Result<(), String> {
        self.backlog.ended.store(true, Ordering::Relaxed);
        self.thread.join().unwrap_or_else(|_| {
            let fault = "the recorder failed inside the program: its file ends before the node did";
            log::error!("{fault}");
            Err(fault.to_owned())
        })
    }
}

/// Limits of a recording: its size, its duration and its file.
struct Limits {
    settings: RecordingSettings,
    path: PathBuf,
    measured: File,
    began: Instant,
}

impl Limits {
    /// Why the written file can no longer be found at its path, if it cannot.
    fn is_gone(&self) -> Option<String> {
        let identity = |metadata: Metadata| (metadata.dev(), metadata.ino());
        let written = self.measured.metadata().map(identity);
        let found = self.path.metadata().map(identity);
        let is_there = matches!((written, found), (Ok(written), Ok(found)) if written == found);
        let path = self.path.display();
        (!is_there)
            .then(|| format!("the recording {path} was moved or removed: what is recorded now may be lost"))
    }

    /// The reason why the content of the file is lost, if the file was removed.
    fn removal(&self) -> Option<String> {
        let is_removed = self.measured.metadata().is_ok_and(|metadata| metadata.nlink() == 0);
        is_removed.then(|| "it was removed".to_owned())
    }

    fn reached(&self) -> Option<String> {
        let RecordingSettings { max_size, max_duration, .. } = self.settings;
        #[expect(clippy::cast_precision_loss, reason = "a file's size is far below 2^52")]
        let megabytes = self.measured.metadata().map_or(0.0, |metadata| metadata.len() as f64 / MEGABYTE);
        if max_size > 0.0 && megabytes >= max_size {
            return Some(format!("record_max_size: {max_size} MB are reached"));
        }
        if max_duration > 0.0 && self.began.elapsed().as_secs_f64() >= max_duration {
            return Some(format!("record_max_duration: {max_duration} s are over"));
        }
        None
    }
}

/// Writes events until the queue is closed or a limit is reached; returns the reason for the end.
fn follow(
    writer: &mut Writer,
    items: &Receiver<Item>,
    backlog: &Backlog,
    limits: &Limits,
) -> Result<String, String> {
    let mut flushed = Instant::now();
    loop {
        // events recorded before the end are written: reading the flag before the queue misses none of them
        let ended = backlog.ended.load(Ordering::Relaxed);
        let item = wait_at_most(if ended { Duration::ZERO } else { LONGEST_WAIT }, items.receive());
        let lost = backlog.lost.swap(0, Ordering::Relaxed);
        if lost > 0 {
            writer.lost_steps += lost;
            log::warn!("the recording misses {lost} steps here: the disk is slower than what happens");
            writer.step(&RecordStep::Lost { steps: lost }, system_time())?;
        }
        match item {
            Some(Some(item)) => {
                backlog.bytes.fetch_sub(item.bytes, Ordering::Relaxed);
                writer.write(item.what, item.at)?;
            }
            None if !ended => {}
            None | Some(None) => return Ok("the node ended".to_owned()),
        }
        if flushed.elapsed() >= FLUSH_PERIOD {
            flushed = Instant::now();
            writer.mcap.flush().map_err(|error| with_causes(&error))?;
            backlog.set_fault(limits.is_gone().or_else(|| writer.gap()));
            if let Some(why) = limits.reached() {
                return Ok(why);
            }
        }
    }
}

/// Creates a new file; if the name is taken, numbered names are tried.
fn create(path: &Path) -> io::Result<(File, PathBuf)> {
    input_files::check_target(path).map_err(|error| io::Error::other(error.reason))?;
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let extension = path.extension().map_or_else(|| "mcap".into(), |extension| extension.to_string_lossy());
    for number in 0..TRIES {
        let name = match number {
            0 => path.to_owned(),
            _ => path.with_file_name(format!("{stem}_{number}.{extension}")),
        };
        match OpenOptions::new().write(true).create_new(true).open(&name) {
            Ok(file) => return Ok((file, name)),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
    Err(io::Error::new(io::ErrorKind::AlreadyExists, format!("{TRIES} files of this name are there already")))
}

pub fn mcap_writer(file: File) -> mcap::McapResult<mcap::Writer<BufWriter<File>>> {
    let options = WriteOptions::new()
        .profile("ros2")
        .library(concat!("clearance ", env!("CARGO_PKG_VERSION")))
        .compression(Some(Compression::Zstd))
        .compression_threads(0)
        // chunks are written whole: a cut-off file then ends with a chunk that is too short, and not with a chunk
        // without a length
        .disable_seeking(true);
    options.create(BufWriter::new(file))
}

/// Completes a file, and writes what is still in memory.
pub fn complete(mut mcap: mcap::Writer<BufWriter<File>>) -> Result<(), String> {
    mcap.finish().map_err(|error| with_causes(&error))?;
    mcap.into_inner().flush().map_err(|error| error.to_string())
}

/// Text of an error and of its causes: that of the MCAP library does not say that the disk is full.
pub fn with_causes(error: &(dyn std::error::Error + 'static)) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text.push_str(": ");
        text.push_str(&error.to_string());
        cause = error.source();
    }
    text
}

/// Names of the topics in the file.
struct Topics {
    names: Names,
    node: String,
}

impl Topics {
    fn new(names: &Names) -> Self {
        Self { names: names.clone(), node: names.full_node_name() }
    }

    /// Full name of a topic, after remapping.
    fn named(&self, name: &str) -> String {
        self.names.resolve(name).map_or_else(|_| name.to_owned(), |name| name.as_str().to_owned())
    }

    /// Topic of the steps. It is never remapped, since readers find it by its name.
    fn steps(&self) -> String {
        format!("{}/{}", self.node, crate::recording::mcap_file::STEPS)
    }
}

/// The MCAP file.
struct Writer {
    mcap: mcap::Writer<BufWriter<File>>,
    /// Channel of each topic.
    channels: BTreeMap<String, u16>,
    topics: Topics,
    /// Number of messages written.
    written: u32,
    /// Number of steps that did not fit into the queue.
    lost_steps: u64,
    /// The last file that could not be attached, if any, with the reason.
    missing_file: Option<String>,
}

impl Writer {
    /// Why the content is incomplete, if it is.
    fn gap(&self) -> Option<String> {
        let lost = self.lost_steps;
        (lost > 0)
            .then(|| format!("the recording misses {lost} steps: the disk is slower than what happens"))
            .or_else(|| self.missing_file.clone())
    }

    fn write(&mut self, what: RecordedEvent, at: u64) -> Result<(), String> {
        let step = match what {
            RecordedEvent::Meshes(meshes) => {
                for mesh in meshes {
                    self.attach(&mesh.file, &mesh.file)?;
                    let (folder, uri, file) = (mesh.folder, mesh.uri, mesh.file);
                    self.step(&RecordStep::Mesh { folder, uri, file }, at)?;
                }
                return Ok(());
            }
            RecordedEvent::Pass { now, parameters, commands, clouds } => {
                for (command, original) in &commands {
                    if let Some(original) = original {
                        self.original(command, original, now, at)?;
                    }
                }
                for RecordedCloud { topic, received_at, cloud, .. } in &clouds {
                    let topic = self.topics.named(topic);
                    self.message(
                        &topic,
                        "sensor_msgs/msg/PointCloud2",
                        cloud.as_ref(),
                        before(at, now, *received_at),
                    )?;
                }
                let clouds =
                    clouds.into_iter().map(|RecordedCloud { topic, received_at, is_shared, .. }| CloudStep {
                        topic,
                        received_at: received_at.into(),
                        is_shared,
                    });
                RecordStep::Pass {
                    now: now.into(),
                    parameters: parameters_to_json(&parameters),
                    commands: commands.into_iter().map(|(command, _)| command).collect(),
                    clouds: clouds.collect(),
                }
            }
            RecordedEvent::MonitorEvent(event) => RecordStep::MonitorEvent(event),
            RecordedEvent::Parameters(parameters) => RecordStep::Parameters(parameters_to_json(&parameters)),
            RecordedEvent::Enabled(enabled) => RecordStep::Enabled(enabled),
            RecordedEvent::TransformsRead => RecordStep::TransformsRead,
            RecordedEvent::JointStateReceived { now, message, source } => RecordStep::JointStateReceived {
                now: now.into(),
                source: self.joint_state(&message, source, at)?,
            },
            RecordedEvent::Evaluated(evaluated) => self.evaluated(*evaluated, at)?,
            RecordedEvent::Transforms { message, now, fixed } => {
                let topic = self.topics.named(if fixed { "tf_static" } else { "tf" });
                self.message(&topic, "tf2_msgs/msg/TFMessage", &message, at)?;
                RecordStep::Transforms { now: now.map(clearance_monitor::Time::nanoseconds), fixed }
            }
            RecordedEvent::Clock(message) => {
                self.message("/clock", "rosgraph_msgs/msg/Clock", &message, at)?;
                RecordStep::Clock
            }
        };
        self.step(&step, at)
    }

    /// Writes the received joint state, if there was one, and the published results.
    fn evaluated(&mut self, evaluated: RecordedEvaluation, at: u64) -> Result<RecordStep, String> {
        let RecordedEvaluation { now, joint_state, result } = evaluated;
        let (now, late) = (now.into(), result.left_out.into());
        let step = match joint_state {
            Some((message, source)) => {
                RecordStep::JointState { now, source: self.joint_state(&message, source, at)?, late }
            }
            None => RecordStep::Heartbeat { now, late },
        };
        let [state, is_free, distance, speed_scale] =
            ["~/state", "~/is_free", "~/distance", "~/speed_scale"].map(|name| self.topics.named(name));
        let kind = "clearance_msgs/msg/CollisionState";
        self.message(&state, kind, &result.state, at)?;
        self.message(&is_free, "std_msgs/msg/Bool", &Bool { data: result.is_free }, at)?;
        self.message(&distance, "std_msgs/msg/Float64", &Float64 { data: result.distance }, at)?;
        self.message(&speed_scale, "std_msgs/msg/Float64", &Float64 { data: result.speed_scale }, at)?;
        Ok(step)
    }

    /// Writes a received joint state; returns its publisher in hexadecimal digits.
    fn joint_state(&mut self, message: &JointState, source: SourceId, at: u64) -> Result<String, String> {
        let topic = self.topics.named("joint_states");
        self.message(&topic, "sensor_msgs/msg/JointState", message, at)?;
        Ok(format!("{:032x}", u128::from_be_bytes(source.0)))
    }

    fn original(
        &mut self,
        command: &RecordedCommand,
        original: &OriginalMessage,
        now: Now,
        at: u64,
    ) -> Result<(), String> {
        let (topic, at) = match command {
            RecordedCommand::Scene { by, received_at, .. } => {
                (by.name(), before(at, now, (*received_at).into()))
            }
            RecordedCommand::Semantic => ("robot_description_semantic", at),
            RecordedCommand::UnreceivablePublishers => ("~/unreceivable_publishers", at),
            _ => ("robot_description", at),
        };
        let topic = self.topics.named(topic);
        match original {
            OriginalMessage::Text(text) => {
                self.message(&topic, "std_msgs/msg/String", &StringMessage { data: text.clone() }, at)
            }
            OriginalMessage::Scene(message) => {
                self.message(&topic, "moveit_msgs/msg/PlanningScene", message, at)
            }
            OriginalMessage::World(message) => {
                self.message(&topic, "moveit_msgs/msg/PlanningSceneWorld", message, at)
            }
            OriginalMessage::Object(message) => {
                self.message(&topic, "moveit_msgs/msg/CollisionObject", message, at)
            }
            OriginalMessage::Attached(message) => {
                self.message(&topic, "moveit_msgs/msg/AttachedCollisionObject", message, at)
            }
            OriginalMessage::States(message) => {
                self.message(&topic, "clearance_msgs/msg/ObstacleStates", message, at)
            }
            OriginalMessage::Octomap(message) => {
                self.message(&topic, "octomap_msgs/msg/Octomap", message, at)
            }
        }
    }

    fn step(&mut self, step: &RecordStep, at: u64) -> Result<(), String> {
        let data = serde_json::to_string(step).map_err(|error| error.to_string())?;
        let topic = self.topics.steps();
        self.message(&topic, "std_msgs/msg/String", &StringMessage { data }, at)
    }

    fn message<M: Serialize>(&mut self, topic: &str, kind: &str, message: &M, at: u64) -> Result<(), String> {
        let bytes = cdr::encode(message)?;
        let channel = self.channel(topic, kind).map_err(|error| with_causes(&error))?;
        let header =
            MessageHeader { channel_id: channel, sequence: self.written, log_time: at, publish_time: at };
        self.written = self.written.wrapping_add(1);
        self.mcap.write_to_known_channel(&header, &bytes).map_err(|error| with_causes(&error))
    }

    fn channel(&mut self, topic: &str, kind: &str) -> mcap::McapResult<u16> {
        if let Some(channel) = self.channels.get(topic) {
            return Ok(*channel);
        }
        let schema = self.mcap.add_schema(kind, "ros2msg", schema(kind).as_bytes())?;
        let channel = self.mcap.add_channel(schema, topic, "cdr", &BTreeMap::new())?;
        self.channels.insert(topic.to_owned(), channel);
        Ok(channel)
    }

    /// Attaches a copy of a file. If the file cannot be read, the recording can still be viewed, but not replayed.
    fn attach(&mut self, file: &Path, name: &Path) -> Result<(), String> {
        let bytes = match input_files::read(file, MESH_LIMIT) {
            Ok(bytes) => bytes,
            Err(error) => {
                let fault = format!("the recording lacks {error}");
                log::error!("{fault}");
                self.missing_file = Some(fault);
                return Ok(());
            }
        };
        let (log_time, name) = (system_time(), name.display().to_string());
        let media_type = "application/octet-stream".to_owned();
        let attachment = Attachment { log_time, create_time: log_time, name, media_type, data: bytes.into() };
        self.mcap.attach(&attachment).map_err(|error| with_causes(&error))
    }
}

/// Time at which something was received, on the recording's clock. That clock shows `at` when the other clocks show
/// `now`.
fn before(at: u64, now: Now, received_at: Now) -> u64 {
    let [now, received_at] = [now, received_at].map(|now| Clocks::from(now).steady);
    at.saturating_sub(now.saturating_sub(received_at))
}
