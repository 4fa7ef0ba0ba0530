//! Methods of the monitor for notifications between joint states: model changes, world updates, faults and memory.

use std::time::Duration;

use super::Monitor;
use crate::Reason;
use crate::world_updates::WorldUpdates;

impl Monitor {
    /// Another robot was described: the status is UNKNOWN until its checker is set or it is rejected.
    pub fn note_model_swap(&mut self) {
        self.swapping = true;
        self.outdated = true;
    }

    /// Another robot description was received and waits for the current build. The status is UNKNOWN until it is
    /// processed.
    pub fn note_description(&mut self) {
        self.received_descriptions += 1;
        self.outdated = true;
    }

    /// Sets the number of descriptions that were loaded or rejected since the start.
    pub fn note_processed_descriptions(&mut self, descriptions: u64) {
        self.processed_descriptions = descriptions;
        self.outdated = true;
    }

    /// A model was rejected. The current one, if any, stays in use.
    pub fn note_model_fault(&mut self, fault: String) {
        self.model_fault = Some(fault);
        self.swapping = false;
        self.outdated = true;
    }

    /// Error of the last model, if it was rejected.
    #[must_use]
    pub fn model_fault(&self) -> Option<&str> {
        self.model_fault.as_deref()
    }

    /// From now on the status is UNKNOWN: the process uses too much memory (MiB), and ends.
    pub fn note_memory(&mut self, used: u64, limit: u64) {
        self.out_of_memory = Some(Reason::Memory { used, limit });
        self.outdated = true;
    }

    /// Sets the faults of the last changes of the world, which become warnings, and the reason why the world is
    /// incomplete, if it is. The rest of the world stays in use.
    pub fn note_world_faults(&mut self, faults: Vec<String>, incomplete: Option<Reason>) {
        self.world_faults = faults;
        let was_late = self
            .world_updates
            .due()
            .is_some_and(|due| self.published_at.is_none_or(|published_at| due <= published_at));
        self.world_updates.complete();
        if was_late {
            // published at once
            self.published_at = None;
        }
        if self.incomplete_world != incomplete {
            self.incomplete_world = incomplete;
            // published at once
            self.published_at = None;
        }
    }

    /// A message about the world was received at this time (steady clock). Until it is in force, the world differs from
    /// the announced one.
    pub fn note_world_update(&mut self, at: Duration) {
        let is_late = |updates: &WorldUpdates| {
            updates.due().zip(self.published_at).is_some_and(|(lags, published_at)| lags <= published_at)
        };
        let was_late = is_late(&self.world_updates);
        self.world_updates.note_received(at);
        // a message that waited long inside the node may be late already when it is first recorded
        self.outdated |= !was_late && is_late(&self.world_updates);
    }

    /// The last received message about the world requires no change.
    pub fn note_world_update_withdrawn(&mut self) {
        self.world_updates.note_withdrawn();
    }

    /// This number of messages about the world, the oldest ones, is in force once a checker is set, or once it is
    /// reported that none is needed.
    pub fn note_world_updates_completing(&mut self, updates: usize) {
        self.world_updates.note_completing(updates);
    }
}
