//! Collision geometry of scaled shapes.

use std::sync::{Arc, OnceLock};

use clearance_geometry::math::Pose;
use clearance_geometry::{ScaleError, Shape, VolumeKind};
use clearance_proximity::{CollisionBody, SolidBody};
use clearance_scene::{MeshModel, VolumeSelection};

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

/// How a body is built from its shapes; equal builds of equal shapes give equal bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyBuild {
    pub scale: f64,
    pub mesh_model: MeshModel,
    /// Kind of its bounding volumes.
    pub volumes: VolumeKind,
    /// All kinds that occur, with which bodies of other kinds may have to be searched.
    pub all_volumes: Vec<VolumeKind>,
}

impl BodyBuild {
    /// The build of a link and what it carries, or of obstacles if `link` is none.
    pub fn new(scale: f64, mesh_model: MeshModel, volumes: &VolumeSelection, link: Option<&str>) -> Self {
        let kind = link.map_or(volumes.all, |link| volumes.of_link(link));
        Self { scale, mesh_model, volumes: kind, all_volumes: volumes.kinds() }
    }
}

impl ScaledBody {
    /// # Panics
    /// When there are no shapes.
    pub fn new(shapes: &[(Pose, &Shape)], build: &BodyBuild) -> Result<Self, ScaleError> {
        let BodyBuild { scale, mesh_model, volumes, ref all_volumes } = *build;
        let scaled = |shape: &Shape| if scale == 1.0 { Ok(shape.clone()) } else { shape.scaled(scale) };
        let shapes = shapes.iter().map(|(pose, shape)| Ok((*pose, scaled(shape)?)));
        let shapes: Vec<(Pose, Shape)> = shapes.collect::<Result<_, ScaleError>>()?;
        let placed = || shapes.iter().map(|(pose, shape)| (pose, shape));
        let body = match mesh_model {
            MeshModel::Surface => CollisionBody::new(placed()),
            MeshModel::Solid => CollisionBody::with_solid_meshes(placed()),
        };
        let body = body.expect("there are shapes").with_volumes_of(volumes, all_volumes);
        let body = Arc::new(body);
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
