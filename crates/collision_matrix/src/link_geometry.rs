//! Collision geometry of a link for the search of proofs.

use clearance_geometry::math::Pose;
use clearance_geometry::{ScaleError, Shape};
use clearance_proximity::CollisionBody;
use clearance_robot::{LinkId, RobotModel};
use clearance_scene::{MeshModel, Settings};

use crate::outline::Outline;
use crate::solid_parts::SolidPart;
use std::sync::OnceLock;

/// The shapes of a link, in its frame.
#[derive(Debug)]
pub struct LinkGeometry {
    /// The link.
    pub link: LinkId,
    /// Hierarchies for distances.
    pub body: CollisionBody,
    /// `None` if a shape is infinite.
    pub outline: Option<Outline>,
    /// Safety distance (m) against other links.
    pub padding: f64,
    /// The shapes at their poses in the frame of the link.
    pub shapes: Vec<(Pose, Shape)>,
    parts: OnceLock<Vec<SolidPart>>,
}

impl LinkGeometry {
    /// The geometry of a link as the checker uses it; `None` without shapes.
    pub fn new(robot: &RobotModel, link: LinkId, settings: &Settings) -> Result<Option<Self>, ScaleError> {
        let name = &robot.link(link).name;
        let scale = settings.link_scale.get(name).copied().unwrap_or(1.0);
        let scaled = |shape: &Shape| if scale == 1.0 { Ok(shape.clone()) } else { shape.scaled(scale) };
        let shapes = robot.link(link).collisions.iter();
        let shapes = shapes.map(|c| Ok((c.pose_ls, scaled(&c.shape)?)));
        let shapes: Vec<(Pose, Shape)> = shapes.collect::<Result<_, ScaleError>>()?;
        let placed = || shapes.iter().map(|(pose, shape)| (pose, shape));
        let body = match settings.mesh_model {
            MeshModel::Surface => CollisionBody::new(placed()),
            MeshModel::Solid => CollisionBody::with_solid_meshes(placed()),
        };
        let padding = settings.link_padding.get(name).copied().unwrap_or(settings.padding);
        let padding = if settings.pad_self { padding } else { 0.0 };
        let outline = Outline::new(&shapes);
        Ok(body.map(|body| Self { link, body, outline, padding, shapes, parts: OnceLock::new() }))
    }

    /// Connected solids of the link, the largest first; computed at the first use.
    #[must_use]
    pub fn parts(&self) -> &[SolidPart] {
        self.parts.get_or_init(|| SolidPart::all(&self.shapes))
    }
}
