//! Splits a scene into messages that are small enough for the network library.

use ros2_interfaces_jazzy_serde::geometry_msgs::msg::TransformStamped;
use ros2_interfaces_jazzy_serde::moveit_msgs::msg::{
    AllowedCollisionMatrix, AttachedCollisionObject, CollisionObject, LinkPadding, LinkScale, PlanningScene,
};

/// Largest message (bytes): `RustDDS` loses messages of more than about 250 kB.
pub const LONGEST: usize = 200_000;

/// Upper bound on the size (bytes) of the fields of an object that have a constant size.
const OBJECT: usize = 200;

/// Upper bound on the size (bytes) of a pose.
const POSE: usize = 56;

/// Upper bound on the size (bytes) of a transform with its header, without names.
const TRANSFORM: usize = 100;

/// Upper bound on the size (bytes) of the length and the padding of a string.
const STRING: usize = 16;

/// Content of differences.
#[derive(Debug, Default)]
pub struct SceneContent {
    /// Name of the robot; may be empty.
    pub robot_model_name: String,
    /// Fixed frames.
    pub frames: Vec<TransformStamped>,
    /// Names of objects that no link holds any more.
    pub detached: Vec<String>,
    /// Objects that links hold.
    pub attached: Vec<AttachedCollisionObject>,
    /// Objects to add and to move.
    pub objects: Vec<CollisionObject>,
    /// Without names, the receivers' matrix does not change.
    pub matrix: AllowedCollisionMatrix,
    /// Paddings (m) of links.
    pub link_padding: Vec<LinkPadding>,
    /// Scale factors of links.
    pub link_scale: Vec<LinkScale>,
    /// Names of objects that are no longer in the world.
    pub removed: Vec<String>,
    /// Matrix to set once these objects are removed; a removal takes entries of the object away.
    pub matrix_after_removals: AllowedCollisionMatrix,
}

impl SceneContent {
    /// As many differences as necessary; none without content.
    ///
    /// After each of them, a subscription has all obstacles that it had before or that replace them. What removes
    /// an object, or can allow its contact, comes last.
    #[must_use]
    pub fn into_differences(self) -> Vec<PlanningScene> {
        let Self { robot_model_name, frames, detached, attached, mut objects, removed, .. } = self;
        let mut packer = Packer::new();
        if !robot_model_name.is_empty() {
            let room = packer.room(STRING + robot_model_name.len());
            room.robot_model_name = robot_model_name;
        }
        if !frames.is_empty() {
            let room = packer.room(frames_size(&frames));
            room.fixed_frame_transforms = frames;
        }
        // until an object is added again, it is where its link released it
        objects.sort_by_key(|object| !detached.contains(&object.id));
        for name in detached {
            packer.add_attached(detachment(name));
        }
        for object in attached {
            packer.add_attached(fitting_attached(object));
        }
        for object in objects {
            packer.add_object(fitting(object));
        }
        packer.set_matrix(self.matrix);
        if !(self.link_padding.is_empty() && self.link_scale.is_empty()) {
            let room = packer.room(link_sizes_size(&self.link_padding, &self.link_scale));
            (room.link_padding, room.link_scale) = (self.link_padding, self.link_scale);
        }
        for name in removed {
            packer.add_object(removal(name));
        }
        if !self.matrix_after_removals.entry_names.is_empty() {
            packer.begin();
            packer.set_matrix(self.matrix_after_removals);
        }
        packer.finish()
    }
}

/// Whether a scene fits into one message.
#[must_use]
pub fn fits(scene: &PlanningScene) -> bool {
    let attached = scene.robot_state.attached_collision_objects.iter().map(attached_size);
    let objects = scene.world.collision_objects.iter().map(object_size);
    let size = attached.chain(objects).sum::<usize>()
        + frames_size(&scene.fixed_frame_transforms)
        + matrix_size(&scene.allowed_collision_matrix)
        + link_sizes_size(&scene.link_padding, &scene.link_scale);
    size <= LONGEST
}

/// Distributes content over differences, in the given order.
struct Packer {
    complete: Vec<PlanningScene>,
    last: PlanningScene,
    /// Size (bytes) of the last difference; zero if it is empty.
    size: usize,
}

impl Packer {
    fn new() -> Self {
        Self { complete: Vec::new(), last: difference(), size: 0 }
    }

    /// Begins another difference, unless the last one is empty.
    fn begin(&mut self) {
        if self.size > 0 {
            self.complete.push(std::mem::replace(&mut self.last, difference()));
            self.size = 0;
        }
    }

    /// The difference for content of this size (bytes).
    fn room(&mut self, size: usize) -> &mut PlanningScene {
        if self.size + size > LONGEST {
            self.begin();
        }
        self.size += size;
        &mut self.last
    }

    fn add_attached(&mut self, object: AttachedCollisionObject) {
        let room = self.room(attached_size(&object));
        room.robot_state.attached_collision_objects.push(object);
    }

    fn add_object(&mut self, object: CollisionObject) {
        self.room(object_size(&object)).world.collision_objects.push(object);
    }

    fn set_matrix(&mut self, matrix: AllowedCollisionMatrix) {
        if !matrix.entry_names.is_empty() {
            let matrix = fitting_matrix(matrix);
            let room = self.room(matrix_size(&matrix));
            room.allowed_collision_matrix = matrix;
        }
    }

    fn finish(mut self) -> Vec<PlanningScene> {
        self.begin();
        self.complete
    }
}

fn difference() -> PlanningScene {
    let mut difference = PlanningScene { is_diff: true, ..PlanningScene::default() };
    difference.robot_state.is_diff = true;
    difference
}

fn removal(id: String) -> CollisionObject {
    CollisionObject { id, operation: CollisionObject::REMOVE, ..CollisionObject::default() }
}

fn detachment(name: String) -> AttachedCollisionObject {
    AttachedCollisionObject { object: removal(name), ..AttachedCollisionObject::default() }
}

/// The object, or its name alone if it is too large for a message: receivers reject an object without shapes, so
/// they know that it is missing.
fn fitting(object: CollisionObject) -> CollisionObject {
    if object_size(&object) <= LONGEST {
        return object;
    }
    warn_of_size(&object.id);
    CollisionObject { id: object.id, operation: object.operation, ..CollisionObject::default() }
}

/// The same for an object that a link holds. For ADD without shapes, receivers would take those of the object in
/// the world; they reject APPEND.
fn fitting_attached(attached: AttachedCollisionObject) -> AttachedCollisionObject {
    if attached_size(&attached) <= LONGEST {
        return attached;
    }
    let id = attached.object.id;
    warn_of_size(&id);
    let object = CollisionObject { id, operation: CollisionObject::APPEND, ..CollisionObject::default() };
    AttachedCollisionObject {
        object,
        link_name: attached.link_name,
        touch_links: attached.touch_links,
        ..AttachedCollisionObject::default()
    }
}

fn warn_of_size(id: &str) {
    log::warn!(
        "monitored_planning_scene: object '{id}' is too large: it is published without its shapes; \
         get_planning_scene has them"
    );
}

/// The matrix, or a name without entries if it is too large for a message: receivers reject it.
fn fitting_matrix(mut matrix: AllowedCollisionMatrix) -> AllowedCollisionMatrix {
    if matrix_size(&matrix) <= LONGEST {
        return matrix;
    }
    log::warn!(
        "monitored_planning_scene: the allowed collision matrix is too large: it is published without its entries; \
         get_planning_scene has them"
    );
    matrix.entry_names.truncate(1);
    AllowedCollisionMatrix { entry_names: matrix.entry_names, ..AllowedCollisionMatrix::default() }
}

/// Upper bound on the size (bytes) of an object in a message.
pub fn object_size(object: &CollisionObject) -> usize {
    let primitives: usize = object.primitives.iter().map(|p| 24 + 8 * p.dimensions.len() + POSE).sum();
    let meshes: usize =
        object.meshes.iter().map(|m| 16 + 12 * m.triangles.len() + 24 * m.vertices.len() + POSE).sum();
    let subframes: usize = object.subframe_names.iter().map(|name| name.len() + 8 + POSE).sum();
    let words =
        object.id.len() + object.header.frame_id.len() + object.type_.key.len() + object.type_.db.len();
    OBJECT + words + primitives + meshes + subframes + object.planes.len() * (32 + POSE)
}

/// The same of an object that a link holds.
pub fn attached_size(attached: &AttachedCollisionObject) -> usize {
    let links: usize = attached.touch_links.iter().map(|link| STRING + link.len()).sum();
    object_size(&attached.object) + attached.link_name.len() + links
}

fn frames_size(frames: &[TransformStamped]) -> usize {
    let names = frames.iter().map(|frame| frame.header.frame_id.len() + frame.child_frame_id.len());
    names.sum::<usize>() + frames.len() * TRANSFORM
}

pub fn matrix_size(matrix: &AllowedCollisionMatrix) -> usize {
    let names: usize =
        matrix.entry_names.iter().chain(&matrix.default_entry_names).map(|name| name.len() + STRING).sum();
    names + matrix.entry_names.len() * matrix.entry_names.len()
}

fn link_sizes_size(padding: &[LinkPadding], scale: &[LinkScale]) -> usize {
    let names =
        padding.iter().map(|entry| &entry.link_name).chain(scale.iter().map(|entry| &entry.link_name));
    names.map(|name| name.len() + STRING + 8).sum()
}
