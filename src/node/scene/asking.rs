//! The scene of a running `move_group`: it is asked for when its service appears, and again when something of what it tells was lost.
//!
//! `MoveIt` tells a whole scene when it starts, and then what changes in it: a node that comes later has never heard of what stood there.

use std::collections::BTreeSet;
use std::time::Duration;

use ros2_interfaces_jazzy_serde::moveit_msgs::msg::PlanningSceneComponents;
use ros2_interfaces_jazzy_serde::moveit_msgs::srv::{GetPlanningSceneRequest, GetPlanningSceneResponse};
use smol::Timer;

use super::topics::SceneTopics;
use crate::monitor::SourceId;
use crate::node::middleware::{Client, Complaints, MiddlewareError};
use crate::node::names::FullName;
use crate::node::recording::SceneDoor;

/// Time between two looks at who serves.
const PERIOD: Duration = Duration::from_millis(200);

/// Time between two questions that follow each other.
const PAUSE: Duration = Duration::from_secs(1);

/// Time that the first answer may take; the next ones have twice as long, up to the longest.
const PATIENCE: Duration = Duration::from_secs(2);
const LONGEST_PATIENCE: Duration = Duration::from_secs(32);

/// All that there is, as in `RViz`.
const EVERYTHING: u32 = PlanningSceneComponents::SCENE_SETTINGS
    | PlanningSceneComponents::ROBOT_STATE
    | PlanningSceneComponents::ROBOT_STATE_ATTACHED_OBJECTS
    | PlanningSceneComponents::WORLD_OBJECT_NAMES
    | PlanningSceneComponents::WORLD_OBJECT_GEOMETRY
    | PlanningSceneComponents::OCTOMAP
    | PlanningSceneComponents::TRANSFORMS
    | PlanningSceneComponents::ALLOWED_COLLISION_MATRIX
    | PlanningSceneComponents::LINK_PADDING_AND_SCALING
    | PlanningSceneComponents::OBJECT_COLORS;

/// Who was asked, and whether that has to be done again.
#[derive(Default)]
pub struct Asking {
    service: Option<Service>,
    complaints: Complaints,
}

/// A service and those who offer it.
struct Service {
    name: FullName,
    client: Client<GetPlanningSceneRequest, GetPlanningSceneResponse>,
    servers: BTreeSet<SourceId>,
    is_due: bool,
    patience: Duration,
}

impl Asking {
    /// Asks whenever there is reason to, for ever. It may be dropped at any time, and go on later.
    pub async fn go_on(&mut self, topics: &SceneTopics) {
        loop {
            match self.ask_if_due(topics).await {
                Ok(pause) => drop(Timer::after(pause).await),
                Err(why) => {
                    self.complaints.warn(|| format!("planning_scene_service: {why}"));
                    Timer::after(PAUSE).await;
                }
            }
        }
    }

    /// How long to wait until the next look.
    async fn ask_if_due(&mut self, topics: &SceneTopics) -> Result<Duration, String> {
        self.turn_to(topics).map_err(|error| error.to_string())?;
        let Some(service) = &mut self.service else { return Ok(PERIOD) };
        let servers = topics.middleware.servers_elsewhere(&service.name);
        service.is_due |= servers.difference(&service.servers).next().is_some() || topics.take_lost();
        service.servers = servers;
        if !service.is_due || service.servers.is_empty() {
            return Ok(PERIOD);
        }
        let heard = topics.scenes_heard();
        let components = PlanningSceneComponents { components: EVERYTHING };
        let request = GetPlanningSceneRequest { components };
        let answer = service.client.call(request, service.patience).await.inspect_err(|_| {
            service.patience = (2 * service.patience).min(LONGEST_PATIENCE);
        })?;
        service.patience = PATIENCE;
        // a change that was told meanwhile may be newer than the answer
        service.is_due = topics.scenes_heard() != heard;
        log::info!("planning_scene_service: {} told its scene", service.name);
        topics.apply(SceneDoor::GetPlanningScene, answer.scene).await;
        Ok(PAUSE)
    }

    /// The service that the parameter names, if it names one.
    fn turn_to(&mut self, topics: &SceneTopics) -> Result<(), MiddlewareError> {
        let wanted = topics.shared.store.get().planning_scene_service;
        let name = if wanted.is_empty() { None } else { Some(topics.names.expand(&wanted)?) };
        if self.service.as_ref().map(|service| &service.name) == name.as_ref() {
            return Ok(());
        }
        self.service = match name {
            Some(name) => Some(Service {
                client: topics.middleware.client(&name, ("moveit_msgs", "GetPlanningScene"))?,
                name,
                servers: BTreeSet::new(),
                is_due: true,
                patience: PATIENCE,
            }),
            None => None,
        };
        Ok(())
    }
}
