//! The topics on which judgements are said.

use std::time::{Duration, Instant};

use ros2_interfaces_jazzy_serde::diagnostic_msgs::msg::DiagnosticArray;
use ros2_interfaces_jazzy_serde::std_msgs::msg::{Bool, Float64};
use ros2_interfaces_jazzy_serde::visualization_msgs::msg::MarkerArray;

use super::clearance_msgs::CollisionState;
use super::markers::Display;
use super::messages::collision_state;
use super::middleware::{Message, MessageKind, Middleware, MiddlewareError, Publisher, Quality};
use super::names::Names;
use super::parameters::Parameters;
use crate::monitor::Judgement;

/// Everything this node says.
pub struct Publishers {
    state: Publisher<CollisionState>,
    is_free: Publisher<Bool>,
    distance: Publisher<Float64>,
    speed_scale: Publisher<Float64>,
    time_to_contact: Publisher<Float64>,
    /// Whether someone may still hold a time to contact that is not zero.
    looked_ahead: bool,
    markers: Publisher<MarkerArray>,
    diagnostics: Publisher<DiagnosticArray>,
    display: Display,
    /// Status and steady time of the last markers.
    last_markers: Option<(&'static str, Duration)>,
}

/// What became of what was said.
pub struct Said {
    /// Messages that had to be dropped.
    pub dropped: u64,
    /// When `~/state` was handed to the middleware, which sends on a thread of its own.
    pub state_at: Instant,
}

impl Publishers {
    pub fn open(middleware: &Middleware, names: &Names) -> Result<Self, MiddlewareError> {
        fn publisher<M: Message>(
            middleware: &Middleware,
            names: &Names,
            name: &str,
            kind: MessageKind,
        ) -> Result<Publisher<M>, MiddlewareError> {
            middleware.publisher(&names.resolve(name)?, kind, Quality::Reliable)
        }
        let float64 = MessageKind("std_msgs", "Float64");
        let array = MessageKind("visualization_msgs", "MarkerArray");
        let diagnostic = MessageKind("diagnostic_msgs", "DiagnosticArray");
        let state = MessageKind("clearance_msgs", "CollisionState");
        Ok(Self {
            state: publisher(middleware, names, "~/state", state)?,
            is_free: publisher(middleware, names, "~/is_free", MessageKind("std_msgs", "Bool"))?,
            distance: publisher(middleware, names, "~/distance", float64)?,
            speed_scale: publisher(middleware, names, "~/speed_scale", float64)?,
            time_to_contact: publisher(middleware, names, "~/time_to_contact", float64)?,
            looked_ahead: false,
            markers: publisher(middleware, names, "~/markers", array)?,
            diagnostics: publisher(middleware, names, "/diagnostics", diagnostic)?,
            display: Display::default(),
            last_markers: None,
        })
    }

    /// Says a judgement on all topics.
    pub fn say(&mut self, judgement: &Judgement, parameters: &Parameters, steady: Duration) -> Said {
        let mut dropped = 0;
        let mut note = |sent: bool| dropped += u64::from(!sent);
        // what stops a robot goes first
        note(self.is_free.publish(Bool { data: judgement.status.is_free() }));
        note(self.speed_scale.publish(Float64 { data: judgement.speed_scale }));
        note(self.state.publish(collision_state(judgement)));
        let state_at = Instant::now();
        note(self.distance.publish(Float64 { data: judgement.distance() }));
        let looks_ahead = parameters.look_ahead_horizon > 0.0;
        // once it is turned off, zero is said once more
        if looks_ahead || self.looked_ahead {
            let data = if looks_ahead { judgement.time_to_contact() } else { 0.0 };
            note(self.time_to_contact.publish(Float64 { data }));
        }
        self.looked_ahead = looks_ahead;
        if let Some(markers) = self.due_markers(judgement, parameters, steady) {
            note(self.markers.publish(markers));
        }
        Said { dropped, state_at }
    }

    pub fn say_diagnostics(&self, diagnostics: DiagnosticArray) -> bool {
        self.diagnostics.publish(diagnostics)
    }

    fn due_markers(
        &mut self,
        judgement: &Judgement,
        parameters: &Parameters,
        steady: Duration,
    ) -> Option<MarkerArray> {
        if !parameters.publish_markers {
            return (!self.display.is_empty()).then(|| self.display.clear(judgement));
        }
        let status = judgement.status.word();
        let period = Duration::try_from_secs_f64(1.0 / parameters.marker_rate).unwrap_or_default();
        let early = |at: Duration| steady.saturating_sub(at) < period;
        if self.last_markers.is_some_and(|(last, at)| last == status && early(at)) {
            return None;
        }
        self.last_markers = Some((status, steady));
        // a marker outlives the longest wait for its successor
        let heartbeat = parameters.monitor_settings().heartbeat_period();
        let lifetime = 3 * period.max(heartbeat) + Duration::from_secs(1);
        Some(self.display.update(judgement, lifetime))
    }
}
