//! Subscription to `/clock` while `use_sim_time` is set.
//!
//! The simulated time of `ros2-client` stays zero, because that library subscribes to `/clock` with the type
//! `builtin_interfaces/Time` instead of `rosgraph_msgs/Clock`. The node therefore has a subscription of its own.

use futures_lite::future;
use ros2_interfaces_jazzy_serde::rosgraph_msgs::msg::Clock;
use smol::channel::Receiver;

use crate::clock::RosClock;
use crate::dds::middleware::Middleware;
use crate::dds::middleware_error::MiddlewareError;
use crate::dds::quality::Quality;
use crate::dds::subscription::Subscription;
use crate::dds::type_name::TypeName;
use crate::messages::time_and_geometry::time_of;
use crate::names::FullName;
use crate::parameters::parameter_store::ParameterStore;
use crate::recording::recorded_event::RecordedEvent;
use crate::recording::recorder_handle::RecorderHandle;

/// Parts of the node that the subscription uses.
pub struct ClockInputs<'n> {
    pub middleware: &'n Middleware,
    pub topic: &'n FullName,
    pub clock: &'n RosClock,
    pub store: &'n ParameterStore,
    pub recording: &'n RecorderHandle,
    /// Receives a notice when a parameter changed.
    pub changes: &'n Receiver<()>,
}

/// Follows `/clock` without end; `changes` notifies it of changed parameters.
pub async fn follow(inputs: ClockInputs<'_>) -> Result<(), MiddlewareError> {
    let ClockInputs { middleware, topic, clock, store, recording, changes } = inputs;
    let kind = TypeName::new("rosgraph_msgs", "Clock");
    let mut subscription: Option<Subscription<Clock>> = None;
    loop {
        if subscription.is_none() && store.get().use_sim_time {
            subscription = Some(middleware.subscription(topic, kind, Quality::BestEffort)?);
        }
        let change = async {
            // parameters can no longer change, but time goes on
            if changes.recv().await.is_err() {
                future::pending::<()>().await;
            }
        };
        let tick = async {
            match &subscription {
                Some(subscription) => {
                    let (message, _) = subscription.next().await;
                    clock.on_simulation_time(time_of(&message.clock));
                    recording.note(|| RecordedEvent::Clock(message));
                }
                None => future::pending().await,
            }
        };
        future::or(change, tick).await;
    }
}
