//! Inputs that the loader reads at the beginning of a pass.

use std::collections::BTreeMap;
use std::sync::{Arc, PoisonError};

use clearance_robot::MeshLog;

use crate::monitor_events::current_evaluation::CurrentEvaluation;
use crate::recording::recorded_event::{OriginalMessage, RecordedCloud, RecordedEvent};
use crate::recording::step::RecordedCommand;
use crate::scene::cloud_inbox::CloudMessage;
use crate::scene::loader_command::LoaderCommand;
use crate::scene::scene_update_context::SceneUpdateContext;
use crate::scene::scene_update_context::robots_at_stamps;
use crate::scene::shared_state::SharedState;

/// Input of one pass: a group of commands, the newest point clouds, and the update context.
pub struct Pass {
    pub update_context: SceneUpdateContext,
    pub commands: Vec<LoaderCommand>,
    pub clouds: BTreeMap<String, CloudMessage>,
}

/// Inputs of the loader: shared state that it reads at the beginning of a pass.
pub struct LoaderInputs {
    pub shared: SharedState,
    pub evaluation: CurrentEvaluation,
    pub meshes: MeshLog,
}

impl LoaderInputs {
    /// Takes a snapshot of all inputs. In a recording, earlier events precede this pass and later events follow it.
    pub fn begin(&self, mut commands: Vec<LoaderCommand>) -> Pass {
        let SharedState { transforms, clouds, joint_state_history, store, clock, recording, .. } =
            &self.shared;
        let parameters = store.get();
        let clouds = clouds.take();
        let originals: Vec<_> =
            if recording.is_on() { commands.iter_mut().map(original).collect() } else { Vec::new() };
        let used = clouds.iter().map(|(topic, message)| RecordedCloud {
            topic: topic.clone(),
            received_at: message.received_at,
            is_shared: message.is_shared,
            cloud: Arc::clone(&message.cloud),
        });
        let used = used.collect();
        let used_parameters = Box::new(parameters.clone());
        let transforms = transforms.lock().unwrap_or_else(PoisonError::into_inner);
        // the monitor waits for this lock: hold it for as little work as possible
        let current = self.evaluation.lock().unwrap_or_else(PoisonError::into_inner);
        let now = clock.read();
        recording.note(|| RecordedEvent::Pass {
            now,
            parameters: used_parameters,
            commands: originals,
            clouds: used,
        });
        let evaluation = current.clone();
        let history = joint_state_history.lock().unwrap_or_else(PoisonError::into_inner);
        let robots_at_stamps = robots_at_stamps(&clouds, &history, parameters.stale_after);
        drop(history);
        drop(current);
        Pass {
            update_context: SceneUpdateContext {
                now,
                parameters,
                transforms: transforms.latest(),
                evaluation,
                robots_at_stamps,
            },
            commands,
            clouds,
        }
    }

    /// Records which meshes were read.
    pub fn note_meshes(&self) {
        let meshes = self.meshes.take();
        if !meshes.is_empty() {
            self.shared.recording.note(|| RecordedEvent::Meshes(meshes));
        }
    }
}

/// A command in the form used by recordings.
fn original(command: &mut LoaderCommand) -> (RecordedCommand, Option<OriginalMessage>) {
    match command {
        LoaderCommand::Description(text) => {
            (RecordedCommand::Description, Some(OriginalMessage::Text(text.clone())))
        }
        LoaderCommand::Semantic(text) => {
            (RecordedCommand::Semantic, Some(OriginalMessage::Text(text.clone())))
        }
        LoaderCommand::Parameters => (RecordedCommand::Parameters, None),
        LoaderCommand::Clouds => (RecordedCommand::Clouds, None),
        LoaderCommand::Display => (RecordedCommand::Display, None),
        LoaderCommand::Frames => (RecordedCommand::Frames, None),
        // while recording is on, each scene command carries its original message
        LoaderCommand::Scene(command) => command.take_original().unwrap_or((RecordedCommand::Clouds, None)),
    }
}
