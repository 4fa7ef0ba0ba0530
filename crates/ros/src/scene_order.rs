//! What a message about the world asks for: an order of the loader.

use clearance_monitor::Observation;
use clearance_scene::{SceneRejection, SceneUpdate};
use ros2_interfaces_jazzy_serde::octomap_msgs::msg::OctomapWithPose;
use smol::channel::Sender;

use super::recording::{OrderStep, OriginalMessage, SceneDoor};
use super::scene::CLEAR_OCTOMAP;

/// Something to be done to the scene.
pub struct SceneOrder {
    /// The topic or service that it came by.
    pub(super) source: &'static str,
    pub(super) update: Option<SceneUpdate>,
    /// What could not be understood of the message.
    pub(super) refusals: Vec<SceneRejection>,
    /// How many messages were lost right before it.
    pub(super) lost: u64,
    /// The octomap as it came, and when it was seen.
    pub(super) octomap: Option<(OctomapWithPose, Observation)>,
    /// Who waits for it to be in force: whether all of it was done.
    pub(super) done: Option<Sender<bool>>,
    /// The message, if somebody records.
    original: Option<(OrderStep, Option<OriginalMessage>)>,
}

impl SceneOrder {
    #[must_use]
    pub fn on(source: &'static str) -> Self {
        Self {
            source,
            update: None,
            refusals: Vec::new(),
            lost: 0,
            octomap: None,
            done: None,
            original: None,
        }
    }

    #[must_use]
    pub fn to(self, update: SceneUpdate) -> Self {
        Self { update: Some(update), ..self }
    }

    #[must_use]
    pub fn refused(self, refusals: Vec<SceneRejection>) -> Self {
        Self { refusals, ..self }
    }

    /// Whether it says something of objects, or of what the robot makes of them.
    #[must_use]
    pub fn tells_of_objects(&self) -> bool {
        !self.refusals.is_empty() || self.update.as_ref().is_none_or(SceneUpdate::tells_of_objects)
    }

    /// With what else it says that never came, by the count of messages.
    #[must_use]
    pub fn after(mut self, lost: u64) -> Self {
        if let Some((OrderStep::Scene { lost: told, .. }, _)) = &mut self.original {
            *told = lost;
        }
        Self { lost, ..self }
    }

    #[must_use]
    pub fn with_octomap(self, octomap: OctomapWithPose, sight: Observation) -> Self {
        let holds_one = !octomap.octomap.id.is_empty();
        Self { octomap: holds_one.then_some((octomap, sight)), ..self }
    }

    /// With the message that it was made of, if somebody records.
    #[must_use]
    pub fn made_of(self, original: Option<(OrderStep, Option<OriginalMessage>)>) -> Self {
        Self { original, ..self }
    }

    /// What it was made of, told once.
    pub fn take_original(&mut self) -> Option<(OrderStep, Option<OriginalMessage>)> {
        self.original.take()
    }

    /// Whether it is of those that somebody waits for: of a recording, nobody does any more.
    #[must_use]
    pub fn is_waited_for(&self) -> bool {
        const DOORS: [SceneDoor; 2] = [SceneDoor::ApplyPlanningScene, SceneDoor::GetPlanningScene];
        self.source == CLEAR_OCTOMAP || DOORS.iter().any(|door| door.name() == self.source)
    }

    #[must_use]
    pub fn answered_on(self, done: Sender<bool>) -> Self {
        Self { done: Some(done), ..self }
    }
}
