//! Data types of the steps of a recording: the events and their order, which no ROS message contains.

use std::path::PathBuf;
use std::time::Duration;

use clearance_monitor::{LeftOut, Now, Time};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value as Json};

use crate::monitor_events::world_update::WorldUpdate;
use crate::parameters::assignment::assign;
use crate::parameters::declarations::DECLARATIONS;
use crate::parameters::parameter_set::{Parameters, UNKNOWN_OR_WARN};
use crate::parameters::parameter_value;
use crate::parameters::parameter_value::Value;

/// An event that changed the node's inputs or outputs. Its messages are stored right before it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RecordStep {
    /// The node started. `given` holds the command-line inputs; the files that they name are attached under their
    /// names.
    Started {
        version: String,
        node: String,
        parameters: Map<String, Json>,
        given: Json,
        /// Whether the rate of joint states before a pause limits the checks after it. Earlier versions forgot it.
        #[serde(default)]
        rate_outlasts_pause: bool,
    },
    /// A mesh URI was resolved to a file, which is attached under its real path.
    Mesh { folder: Option<PathBuf>, uri: String, file: PathBuf },
    /// The loader processed commands and clouds: one message each, in this order.
    Pass {
        now: Clocks,
        parameters: Map<String, Json>,
        #[serde(rename = "orders")]
        commands: Vec<RecordedCommand>,
        clouds: Vec<CloudStep>,
    },
    /// The monitor processed the loader's next event.
    #[serde(rename = "told")]
    MonitorEvent(RecordedMonitorEvent),
    /// The monitor's parameters changed.
    Parameters(Map<String, Json>),
    /// Checking was switched on or off.
    Enabled(bool),
    /// The monitor read the transforms.
    #[serde(rename = "looked")]
    TransformsRead,
    /// A joint state was received and not evaluated, because the next one followed at once. Its message precedes this
    /// step. `source` identifies its publisher, in hexadecimal digits.
    #[serde(rename = "heard")]
    JointStateReceived { now: Clocks, source: String },
    /// A joint state was evaluated. Its message precedes this step, followed by the results.
    JointState {
        now: Clocks,
        source: String,
        #[serde(default)]
        late: Late,
    },
    /// The state was published again or evaluated again. The results precede this step.
    Heartbeat {
        now: Clocks,
        #[serde(default)]
        late: Late,
    },
    /// A message was received on `/tf` or `/tf_static`.
    Transforms { now: Option<i64>, fixed: bool },
    /// A message was received on `/clock`.
    Clock,
    /// The recorder was too slow here: this number of steps is missing.
    Lost { steps: u64 },
    /// The recording ended regularly, for this reason.
    Ended { why: String },
}

/// The part of a result that was not computed in time, which depends on the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Late {
    #[default]
    Nothing,
    Contacts,
    LookAhead,
    PassageExtent,
    MotionSincePrevious,
    FartherDistance,
    Pairs,
}

/// Events for the monitor: a description or a message about the world was received, or the loader reports its progress.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RecordedMonitorEvent {
    Checker,
    ModelSwap,
    Described,
    Heeded,
    /// The message contains folder names of the recording machine.
    ModelFault(String),
    World,
    WorldUpdate(WorldUpdate),
    /// The process used this much memory and was allowed that much (MiB).
    Memory {
        used: u64,
        limit: u64,
    },
}

/// Readings of the clocks, in nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Clocks {
    pub ros: Option<i64>,
    pub steady: u64,
}

/// One command to the loader.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RecordedCommand {
    Description,
    Semantic,
    Parameters,
    Clouds,
    /// The robot moved in a frame that obstacles are placed in.
    Frames,
    /// The content of the display changed.
    Display,
    ClearOctomap,
    /// Publishers from which the node cannot receive appeared or disappeared. The message has one line for each.
    UnreceivablePublishers,
    /// A message about the world that could not be decoded.
    Unreadable {
        by: SceneSource,
    },
    /// A message about the world.
    Scene {
        by: SceneSource,
        /// Time of reception.
        #[serde(rename = "came")]
        received_at: Clocks,
        unknown_is_occupied: bool,
        /// Number of messages that were lost right before it.
        #[serde(default)]
        lost: u64,
        /// Whether several publishers sent on its topic, which has to have one. Earlier versions did not detect it.
        #[serde(default, rename = "shared")]
        is_shared: bool,
    },
}

/// Topic or service on which a message about the world was received.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SceneSource {
    PlanningScene,
    ApplyPlanningScene,
    /// Service of another node, called by this node.
    GetPlanningScene,
    PlanningSceneWorld,
    CollisionObject,
    AttachedCollisionObject,
    ObstacleStates,
    OctomapBinary,
    OctomapFull,
}

/// One cloud that the loader processed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CloudStep {
    pub topic: String,
    /// Time of reception.
    #[serde(rename = "came")]
    pub received_at: Clocks,
    /// Whether several publishers sent on its topic. Earlier versions did not detect it.
    #[serde(default, rename = "shared")]
    pub is_shared: bool,
}

impl SceneSource {
    /// Relative name of the topic or service.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::PlanningScene => "planning_scene",
            Self::ApplyPlanningScene => "apply_planning_scene",
            Self::GetPlanningScene => "planning_scene_service",
            Self::PlanningSceneWorld => "planning_scene_world",
            Self::CollisionObject => "collision_object",
            Self::AttachedCollisionObject => "attached_collision_object",
            Self::ObstacleStates => "~/obstacle_states",
            Self::OctomapBinary => "octomap_binary",
            Self::OctomapFull => "octomap_full",
        }
    }
}

impl From<Now> for Clocks {
    fn from(now: Now) -> Self {
        let steady = u64::try_from(now.steady.as_nanos()).unwrap_or(u64::MAX);
        Self { ros: now.ros.map(Time::nanoseconds), steady }
    }
}

impl From<Clocks> for Now {
    fn from(clocks: Clocks) -> Self {
        Self { ros: clocks.ros.map(Time::from_nanoseconds), steady: Duration::from_nanos(clocks.steady) }
    }
}

impl From<LeftOut> for Late {
    fn from(left_out: LeftOut) -> Self {
        match left_out {
            LeftOut::Nothing => Self::Nothing,
            LeftOut::Contacts => Self::Contacts,
            LeftOut::LookAhead => Self::LookAhead,
            LeftOut::PassageExtent => Self::PassageExtent,
            LeftOut::MotionSincePrevious => Self::MotionSincePrevious,
            LeftOut::FartherDistance => Self::FartherDistance,
            LeftOut::Pairs => Self::Pairs,
        }
    }
}

impl From<Late> for LeftOut {
    fn from(late: Late) -> Self {
        match late {
            Late::Nothing => Self::Nothing,
            Late::Contacts => Self::Contacts,
            Late::LookAhead => Self::LookAhead,
            Late::PassageExtent => Self::PassageExtent,
            Late::MotionSincePrevious => Self::MotionSincePrevious,
            Late::FartherDistance => Self::FartherDistance,
            Late::Pairs => Self::Pairs,
        }
    }
}

/// All parameters by name.
#[must_use]
pub fn parameters_to_json(parameters: &Parameters) -> Map<String, Json> {
    let json = |value| match value {
        Value::Bool(value) => Json::from(value),
        Value::Integer(value) => Json::from(value),
        Value::Double(value) => Json::from(value),
        Value::Text(value) => Json::from(value),
        Value::Texts(values) => Json::from(values),
        Value::Doubles(values) => Json::from(values),
        Value::EmptyList => Json::Array(Vec::new()),
        Value::Other(_) => Json::Null,
    };
    DECLARATIONS.iter().map(|d| (d.name.to_owned(), json(d.get(parameters)))).collect()
}

/// Parameters from a map by name; missing ones have their defaults.
///
/// # Errors
/// A parameter that this build does not have, or a value that it does not accept.
pub fn parameters_from_json(json: &Map<String, Json>) -> Result<Parameters, String> {
    let mut parameters = Parameters::default();
    for (name, value) in json {
        // a text stays a text, whatever its meaning in YAML
        let text = value.as_str().map(|text| Value::Text(text.to_owned()));
        let value = text.unwrap_or_else(|| parameter_value::from_node(value));
        assign(&mut parameters, name, &value)?;
    }
    if !json.contains_key("exact_distance_share") {
        // versions without this parameter computed exact distances
        parameters.exact_distance_share = 0.0;
    }
    if !json.contains_key("check_between_states") {
        // versions without this parameter checked each state alone
        parameters.check_between_states = false;
    }
    // versions without these parameters had warnings in these cases
    for name in ["blind_cloud", "rejected_obstacle", "lost_messages", "mimic_contradiction"] {
        if !json.contains_key(name) {
            assign(&mut parameters, name, &Value::Text(UNKNOWN_OR_WARN[1].to_owned()))?;
        }
    }
    parameters.check_together()?;
    Ok(parameters)
}
