//! Types of recorded events: inputs and evaluations of the node, as it passes them to the recorder.

use std::path::PathBuf;
use std::sync::Arc;

use clearance_monitor::{Evaluation, LeftOut, Now, SourceId, Time};
use clearance_robot::{MeshLog, MeshUse};
use ros2_interfaces_jazzy_serde::moveit_msgs::msg::{
    AttachedCollisionObject, CollisionObject, PlanningScene, PlanningSceneWorld,
};
use ros2_interfaces_jazzy_serde::octomap_msgs::msg::Octomap;
use ros2_interfaces_jazzy_serde::rosgraph_msgs::msg::Clock;
use ros2_interfaces_jazzy_serde::sensor_msgs::msg::{JointState, PointCloud2};
use ros2_interfaces_jazzy_serde::tf2_msgs::msg::TFMessage;

use crate::messages::clearance_msgs::{CollisionState, ObstacleStates};
use crate::messages::collision_state::collision_state;
use crate::parameters::parameter_set::Parameters;
use crate::recording::step::{RecordedCommand, RecordedMonitorEvent};

/// Command-line inputs of the node, stored for the replay.
#[derive(Clone, Debug, Default)]
pub struct CommandLineInputs {
    /// The arguments, which only the command line interprets.
    pub arguments: serde_json::Value,
    /// Files that the arguments name.
    pub files: Vec<PathBuf>,
    /// Log of the mesh files that were loaded.
    pub meshes: MeshLog,
}

/// A message as it was received.
#[derive(Clone, Debug)]
pub enum OriginalMessage {
    Text(String),
    Scene(Box<PlanningScene>),
    World(Box<PlanningSceneWorld>),
    Object(Box<CollisionObject>),
    Attached(Box<AttachedCollisionObject>),
    States(Box<ObstacleStates>),
    Octomap(Box<Octomap>),
}

/// A cloud that the loader processed.
#[derive(Clone, Debug)]
pub struct RecordedCloud {
    pub topic: String,
    pub received_at: Now,
    /// Whether several publishers sent on its topic.
    pub is_shared: bool,
    pub cloud: Arc<PointCloud2>,
}

/// An event that changed the node's inputs or outputs.
#[derive(Debug)]
pub enum RecordedEvent {
    Meshes(Vec<MeshUse>),
    Pass {
        now: Now,
        parameters: Box<Parameters>,
        commands: Vec<(RecordedCommand, Option<OriginalMessage>)>,
        clouds: Vec<RecordedCloud>,
    },
    MonitorEvent(RecordedMonitorEvent),
    Parameters(Box<Parameters>),
    Enabled(bool),
    /// The monitor read the transforms.
    TransformsRead,
    /// A joint state was received and not evaluated, because the next one followed at once.
    JointStateReceived {
        now: Now,
        message: Box<JointState>,
        source: SourceId,
    },
    Evaluated(Box<RecordedEvaluation>),
    Transforms {
        message: TFMessage,
        now: Option<Time>,
        fixed: bool,
    },
    Clock(Clock),
}

/// An evaluation that is published, and its cause: a joint state, or the passage of time.
#[derive(Debug)]
pub struct RecordedEvaluation {
    pub now: Now,
    pub joint_state: Option<(JointState, SourceId)>,
    pub result: RecordedResult,
}

/// The recorded part of an evaluation. It holds no checker, so that events that wait for a slow disk keep no old robots
/// and worlds in memory.
#[derive(Debug)]
pub struct RecordedResult {
    pub state: CollisionState,
    pub is_free: bool,
    pub distance: f64,
    pub speed_scale: f64,
    pub left_out: LeftOut,
}

impl From<&Evaluation> for RecordedResult {
    fn from(evaluation: &Evaluation) -> Self {
        Self {
            state: collision_state(evaluation),
            is_free: evaluation.status.is_free(),
            distance: evaluation.distance(),
            speed_scale: evaluation.speed_scale,
            left_out: evaluation.left_out,
        }
    }
}
