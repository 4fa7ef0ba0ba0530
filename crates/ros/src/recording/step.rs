//! What happened, and in which order: the part of a recording that no ROS message has.

use std::path::PathBuf;
use std::time::Duration;

use clearance_monitor::{LeftOut, Now, Time};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value as Json};

use crate::monitor_loop::WorldUpdate;
use crate::parameter_value::{self, Value};
use crate::parameters::{DECLARATIONS, Parameters, UNKNOWN_OR_WARN};

/// One thing that changed what is known or said. The messages that it is about stand right before it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RecordStep {
    /// The node began; `given` is what the command line named, whose files are attached by their names.
    Started { version: String, node: String, parameters: Map<String, Json>, given: Json },
    /// A mesh name led to a file, which is attached under its real path.
    Mesh { folder: Option<PathBuf>, uri: String, file: PathBuf },
    /// The loader heeded orders and clouds: one message each, in this order.
    Pass { now: Clocks, parameters: Map<String, Json>, orders: Vec<OrderStep>, clouds: Vec<CloudStep> },
    /// The monitor heeded what the loader had told it next.
    Told(RecordedMonitorEvent),
    /// The monitor's parameters changed.
    Parameters(Map<String, Json>),
    /// Checking was turned on or off.
    Enabled(bool),
    /// The monitor looked at the transforms.
    Looked,
    /// A joint state was heard that another one followed at once: it. `source` is its publisher's, in hexadecimal digits.
    Heard { now: Clocks, source: String },
    /// A joint state was judged: it, then the answers.
    JointState {
        now: Clocks,
        source: String,
        #[serde(default)]
        late: Late,
    },
    /// The state was said again, or judged anew: the answers.
    Heartbeat {
        now: Clocks,
        #[serde(default)]
        late: Late,
    },
    /// A message came on tf.
    Transforms { now: Option<i64>, fixed: bool },
    /// A message came on `/clock`.
    Clock,
    /// Here, the recorder could not follow: so many steps are missing.
    Lost { steps: u64 },
    /// The recording ended as it was meant to, and why.
    Ended { why: String },
}

/// What of an answer was not there in time: it depends on the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Late {
    #[default]
    Nothing,
    LookAhead,
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
    /// In words that name the folders of the machine it was on.
    ModelFault(String),
    World,
    WorldUpdate(WorldUpdate),
    /// The process took this much memory and was allowed that much (MiB).
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

/// One order of the loader.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OrderStep {
    Description,
    Semantic,
    Parameters,
    Clouds,
    /// The robot is elsewhere in what obstacles stand in.
    Frames,
    /// Something else is to be shown.
    Display,
    ClearOctomap,
    /// A message about the world that could not be decoded.
    Unreadable {
        by: SceneDoor,
    },
    /// A message about the world.
    Scene {
        by: SceneDoor,
        /// When it came.
        came: Clocks,
        unknown_is_occupied: bool,
        /// How many messages were lost right before it.
        #[serde(default)]
        lost: u64,
    },
}

/// By which topic or service a message about the world came.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SceneDoor {
    PlanningScene,
    ApplyPlanningScene,
    /// Of another node, which was asked.
    GetPlanningScene,
    PlanningSceneWorld,
    CollisionObject,
    AttachedCollisionObject,
    OctomapBinary,
    OctomapFull,
}

/// One cloud that the loader looked at.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CloudStep {
    pub topic: String,
    /// When it came.
    pub came: Clocks,
}

impl SceneDoor {
    /// The relative name of the topic or service.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::PlanningScene => "planning_scene",
            Self::ApplyPlanningScene => "apply_planning_scene",
            Self::GetPlanningScene => "planning_scene_service",
            Self::PlanningSceneWorld => "planning_scene_world",
            Self::CollisionObject => "collision_object",
            Self::AttachedCollisionObject => "attached_collision_object",
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
            LeftOut::LookAhead => Self::LookAhead,
            LeftOut::Pairs => Self::Pairs,
        }
    }
}

impl From<Late> for LeftOut {
    fn from(late: Late) -> Self {
        match late {
            Late::Nothing => Self::Nothing,
            Late::LookAhead => Self::LookAhead,
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

/// Parameters by name; those that are not there have their defaults.
///
/// # Errors
/// The parameter that this build does not have, or not with this value.
pub fn parameters_from_json(json: &Map<String, Json>) -> Result<Parameters, String> {
    let mut parameters = Parameters::default();
    for (name, value) in json {
        // a text stays one, whatever it would mean in YAML
        let text = value.as_str().map(|text| Value::Text(text.to_owned()));
        let value = text.unwrap_or_else(|| parameter_value::from_node(value));
        parameters.assign(name, &value)?;
    }
    if !json.contains_key("exact_distance_share") {
        // before there was a choice distances were exact
        parameters.exact_distance_share = 0.0;
    }
    // before there was a choice these were warnings
    for name in ["blind_cloud", "rejected_obstacle", "lost_messages", "mimic_contradiction"] {
        if !json.contains_key(name) {
            parameters.assign(name, &Value::Text(UNKNOWN_OR_WARN[1].to_owned()))?;
        }
    }
    parameters.check_together()?;
    Ok(parameters)
}
