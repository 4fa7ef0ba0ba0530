//! Obstacles of world files, and warnings about messages that remove them.

use clearance_robot::quoted_list;
use clearance_scene::{OCTOMAP, Scene, SceneUpdate};

/// Obstacles and attached objects of world files.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FileObstacles {
    has_octree: bool,
    /// Names of all but the octree.
    objects: Vec<String>,
}

impl FileObstacles {
    /// Those of a scene that was read from files.
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        let obstacles = scene.world.obstacles().map(|obstacle| &obstacle.name);
        let attached = scene.world.attached().iter().map(|object| &object.name);
        let objects = obstacles.chain(attached).filter(|name| *name != OCTOMAP).cloned().collect();
        Self { has_octree: scene.file_octree().is_some(), objects }
    }

    /// Those in a scene that an update is about to change, and that it may remove without naming them.
    #[must_use]
    pub fn exposed_to(&self, update: &SceneUpdate, scene: &Scene) -> Self {
        let is_of_all = update.is_whole() || update.removes_all_objects();
        let objects = self.objects.iter().filter(|name| is_of_all && has_object(scene, name));
        Self { has_octree: scene.file_octree().is_some(), objects: objects.cloned().collect() }
    }

    /// Warnings about those that a scene does not contain any more, after a message of `source`.
    #[must_use]
    pub fn removed_from(&self, scene: &Scene, source: &str) -> Vec<String> {
        let mut warnings = Vec::new();
        if self.has_octree && scene.file_octree().is_none() {
            let is_replaced = scene.world.id(OCTOMAP).is_some();
            let verb = if is_replaced { "replaces" } else { "removes" };
            warnings.push(format!("{source}: the message {verb} the octree of the world files"));
        }
        let removed: Vec<String> =
            self.objects.iter().filter(|name| !has_object(scene, name)).cloned().collect();
        if !removed.is_empty() {
            let (count, names) = (removed.len(), quoted_list(&removed));
            warnings.push(format!("{source}: the scene removes {count} obstacles of world files: {names}"));
        }
        warnings
    }
}

fn has_object(scene: &Scene, name: &str) -> bool {
    scene.world.id(name).is_some() || scene.world.attached_by_name(name).is_some()
}
