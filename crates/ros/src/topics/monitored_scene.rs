//! Publisher of `monitored_planning_scene`: first all of the scene, then its changes.
//!
//! A scene that does not fit into one message is published as differences that add up to it. A whole scene with a
//! part of the objects would remove the others from the worlds of subscriptions.

mod scene_content;

use std::collections::BTreeSet;
use std::sync::Arc;

use clearance_scene::AllowedCollisionMatrix as Matrix;
use clearance_scene::{AttachedObject, Obstacle};
use ros2_interfaces_jazzy_serde::moveit_msgs::msg::{
    AllowedCollisionMatrix, AttachedCollisionObject, PlanningScene, PlanningSceneComponents,
};

use crate::dds::middleware::Middleware;
use crate::dds::middleware_error::MiddlewareError;
use crate::dds::publisher::Publisher;
use crate::dds::quality::Quality;
use crate::dds::type_name::TypeName;
use crate::names::Names;
use crate::scene::active_scene::ActiveScene;
use crate::scene::scene_message_writer::{SceneMessages, is_representable, removed_frame, scene_message};
use crate::topics::monitored_scene::scene_content::{
    LONGEST, SceneContent, attached_size, fits, matrix_size, object_size,
};

/// Number of messages that are kept for later subscriptions.
const KEPT: usize = 100;

/// Maximum number of differences between two publications of all of the scene.
const DIFFERENCES: usize = 80;

/// Number of names in scenes that were not published completely above which earlier ones are forgotten.
const MOST_UNCERTAIN: usize = 20_000;

/// Components of a whole scene. Octomaps and clouds are too large and are not published.
const EVERYTHING: u32 = PlanningSceneComponents::SCENE_SETTINGS
    | PlanningSceneComponents::TRANSFORMS
    | PlanningSceneComponents::ROBOT_STATE_ATTACHED_OBJECTS
    | PlanningSceneComponents::ALLOWED_COLLISION_MATRIX
    | PlanningSceneComponents::LINK_PADDING_AND_SCALING
    | PlanningSceneComponents::WORLD_OBJECT_GEOMETRY;

/// Publishes every change of the scene.
pub struct MonitoredScene {
    publisher: Publisher<PlanningScene>,
    /// The last published scene; `None` at first, and after a message was dropped.
    last: Option<Arc<ActiveScene>>,
    /// Names of all that subscriptions may have after a message was dropped.
    uncertain: UncertainNames,
    /// Number of messages of the last publication of all of the scene.
    complete: usize,
    /// Number of differences since then.
    since_complete: usize,
}

/// Names in a scene that subscriptions have.
#[derive(Debug, Default)]
pub struct KnownNames<'s> {
    objects: Vec<&'s str>,
    attached: Vec<&'s str>,
    frames: Vec<&'s str>,
}

/// Names in scenes of which some messages were dropped.
#[derive(Debug, Default)]
struct UncertainNames {
    objects: BTreeSet<String>,
    attached: BTreeSet<String>,
    frames: BTreeSet<String>,
}

impl MonitoredScene {
    pub fn open(middleware: &Middleware, names: &Names) -> Result<Self, MiddlewareError> {
        let kind = TypeName::new("moveit_msgs", "PlanningScene");
        let name = names.resolve("monitored_planning_scene")?;
        let publisher = middleware.publisher(&name, kind, Quality::Kept)?;
        let uncertain = UncertainNames::default();
        Ok(Self { publisher, last: None, uncertain, complete: 0, since_complete: 0 })
    }

    /// Publishes the changes of a scene since the last call.
    pub fn publish(&mut self, scene: &Arc<ActiveScene>) {
        let before = self.last.take();
        let messages = self.messages(before.as_deref(), scene);
        // a later message may remove what a dropped one replaces
        if messages.into_iter().all(|message| self.publisher.publish(message)) {
            self.last = Some(Arc::clone(scene));
            return;
        }
        log::warn!(
            "monitored_planning_scene: a change was dropped, because a subscription does not keep up: the next \
             change publishes all of the scene"
        );
        if let Some(before) = before {
            self.uncertain = UncertainNames::default();
            self.uncertain.add(&before);
        }
        self.uncertain.add(scene);
    }

    /// The changes of a scene, or from time to time all of it.
    fn messages(&mut self, before: Option<&ActiveScene>, scene: &ActiveScene) -> Vec<PlanningScene> {
        if let Some(before) = before.filter(|before| is_of_same_robot(before, scene)) {
            let messages = differences(before, scene);
            if self.since_complete + messages.len() <= most_differences(self.complete) {
                self.since_complete += messages.len();
                return messages;
            }
        }
        let known = before.map_or_else(|| self.uncertain.names(), KnownNames::of);
        let messages = complete(&known, before, scene);
        (self.complete, self.since_complete) = (messages.len(), 0);
        messages
    }
}

impl<'s> KnownNames<'s> {
    /// Those of a scene that was published.
    #[must_use]
    pub fn of(scene: &'s ActiveScene) -> Self {
        let (world, frames) = (&scene.scene.world, &scene.scene.fixed_frames);
        let objects = world.obstacles().filter(|object| is_representable(object));
        Self {
            objects: objects.map(|object| object.name.as_str()).collect(),
            attached: world.attached().iter().map(|object| object.name.as_str()).collect(),
            frames: frames.keys().map(String::as_str).collect(),
        }
    }
}

impl UncertainNames {
    /// Adds the names in a scene. When there are too many, earlier ones are forgotten: subscriptions then keep objects
    /// that are gone.
    fn add(&mut self, scene: &ActiveScene) {
        if self.objects.len() + self.attached.len() + self.frames.len() > MOST_UNCERTAIN {
            *self = Self::default();
        }
        let KnownNames { objects, attached, frames } = KnownNames::of(scene);
        self.objects.extend(objects.into_iter().map(str::to_owned));
        self.attached.extend(attached.into_iter().map(str::to_owned));
        self.frames.extend(frames.into_iter().map(str::to_owned));
    }

    fn names(&self) -> KnownNames<'_> {
        KnownNames {
            objects: self.objects.iter().map(String::as_str).collect(),
            attached: self.attached.iter().map(String::as_str).collect(),
            frames: self.frames.iter().map(String::as_str).collect(),
        }
    }
}

fn is_of_same_robot(a: &ActiveScene, b: &ActiveScene) -> bool {
    a.revision.model == b.revision.model
}

/// Maximum number of differences after a publication of all of the scene in `complete` messages. A later
/// subscription receives both, unless the scene takes more than half of the messages that are kept.
fn most_differences(complete: usize) -> usize {
    let left = KEPT.saturating_sub(complete);
    if left < KEPT / 2 { DIFFERENCES } else { DIFFERENCES.min(left) }
}

/// All of the scene: a whole scene if it fits into one message, otherwise differences. `known`: names that
/// subscriptions may have; `last`: the scene that they have, if it is known.
pub fn complete(known: &KnownNames, last: Option<&ActiveScene>, scene: &ActiveScene) -> Vec<PlanningScene> {
    let writer = writer(scene);
    let whole = scene_message(&writer, EVERYTHING);
    if fits(&whole) {
        return vec![whole];
    }
    let last = last.filter(|last| is_of_same_robot(last, scene));
    let is_unchanged =
        |object: &Obstacle| last.is_some_and(|last| differs_at_most_in_pose(last, scene, object));
    let objects = writer.objects().zip(whole.world.collision_objects).map(|(object, message)| {
        let is_too_large = object_size(&message) > LONGEST;
        if is_too_large && is_unchanged(object) { writer.move_message(object) } else { message }
    });
    // subscriptions that have large parts from a service keep them
    let is_held = |object: &AttachedCollisionObject| {
        let held = |of: &ActiveScene| of.scene.world.attached_by_name(&object.object.id).cloned();
        last.and_then(held).zip(held(scene)).is_some_and(|(before, now)| Arc::ptr_eq(&before, &now))
    };
    let mut attached = whole.robot_state.attached_collision_objects;
    attached.retain(|object| attached_size(object) <= LONGEST || !is_held(object));
    let is_told = last.is_some_and(|last| last.scene.matrix == scene.scene.matrix);
    let matrix = Some(whole.allowed_collision_matrix).filter(|m| matrix_size(m) <= LONGEST || !is_told);
    let mut content = removals(known, scene);
    content.frames.extend(whole.fixed_frame_transforms);
    let content = SceneContent {
        robot_model_name: whole.robot_model_name,
        attached,
        objects: objects.collect(),
        matrix: matrix.unwrap_or_default(),
        link_padding: whole.link_padding,
        link_scale: whole.link_scale,
        ..content
    };
    content.into_differences()
}

/// Messages with the differences between two scenes; none if the scenes are equal.
pub fn differences(before: &ActiveScene, after: &ActiveScene) -> Vec<PlanningScene> {
    let writer = writer(after);
    let mut content = removals(&KnownNames::of(before), after);
    let is_known =
        |o: &&Arc<AttachedObject>| before.scene.world.attached().iter().any(|known| Arc::ptr_eq(known, o));
    let attached = after.scene.world.attached().iter().filter(|object| !is_known(object));
    content.attached = attached.map(|object| writer.attached_message(object)).collect();
    if before.scene.matrix != after.scene.matrix {
        content.matrix = writer.matrix();
    }
    let sizes = |scene: &ActiveScene| {
        (scene.scene.link_padding.clone(), scene.scene.link_scale.clone(), scene.parameters.padding)
    };
    if sizes(before) != sizes(after) {
        (content.link_padding, content.link_scale) = writer.link_sizes();
    }
    if before.scene.fixed_frames != after.scene.fixed_frames {
        content.frames.extend(writer.fixed_frames());
    }
    let changed = |object: &Obstacle| match before.scene.world.obstacle_by_name(&object.name) {
        Some(known) if std::ptr::eq(known.as_ref(), object) => None,
        _ if differs_at_most_in_pose(before, after, object) => Some(writer.move_message(object)),
        _ => Some(writer.object_message(object)),
    };
    content.objects = writer.objects().filter_map(changed).collect();
    content.into_differences()
}

/// Removals of the parts that subscriptions may have and a scene does not.
fn removals(known: &KnownNames, scene: &ActiveScene) -> SceneContent {
    let world = &scene.scene.world;
    let is_held = |name: &str| world.attached_by_name(name).is_some();
    let is_object = |name: &str| world.obstacle_by_name(name).is_some_and(|object| is_representable(object));
    let owned = |name: &&str| (*name).to_owned();
    // a detached object stays in a subscriber's world, until it is removed there
    let held = known.attached.iter().filter(|name| !known.objects.contains(name));
    let in_world = known.objects.iter().chain(held);
    let removed: Vec<String> =
        in_world.filter(|name| !is_object(name) && !is_held(name)).map(owned).collect();
    let frames = known.frames.iter().filter(|name| !scene.scene.fixed_frames.contains_key(**name));
    SceneContent {
        detached: known.attached.iter().filter(|name| !is_held(name)).map(owned).collect(),
        matrix_after_removals: matrix_after_removals(scene, &removed),
        removed,
        frames: frames.map(|name| removed_frame(name)).collect(),
        ..SceneContent::default()
    }
}

/// The matrix, if the scene keeps entries of removed objects; otherwise one without names. A world keeps them when
/// another world without the object replaces it. Subscriptions receive a removal, which takes the entries away.
fn matrix_after_removals(scene: &ActiveScene, removed: &[String]) -> AllowedCollisionMatrix {
    let writer = writer(scene);
    let matrix = || scene.scene.matrix.clone().unwrap_or_else(|| Matrix::of_robot(writer.robot));
    let is_kept = |matrix: Matrix| removed.iter().any(|name| matrix.has_entries(name));
    if removed.is_empty() || !is_kept(matrix()) {
        return AllowedCollisionMatrix::default();
    }
    writer.matrix()
}

/// Whether an object of a scene has at most moved since another scene. Copies of an object share their shapes.
fn differs_at_most_in_pose(before: &ActiveScene, after: &ActiveScene, object: &Obstacle) -> bool {
    let kind = |scene: &ActiveScene| scene.scene.kinds.get(&object.name).cloned().unwrap_or_default();
    before.scene.world.obstacle_by_name(&object.name).is_some_and(|known| {
        Arc::ptr_eq(&known.shapes, &object.shapes) && known.subframes == object.subframes
    }) && kind(before) == kind(after)
}

fn writer(scene: &ActiveScene) -> SceneMessages<'_> {
    SceneMessages {
        robot: scene.revision.checker.robot(),
        scene: &scene.scene,
        padding: scene.parameters.padding,
        configuration: None,
        octomap: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_later_subscription_receives_all_of_the_scene_and_all_changes_after_it() {
        for complete in 1..=KEPT / 2 {
            let differences = most_differences(complete);
            assert!(complete + differences <= KEPT && differences >= KEPT / 2, "{complete}");
        }
        // larger scenes are published as often as small ones
        for complete in [KEPT / 2 + 1, KEPT, 3 * KEPT] {
            assert_eq!(most_differences(complete), DIFFERENCES);
        }
    }
}
