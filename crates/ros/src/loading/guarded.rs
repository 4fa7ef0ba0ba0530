//! Catches panics of work on untrusted input, so that they do not end the node.

use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::scene::loader_scene::LoaderScene;

/// Applies a scene message; returns true if the scene may have changed.
pub fn guarded_scene(scene: &mut LoaderScene, change: impl FnOnce(&mut LoaderScene) -> bool) -> bool {
    catch_unwind(AssertUnwindSafe(|| change(scene))).unwrap_or_else(|_| {
        const FAULT: &str = "a change of the world failed inside the program; the world may lack it";
        log::error!("{FAULT}");
        scene.note_failure(FAULT);
        true
    })
}

/// Builds from a description, or from the world.
pub fn guarded<T>(what: &str, build: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(build))
        .unwrap_or_else(|_| Err(format!("{what}: reading it failed inside the program")))
}
