//! Builds the checker of a robot in a scene from the settings in the scene and in the parameters.

use clearance_checker::{CollisionChecker, SolidMeshRemark, solid_mesh_remarks};
use clearance_robot::{RobotModel, quoted_list};
use clearance_scene::Scene;
use clearance_scene::{MeshModel, Settings, VolumeSelection, VolumeSelectionError};
use std::sync::Arc;

use crate::parameters::parameter_set::Parameters;

/// Checker of a robot in a scene. It shares unchanged data with an existing checker of the same robot.
pub fn checker_of(
    robot: &Arc<RobotModel>,
    scene: &Scene,
    mesh_model: MeshModel,
    parameters: &Parameters,
    known: Option<&CollisionChecker>,
) -> Result<CollisionChecker, String> {
    let (padding, pad_self) = (parameters.padding, parameters.pad_self);
    let mut volumes = volumes_of(parameters)?;
    // no result depends on the volumes: links that the robot does not have change nothing
    volumes.links.retain(|link, _| robot.link_by_name(link).is_some());
    let mut settings =
        Settings { padding, pad_self, mesh_model, volumes, ..Settings::default() }.with_scene(scene);
    // the scene keeps the sizes of links of an earlier robot
    settings.link_padding.retain(|link, _| robot.link_by_name(link).is_some());
    settings.link_scale.retain(|link, _| robot.link_by_name(link).is_some());
    let matrix = scene.matrix.as_ref();
    let built = match known.filter(|known| Arc::ptr_eq(known.robot(), robot)) {
        Some(known) => known.with_world(&scene.world, settings, matrix),
        None => CollisionChecker::with_matrix(Arc::clone(robot), &scene.world, settings, matrix),
    };
    built.map_err(|error| error.to_string())
}

fn volumes_of(parameters: &Parameters) -> Result<VolumeSelection, String> {
    parameters.volumes.parse().map_err(|error: VolumeSelectionError| format!("volumes: {error}"))
}

/// Warning about volumes of links that the robot does not have.
pub fn volumes_without_effect(robot: &RobotModel, parameters: &Parameters) -> Option<String> {
    let links = volumes_of(parameters).ok()?.links;
    let unknown: Vec<String> = links.into_keys().filter(|link| robot.link_by_name(link).is_none()).collect();
    (!unknown.is_empty()).then(|| format!("volumes: the robot has no link {}", quoted_list(&unknown)))
}

/// Warnings about the checks: defects of meshes that should be solid, and an empty set of pairs.
pub fn warnings_of(checker: &CollisionChecker, meshes: &[SolidMeshRemark]) -> impl Iterator<Item = String> {
    about_solids(meshes).into_iter().chain(nothing_to_check(checker))
}

/// Warnings about meshes that are treated as solids; empty where meshes are treated as surfaces.
pub fn solid_meshes(checker: &CollisionChecker) -> Vec<SolidMeshRemark> {
    match checker.settings().mesh_model {
        MeshModel::Surface => Vec::new(),
        MeshModel::Solid => solid_mesh_remarks(checker.robot(), checker.world()),
    }
}

fn nothing_to_check(checker: &CollisionChecker) -> Option<String> {
    const NOTHING: &str = "there is no pair to check: every state counts as free";
    // without geometry the state is UNKNOWN
    let has_geometry = checker.robot().links().iter().any(|link| !link.collisions.is_empty());
    (has_geometry && checker.pairs().is_empty()).then(|| NOTHING.to_owned())
}

/// One line for all meshes that stay surfaces, and one line for each repaired mesh.
fn about_solids(meshes: &[SolidMeshRemark]) -> Vec<String> {
    const TOLD: usize = 5;
    let (surfaces, repaired): (Vec<_>, Vec<_>) = meshes.iter().partition(|remark| remark.is_surface);
    let mut warnings = Vec::new();
    if !surfaces.is_empty() {
        let left = surfaces.len().saturating_sub(TOLD);
        let more = if left > 0 { format!(" and {left} more") } else { String::new() };
        let named: Vec<&str> = surfaces.iter().take(TOLD).map(|remark| remark.mesh.as_str()).collect();
        warnings.push(format!(
            "not solid, because not closed or too tangled, and whatever is wholly inside touches nothing: {}{more}",
            named.join(", ")
        ));
    }
    warnings.extend(repaired.iter().take(TOLD).map(ToString::to_string));
    if repaired.len() > TOLD {
        warnings.push(format!("{} more solid meshes have faults: see the log", repaired.len() - TOLD));
    }
    warnings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_many_meshes_with_faults_some_are_named_and_all_counted() {
        let remark = |number: usize| SolidMeshRemark {
            mesh: format!("mesh {number}"),
            is_surface: number.is_multiple_of(2),
            text: "a fault".to_owned(),
        };
        assert_eq!(about_solids(&[]), [""; 0]);
        let told = about_solids(&(0..20).map(remark).collect::<Vec<_>>());
        assert!(
            told[0].starts_with("not solid") && told[0].ends_with("mesh 6, mesh 8 and 5 more"),
            "{told:?}"
        );
        assert_eq!((told[1].as_str(), told.len()), ("mesh 1: a fault", 7));
        assert!(told[6].starts_with("5 more"), "{told:?}");
    }
}
