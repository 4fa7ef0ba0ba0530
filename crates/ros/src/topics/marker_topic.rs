//! `~/markers`, computed and published on a separate thread: colliding meshes and a thousand lines take longer than a
//! check, and would delay the joint states.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use clearance_monitor::Evaluation;
use ros2_interfaces_jazzy_serde::visualization_msgs::msg::MarkerArray;

use crate::dds::middleware::Middleware;
use crate::dds::middleware_error::MiddlewareError;
use crate::dds::publisher::Publisher;
use crate::dds::quality::Quality;
use crate::dds::type_name::TypeName;
use crate::names::Names;
use crate::parameters::parameter_set::Parameters;
use crate::threading::mailbox;
use crate::threading::mailbox::{Receiver, Sender};
use crate::threading::timed_wait::wait_at_most;
use crate::topics::markers::MarkerDisplay;

/// Content of the display.
#[derive(Debug)]
enum MarkerUpdate {
    /// The markers of an evaluation, with their lifetime.
    Of(Box<Evaluation>, Duration),
    /// No markers: the published ones are deleted.
    Nothing(Box<Evaluation>),
}

/// Sending end on the monitor's thread: passes evaluations to the thread that publishes the markers.
#[derive(Debug)]
pub struct MarkerFeed {
    updates: Sender<MarkerUpdate>,
    /// Status and steady time of the last queued update; `None` if nothing is shown.
    shown: Option<(&'static str, Duration)>,
    dropped: Arc<AtomicU64>,
}

/// Receiving end: publishes markers until the sending end is dropped.
pub struct MarkerWorker {
    updates: Receiver<MarkerUpdate>,
    publisher: Publisher<MarkerArray>,
    display: MarkerDisplay,
    dropped: Arc<AtomicU64>,
}

/// Creates the sending end and the receiving end of the topic.
pub fn open(middleware: &Middleware, names: &Names) -> Result<(MarkerFeed, MarkerWorker), MiddlewareError> {
    let kind = TypeName::new("visualization_msgs", "MarkerArray");
    let publisher = middleware.publisher(&names.resolve("~/markers")?, kind, Quality::Reliable)?;
    let (feed, updates) = feed();
    let dropped = Arc::clone(&feed.dropped);
    Ok((feed, MarkerWorker { updates, publisher, display: MarkerDisplay::default(), dropped }))
}

/// The queue holds one update: older updates are of no use.
fn feed() -> (MarkerFeed, Receiver<MarkerUpdate>) {
    let (sender, updates) = mailbox::bounded(1);
    (MarkerFeed { updates: sender, shown: None, dropped: Arc::default() }, updates)
}

impl MarkerFeed {
    /// Queues an evaluation at every change of status, and otherwise at the marker rate. It is skipped if the queue
    /// still holds the last one.
    pub fn show(&mut self, evaluation: &Evaluation, parameters: &Parameters, steady: Duration) {
        let boxed = || Box::new(evaluation.clone());
        if !parameters.publish_markers {
            if self.shown.is_some() && self.updates.send(MarkerUpdate::Nothing(boxed())).is_ok() {
                self.shown = None;
            }
            return;
        }
        let status = evaluation.status.word();
        let period = Duration::try_from_secs_f64(1.0 / parameters.marker_rate).unwrap_or_default();
        let early = |at: Duration| steady.saturating_sub(at) < period;
        if self.shown.is_some_and(|(last, at)| last == status && early(at)) {
            return;
        }
        // the lifetime is longer than the longest time until the next marker
        let heartbeat = parameters.monitor_settings().heartbeat_period();
        let lifetime = 3 * period.max(heartbeat) + Duration::from_secs(1);
        if self.updates.send(MarkerUpdate::Of(boxed(), lifetime)).is_ok() {
            self.shown = Some((status, steady));
        }
    }

    /// Number of messages dropped since the last call.
    pub fn take_dropped(&self) -> u64 {
        self.dropped.swap(0, Ordering::Relaxed)
    }
}

impl MarkerWorker {
    pub fn run(mut self) {
        while let Some(Some(update)) = wait_at_most(Duration::MAX, self.updates.receive()) {
            let markers = match update {
                MarkerUpdate::Of(evaluation, lifetime) => self.display.update(&evaluation, lifetime),
                MarkerUpdate::Nothing(evaluation) => self.display.clear(&evaluation),
            };
            let sent = self.publisher.publish(markers);
            self.dropped.fetch_add(u64::from(!sent), Ordering::Relaxed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clearance_monitor::{Monitor, MonitorSettings, Now};

    fn evaluation(steady: Duration) -> Evaluation {
        Monitor::new(MonitorSettings::default(), || Duration::ZERO).on_heartbeat(Now { ros: None, steady })
    }

    fn taken(updates: &Receiver<MarkerUpdate>) -> Option<MarkerUpdate> {
        wait_at_most(Duration::ZERO, updates.receive()).flatten()
    }

    #[test]
    fn pictures_come_at_their_rate_and_none_waits_behind_another() {
        let (mut feed, updates) = feed();
        let parameters = Parameters { marker_rate: 10.0, ..Parameters::default() };
        let mut show = |milliseconds| {
            let steady = Duration::from_millis(milliseconds);
            feed.show(&evaluation(steady), &parameters, steady);
        };
        show(0);
        show(99);
        assert!(taken(&updates).is_some() && taken(&updates).is_none());
        show(100);
        show(200);
        assert!(taken(&updates).is_some() && taken(&updates).is_none());
        // the call at 200 ms found the queue full, so it did not count as shown
        show(201);
        assert!(taken(&updates).is_some());
    }

    #[test]
    fn what_is_turned_off_is_taken_away_once() {
        let (mut feed, updates) = feed();
        let on = Parameters::default();
        let off = Parameters { publish_markers: false, ..Parameters::default() };
        feed.show(&evaluation(Duration::ZERO), &off, Duration::ZERO);
        assert!(taken(&updates).is_none());
        feed.show(&evaluation(Duration::ZERO), &on, Duration::ZERO);
        feed.show(&evaluation(Duration::ZERO), &off, Duration::ZERO);
        assert!(matches!(taken(&updates), Some(MarkerUpdate::Of(..))));
        feed.show(&evaluation(Duration::ZERO), &off, Duration::ZERO);
        assert!(matches!(taken(&updates), Some(MarkerUpdate::Nothing(_))));
        feed.show(&evaluation(Duration::ZERO), &off, Duration::ZERO);
        assert!(taken(&updates).is_none());
    }
}
