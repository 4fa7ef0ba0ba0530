//! Publishers of results: `~/state`, `~/is_free`, distances, `~/speed_scale`, `/diagnostics` and others.

use std::time::{Duration, Instant};

use clearance_checker::PairKind;
use clearance_monitor::Evaluation;
use ros2_interfaces_jazzy_serde::diagnostic_msgs::msg::DiagnosticArray;
use ros2_interfaces_jazzy_serde::std_msgs::msg::{Bool, Float64};

use crate::dds::Message;
use crate::dds::middleware::Middleware;
use crate::dds::middleware_error::MiddlewareError;
use crate::dds::publisher::Publisher;
use crate::dds::quality::Quality;
use crate::dds::type_name::TypeName;
use crate::messages::clearance_msgs::{CollisionState, Separation};
use crate::messages::collision_state::collision_state;
use crate::messages::separation::separation_message;
use crate::names::Names;
use crate::parameters::parameter_set::Parameters;
use crate::topics::marker_topic::MarkerFeed;
use crate::topics::retreat_topic::RetreatFeed;

/// All publishers of the node's results.
pub struct Publishers {
    state: Publisher<CollisionState>,
    heartbeat_state: Publisher<CollisionState>,
    is_free: Publisher<Bool>,
    distance: Publisher<Float64>,
    self_distance: Publisher<Float64>,
    world_distance: Publisher<Float64>,
    speed_scale: Publisher<Float64>,
    separation: Publisher<Separation>,
    /// Whether the last published separation may have a result.
    monitored_separation: bool,
    time_to_contact: Publisher<Float64>,
    /// Whether the last published time to contact may be different from zero.
    looked_ahead: bool,
    markers: MarkerFeed,
    retreat: RetreatFeed,
    diagnostics: Publisher<DiagnosticArray>,
}

/// Result of a publication.
pub struct Published {
    /// Number of dropped messages.
    pub dropped: u64,
    /// Time at which `~/state` was passed to the middleware, which sends it on its own thread.
    pub state_at: Instant,
}

impl Publishers {
    /// `markers` passes evaluations to the thread that publishes the markers, `retreat` notifies the one that computes
    /// directions out of a collision.
    pub fn open(
        middleware: &Middleware,
        names: &Names,
        markers: MarkerFeed,
        retreat: RetreatFeed,
    ) -> Result<Self, MiddlewareError> {
        fn publisher<M: Message>(
            middleware: &Middleware,
            names: &Names,
            name: &str,
            kind: TypeName,
        ) -> Result<Publisher<M>, MiddlewareError> {
            middleware.publisher(&names.resolve(name)?, kind, Quality::Reliable)
        }
        let float64 = TypeName::new("std_msgs", "Float64");
        let diagnostic = TypeName::new("diagnostic_msgs", "DiagnosticArray");
        let state = TypeName::new("clearance_msgs", "CollisionState");
        let separation = TypeName::new("clearance_msgs", "Separation");
        Ok(Self {
            state: publisher(middleware, names, "~/state", state)?,
            heartbeat_state: publisher(middleware, names, "~/heartbeat_state", state)?,
            is_free: publisher(middleware, names, "~/is_free", TypeName::new("std_msgs", "Bool"))?,
            distance: publisher(middleware, names, "~/distance", float64)?,
            self_distance: publisher(middleware, names, "~/self_distance", float64)?,
            world_distance: publisher(middleware, names, "~/world_distance", float64)?,
            speed_scale: publisher(middleware, names, "~/speed_scale", float64)?,
            separation: publisher(middleware, names, "~/separation", separation)?,
            monitored_separation: false,
            time_to_contact: publisher(middleware, names, "~/time_to_contact", float64)?,
            looked_ahead: false,
            markers,
            retreat,
            diagnostics: publisher(middleware, names, "/diagnostics", diagnostic)?,
        })
    }

    /// Publishes an evaluation on all topics.
    pub fn publish(
        &mut self,
        evaluation: &Evaluation,
        parameters: &Parameters,
        steady: Duration,
    ) -> Published {
        let mut dropped = self.markers.take_dropped() + self.retreat.take_dropped();
        let mut note = |sent: bool| dropped += u64::from(!sent);
        // the topics that stop a robot are published first
        note(self.is_free.publish(Bool { data: evaluation.status.is_free() }));
        note(self.speed_scale.publish(Float64 { data: evaluation.speed_scale }));
        let state = collision_state(evaluation);
        let heartbeat_state = evaluation.history.is_heartbeat.then(|| state.clone());
        note(self.state.publish(state));
        let state_at = Instant::now();
        if let Some(state) = heartbeat_state {
            note(self.heartbeat_state.publish(state));
        }
        note(self.distance.publish(Float64 { data: evaluation.distance() }));
        note(self.self_distance.publish(Float64 { data: evaluation.distance_of(PairKind::SelfPair) }));
        note(self.world_distance.publish(Float64 { data: evaluation.distance_of(PairKind::WorldPair) }));
        let monitors_separation = parameters.monitors_separation();
        // when the monitoring is turned off, an unknown separation is published once
        if monitors_separation || self.monitored_separation {
            note(self.separation.publish(separation_message(evaluation)));
        }
        self.monitored_separation = monitors_separation;
        let looks_ahead = parameters.look_ahead_horizon > 0.0;
        // when the look-ahead is turned off, zero is published once
        if looks_ahead || self.looked_ahead {
            let data = if looks_ahead { evaluation.time_to_contact() } else { 0.0 };
            note(self.time_to_contact.publish(Float64 { data }));
        }
        self.looked_ahead = looks_ahead;
        self.markers.show(evaluation, parameters, steady);
        self.retreat.note(evaluation, parameters, steady);
        Published { dropped, state_at }
    }

    pub fn publish_diagnostics(&self, diagnostics: DiagnosticArray) -> bool {
        self.diagnostics.publish(diagnostics)
    }
}
