//! Sender of scene commands to the loader. It notifies the monitor of each scene message, and counts changes of objects.

use std::cell::Cell;
use std::sync::PoisonError;
use std::time::Instant;

use clearance_monitor::Now;
use ros2_interfaces_jazzy_serde::moveit_msgs::msg::{
    AttachedCollisionObject, CollisionObject, PlanningScene, PlanningSceneWorld,
};
use ros2_interfaces_jazzy_serde::octomap_msgs::msg::Octomap;
use smol::channel::{self, Sender};

use crate::monitor_events::monitor_event::Event;
use crate::monitor_events::world_update::WorldUpdate;
use crate::recording::recorder_handle::OriginalMessage;
use crate::recording::step::{OrderStep, SceneDoor};
use crate::scene::command_conversion::{
    attached_order, object_order, octomap_order, scene_order, unreadable_order, world_order,
};
use crate::scene::loader_command::Order;
use crate::scene::scene_command::SceneOrder;
use crate::scene::shared_state::Shared;
use crate::threading::mailbox;

/// Sends the commands of one thread.
pub struct SceneCommandSender {
    pub shared: Shared,
    orders: Sender<Order>,
    events: mailbox::Sender<Event>,
    /// Number of received messages about objects.
    object_changes: Cell<u64>,
    /// Whether messages about objects were lost since the last query.
    is_lost: Cell<bool>,
}

impl SceneCommandSender {
    #[must_use]
    pub fn new(shared: Shared, orders: Sender<Order>, events: mailbox::Sender<Event>) -> Self {
        Self { shared, orders, events, object_changes: Cell::default(), is_lost: Cell::default() }
    }

    /// Reports the reception of a scene message to the monitor, before the message is converted, since that takes long as well. One
    /// command to the loader has to follow.
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
        let _ = self.events.send(Event::WorldUpdate(update));
    }

    /// Whether a robot model is loaded, which a scene requires.
    pub fn has_robot(&self) -> bool {
        self.shared.scene.lock().unwrap_or_else(PoisonError::into_inner).is_some()
    }

    /// Number of messages about objects.
    pub fn object_changes(&self) -> u64 {
        self.object_changes.get()
    }

    /// Whether messages about objects were lost since the last call.
    pub fn take_lost(&self) -> bool {
        self.is_lost.take()
    }

    /// Sends a command; returns whether the loader still exists.
    pub async fn send(&self, order: Order) -> bool {
        self.orders.send(order).await.is_ok()
    }

    /// Sends a command that the monitor was notified of, and waits until it is in force. Returns whether all of it was applied.
    pub async fn apply(&self, order: SceneOrder) -> bool {
        let (done, is_done) = channel::bounded(1);
        let order = Order::Scene(Box::new(order.answered_on(done)));
        // a loader that has ended processes no command
        self.send(order).await && is_done.recv().await.unwrap_or(false)
    }

    /// Command for a message, together with the message itself if a recorder runs.
    fn order<M: Clone>(
        &self,
        by: SceneDoor,
        message: M,
        keep: impl FnOnce(M) -> OriginalMessage,
        read: impl FnOnce(M, bool, Now) -> SceneOrder,
    ) -> SceneOrder {
        let Shared { store, clock, tape, .. } = &self.shared;
        let (came, unknown_is_occupied) = (clock.read(), store.get().unknown_is_occupied());
        let original = tape.is_on().then(|| {
            let step = OrderStep::Scene { by, came: came.into(), unknown_is_occupied, lost: 0 };
            (step, Some(keep(message.clone())))
        });
        let order = read(message, unknown_is_occupied, came).made_of(original);
        if by != SceneDoor::GetPlanningScene && order.tells_of_objects() {
            self.object_changes.set(self.object_changes.get() + 1);
        }
        order
    }

    /// Sets the number of messages about objects that were lost right before this command.
    #[must_use]
    pub fn after(&self, order: SceneOrder, lost: u64) -> SceneOrder {
        if lost > 0 {
            self.is_lost.set(true);
            self.object_changes.set(self.object_changes.get() + 1);
        }
        order.after(lost)
    }

    /// Command for a message that could not be decoded. The scene of `move_group` is requested again.
    pub fn unreadable(&self, by: SceneDoor) -> SceneOrder {
        self.is_lost.set(true);
        self.object_changes.set(self.object_changes.get() + 1);
        let is_recorded = self.shared.tape.is_on();
        unreadable_order(by).made_of(is_recorded.then_some((OrderStep::Unreadable { by }, None)))
    }

    pub fn object(&self, message: CollisionObject) -> SceneOrder {
        let keep = |m| OriginalMessage::Object(Box::new(m));
        self.order(SceneDoor::CollisionObject, message, keep, |m, _, _| object_order(&m))
    }

    pub fn attached(&self, message: AttachedCollisionObject) -> SceneOrder {
        let keep = |m| OriginalMessage::Attached(Box::new(m));
        self.order(SceneDoor::AttachedCollisionObject, message, keep, |m, _, _| attached_order(&m))
    }

    pub fn world(&self, message: PlanningSceneWorld) -> SceneOrder {
        let keep = |m| OriginalMessage::World(Box::new(m));
        self.order(SceneDoor::PlanningSceneWorld, message, keep, world_order)
    }

    /// Command to apply a whole or partial scene.
    pub fn scene(&self, by: SceneDoor, message: PlanningScene) -> SceneOrder {
        let read = |m, unknown_is_occupied, came| scene_order(by, m, unknown_is_occupied, came);
        self.order(by, message, |m| OriginalMessage::Scene(Box::new(m)), read)
    }

    pub fn octomap(&self, by: SceneDoor, message: Octomap) -> SceneOrder {
        let read = |m, unknown_is_occupied, came| octomap_order(by, m, unknown_is_occupied, came);
        self.order(by, message, |m| OriginalMessage::Octomap(Box::new(m)), read)
    }
}
