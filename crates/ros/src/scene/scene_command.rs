//! Scene command: the loader's input for one scene message, with its update, rejections and lost messages.

use clearance_monitor::Observation;
use clearance_scene::{SceneRejection, SceneUpdate};
use ros2_interfaces_jazzy_serde::octomap_msgs::msg::OctomapWithPose;
use smol::channel::Sender;

use crate::recording::recorded_event::OriginalMessage;
use crate::recording::step::{RecordedCommand, SceneSource};

/// Name of the service that clears the octomap.
pub const CLEAR_OCTOMAP: &str = "clear_octomap";

/// Change of the scene.
pub struct SceneCommand {
    /// Topic or service of the message.
    pub source: &'static str,
    pub update: Option<SceneUpdate>,
    /// Parts of the message that are invalid.
    pub rejections: Vec<SceneRejection>,
    /// Number of messages that were lost directly before this one.
    pub lost: u64,
    /// The received octomap, and its observation time.
    pub octomap: Option<(OctomapWithPose, Observation)>,
    /// Warnings about publishers from which the node cannot receive, if they changed.
    pub unreceivable: Option<Vec<String>>,
    /// Notified when the change is in use; true if all of it was applied.
    pub done: Option<Sender<bool>>,
    /// The original message, if recording is on.
    original: Option<(RecordedCommand, Option<OriginalMessage>)>,
}

impl SceneCommand {
    #[must_use]
    pub fn on(source: &'static str) -> Self {
        Self {
            source,
            update: None,
            rejections: Vec::new(),
            lost: 0,
            octomap: None,
            unreceivable: None,
            done: None,
            original: None,
        }
    }

    #[must_use]
    pub fn with_update(self, update: SceneUpdate) -> Self {
        Self { update: Some(update), ..self }
    }

    #[must_use]
    pub fn with_rejections(self, rejections: Vec<SceneRejection>) -> Self {
        Self { rejections, ..self }
    }

    /// Whether it contains data of objects, or robot settings that apply to them.
    #[must_use]
    pub fn concerns_objects(&self) -> bool {
        // states come again
        let is_of_states = matches!(self.update, Some(SceneUpdate::States(_)));
        (!self.rejections.is_empty() && !is_of_states)
            || self.update.as_ref().is_none_or(SceneUpdate::changes_objects)
    }

    /// Sets the number of messages that were lost before this one.
    #[must_use]
    pub fn after(mut self, lost: u64) -> Self {
        if let Some((RecordedCommand::Scene { lost: recorded, .. }, _)) = &mut self.original {
            *recorded = lost;
        }
        Self { lost, ..self }
    }

    /// Rejects an octomap if several publishers send on its topic: it would replace that of another one.
    #[must_use]
    pub fn of_shared_topic(mut self, is_shared: bool) -> Self {
        if let Some((RecordedCommand::Scene { is_shared: recorded, .. }, _)) = &mut self.original {
            *recorded = is_shared;
        }
        if !is_shared {
            return self;
        }
        let why = format!(
            "octomap: several publishers send on this topic, and each map would replace that of the other: give the node one publisher \
             (ros2 topic info -v {} lists them)",
            self.source
        );
        Self { update: None, octomap: None, rejections: vec![SceneRejection::of_octomap(why)], ..self }
    }

    #[must_use]
    pub fn with_octomap(self, octomap: OctomapWithPose, observation: Observation) -> Self {
        let holds_one = !octomap.octomap.id.is_empty();
        Self { octomap: holds_one.then_some((octomap, observation)), ..self }
    }

    #[must_use]
    pub fn with_unreceivable(self, publishers: Vec<String>) -> Self {
        Self { unreceivable: Some(publishers), ..self }
    }

    /// Attaches the original message, if recording is on.
    #[must_use]
    pub fn with_original(self, original: Option<(RecordedCommand, Option<OriginalMessage>)>) -> Self {
        Self { original, ..self }
    }

    /// Takes the original message.
    pub fn take_original(&mut self) -> Option<(RecordedCommand, Option<OriginalMessage>)> {
        self.original.take()
    }

    /// Whether a client waits for the response to this kind of command. In a replay the commands are the same, but
    /// there is no client.
    #[must_use]
    pub fn is_waited_for(&self) -> bool {
        const DOORS: [SceneSource; 2] = [SceneSource::ApplyPlanningScene, SceneSource::GetPlanningScene];
        self.source == CLEAR_OCTOMAP || DOORS.iter().any(|door| door.name() == self.source)
    }

    #[must_use]
    pub fn notifying(self, done: Sender<bool>) -> Self {
        Self { done: Some(done), ..self }
    }
}
