//! Messages of a recorded step, and the commands that are read from them.

use clearance_monitor::{JointStateInput, SourceId};
use ros2_interfaces_jazzy_serde::sensor_msgs::msg::JointState;
use ros2_interfaces_jazzy_serde::std_msgs::msg::String as StringMessage;

use crate::dds::cdr;
use crate::messages::joint_state::joint_state_input;
use crate::recording::mcap_file::RawMessage;
use crate::recording::step::{Clocks, RecordedCommand, SceneSource};
use crate::scene::command_conversion::{
    attached_command, clear_octomap, object_command, octomap_command, scene_command, states_command,
    undecodable_command, unreceivable_command, world_command,
};
use crate::scene::loader_command::LoaderCommand;
use crate::scene::scene_command::SceneCommand;

/// The messages of a step, in their order.
pub(super) struct StepMessages(std::vec::IntoIter<RawMessage>);

impl StepMessages {
    pub fn new(messages: Vec<RawMessage>) -> Self {
        Self(messages.into_iter())
    }

    pub fn raw(&mut self, what: &str) -> Result<RawMessage, String> {
        self.0.next().ok_or_else(|| format!("{what} is missing before a step"))
    }

    /// Whether they are of a part of a recording: a result without the allowed speed, as in `save_part`.
    pub fn are_of_part(&self) -> bool {
        let is_number = |message: &&RawMessage| message.kind == "std_msgs/msg/Float64";
        self.0.as_slice().iter().filter(is_number).count() < 2
    }

    pub fn is_empty(&self) -> bool {
        self.0.as_slice().is_empty()
    }

    pub fn joint_state(&mut self, source: &str) -> Result<JointStateInput, String> {
        let message: JointState = self.next("a joint state")?;
        Ok(joint_state_input(message, source_id(source)?))
    }

    pub fn next<M: serde::de::DeserializeOwned>(&mut self, what: &str) -> Result<M, String> {
        let raw = self.raw(what)?;
        cdr::decode(&raw.data).map_err(|why| format!("{} ({what}): {why}", raw.topic))
    }
}

fn source_id(hexadecimal: &str) -> Result<SourceId, String> {
    let wrong = || "the publisher of a joint state is not 32 hexadecimal digits".to_owned();
    let number = u128::from_str_radix(hexadecimal, 16).map_err(|_| wrong())?;
    (hexadecimal.len() == 32).then(|| SourceId(number.to_be_bytes())).ok_or_else(wrong)
}

/// Reads a command of the loader and its message.
pub(super) fn read_command(
    command: RecordedCommand,
    messages: &mut StepMessages,
) -> Result<LoaderCommand, String> {
    let text =
        |messages: &mut StepMessages| messages.next::<StringMessage>("a description").map(|text| text.data);
    Ok(match command {
        RecordedCommand::Description => LoaderCommand::Description(text(messages)?),
        RecordedCommand::Semantic => LoaderCommand::Semantic(text(messages)?),
        RecordedCommand::Parameters => LoaderCommand::Parameters,
        RecordedCommand::Clouds => LoaderCommand::Clouds,
        RecordedCommand::Display => LoaderCommand::Display,
        RecordedCommand::Frames => LoaderCommand::Frames,
        RecordedCommand::ClearOctomap => LoaderCommand::Scene(Box::new(clear_octomap())),
        RecordedCommand::UnreceivablePublishers => {
            let publishers = text(messages)?.lines().map(str::to_owned).collect();
            LoaderCommand::Scene(Box::new(unreceivable_command(publishers)))
        }
        RecordedCommand::Unreadable { by } => LoaderCommand::Scene(Box::new(undecodable_command(by))),
        RecordedCommand::Scene { by, received_at, unknown_is_occupied, lost, is_shared } => {
            let command = read_scene_command(by, received_at, unknown_is_occupied, messages)?;
            LoaderCommand::Scene(Box::new(command.after(lost).of_shared_topic(is_shared)))
        }
    })
}

fn read_scene_command(
    by: SceneSource,
    received_at: Clocks,
    unknown: bool,
    messages: &mut StepMessages,
) -> Result<SceneCommand, String> {
    let (name, received_at) = (by.name(), received_at.into());
    Ok(match by {
        SceneSource::CollisionObject => object_command(&messages.next(name)?),
        SceneSource::AttachedCollisionObject => attached_command(&messages.next(name)?),
        SceneSource::ObstacleStates => states_command(&messages.next(name)?, received_at),
        SceneSource::PlanningSceneWorld => world_command(messages.next(name)?, unknown, received_at),
        SceneSource::PlanningScene | SceneSource::ApplyPlanningScene | SceneSource::GetPlanningScene => {
            scene_command(by, messages.next(name)?, unknown, received_at)
        }
        SceneSource::OctomapBinary | SceneSource::OctomapFull => {
            octomap_command(by, messages.next(name)?, unknown, received_at)
        }
    })
}
