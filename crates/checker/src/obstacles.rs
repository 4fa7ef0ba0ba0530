//! The obstacles of a checker, by place, with their collision geometry.

use std::sync::Arc;

use clearance_geometry::Shape;
use clearance_geometry::constants::MOTION_SLACK;
use clearance_geometry::math::{MatrixPose, Point, Pose};
use clearance_proximity::bvh::AxisBox;
use clearance_proximity::{CollisionBody, Piece, PieceVolume};
use clearance_robot::Reach;
use clearance_scene::{Obstacle, ObstacleId, World};
use rayon::prelude::*;

use super::SettingsError;
use super::bodies::{object_padding, object_scale, solid};
use super::capsule_fit::corners;
use super::capsules::LinkCapsule;
use super::pieces::{Pieces, Placed};
use super::reachable::Reachable;
use super::root_volume::{RootCapsule, RootVolume};
use clearance_scene::{MeshModel, Settings};

/// All obstacles of a world.
#[derive(Clone, Debug, Default)]
pub(super) struct Obstacles {
    /// By id; `None` at gaps.
    places: Vec<Option<Arc<PlacedObstacle>>>,
    pub pieces: Pieces,
}

/// An obstacle with its collision geometry.
#[derive(Debug)]
pub(super) struct PlacedObstacle {
    source: Arc<Obstacle>,
    pub solid: Arc<CollisionBody>,
    /// Its pieces, if it can be split.
    told_apart: Arc<[(Piece, PieceVolume)]>,
    /// Bounding volume, in the frame of the obstacle.
    capsule: LinkCapsule,
    pub pose_ro: MatrixPose,
    /// Its capsule, in the root frame.
    pub reach: Reach,
    /// Safety distance (m).
    pub padding: f64,
    scale: f64,
    mesh_model: MeshModel,
}

/// New content of a place.
pub(super) type Change = (ObstacleId, Option<Arc<PlacedObstacle>>);

/// Approximate maximum number of pieces that a large obstacle is split into.
const MOST_PIECES: usize = 384;

impl Obstacles {
    /// The obstacles of a world; those in `known` are reused.
    pub fn new(
        world: &World,
        settings: &Settings,
        known: &Self,
        reachable: &Reachable,
    ) -> Result<Self, SettingsError> {
        let ids = (0..world.place_count()).into_par_iter();
        let places = ids
            .map(|i| {
                let id = ObstacleId(u32::try_from(i).expect("ids are of 32 bits"));
                let Some(source) = world.place(id) else { return Ok(None) };
                Ok(Some(PlacedObstacle::new(source, settings, known.get(id))?))
            })
            .collect::<Result<Vec<_>, _>>()?;
        let pieces =
            places.iter().map(|place| place.as_deref().map_or_else(Vec::new, PlacedObstacle::pieces));
        Ok(Self { pieces: Pieces::new(pieces.collect(), reachable), places })
    }

    /// New contents of the places that differ from a world.
    pub fn outdated(&self, world: &World, settings: &Settings) -> Result<Vec<Change>, SettingsError> {
        let places = world.place_count().max(self.places.len());
        let outdated = (0..).map(ObstacleId).take(places).filter(|id| !self.is_up_to_date(world, *id));
        outdated
            .map(|id| {
                let source = world.place(id);
                Ok((id, source.map(|s| PlacedObstacle::new(s, settings, self.get(id))).transpose()?))
            })
            .collect()
    }

    /// Updates one place and no other.
    pub fn set(&mut self, (id, found): Change, reachable: &Reachable) {
        let place = id.0 as usize;
        if self.places.len() <= place {
            self.places.resize(place + 1, None);
        }
        let placed = found.as_deref().map_or_else(Vec::new, PlacedObstacle::pieces);
        self.pieces.set(id.0, placed, reachable);
        self.places[place] = found;
    }

    fn is_up_to_date(&self, world: &World, id: ObstacleId) -> bool {
        match (self.get(id), world.place(id)) {
            (Some(known), Some(source)) => Arc::ptr_eq(&known.source, source),
            (known, source) => known.is_none() && source.is_none(),
        }
    }

    /// Number of places.
    pub fn place_count(&self) -> usize {
        self.places.len()
    }

    pub fn get(&self, id: ObstacleId) -> Option<&Arc<PlacedObstacle>> {
        self.places.get(id.0 as usize)?.as_ref()
    }

    /// # Panics
    /// When there is none at this place.
    pub fn at(&self, place: usize) -> &PlacedObstacle {
        self.places[place].as_ref().expect("pairs name only obstacles that are there")
    }

    pub fn iter(&self) -> impl Iterator<Item = &PlacedObstacle> {
        self.places.iter().flatten().map(AsRef::as_ref)
    }
}

impl PlacedObstacle {
    fn new(
        source: &Arc<Obstacle>,
        settings: &Settings,
        known: Option<&Arc<Self>>,
    ) -> Result<Arc<Self>, SettingsError> {
        let (scale, padding) =
            (object_scale(settings, &source.name)?, object_padding(settings, &source.name)?);
        let mesh_model = settings.mesh_model;
        let same = known.filter(|known| {
            Arc::ptr_eq(&known.source.shapes, &source.shapes)
                && known.scale.to_bits() == scale.to_bits()
                && known.mesh_model == mesh_model
        });
        let (solid, capsule, told_apart) = match same {
            Some(same)
                if Arc::ptr_eq(&same.source, source) && same.padding.to_bits() == padding.to_bits() =>
            {
                return Ok(Arc::clone(same));
            }
            Some(same) => (Arc::clone(&same.solid), same.capsule, Arc::clone(&same.told_apart)),
            None => {
                let shapes = source.shapes.iter().map(|s| (s.pose_os, &s.shape));
                let (solid, capsule) = solid(&shapes.collect::<Vec<_>>(), scale, mesh_model)
                    .map_err(|why| SettingsError::CannotScale { of: source.name.clone(), why })?;
                let told_apart = solid.pieces(MOST_PIECES).into();
                (solid, capsule, told_apart)
            }
        };
        let pose_ro = MatrixPose::from(&source.pose_ro);
        let reach = capsule.reach_at(&pose_ro);
        Ok(Arc::new(Self {
            source: Arc::clone(source),
            solid,
            told_apart,
            capsule,
            pose_ro,
            reach,
            padding,
            scale,
            mesh_model,
        }))
    }

    /// Bounding volumes of its pieces at their poses, with its padding; of the whole obstacle where it cannot be split.
    fn pieces(&self) -> Vec<Placed> {
        let placed = |(piece, volume): &(Piece, PieceVolume)| {
            let volume = RootVolume::of_piece(volume, &self.pose_ro, self.padding);
            (*piece, volume, volume.axis_box())
        };
        if self.told_apart.is_empty() {
            let volume = RootVolume::Capsule(RootCapsule::of_reach(&self.reach, self.padding));
            return vec![(Piece::Whole, volume, self.bounds().grown(self.padding))];
        }
        self.told_apart.iter().map(placed).collect()
    }

    /// A box around it, in the root frame.
    fn bounds(&self) -> AxisBox {
        if self.scale != 1.0 {
            return AxisBox::around(self.reach.ends.map(Point::from), self.reach.radius);
        }
        let of_shapes = self.source.placed_shapes().map(|(pose_rs, shape)| bounds_of(&pose_rs, shape));
        let of_shapes = of_shapes.fold(AxisBox::EMPTY, |all, bounds| all.union(&bounds));
        // rounding errors are smaller than the margin added to the capsule
        of_shapes.grown(MOTION_SLACK * (1.0 + self.reach.extent()))
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
