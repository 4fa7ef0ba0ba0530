//! Applies updates to a scene, as MoveIt 2 does.

use super::{Applied, Scene, SceneContext, SceneUpdate};

impl Scene {
    /// Applies a message; each object and each field is applied completely or not at all. As in `MoveIt`, valid parts are applied even if
    /// others are rejected.
    pub fn apply(&mut self, update: &SceneUpdate, context: &SceneContext) -> Applied {
        let mut applied = Applied::default();
        match update {
            SceneUpdate::Object(object) => {
                let result = self.change_object(object, context, &mut applied.warnings);
                applied.record(result);
            }
            SceneUpdate::Attached(attached) => {
                let result = self.change_attached(attached, context, &mut applied.warnings);
                applied.record(result);
            }
            SceneUpdate::Octomap(octomap) => applied.record(self.set_octomap(octomap.as_ref(), context)),
            SceneUpdate::States(states) => {
                for result in self.set_states(states, context) {
                    applied.record(result);
                }
            }
            SceneUpdate::World(world) => self.replace_world(world, false, context, &mut applied),
            SceneUpdate::Scene(change) => self.change_scene(change, context, &mut applied),
        }
        applied
    }
}
