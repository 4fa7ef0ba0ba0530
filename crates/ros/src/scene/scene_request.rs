//! The scene of a running `move_group`: it is asked for when its service appears, and again when something of what it tells was lost.
//!
//! `MoveIt` tells a whole scene when it starts, and then what changes in it: a node that comes later has never heard of what stood there.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use clearance_monitor::SourceId;
use futures_lite::future;
use ros2_interfaces_jazzy_serde::moveit_msgs::msg::PlanningSceneComponents;
use ros2_interfaces_jazzy_serde::moveit_msgs::srv::{GetPlanningSceneRequest, GetPlanningSceneResponse};
use smol::Timer;

use super::topics::SceneTopics;
use crate::middleware::{Client, DecodeErrorLog};
use crate::names::FullName;
use crate::recording::SceneDoor;

/// Time between two looks at who serves.
const PERIOD: Duration = Duration::from_millis(200);

/// Time between two looks at the parameter, while it names nobody.
const PAUSE: Duration = Duration::from_secs(1);

/// Time that an answer may take, and until the next question where it did not come or was not taken; each time twice as long, up to the
/// longest.
const PATIENCE: Duration = Duration::from_secs(2);
const LONGEST_PATIENCE: Duration = Duration::from_secs(16);

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
pub struct SceneRequester {
    service: Option<Service>,
    complaints: DecodeErrorLog,
}

/// A service and those who offer it.
struct Service {
    name: FullName,
    client: Client<GetPlanningSceneRequest, GetPlanningSceneResponse>,
    servers: BTreeSet<SourceId>,
    is_due: bool,
    /// No earlier than this.
    due_at: Instant,
    patience: Duration,
}

impl SceneRequester {
    /// Asks whenever there is reason to, for ever.
    pub async fn go_on(mut self, topics: &SceneTopics) {
        loop {
            if let Err(why) = self.look(topics).await {
                self.complaints.warn(|| format!("planning_scene_service: {why}"));
            }
            Timer::after(if self.service.is_some() { PERIOD } else { PAUSE }).await;
        }
    }

    /// Asks if there is reason to now.
    async fn look(&mut self, topics: &SceneTopics) -> Result<(), String> {
        self.turn_to(topics)?;
        let Some(service) = self.service.as_mut().filter(|_| topics.has_robot()) else { return Ok(()) };
        service.meet(topics.middleware.servers_elsewhere(&service.name));
        service.is_due |= topics.take_lost();
        if service.is_due && !service.servers.is_empty() && Instant::now() >= service.due_at {
            return service.ask(topics).await.inspect_err(|_| service.be_patient());
        }
        Ok(())
    }

    /// The service that the parameter names, if it names one.
    fn turn_to(&mut self, topics: &SceneTopics) -> Result<(), String> {
        let wanted = topics.shared.store.get().planning_scene_service;
        let name = if wanted.is_empty() {
            None
        } else {
            Some(topics.names.expand(&wanted).map_err(|why| why.to_string())?)
        };
        if name.is_some() && name == topics.names.resolve("get_planning_scene").ok() {
            self.service = None;
            return Err(format!(
                "{wanted} is the service of this node itself: give that another name (--ros-args -r get_planning_scene:=~/get_planning_scene)"
            ));
        }
        if self.service.as_ref().map(|service| &service.name) == name.as_ref() {
            return Ok(());
        }
        self.service = match name {
            Some(name) => Some(Service {
                client: (topics.middleware.client(&name, ("moveit_msgs", "GetPlanningScene")))
                    .map_err(|why| why.to_string())?,
                name,
                servers: BTreeSet::new(),
                is_due: true,
                due_at: Instant::now(),
                patience: PATIENCE,
            }),
            None => None,
        };
        Ok(())
    }
}

impl Service {
    /// Who comes anew has another scene.
    fn meet(&mut self, servers: BTreeSet<SourceId>) {
        if servers.difference(&self.servers).next().is_some() {
            (self.is_due, self.due_at, self.patience) = (true, Instant::now(), PATIENCE);
        }
        self.servers = servers;
    }

    fn be_patient(&mut self) {
        self.due_at = Instant::now() + self.patience;
        self.patience = (2 * self.patience).min(LONGEST_PATIENCE);
    }

    /// Asks, and has the answer applied unless a change that came meanwhile may be newer: then it is asked again.
    async fn ask(&mut self, topics: &SceneTopics) -> Result<(), String> {
        let heard = topics.changes_heard();
        let components = PlanningSceneComponents { components: EVERYTHING };
        let answer = self.client.call(GetPlanningSceneRequest { components }, self.patience);
        let scene = future::or(answer, self.another_server(topics)).await?.scene;
        if scene.robot_model_name.is_empty() {
            return Err(format!("{} tells the scene of no robot: it has none yet", self.name));
        }
        if scene.is_diff {
            return Err(format!("{} tells what has changed, not the whole scene", self.name));
        }
        if topics.changes_heard() != heard {
            return Ok(());
        }
        topics.note_update(Instant::now());
        if !topics.have_done(topics.scene(SceneDoor::GetPlanningScene, scene)).await {
            return Err(format!("not all of what {} told was taken", self.name));
        }
        log::info!("planning_scene_service: {} told its scene", self.name);
        (self.is_due, self.patience) = (false, PATIENCE);
        Ok(())
    }

    /// Waits until others serve than those who were asked.
    async fn another_server<T>(&self, topics: &SceneTopics) -> Result<T, String> {
        while topics.middleware.servers_elsewhere(&self.name) == self.servers {
            Timer::after(PERIOD).await;
        }
        Err(format!("others serve {} now than those who were asked", self.name))
    }
}
