//! Passes changed parameters to the parts of the node, and decides whether the checker is built again.

use std::sync::{Arc, Mutex, PoisonError};

use smol::channel::Sender;

use crate::clock::RosClock;
use crate::monitor_events::monitor_event::MonitorEvent;
use crate::node::node_threads::StopSignal;
use crate::parameters::parameter_set::Parameters;
use crate::parameters::parameter_store::OnChange;
use crate::scene::loader_command::LoaderCommand;

/// Callback that passes changed parameters to all parts that use them.
pub fn on_change(
    initial: Parameters,
    clock: Arc<RosClock>,
    StopSignal { events, commands, .. }: &StopSignal,
    changes: [Sender<()>; 2],
) -> OnChange {
    let (events, commands) = (events.clone(), commands.clone());
    let last = Mutex::new(initial);
    Box::new(move |parameters| {
        let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
        clock.use_sim_time(parameters.use_sim_time);
        // an error means that the receiver has ended
        let _ = events.send(MonitorEvent::Parameters(Box::new(parameters.clone())));
        if what_is_built(&last) != what_is_built(parameters) {
            let _ = commands.try_send(LoaderCommand::Parameters);
        }
        if last.link_volume_level != parameters.link_volume_level {
            let _ = commands.try_send(LoaderCommand::Display);
        }
        for changes in &changes {
            let _ = changes.try_send(());
        }
        *last = parameters.clone();
    })
}

/// Parameters that require a rebuild of the checker, or a pass of the loader, when they change.
fn what_is_built(parameters: &Parameters) -> impl PartialEq + use<> {
    (
        (parameters.padding, parameters.pad_self, parameters.stale_source_policy),
        parameters.volumes.clone(),
        (parameters.joint_prefix.clone(), parameters.link_prefix.clone()),
        (parameters.point_cloud_ttl, parameters.octomap_ttl, parameters.point_cloud_topics.clone()),
        (parameters.require_planning_scene, parameters.planning_scene_service.clone()),
        (parameters.blind_cloud, parameters.rejected_obstacle, parameters.lost_messages),
        (parameters.obstacle_state_ttl, parameters.obstacle_limits()),
    )
}
