//! Client of a running `move_group`'s scene service. It requests the scene when the service appears, and again when
//! changes were lost.
//!
//! `MoveIt` publishes a whole scene when it starts, and only changes after that. A node that starts later would miss
//! the objects that were there before.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use clearance_monitor::SourceId;
use futures_lite::future;
use ros2_interfaces_jazzy_serde::moveit_msgs::msg::PlanningSceneComponents;
use ros2_interfaces_jazzy_serde::moveit_msgs::srv::{GetPlanningSceneRequest, GetPlanningSceneResponse};
use smol::Timer;

use crate::dds::client::Client;
use crate::dds::decode_error_log::DecodeErrorLog;
use crate::dds::middleware::Middleware;
use crate::dds::type_name::TypeName;
use crate::names::FullName;
use crate::names::Names;
use crate::recording::step::SceneSource;
use crate::scene::scene_command_sender::SceneCommandSender;

/// Time between two checks of which servers are present.
const PERIOD: Duration = Duration::from_millis(200);

/// Time between two checks of the parameter, while it names no service.
const PAUSE: Duration = Duration::from_secs(1);

/// Timeout of a request, and time until the next request if there was no response or it was rejected. It doubles each
/// time, up to the longest.
const TIMEOUT: Duration = Duration::from_secs(2);
const LONGEST_TIMEOUT: Duration = Duration::from_secs(16);

/// All components, as in `RViz`.
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

/// Parts of the node that requests use.
#[derive(Clone, Copy)]
pub struct RequestContext<'n> {
    pub middleware: &'n Middleware,
    pub names: &'n Names,
    pub sender: &'n SceneCommandSender,
}

/// Service in use, and whether a request is due.
#[derive(Default)]
pub struct SceneRequester {
    service: Option<Service>,
    decode_errors: DecodeErrorLog,
}

/// A service and the nodes that serve it.
struct Service {
    name: FullName,
    client: Client<GetPlanningSceneRequest, GetPlanningSceneResponse>,
    servers: BTreeSet<SourceId>,
    is_due: bool,
    /// Earliest time of the next request.
    due_at: Instant,
    timeout: Duration,
}

impl SceneRequester {
    /// Sends a request whenever one is due. Never returns.
    pub async fn run(mut self, context: RequestContext<'_>) {
        loop {
            if let Err(why) = self.send_due_request(context).await {
                self.decode_errors.warn(|| format!("planning_scene_service: {why}"));
            }
            Timer::after(if self.service.is_some() { PERIOD } else { PAUSE }).await;
        }
    }

    /// Sends a request if one is due now.
    async fn send_due_request(&mut self, context: RequestContext<'_>) -> Result<(), String> {
        self.select_service(context)?;
        let Some(service) = self.service.as_mut().filter(|_| context.sender.has_robot()) else {
            return Ok(());
        };
        service.update_servers(context.middleware.servers_elsewhere(&service.name));
        service.is_due |= context.sender.take_lost();
        if service.is_due && !service.servers.is_empty() && Instant::now() >= service.due_at {
            return service.request(context).await.inspect_err(|_| service.postpone());
        }
        Ok(())
    }

    /// Switches to the service that the parameter names, if it names one.
    fn select_service(&mut self, context: RequestContext<'_>) -> Result<(), String> {
        let wanted = context.sender.shared.store.get().planning_scene_service;
        let name = if wanted.is_empty() {
            None
        } else {
            Some(context.names.expand(&wanted).map_err(|why| why.to_string())?)
        };
        if name.is_some() && name == context.names.resolve_service("get_planning_scene").ok() {
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
                client: (context.middleware.client(&name, TypeName::new("moveit_msgs", "GetPlanningScene")))
                    .map_err(|why| why.to_string())?,
                name,
                servers: BTreeSet::new(),
                is_due: true,
                due_at: Instant::now(),
                timeout: TIMEOUT,
            }),
            None => None,
        };
        Ok(())
    }
}

impl Service {
    /// Schedules a request if a new server appeared, since it has another scene.
    fn update_servers(&mut self, servers: BTreeSet<SourceId>) {
        if servers.difference(&self.servers).next().is_some() {
            (self.is_due, self.due_at, self.timeout) = (true, Instant::now(), TIMEOUT);
        }
        self.servers = servers;
    }

    fn postpone(&mut self) {
        self.due_at = Instant::now() + self.timeout;
        self.timeout = (2 * self.timeout).min(LONGEST_TIMEOUT);
    }

    /// Sends a request and has the response applied. If a change was received meanwhile, it may be newer: then the
    /// response is discarded and requested again.
    async fn request(&mut self, context: RequestContext<'_>) -> Result<(), String> {
        let changes = context.sender.object_changes();
        let components = PlanningSceneComponents { components: EVERYTHING };
        let response = self.client.call(GetPlanningSceneRequest { components }, self.timeout);
        let scene = future::or(response, self.another_server(context)).await?.scene;
        if scene.robot_model_name.is_empty() {
            return Err(format!("{} returns a scene without a robot: it has none yet", self.name));
        }
        if scene.is_diff {
            return Err(format!("{} returned changes, not the whole scene", self.name));
        }
        if context.sender.object_changes() != changes {
            return Ok(());
        }
        context.sender.note_update(Instant::now());
        if !context.sender.apply(context.sender.scene(SceneSource::GetPlanningScene, scene)).await {
            return Err(format!("not all of the scene of {} was applied", self.name));
        }
        log::info!("planning_scene_service: the scene of {} was received", self.name);
        (self.is_due, self.timeout) = (false, TIMEOUT);
        Ok(())
    }

    /// Waits until the set of servers differs from the one that was called.
    async fn another_server<T>(&self, context: RequestContext<'_>) -> Result<T, String> {
        while context.middleware.servers_elsewhere(&self.name) == self.servers {
            Timer::after(PERIOD).await;
        }
        Err(format!("the servers of {} have changed since the request", self.name))
    }
}
