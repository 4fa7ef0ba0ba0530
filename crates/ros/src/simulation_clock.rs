//! Subscription to `/clock` while `use_sim_time` is set.
//!
//! The client library subscribes to it with another message type, so its simulated time stays zero.

use futures_lite::future;
use ros2_interfaces_jazzy_serde::rosgraph_msgs::msg::Clock;
use smol::channel::Receiver;

use super::clock::RosClock;
use super::messages::time_of;
use super::middleware::{MessageKind, Middleware, MiddlewareError, Quality, Subscription};
use super::names::FullName;
use super::parameter_services::ParameterStore;
use super::recording::{RecordedEvent, RecorderHandle};

/// Follows `/clock` without end; `changes` notifies it of changed parameters.
pub async fn follow(
    middleware: &Middleware,
    name: &FullName,
    clock: &RosClock,
    (store, tape): (&ParameterStore, &RecorderHandle),
    changes: &Receiver<()>,
) -> Result<(), MiddlewareError> {
    let kind = MessageKind("rosgraph_msgs", "Clock");
    let mut subscription: Option<Subscription<Clock>> = None;
    loop {
        if subscription.is_none() && store.get().use_sim_time {
            subscription = Some(middleware.subscription(name, kind, Quality::BestEffort)?);
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
                    tape.note(|| RecordedEvent::Clock(message));
                }
                None => future::pending().await,
            }
        };
        future::or(change, tick).await;
    }
}
