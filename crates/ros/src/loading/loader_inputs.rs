//! Inputs that the loader reads at the beginning of a pass.

use std::collections::BTreeMap;
use std::sync::{Arc, PoisonError};

use clearance_robot::MeshLog;

use crate::monitor_events::current_evaluation::CurrentEvaluation;
use crate::recording::recorder_handle::{OriginalMessage, RecordedEvent};
use crate::recording::step::OrderStep;
use crate::scene::cloud_inbox::CloudMessage;
use crate::scene::loader_command::Order;
use crate::scene::scene_update_context::SceneUpdateContext;
use crate::scene::scene_update_context::places_of;
use crate::scene::shared_state::Shared;

/// Input of one pass: a group of orders, the newest point clouds, and the update context.
pub struct Pass {
    pub update_context: SceneUpdateContext,
    pub orders: Vec<Order>,
    pub clouds: BTreeMap<String, CloudMessage>,
}

/// Inputs of the loader: shared state that it reads at the beginning of a pass.
pub struct LoaderInputs {
    pub shared: Shared,
    pub evaluation: CurrentEvaluation,
    pub meshes: MeshLog,
}

impl LoaderInputs {
    /// Takes a snapshot of all inputs. In a recording, earlier events precede this pass and later events follow it.
    pub fn begin(&self, mut orders: Vec<Order>) -> Pass {
        let Shared { transforms, clouds, joint_state_history, store, clock, tape, .. } = &self.shared;
        let parameters = store.get();
        let clouds = clouds.take();
        let originals: Vec<_> =
            if tape.is_on() { orders.iter_mut().map(original).collect() } else { Vec::new() };
        let used = clouds.iter().map(|(topic, c)| (topic.clone(), c.came, Arc::clone(&c.cloud))).collect();
        let used_parameters = Box::new(parameters.clone());
        let transforms = transforms.lock().unwrap_or_else(PoisonError::into_inner);
        // the monitor waits for this lock: hold it for as little work as possible
        let current = self.evaluation.lock().unwrap_or_else(PoisonError::into_inner);
        let now = clock.read();
        tape.note(|| RecordedEvent::Pass {
            now,
            parameters: used_parameters,
            orders: originals,
            clouds: used,
        });
        let evaluation = current.clone();
        let places = places_of(&clouds, &joint_state_history.lock().unwrap_or_else(PoisonError::into_inner));
        drop(current);
        Pass {
            update_context: SceneUpdateContext {
                now,
                parameters,
                transforms: transforms.clone(),
                evaluation,
                places,
            },
            orders,
            clouds,
        }
    }

    /// Records which meshes were read.
    pub fn note_meshes(&self) {
        let meshes = self.meshes.take();
        if !meshes.is_empty() {
            self.shared.tape.note(|| RecordedEvent::Meshes(meshes));
        }
    }
}

/// An order in the form used by recordings.
fn original(order: &mut Order) -> (OrderStep, Option<OriginalMessage>) {
    match order {
        Order::Description(text) => (OrderStep::Description, Some(OriginalMessage::Text(text.clone()))),
        Order::Semantic(text) => (OrderStep::Semantic, Some(OriginalMessage::Text(text.clone()))),
        Order::Parameters => (OrderStep::Parameters, None),
        Order::Clouds => (OrderStep::Clouds, None),
        Order::Display => (OrderStep::Display, None),
        Order::Frames => (OrderStep::Frames, None),
        // while recording is on, each scene order carries its original message
        Order::Scene(order) => order.take_original().unwrap_or((OrderStep::Clouds, None)),
    }
}
