//! Obstacle with its collision geometry.

use std::sync::Arc;

use clearance_geometry::Shape;
use clearance_geometry::constants::MOTION_SLACK;
use clearance_geometry::math::{MatrixPose, Point, Pose};
use clearance_proximity::bvh::AxisBox;
use clearance_proximity::{CollisionBody, Piece, PieceVolume, SolidBody};
use clearance_robot::Reach;
use clearance_scene::{Obstacle, Settings};

use super::piece_trees::PieceVolumes;
use crate::capsules::{LinkCapsule, RootCapsule, RootVolume, corners};
use crate::robot::{BodyBuild, LazySolidBody, ScaledBody, object_padding, object_scale};
use crate::settings_error::SettingsError;

/// Approximate maximum number of pieces that a large obstacle is split into.
const MOST_PIECES: usize = 384;

/// An obstacle with its collision geometry.
#[derive(Debug)]
pub struct PlacedObstacle {
    source: Arc<Obstacle>,
    solid: Arc<CollisionBody>,
    solids: Arc<LazySolidBody>,
    /// Its pieces, if it can be split.
    pieces: Arc<[(Piece, PieceVolume)]>,
    /// Bounding volume, in the frame of the obstacle.
    capsule: LinkCapsule,
    pose_ro: MatrixPose,
    pose_or: MatrixPose,
    /// Its capsule, in the root frame.
    reach: Reach,
    /// Safety distance (m).
    padding: f64,
    build: BodyBuild,
}

impl PlacedObstacle {
    /// The obstacle with its geometry; the geometry of `known` is reused where its inputs are the same.
    pub fn new(
        source: &Arc<Obstacle>,
        settings: &Settings,
        known: Option<&Arc<Self>>,
    ) -> Result<Arc<Self>, SettingsError> {
        let (scale, padding) =
            (object_scale(settings, &source.name)?, object_padding(settings, &source.name)?);
        let build = BodyBuild::new(scale, settings.mesh_model, &settings.volumes, None);
        let same =
            known.filter(|known| Arc::ptr_eq(&known.source.shapes, &source.shapes) && known.build == build);
        let (geometry, pieces) = match same {
            Some(same)
                if Arc::ptr_eq(&same.source, source) && same.padding.to_bits() == padding.to_bits() =>
            {
                return Ok(Arc::clone(same));
            }
            Some(same) => (same.geometry(), Arc::clone(&same.pieces)),
            None => {
                let shapes = source.shapes.iter().map(|s| (s.pose_os, &s.shape));
                let geometry = ScaledBody::new(&shapes.collect::<Vec<_>>(), &build)
                    .map_err(|why| SettingsError::CannotScale { of: source.name.clone(), why })?;
                let pieces = geometry.body.pieces(MOST_PIECES).into();
                (geometry, pieces)
            }
        };
        let pose_ro = MatrixPose::from(&source.pose_ro);
        let ScaledBody { body, capsule, solids } = geometry;
        let reach = capsule.reach_at(&pose_ro);
        Ok(Arc::new(Self {
            source: Arc::clone(source),
            solid: body,
            solids,
            pieces,
            capsule,
            pose_or: pose_ro.inverse(),
            pose_ro,
            reach,
            padding,
            build,
        }))
    }

    /// Bounding volumes of its pieces at their poses, with its padding; of the whole obstacle where it cannot be split.
    pub fn placed_pieces(&self) -> Vec<PieceVolumes> {
        let placed = |(piece, volume): &(Piece, PieceVolume)| {
            let volume = RootVolume::of_piece(volume, &self.pose_ro, self.padding);
            PieceVolumes { piece: *piece, volume, bounds: volume.axis_box() }
        };
        if self.pieces.is_empty() {
            let volume = RootVolume::Capsule(RootCapsule::of_reach(&self.reach, self.padding));
            let bounds = self.bounds().grown(self.padding);
            return vec![PieceVolumes { piece: Piece::Whole, volume, bounds }];
        }
        self.pieces.iter().map(placed).collect()
    }

    /// A box around it, in the root frame.
    fn bounds(&self) -> AxisBox {
        if self.build.scale != 1.0 {
            return AxisBox::around(self.reach.ends.map(Point::from), self.reach.radius);
        }
        let of_shapes = self.source.placed_shapes().map(|(pose_rs, shape)| bounds_of(&pose_rs, shape));
        let of_shapes = of_shapes.fold(AxisBox::EMPTY, |all, bounds| all.union(&bounds));
        // rounding errors are smaller than the margin added to the capsule
        of_shapes.grown(MOTION_SLACK * (1.0 + self.reach.extent()))
    }

    /// True if it was built from this obstacle.
    pub fn is_of(&self, source: &Arc<Obstacle>) -> bool {
        Arc::ptr_eq(&self.source, source)
    }

    #[inline]
    pub fn solid(&self) -> &CollisionBody {
        &self.solid
    }

    /// False if a point (root frame) is certainly outside of its solid meshes.
    #[inline]
    pub fn may_contain(&self, point: &Point) -> bool {
        self.solid.may_contain(&(&self.pose_or * *point))
    }

    /// True if it has solid meshes.
    pub fn has_inside(&self) -> bool {
        self.solid.inside_grids().next().is_some()
    }

    /// Its shapes for queries of penetration depth.
    pub fn solids(&self) -> &SolidBody {
        self.solids.get()
    }

    fn geometry(&self) -> ScaledBody {
        ScaledBody { body: Arc::clone(&self.solid), capsule: self.capsule, solids: Arc::clone(&self.solids) }
    }

    #[inline]
    pub fn pose_ro(&self) -> &MatrixPose {
        &self.pose_ro
    }

    /// Its capsule, in the root frame, without padding.
    #[inline]
    pub fn reach(&self) -> Reach {
        self.reach
    }

    /// Safety distance (m).
    #[inline]
    pub fn padding(&self) -> f64 {
        self.padding
    }

    pub fn name(&self) -> &str {
        &self.source.name
    }

    pub fn pose(&self) -> Pose {
        self.source.pose_ro
    }

    /// Its capsule at another pose in the root frame.
    pub fn reach_at(&self, pose: &MatrixPose) -> Reach {
        self.capsule.reach_at(pose)
    }
}

/// A box around a shape at its pose, in the root frame.
fn bounds_of(pose_rs: &Pose, shape: &Shape) -> AxisBox {
    let around = |bounds| AxisBox::around(corners(bounds).map(|p| pose_rs * p), 0.0);
    match shape {
        Shape::Primitive(primitive) => AxisBox::around(primitive.hull_points().map(|p| pose_rs * p), 0.0),
        Shape::Mesh(mesh) => around(mesh.bounds()),
        Shape::Points(cloud) => around(cloud.bounds()),
        Shape::Voxels(voxels) => around(voxels.bounds()),
        Shape::Plane(_) => AxisBox::ALL,
    }
}
