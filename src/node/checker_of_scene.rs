//! The checker of a robot in a scene, with the settings that scene and parameters make together.

use std::sync::Arc;

use super::parameters::Parameters;
use crate::checker::{CollisionChecker, MeshModel, Settings, open_meshes};
use crate::math::Extremes;
use crate::monitor::scene::PlanningSceneState;
use crate::robot::RobotModel;

/// A checker of a robot in a scene; what a known one of the same robot has in common with it is shared.
pub fn checker_of(
    robot: &Arc<RobotModel>,
    scene: &PlanningSceneState,
    mesh_model: MeshModel,
    parameters: &Parameters,
    known: Option<&CollisionChecker>,
) -> Result<CollisionChecker, String> {
    // a scene that pads less than the parameter takes nothing off it
    let padded = |(link, padding): (&String, &f64)| (link.clone(), padding.greater(parameters.padding));
    let settings = Settings {
        padding: parameters.padding,
        link_padding: scene.link_padding.iter().map(padded).collect(),
        link_scale: scene.link_scale.clone(),
        pad_self: parameters.pad_self,
        mesh_model,
        ..Settings::default()
    };
    let matrix = scene.matrix.as_ref();
    let built = match known.filter(|known| Arc::ptr_eq(known.robot(), robot)) {
        Some(known) => known.with_world(&scene.world, settings, matrix),
        None => CollisionChecker::with_matrix(Arc::clone(robot), &scene.world, settings, matrix),
    };
    built.map_err(|error| error.to_string())
}

/// Warnings about the checks themselves: meshes that are not solid although that was asked for, and no pair to check.
pub fn warnings_of(checker: &CollisionChecker) -> impl Iterator<Item = String> {
    told_solid_in_vain(checker).into_iter().chain(nothing_to_check(checker))
}

fn nothing_to_check(checker: &CollisionChecker) -> Option<String> {
    const NOTHING: &str = "there is no pair to check: every state counts as free";
    checker.pairs().is_empty().then(|| NOTHING.to_owned())
}

/// Meshes that are to be solid and cannot be: nothing inside of them is found.
fn told_solid_in_vain(checker: &CollisionChecker) -> Option<String> {
    const TOLD: usize = 5;
    if checker.settings().mesh_model != MeshModel::Solid {
        return None;
    }
    let mut open = open_meshes(checker.robot(), checker.world());
    let left = open.len().saturating_sub(TOLD);
    open.truncate(TOLD);
    let more = if left > 0 { format!(" and {left} more") } else { String::new() };
    (!open.is_empty()).then(|| {
        let open = open.join(", ");
        format!("not solid, because not closed, and whatever is wholly inside touches nothing: {open}{more}")
    })
}
