//! Collision geometry of scaled shapes.

use std::sync::{Arc, OnceLock};

use clearance_geometry::math::Pose;
use clearance_geometry::{ScaleError, Shape};
use clearance_proximity::{CollisionBody, SolidBody};
use clearance_scene::MeshModel;

use crate::capsules::{LinkCapsule, capsule_around};

/// Collision geometry of some shapes, each scaled by a factor.
#[derive(Clone, Debug)]
pub struct ScaledBody {
    pub body: Arc<CollisionBody>,
    /// A capsule around all shapes.
    pub capsule: LinkCapsule,
    /// The same shapes for queries of penetration depth.
    pub solids: Arc<LazySolidBody>,
}

/// Solids that are built at the first query of a depth: most bodies never need them.
#[derive(Debug)]
pub struct LazySolidBody {
    shapes: Vec<(Pose, Shape)>,
    /// Built from the shapes.
    body: Arc<CollisionBody>,
    solids: OnceLock<SolidBody>,
}

impl ScaledBody {
    /// # Panics
    /// When there are no shapes.
    pub fn new(shapes: &[(Pose, &Shape)], scale: f64, mesh_model: MeshModel) -> Result<Self, ScaleError> {
        let scaled = |shape: &Shape| if scale == 1.0 { Ok(shape.clone()) } else { shape.scaled(scale) };
        let shapes = shapes.iter().map(|(pose, shape)| Ok((*pose, scaled(shape)?)));
        let shapes: Vec<(Pose, Shape)> = shapes.collect::<Result<_, ScaleError>>()?;
        let placed = || shapes.iter().map(|(pose, shape)| (pose, shape));
        let body = match mesh_model {
            MeshModel::Surface => CollisionBody::new(placed()),
            MeshModel::Solid => CollisionBody::with_solid_meshes(placed()),
        };
        let body = Arc::new(body.expect("there are shapes"));
        let capsule = capsule_around(&shapes).expect("there are shapes");
        let solids = LazySolidBody { shapes, body: Arc::clone(&body), solids: OnceLock::new() };
        Ok(Self { body, capsule, solids: Arc::new(solids) })
    }
}

impl LazySolidBody {
    pub fn get(&self) -> &SolidBody {
        let shapes = self.shapes.iter().map(|(pose, shape)| (pose, shape));
        self.solids.get_or_init(|| SolidBody::of_body(&self.body, shapes))
    }
}
