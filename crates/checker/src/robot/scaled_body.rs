//! Collision body of scaled shapes.

use std::sync::Arc;

use clearance_geometry::math::Pose;
use clearance_geometry::{ScaleError, Shape};
use clearance_proximity::CollisionBody;
use clearance_scene::MeshModel;

use crate::capsules::{LinkCapsule, capsule_around};

/// The collision body of some shapes, each scaled by a factor, and a capsule around it.
///
/// # Panics
/// When there are no shapes.
pub fn scaled_body(
    shapes: &[(Pose, &Shape)],
    scale: f64,
    mesh_model: MeshModel,
) -> Result<(Arc<CollisionBody>, LinkCapsule), ScaleError> {
    let scaled = |shape: &Shape| if scale == 1.0 { Ok(shape.clone()) } else { shape.scaled(scale) };
    let shapes = shapes.iter().map(|(pose, shape)| Ok((*pose, scaled(shape)?)));
    let shapes: Vec<(Pose, Shape)> = shapes.collect::<Result<_, ScaleError>>()?;
    let placed = || shapes.iter().map(|(pose, shape)| (pose, shape));
    let solid = match mesh_model {
        MeshModel::Surface => CollisionBody::new(placed()),
        MeshModel::Solid => CollisionBody::with_solid_meshes(placed()),
    };
    let solid = solid.expect("there are shapes");
    Ok((Arc::new(solid), capsule_around(&shapes).expect("there are shapes")))
}
