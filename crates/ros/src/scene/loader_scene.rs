//! Stores the current scene, applies messages and sensor data to it, and responds to clients that wait for a change.

mod clouds;
mod incomplete;

use std::collections::{BTreeMap, HashSet, VecDeque};
use std::sync::Arc;
use std::time::Duration;

use clearance_geometry::math::Extremes;
use clearance_monitor::cloud::SelfFilter;
use clearance_monitor::{Now, Observation, Time, WorldSource};
use clearance_robot::RobotModel;
use clearance_scene::{
    DroppedParts, GapSubject, OCTOMAP, ObstacleTwist, Scene, SceneContext, SceneRejection, SceneUpdate,
};
use ros2_interfaces_jazzy_serde::octomap_msgs::msg::OctomapWithPose;
use smol::channel::Sender;

use crate::log_rate_limiter::LogRateLimiter;
use crate::monitor_events::cloud_report::CloudReports;
use crate::parameters::parameter_set::Parameters;
use crate::recording::step::SceneSource;
use crate::scene::cloud_inbox::delay_of;
use crate::scene::cloud_topic_status::CloudTopicStatus;
use crate::scene::file_obstacles::FileObstacles;
use crate::scene::lost_messages::LostMessages;
use crate::scene::missing_objects::MissingObjects;
use crate::scene::scene_command::SceneCommand;
use crate::scene::scene_update_context::SceneUpdateContext;
use crate::scene::whole_scene::WholeScene;

/// Maximum number of commands that wait for a robot; later ones are rejected.
const WAITING: usize = 1000;

/// Maximum number of reported rejections per message.
const MOST_LISTED: usize = 20;

/// Name of the octomap as a world source.
pub const OCTOMAP_SOURCE: &str = OCTOMAP;

/// Where an octomap came from.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
enum OctomapOrigin {
    /// A topic of octomaps, or a file.
    #[default]
    Sensor,
    /// A scene.
    Scene,
}

impl OctomapOrigin {
    fn of(source: &str) -> Self {
        let topics = [SceneSource::OctomapBinary, SceneSource::OctomapFull];
        if topics.iter().any(|topic| topic.name() == source) { Self::Sensor } else { Self::Scene }
    }
}

/// Observation, origin and usability of the octomap.
#[derive(Default)]
struct OctomapState {
    /// Last observation of the octomap; `None` if none was received since it was cleared.
    seen: Option<Observation>,
    /// Stamp of the last octomap, and the topic that it was received on.
    of_topic: Option<(String, Time)>,
    /// Whether the octomap was dropped, and must be received again.
    is_missing: bool,
    /// Where the octomap in use came from.
    in_use: OctomapOrigin,
    /// Where the last octomap came from, which may have been rejected.
    last: OctomapOrigin,
    /// Whether the current octomap contains any known space.
    shows_environment: bool,
    /// Why the last octomap of a topic shows nothing of the environment; `None` if it is usable.
    why_blind: Option<String>,
}

/// Stores the scene; owned by the loader's thread.
#[derive(Default)]
pub struct LoaderScene {
    pub state: Scene,
    pub octomap: Option<Arc<OctomapWithPose>>,
    octomap_state: OctomapState,
    clouds: BTreeMap<String, CloudTopicStatus>,
    filter: Option<SelfFilter>,
    /// Orders that arrived before there was a robot.
    waiting: VecDeque<SceneCommand>,
    /// Rejected parts of the last message that changed the scene, or was intended to.
    faults: Vec<String>,
    /// Parts of the scene that are not valid for the new robot; cleared by the next complete scene.
    invalid_parts: Vec<String>,
    /// Objects that the previous robot held and the new one cannot; cleared by the next complete scene.
    dropped_objects: Vec<String>,
    /// Failure of a whole update; cleared by the next complete scene.
    failure: Option<String>,
    /// Parts of the last message that were intended to change the scene, but have no effect.
    ineffective: Vec<String>,
    missing: MissingObjects,
    lost: LostMessages,
    /// Warnings about publishers of the world's topics from which the node cannot receive.
    unreceivable: Vec<String>,
    /// Rate limiter for messages with faults.
    rate_limiter: LogRateLimiter,
    /// Sources whose data was removed because it was too old.
    dropped: Vec<String>,
    whole: WholeScene,
    of_files: FileObstacles,
    /// Whether a message or a sensor has changed the scene since the start.
    is_changed: bool,
    waiting_clients: Vec<(Sender<bool>, bool)>,
}

impl LoaderScene {
    /// Whether the scene still comes only from the files.
    #[must_use]
    pub fn is_unchanged(&self) -> bool {
        !self.is_changed
    }

    /// Restores an earlier scene, because the checker of the new one could not be built.
    pub fn restore(&mut self, scene: &Scene, fault: &str) {
        self.restore_scene(scene.clone());
        self.note_failure(fault);
    }

    /// Restores an earlier scene, because a new robot was rejected.
    pub fn restore_scene(&mut self, scene: Scene) {
        self.state = scene;
        self.whole.restore();
        self.lost.restore();
        for (_, succeeded) in &mut self.waiting_clients {
            *succeeded = false;
        }
    }

    /// Sets the service that is queried for the whole scene, from the parameters.
    pub fn set_required_service(&mut self, service: &str) {
        self.whole.set_service(service);
    }

    /// Counts commands of these topics as lost, because the robot that they waited for was rejected.
    pub fn count_as_lost(&mut self, topics: &[&'static str]) {
        // states come again
        for topic in topics.iter().filter(|topic| **topic != SceneSource::ObstacleStates.name()) {
            self.lost.note(topic, 1);
        }
    }

    /// Adapts the scene to a new robot.
    pub fn adapt_to(&mut self, robot: &RobotModel) {
        let DroppedParts { dropped, warnings } = self.state.adapt_to_robot(robot);
        for warning in dropped.iter().chain(&warnings) {
            log::warn!("{warning}");
        }
        self.dropped_objects.extend(dropped);
        self.dropped_objects.truncate(MOST_LISTED);
        self.invalid_parts = warnings.into_iter().take(MOST_LISTED).collect();
    }

    /// Frees the data that was built for the previous robot.
    pub fn release_robot(&mut self) {
        self.filter = None;
    }

    /// Stores a command until there is a robot.
    pub fn store(&mut self, mut command: SceneCommand) {
        if let Some(unreceivable) = command.unreceivable.take() {
            // these need no robot
            self.unreceivable = unreceivable;
        } else if command.is_waited_for() {
            log::warn!("{}: there is no robot model yet", command.source);
            if let Some(update) = &command.update {
                self.missing.note_unused(command.source, update, "there was no robot model yet");
            }
            if let Some(done) = command.done {
                let _ = done.try_send(false);
            }
        } else if let Some(SceneUpdate::States(states)) = &command.update {
            // the newest state of each obstacle suffices
            let names: HashSet<&str> = states.states.iter().map(|state| state.id.as_str()).collect();
            let is_needed = |update: &SceneUpdate| match update {
                SceneUpdate::States(earlier) => {
                    earlier.states.iter().any(|state| !names.contains(state.id.as_str()))
                }
                _ => true,
            };
            self.waiting.retain(|waiting| waiting.update.as_ref().is_none_or(is_needed));
            self.waiting.push_back(command);
            self.waiting.truncate(WAITING);
        } else if self.waiting.len() < WAITING {
            self.waiting.push_back(command);
        } else {
            log::warn!("{}: dropped: {WAITING} messages wait for a robot model already", command.source);
            self.lost.note(command.source, 1);
        }
    }

    /// Takes the stored commands.
    pub fn take_waiting(&mut self) -> impl Iterator<Item = SceneCommand> + use<> {
        std::mem::take(&mut self.waiting).into_iter()
    }

    /// Applies a message to the scene; returns whether the scene changed.
    pub fn apply(
        &mut self,
        command: SceneCommand,
        robot: &Arc<RobotModel>,
        update_context: &SceneUpdateContext,
    ) -> bool {
        let SceneCommand {
            source, mut update, mut rejections, lost, mut octomap, unreceivable, done, ..
        } = command;
        if let Some(unreceivable) = unreceivable {
            self.unreceivable = unreceivable;
            return false;
        }
        self.lost.note(source, lost);
        let late = self.late_octomap(source, update.as_ref(), octomap.as_ref(), update_context.now);
        if let Some(rejection) = late {
            rejections.push(rejection);
            (update, octomap) = (None, None);
        }
        if octomap.is_some() || rejections.iter().any(is_of_octomap) {
            self.octomap_state.last = OctomapOrigin::of(source);
        }
        if let Some(update) = &mut update {
            self.keep_octomap(source, update);
        }
        if self.check_blindness(source, update.as_ref()) && update_context.parameters.blind_makes_unknown() {
            // the last map that showed something stays in use
            self.octomap_state.seen = octomap.take().map(|(_, observation)| observation);
            self.octomap_state.of_topic = self.octomap_state.seen.map(|seen| (source.to_owned(), seen.stamp));
            update = None;
        }
        let before = self.state.world.obstacle_by_name(OCTOMAP).cloned();
        let of_files = update.as_ref().map(|update| self.of_files.exposed_to(update, &self.state));
        let (mut changed, mut warnings) = (false, Vec::new());
        if let Some(update) = &update {
            let checked_state = update_context.checked_state(robot);
            let poses = checked_state.as_ref().map(|e| &e.poses);
            let SceneUpdateContext { now, parameters, transforms, .. } = update_context;
            let context = SceneContext::new(robot, poses, transforms, now.ros, parameters.transform_ttl)
                .at_configuration(checked_state.as_ref().map(|e| &e.configuration));
            let applied = self.state.apply(update, &context);
            changed = applied.changed;
            rejections.extend(applied.refusals);
            self.ineffective = applied.ineffective.iter().map(|text| format!("{source}: {text}")).collect();
            warnings.extend_from_slice(&self.ineffective);
            warnings.extend(applied.warnings.iter().map(|warning| format!("{source}: {warning}")));
        }
        let after = self.state.world.obstacle_by_name(OCTOMAP);
        let is_same = before.is_some() && after.zip(before.as_ref()).is_some_and(|(a, b)| Arc::ptr_eq(a, b));
        if !is_same {
            self.note_octomap(source, octomap, &rejections, update.as_ref());
        }
        // each of them is logged once, whatever the rate of the messages
        for warning in of_files.iter().flat_map(|before| before.removed_from(&self.state, source)) {
            log::warn!("{warning}");
        }
        self.note_rejections(source, &rejections, update.as_ref());
        if let Some(update) = &update {
            self.whole.on_update(update, source);
            self.lost.on_update(update);
            if update.is_whole() {
                self.invalid_parts.clear();
            }
            if update.is_whole_of_robot() {
                self.dropped_objects.clear();
                self.failure = None;
            }
        }
        warnings.extend_from_slice(&self.faults);
        if !warnings.is_empty() && self.rate_limiter.admit(update_context.now.steady) {
            for warning in warnings {
                log::warn!("{warning}");
            }
        }
        self.is_changed |= changed;
        if let Some(done) = done {
            self.waiting_clients.push((done, rejections.is_empty()));
        }
        changed
    }

    /// Replaces the scene from files for another robot. Obstacles keep their poses in the environment.
    pub fn replace_scene(
        &mut self,
        mut state: Scene,
        robot: &Arc<RobotModel>,
        update_context: &SceneUpdateContext,
    ) {
        let SceneUpdateContext { now, parameters, transforms, .. } = update_context;
        let context = SceneContext::new(robot, None, transforms, now.ros, parameters.transform_ttl);
        state.keep_anchors_of(&self.state, &context);
        self.of_files = FileObstacles::of(&state);
        self.state = state;
    }

    /// Moves the obstacles to the current poses of their frames; returns whether any has moved.
    pub fn follow_frames(&mut self, robot: &Arc<RobotModel>, update_context: &SceneUpdateContext) -> bool {
        let SceneUpdateContext { now, parameters, transforms, .. } = update_context;
        let context = SceneContext::new(robot, None, transforms, now.ros, parameters.transform_ttl);
        self.state.follow_anchor_frames(&context)
    }

    /// Keeps the octomap of a sensor or of a file when another node publishes a whole scene without one: that node
    /// does not know it. A map of a sensor that was rejected stays missed. As in `MoveIt`, the octomap of an earlier scene
    /// is removed.
    fn keep_octomap(&self, source: &str, update: &mut SceneUpdate) {
        let SceneUpdate::Scene(scene) = update else { return };
        let has_octomap = self.octomap.is_some() || self.state.file_octree().is_some();
        let is_of_sensor = self.octomap_state.last == OctomapOrigin::Sensor
            || has_octomap && self.octomap_state.in_use == OctomapOrigin::Sensor;
        if source == SceneSource::PlanningScene.name() && is_of_sensor {
            scene.keeps_octomap |= scene.world.octomap.is_none();
        }
    }

    /// Stores a new octomap, or that there is none.
    fn note_octomap(
        &mut self,
        source: &str,
        octomap: Option<(OctomapWithPose, Observation)>,
        rejections: &[SceneRejection],
        update: Option<&SceneUpdate>,
    ) {
        if rejections.iter().any(is_of_octomap) {
            return;
        }
        let Some(update) = update.filter(|update| update.changes_octomap()) else { return };
        self.dropped.retain(|name| name != OCTOMAP_SOURCE);
        self.octomap_state.is_missing = false;
        self.octomap_state.shows_environment = octomap.is_some() && update.has_known_cells();
        self.octomap_state.seen = octomap.as_ref().map(|(_, observation)| *observation);
        let is_of_topic = matches!(update, SceneUpdate::Octomap(_));
        let of_topic = self.octomap_state.seen.filter(|_| is_of_topic);
        self.octomap_state.of_topic = of_topic.map(|seen| (source.to_owned(), seen.stamp));
        self.octomap_state.in_use = OctomapOrigin::of(source);
        self.octomap = octomap.filter(|(map, _)| !map.octomap.data.is_empty()).map(|(map, _)| Arc::new(map));
    }

    /// Rejects an octomap that is older than the last one of its topic, as of a second sensor: the newer one remains.
    fn late_octomap(
        &self,
        source: &str,
        update: Option<&SceneUpdate>,
        octomap: Option<&(OctomapWithPose, Observation)>,
        now: Now,
    ) -> Option<SceneRejection> {
        let (_, observation) = octomap.filter(|_| matches!(update, Some(SceneUpdate::Octomap(_))))?;
        let (_, last) = self.octomap_state.of_topic.as_ref().filter(|(topic, _)| topic == source)?;
        let delay = delay_of(observation.stamp, *last, now)?;
        Some(SceneRejection::of_octomap(format!(
            "octomap: header.stamp is {delay:.3} s older than that of the last octomap, which remains; give the node the maps of one \
             publisher"
        )))
    }

    /// Records and returns whether the octomap of a topic shows nothing, after one that showed something, also one of a
    /// file. A scene message that removes the map is intended, and not counted.
    fn check_blindness(&mut self, source: &str, update: Option<&SceneUpdate>) -> bool {
        let Some(update) = update.filter(|update| update.changes_octomap()) else { return false };
        let is_of_sensor = matches!(update, SceneUpdate::Octomap(Some(_)));
        let has_file_octree = self.state.file_octree().is_some();
        let showed_environment =
            self.octomap_state.shows_environment || self.octomap_state.why_blind.is_some() || has_file_octree;
        let is_blind = is_of_sensor && !update.has_known_cells() && showed_environment;
        let cause = || {
            let hint = "; if the octree of the world files is to stay, remap this topic";
            let hint = if has_file_octree { hint } else { "" };
            format!("the octree of {source} has no leaf, neither occupied nor free{hint}")
        };
        self.octomap_state.why_blind = is_blind.then(cause);
        is_blind
    }

    fn note_rejections(&mut self, source: &str, rejections: &[SceneRejection], update: Option<&SceneUpdate>) {
        self.missing.on_message(source, update, rejections);
        self.missing.close_released(&self.state.world);
        self.faults =
            rejections.iter().take(MOST_LISTED).map(|rejection| format!("{source}: {rejection}")).collect();
        if rejections.len() > MOST_LISTED {
            self.faults.push(format!("{source}: and {} more faults", rejections.len() - MOST_LISTED));
        }
    }

    /// Whether a client waits until a change is in use.
    #[must_use]
    pub fn has_waiting_clients(&self) -> bool {
        !self.waiting_clients.is_empty()
    }

    /// Responds to the clients whose changes are now in use.
    pub fn respond(&mut self) {
        for (done, succeeded) in self.waiting_clients.drain(..) {
            // an error means that the client has gone
            let _ = done.try_send(succeeded);
        }
    }

    /// Removes data that is too old, if the parameters select this; returns whether anything changed.
    pub fn drop_stale(&mut self, now: Now, parameters: &Parameters) -> bool {
        let dropped = self.dropped.len();
        let is_watched =
            |name: &String| name == OCTOMAP_SOURCE || parameters.point_cloud_topics.contains(name);
        self.dropped.retain(is_watched);
        let mut changed = self.dropped.len() < dropped;
        if !parameters.drops_stale_sources() {
            changed |= !self.dropped.is_empty();
            self.miss_dropped();
            return changed;
        }
        for source in self.watched(parameters) {
            if source.seen.is_none() || source.freshness(now).is_ok() || self.dropped.contains(&source.name) {
                continue;
            }
            log::warn!("what '{}' saw is dropped: it is older than {} s", source.name, source.ttl);
            if source.name == OCTOMAP_SOURCE {
                self.octomap = None;
                self.state.remove_octomap();
            } else {
                self.state.remove_sensed(&source.name);
            }
            self.dropped.push(source.name);
            changed = true;
        }
        changed
    }

    /// Counts dropped data as never received, so that the world is unknown until new data arrives.
    fn miss_dropped(&mut self) {
        for name in std::mem::take(&mut self.dropped) {
            if name == OCTOMAP_SOURCE {
                self.octomap_state.is_missing = true;
            } else if let Some(cloud) = self.clouds.get_mut(&name) {
                cloud.seen = None;
            }
        }
    }

    /// Time until the next removal, if no new data arrives.
    #[must_use]
    pub fn time_to_drop(&self, now: Now, parameters: &Parameters) -> Option<Duration> {
        if !parameters.drops_stale_sources() {
            return None;
        }
        let waiting = self.watched(parameters).into_iter().filter(|s| !self.dropped.contains(&s.name));
        let left = waiting.filter_map(|source| Some((source.ttl - source.age(now)?).greater(0.0)));
        let left = left.fold(f64::INFINITY, f64::lesser);
        Some(Duration::try_from_secs_f64(left).ok()? + Duration::from_millis(1))
    }

    /// Sources whose data expires.
    fn watched(&self, parameters: &Parameters) -> Vec<WorldSource> {
        let cloud = |topic: &String| WorldSource {
            name: topic.clone(),
            seen: self.clouds.get(topic).and_then(|cloud| cloud.seen),
            ttl: parameters.point_cloud_ttl,
        };
        let expires = self.octomap_state.seen.is_some() && parameters.octomap_ttl > 0.0;
        // the octree of a file does not expire
        let is_of_file = self.state.file_octree().is_some();
        let octomap = (!is_of_file && (expires || self.octomap_state.is_missing)).then(|| WorldSource {
            name: OCTOMAP_SOURCE.to_owned(),
            seen: self.octomap_state.seen.filter(|_| !self.octomap_state.is_missing),
            ttl: parameters.octomap_ttl,
        });
        parameters.point_cloud_topics.iter().map(cloud).chain(octomap).collect()
    }

    /// Sources that must be fresh for the world to count as known.
    #[must_use]
    pub fn sources(&self, parameters: &Parameters) -> Vec<WorldSource> {
        let mut watched = self.watched(parameters);
        watched.retain(|source| !self.dropped.contains(&source.name));
        watched.extend(self.whole.awaited(parameters));
        let limits = parameters.obstacle_limits();
        let may_move = |twist: &&ObstacleTwist| twist.moves() || limits.of(&twist.name).acceleration > 0.0;
        watched.extend(self.state.obstacle_twists().filter(may_move).map(|twist| WorldSource {
            name: format!("{} of {}", SceneSource::ObstacleStates.name(), twist.name),
            seen: Some(Observation { stamp: twist.stamp, at: twist.received }),
            ttl: parameters.obstacle_state_ttl,
        }));
        watched
    }

    /// Warnings about sources whose data was removed.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        let warning = |name: &String| {
            format!("what '{name}' saw was dropped, because it was too old: it is not avoided any more")
        };
        self.dropped.iter().map(warning).collect()
    }

    /// Records that the received data is now in use.
    pub fn note_in_use(&mut self) -> CloudReports {
        self.whole.note_in_use();
        self.lost.note_in_use();
        for cloud in self.clouds.values_mut() {
            if let Some(since) = cloud.since.take() {
                cloud.report.latency = since.elapsed();
            }
        }
        self.clouds.iter().map(|(topic, cloud)| (topic.clone(), cloud.report.clone())).collect()
    }
}

/// Whether a part was rejected that is about the octomap.
fn is_of_octomap(rejection: &SceneRejection) -> bool {
    rejection.gap.as_ref().is_some_and(|gap| gap.subject == GapSubject::Octomap)
}
