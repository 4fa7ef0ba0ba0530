//! Sender of scene commands to the loader. It notifies the monitor of each scene message, and counts changes of
//! objects.

use std::cell::Cell;
use std::sync::PoisonError;
use std::time::Instant;

use clearance_monitor::Now;
use ros2_interfaces_jazzy_serde::moveit_msgs::msg::{
    AttachedCollisionObject, CollisionObject, PlanningScene, PlanningSceneWorld,
};
use ros2_interfaces_jazzy_serde::octomap_msgs::msg::Octomap;
use smol::channel::{self, Sender};

use crate::messages::clearance_msgs::ObstacleStates;
use crate::monitor_events::monitor_event::MonitorEvent;
use crate::monitor_events::world_update::WorldUpdate;
use crate::recording::recorded_event::OriginalMessage;
use crate::recording::step::{RecordedCommand, SceneSource};
use crate::scene::command_conversion::{
    attached_command, object_command, octomap_command, scene_command, states_command, undecodable_command,
    unreceivable_command, world_command,
};
use crate::scene::loader_command::LoaderCommand;
use crate::scene::scene_command::SceneCommand;
use crate::scene::scene_message_reader::lacks_content;
use crate::scene::shared_state::SharedState;
use crate::threading::mailbox;

/// Sends the commands of one thread.
pub struct SceneCommandSender {
    pub shared: SharedState,
    commands: Sender<LoaderCommand>,
    events: mailbox::Sender<MonitorEvent>,
    /// Number of received messages about objects.
    object_changes: Cell<u64>,
    /// Whether messages about objects were lost, or lacked content, since the last query.
    is_lost: Cell<bool>,
}

impl SceneCommandSender {
    #[must_use]
    pub fn new(
        shared: SharedState,
        commands: Sender<LoaderCommand>,
        events: mailbox::Sender<MonitorEvent>,
    ) -> Self {
        Self { shared, commands, events, object_changes: Cell::default(), is_lost: Cell::default() }
    }

    /// Reports the reception of a scene message to the monitor, before the message is converted, since that takes long
    /// as well. One command to the loader has to follow.
    pub fn note_update(&self, received: Instant) {
        let at = self.shared.clock.steady().saturating_sub(received.elapsed());
        self.notify(WorldUpdate::Received { steady: u64::try_from(at.as_nanos()).unwrap_or(u64::MAX) });
    }

    /// Reports to the monitor that the last received message requires no change.
    pub fn note_update_withdrawn(&self) {
        self.notify(WorldUpdate::Withdrawn);
    }

    fn notify(&self, update: WorldUpdate) {
        // a monitor that has ended publishes nothing
        let _ = self.events.send(MonitorEvent::WorldUpdate(update));
    }

    /// Whether a robot model is loaded, which a scene requires.
    pub fn has_robot(&self) -> bool {
        self.shared.scene.lock().unwrap_or_else(PoisonError::into_inner).is_some()
    }

    /// Number of messages about objects.
    pub fn object_changes(&self) -> u64 {
        self.object_changes.get()
    }

    /// Whether messages about objects were lost, or lacked content, since the last call.
    pub fn take_lost(&self) -> bool {
        self.is_lost.take()
    }

    /// Sends a command; returns whether the loader still exists.
    pub async fn send(&self, command: LoaderCommand) -> bool {
        self.commands.send(command).await.is_ok()
    }

    /// Sends a command that the monitor was notified of, and waits until it is in force. Returns whether all of it was
    /// applied.
    pub async fn apply(&self, command: SceneCommand) -> bool {
        let (done, is_done) = channel::bounded(1);
        let command = LoaderCommand::Scene(Box::new(command.notifying(done)));
        // a loader that has ended processes no command
        self.send(command).await && is_done.recv().await.unwrap_or(false)
    }

    /// Command for a message, together with the message itself if a recorder runs.
    fn command<M: Clone>(
        &self,
        by: SceneSource,
        message: M,
        keep: impl FnOnce(M) -> OriginalMessage,
        read: impl FnOnce(M, bool, Now) -> SceneCommand,
    ) -> SceneCommand {
        let SharedState { store, clock, recording, .. } = &self.shared;
        let (received_at, unknown_is_occupied) = (clock.read(), store.get().unknown_is_occupied());
        let original = recording.is_on().then(|| {
            let received_at = received_at.into();
            let step =
                RecordedCommand::Scene { by, received_at, unknown_is_occupied, lost: 0, is_shared: false };
            (step, Some(keep(message.clone())))
        });
        let command = read(message, unknown_is_occupied, received_at).with_original(original);
        if by != SceneSource::GetPlanningScene && command.concerns_objects() {
            self.object_changes.set(self.object_changes.get() + 1);
        }
        command
    }

    /// Sets the number of messages about objects that were lost right before this command.
    #[must_use]
    pub fn after(&self, command: SceneCommand, lost: u64) -> SceneCommand {
        if lost > 0 {
            self.is_lost.set(true);
            self.object_changes.set(self.object_changes.get() + 1);
        }
        command.after(lost)
    }

    /// Command for a message that could not be decoded. The scene of `move_group` is requested again.
    pub fn undecodable(&self, by: SceneSource) -> SceneCommand {
        self.is_lost.set(true);
        self.object_changes.set(self.object_changes.get() + 1);
        let is_recorded = self.shared.recording.is_on();
        undecodable_command(by)
            .with_original(is_recorded.then_some((RecordedCommand::Unreadable { by }, None)))
    }

    /// Command that reports publishers from which the node cannot receive.
    pub fn unreceivable(&self, publishers: Vec<String>) -> SceneCommand {
        let original = self.shared.recording.is_on().then(|| {
            let text = OriginalMessage::Text(publishers.join("\n"));
            (RecordedCommand::UnreceivablePublishers, Some(text))
        });
        unreceivable_command(publishers).with_original(original)
    }

    pub fn object(&self, message: CollisionObject) -> SceneCommand {
        let keep = |m| OriginalMessage::Object(Box::new(m));
        self.command(SceneSource::CollisionObject, message, keep, |m, _, _| object_command(&m))
    }

    pub fn attached(&self, message: AttachedCollisionObject) -> SceneCommand {
        let keep = |m| OriginalMessage::Attached(Box::new(m));
        self.command(SceneSource::AttachedCollisionObject, message, keep, |m, _, _| attached_command(&m))
    }

    pub fn states(&self, message: ObstacleStates) -> SceneCommand {
        let keep = |m| OriginalMessage::States(Box::new(m));
        let read = |m, _, received_at| states_command(&m, received_at);
        self.command(SceneSource::ObstacleStates, message, keep, read)
    }

    pub fn world(&self, message: PlanningSceneWorld) -> SceneCommand {
        let keep = |m| OriginalMessage::World(Box::new(m));
        self.command(SceneSource::PlanningSceneWorld, message, keep, world_command)
    }

    /// Command to apply a whole or partial scene.
    pub fn scene(&self, by: SceneSource, message: PlanningScene) -> SceneCommand {
        if by == SceneSource::PlanningScene && lacks_content(&message) {
            // the service has it
            self.is_lost.set(true);
        }
        let read =
            |m, unknown_is_occupied, received_at| scene_command(by, m, unknown_is_occupied, received_at);
        self.command(by, message, |m| OriginalMessage::Scene(Box::new(m)), read)
    }

    pub fn octomap(&self, by: SceneSource, message: Octomap) -> SceneCommand {
        let read =
            |m, unknown_is_occupied, received_at| octomap_command(by, m, unknown_is_occupied, received_at);
        self.command(by, message, |m| OriginalMessage::Octomap(Box::new(m)), read)
    }
}
