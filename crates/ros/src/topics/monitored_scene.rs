//! Publisher of `monitored_planning_scene`: first the whole scene, then its changes.

use std::collections::HashSet;
use std::sync::Arc;

use clearance_scene::{AttachedObject, Obstacle};
use ros2_interfaces_jazzy_serde::moveit_msgs::msg::{
    CollisionObject, PlanningScene, PlanningSceneComponents,
};

use crate::dds::middleware::Middleware;
use crate::dds::middleware_error::MiddlewareError;
use crate::dds::publisher::Publisher;
use crate::dds::quality::Quality;
use crate::dds::type_name::TypeName;
use crate::names::Names;
use crate::scene::active_scene::ActiveScene;
use crate::scene::scene_message_writer::{SceneMessages, scene_message};

/// Largest message (bytes): `RustDDS` loses messages of more than about 250 kB.
const LONGEST: usize = 200_000;

/// Number of differences published between two whole scenes. A subscription that comes later receives a whole scene and
/// all differences after it.
const DIFFERENCES: usize = 80;

/// Publishes every change of the scene. Octomaps and clouds are too large and are not published.
pub struct MonitoredScene {
    publisher: Publisher<PlanningScene>,
    last: Option<Arc<ActiveScene>>,
    since_whole: usize,
}

impl MonitoredScene {
    pub fn open(middleware: &Middleware, names: &Names) -> Result<Self, MiddlewareError> {
        let kind = TypeName::new("moveit_msgs", "PlanningScene");
        let name = names.resolve("monitored_planning_scene")?;
        let publisher = middleware.publisher(&name, kind, Quality::Kept)?;
        Ok(Self { publisher, last: None, since_whole: 0 })
    }

    /// Publishes the changes of a scene since the last call.
    pub fn publish(&mut self, scene: &Arc<ActiveScene>) {
        let before = self.last.replace(Arc::clone(scene));
        let messages = match before {
            Some(before) if self.since_whole < DIFFERENCES && is_of_same_robot(&before, scene) => {
                let messages = differences(&before, scene);
                self.since_whole += messages.len();
                messages
            }
            _ => {
                self.since_whole = 0;
                whole(scene)
            }
        };
        let published = messages.into_iter().map(|message| self.publisher.publish(message));
        if published.filter(|published| !published).count() > 0 {
            log::warn!(
                "monitored_planning_scene: a change was dropped, because a subscription does not keep up: the next \
                 change publishes the whole scene"
            );
            self.last = None;
        }
    }
}

fn is_of_same_robot(a: &ActiveScene, b: &ActiveScene) -> bool {
    a.revision.model == b.revision.model
}

/// The whole scene without octomaps. Objects that do not fit into the first message follow as differences.
pub fn whole(scene: &ActiveScene) -> Vec<PlanningScene> {
    type C = PlanningSceneComponents;
    let writer = writer(scene);
    let components = C::SCENE_SETTINGS
        | C::TRANSFORMS
        | C::ROBOT_STATE_ATTACHED_OBJECTS
        | C::ALLOWED_COLLISION_MATRIX
        | C::LINK_PADDING_AND_SCALING;
    let first = scene_message(&writer, components);
    let size = first.robot_state.attached_collision_objects.iter().map(|o| size(&o.object)).sum::<usize>()
        + matrix_size(&first);
    let objects = writer.objects().map(|o| writer.object_message(o)).collect();
    split(first, size, objects)
}

/// Messages with the differences between two scenes; none if the scenes are equal.
pub fn differences(before: &ActiveScene, after: &ActiveScene) -> Vec<PlanningScene> {
    let (old, new) = (writer(before), writer(after));
    let mut first = PlanningScene { is_diff: true, ..PlanningScene::default() };
    first.robot_state.is_diff = true;
    let blank = first.clone();
    let attached =
        |o: &&Arc<AttachedObject>| !before.scene.world.attached().iter().any(|known| Arc::ptr_eq(known, o));
    let attached_messages =
        after.scene.world.attached().iter().filter(attached).map(|o| new.attached_message(o));
    let is_detached = |o: &&Arc<AttachedObject>| after.scene.world.attached_by_name(&o.name).is_none();
    let detached = || before.scene.world.attached().iter().filter(is_detached);
    let detachments = detached().map(|o| {
        let mut message = old.attached_message(o);
        message.object =
            CollisionObject { id: o.name.clone(), operation: CollisionObject::REMOVE, ..Default::default() };
        message
    });
    first.robot_state.attached_collision_objects = detachments.chain(attached_messages).collect();
    if before.scene.matrix != after.scene.matrix {
        first.allowed_collision_matrix =
            scene_message(&new, PlanningSceneComponents::ALLOWED_COLLISION_MATRIX).allowed_collision_matrix;
    }
    let sizes = |scene: &ActiveScene| {
        (scene.scene.link_padding.clone(), scene.scene.link_scale.clone(), scene.parameters.padding)
    };
    if sizes(before) != sizes(after) {
        let message = scene_message(&new, PlanningSceneComponents::LINK_PADDING_AND_SCALING);
        (first.link_padding, first.link_scale) = (message.link_padding, message.link_scale);
    }
    if before.scene.fixed_frames != after.scene.fixed_frames {
        first.fixed_frame_transforms =
            scene_message(&new, PlanningSceneComponents::TRANSFORMS).fixed_frame_transforms;
    }
    let published: HashSet<&str> = new.objects().map(|o| o.name.as_str()).collect();
    // a detached object stays in a subscriber's world, until it is removed there
    let known = old.objects().map(|o| &o.name).chain(detached().map(|o| &o.name));
    let removed = known.filter(|name| !published.contains(name.as_str())).map(|name| CollisionObject {
        id: name.clone(),
        operation: CollisionObject::REMOVE,
        ..CollisionObject::default()
    });
    let changed = |o: &Obstacle| match before.scene.world.obstacle_by_name(&o.name) {
        Some(known) if std::ptr::eq(known.as_ref(), o) => None,
        Some(known) if is_same_but_for_pose(known, o) && old.kind(&o.name) == new.kind(&o.name) => {
            Some(new.move_message(o))
        }
        _ => Some(new.object_message(o)),
    };
    let objects = removed.chain(new.objects().filter_map(changed)).collect::<Vec<_>>();
    if first == blank && objects.is_empty() {
        return Vec::new();
    }
    let size = first.robot_state.attached_collision_objects.iter().map(|o| size(&o.object)).sum::<usize>()
        + matrix_size(&first);
    split(first, size, objects)
}

/// Whether an object has at most moved. Copies of an object share their shapes.
fn is_same_but_for_pose(a: &Obstacle, b: &Obstacle) -> bool {
    Arc::ptr_eq(&a.shapes, &b.shapes) && a.subframes == b.subframes
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

/// Splits objects into as many messages as necessary. The first message also has the other fields.
fn split(first: PlanningScene, size_of_first: usize, objects: Vec<CollisionObject>) -> Vec<PlanningScene> {
    let mut messages = vec![first];
    let mut total = size_of_first;
    for mut object in objects {
        let mut bytes = size(&object);
        if bytes > LONGEST {
            log::warn!(
                "monitored_planning_scene: object '{}' is too large: it is published without its shapes",
                object.id
            );
            object.primitives.clear();
            object.primitive_poses.clear();
            object.meshes.clear();
            object.mesh_poses.clear();
            bytes = size(&object);
        }
        if total + bytes > LONGEST {
            let mut next = PlanningScene { is_diff: true, ..PlanningScene::default() };
            next.robot_state.is_diff = true;
            messages.push(next);
            total = 0;
        }
        total += bytes;
        messages.last_mut().expect("there is a first").world.collision_objects.push(object);
    }
    messages
}

/// Upper bound on the size (bytes) of an object in a message.
fn size(object: &CollisionObject) -> usize {
    const POSE: usize = 56;
    const REST: usize = 200;
    let primitives: usize = object.primitives.iter().map(|p| 24 + 8 * p.dimensions.len() + POSE).sum();
    let meshes: usize =
        object.meshes.iter().map(|m| 16 + 12 * m.triangles.len() + 24 * m.vertices.len() + POSE).sum();
    let subframes: usize = object.subframe_names.iter().map(|name| name.len() + 8 + POSE).sum();
    let words =
        object.id.len() + object.header.frame_id.len() + object.type_.key.len() + object.type_.db.len();
    REST + words + primitives + meshes + subframes + object.planes.len() * (32 + POSE)
}

fn matrix_size(scene: &PlanningScene) -> usize {
    let matrix = &scene.allowed_collision_matrix;
    let names: usize =
        matrix.entry_names.iter().chain(&matrix.default_entry_names).map(|n| n.len() + 16).sum();
    names + matrix.entry_names.len() * matrix.entry_names.len()
}
