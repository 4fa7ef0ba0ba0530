//! The obstacles of a checker, each at its place, and the tree by which those near a part are found.

use std::sync::Arc;

use rayon::prelude::*;

use super::SettingsError;
use super::bodies::solid;
use super::capsule_fit::corners;
use super::capsules::LinkCapsule;
use super::settings::{MeshModel, Settings};
use crate::bvh::{AxisBox, DynamicTree};
use crate::constants::MOTION_SLACK;
use crate::geometry::Shape;
use crate::math::{MatrixPose, Point, Pose};
use crate::query::CollisionBody;
use crate::robot::Reach;
use crate::world::{Obstacle, ObstacleId, World};

/// All obstacles of a world.
#[derive(Clone, Debug, Default)]
pub(super) struct Obstacles {
    /// By id; `None` at gaps.
    places: Vec<Option<Arc<PlacedObstacle>>>,
    /// Boxes around those that have bounds.
    pub tree: DynamicTree,
    /// Those that have none.
    pub unbounded: Vec<u32>,
    /// Not less than any padding (m).
    pub largest_padding: f64,
}

/// An obstacle, ready for questions.
#[derive(Debug)]
pub(super) struct PlacedObstacle {
    source: Arc<Obstacle>,
    pub solid: Arc<CollisionBody>,
    /// In the frame of the obstacle.
    capsule: LinkCapsule,
    pub pose_ro: MatrixPose,
    /// Its capsule, in the root frame.
    pub reach: Reach,
    /// Safety distance (m).
    pub padding: f64,
    scale: f64,
    mesh_model: MeshModel,
}

impl Obstacles {
    /// The obstacles of a world; what `known` has is not built again.
    pub fn new(world: &World, settings: &Settings, known: &Self) -> Result<Self, SettingsError> {
        let ids = (0..world.place_count()).into_par_iter();
        let places = ids
            .map(|i| {
                let id = ObstacleId(u32::try_from(i).expect("ids are of 32 bits"));
                let Some(source) = world.place(id) else { return Ok(None) };
                Ok(Some(PlacedObstacle::new(source, settings, known.get(id))?))
            })
            .collect::<Result<Vec<_>, _>>()?;
        let mut items = Vec::new();
        let mut unbounded = Vec::new();
        let mut largest_padding = 0.0_f64;
        for (number, place) in (0..).zip(&places) {
            let Some(place) = place else { continue };
            largest_padding = largest_padding.max(place.padding);
            let bounds = place.bounds();
            if bounds.is_bounded() { items.push((number, bounds)) } else { unbounded.push(number) }
        }
        Ok(Self { places, tree: DynamicTree::build(&items), unbounded, largest_padding })
    }

    /// Brings one place up to date, which nothing but its obstacle takes part in.
    pub fn update(
        &mut self,
        world: &World,
        id: ObstacleId,
        settings: &Settings,
    ) -> Result<(), SettingsError> {
        let place = id.0 as usize;
        if self.places.len() <= place {
            self.places.resize(place + 1, None);
        }
        let found = match world.place(id) {
            Some(source) => Some(PlacedObstacle::new(source, settings, self.get(id))?),
            None => None,
        };
        let bounds = found.as_ref().map(|found| found.bounds());
        self.unbounded.retain(|number| *number != id.0);
        match bounds {
            Some(bounds) if bounds.is_bounded() => self.tree.set(id.0, bounds),
            Some(_) => {
                self.tree.remove(id.0);
                self.unbounded.push(id.0);
                self.unbounded.sort_unstable();
            }
            None => self.tree.remove(id.0),
        }
        self.largest_padding = found.as_ref().map_or(0.0, |found| found.padding).max(self.largest_padding);
        self.places[place] = found;
        Ok(())
    }

    /// Whether a place holds what it holds in a world.
    pub fn is_up_to_date(&self, world: &World, id: ObstacleId) -> bool {
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
        let (scale, padding) = (settings.scale_of(&source.name)?, settings.padding_of(&source.name)?);
        let mesh_model = settings.mesh_model;
        let same = known.filter(|known| {
            Arc::ptr_eq(&known.source.shapes, &source.shapes)
                && known.scale.to_bits() == scale.to_bits()
                && known.mesh_model == mesh_model
        });
        let (solid, capsule) = match same {
            Some(same)
                if Arc::ptr_eq(&same.source, source) && same.padding.to_bits() == padding.to_bits() =>
            {
                return Ok(Arc::clone(same));
            }
            Some(same) => (Arc::clone(&same.solid), same.capsule),
            None => {
                let shapes = source.shapes.iter().map(|s| (s.pose_os, &s.shape));
                solid(&shapes.collect::<Vec<_>>(), scale, mesh_model)
                    .map_err(|why| SettingsError::CannotScale { of: source.name.clone(), why })?
            }
        };
        let pose_ro = MatrixPose::from(&source.pose_ro);
        let reach = capsule.reach_at(&pose_ro);
        Ok(Arc::new(Self {
            source: Arc::clone(source),
            solid,
            capsule,
            pose_ro,
            reach,
            padding,
            scale,
            mesh_model,
        }))
    }

    /// A box around it, in the root frame.
    fn bounds(&self) -> AxisBox {
        if self.scale != 1.0 {
            return AxisBox::around(self.reach.ends.map(Point::from), self.reach.radius);
        }
        let of_shapes = self.source.placed_shapes().map(|(pose_rs, shape)| bounds_of(&pose_rs, shape));
        let of_shapes = of_shapes.fold(AxisBox::EMPTY, |all, bounds| all.union(&bounds));
        // what rounds is less than what the capsule is widened by
        of_shapes.grown(MOTION_SLACK * (1.0 + self.reach.extent()))
    }

    pub fn name(&self) -> &str {
        &self.source.name
    }

    pub fn pose(&self) -> Pose {
        self.source.pose_ro
    }

    /// Its capsule, were it at another pose in the root frame.
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
