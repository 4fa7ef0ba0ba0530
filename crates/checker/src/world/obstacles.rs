//! The obstacles of a world by place, and the trees of their pieces.

use std::sync::Arc;

use clearance_scene::{ObstacleId, Settings, World};
use rayon::prelude::*;

use super::piece_trees::{PieceTrees, PieceVolumes};
use super::placed_obstacle::PlacedObstacle;
use super::reachable_regions::ReachableRegions;
use crate::settings_error::SettingsError;

/// All obstacles of a world.
#[derive(Clone, Debug, Default)]
pub struct Obstacles {
    /// By id; `None` at gaps.
    places: Vec<Option<Arc<PlacedObstacle>>>,
    pieces: PieceTrees,
    /// Boxes that together contain the inside of solid meshes.
    inside: PieceTrees,
}

/// Parts of obstacles that are searched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ObstaclePart {
    /// Triangles and all other elements.
    Elements,
    /// The inside of solid meshes, without their surfaces.
    Inside,
}

/// New content of the place of an obstacle.
#[derive(Clone, Debug)]
pub struct PlaceChange {
    pub id: ObstacleId,
    /// `None` if the place becomes empty.
    obstacle: Option<Arc<PlacedObstacle>>,
}

impl Obstacles {
    /// The obstacles of a world; those in `known` are reused.
    pub fn new(
        world: &World,
        settings: &Settings,
        known: &Self,
        reachable: &ReachableRegions,
    ) -> Result<Self, SettingsError> {
        let ids = (0..world.place_count()).into_par_iter();
        let places = ids
            .map(|i| {
                let id = ObstacleId(u32::try_from(i).expect("ids are of 32 bits"));
                let Some(source) = world.place(id) else { return Ok(None) };
                Ok(Some(PlacedObstacle::new(source, settings, known.get(id))?))
            })
            .collect::<Result<Vec<_>, _>>()?;
        let trees = |placed: fn(&PlacedObstacle) -> Vec<PieceVolumes>| {
            let of_places = places.iter().map(|place| place.as_deref().map_or_else(Vec::new, placed));
            PieceTrees::new(of_places.collect(), reachable)
        };
        let (pieces, inside) = (trees(PlacedObstacle::placed_pieces), trees(PlacedObstacle::placed_inside));
        Ok(Self { pieces, inside, places })
    }

    /// New contents of the places that differ from a world.
    pub fn outdated(&self, world: &World, settings: &Settings) -> Result<Vec<PlaceChange>, SettingsError> {
        let places = world.place_count().max(self.places.len());
        let outdated = (0..).map(ObstacleId).take(places).filter(|id| !self.is_up_to_date(world, *id));
        outdated
            .map(|id| {
                let source = world.place(id);
                let obstacle = source.map(|s| PlacedObstacle::new(s, settings, self.get(id))).transpose()?;
                Ok(PlaceChange { id, obstacle })
            })
            .collect()
    }

    /// Updates one place and no other.
    pub fn set(&mut self, PlaceChange { id, obstacle }: PlaceChange, reachable: &ReachableRegions) {
        let place = id.0 as usize;
        if self.places.len() <= place {
            self.places.resize(place + 1, None);
        }
        let placed = |placed: fn(&PlacedObstacle) -> Vec<PieceVolumes>| {
            obstacle.as_deref().map_or_else(Vec::new, placed)
        };
        self.pieces.set(id.0, placed(PlacedObstacle::placed_pieces), reachable);
        self.inside.set(id.0, placed(PlacedObstacle::placed_inside), reachable);
        self.places[place] = obstacle;
    }

    fn is_up_to_date(&self, world: &World, id: ObstacleId) -> bool {
        match (self.get(id), world.place(id)) {
            (Some(known), Some(source)) => known.is_of(source),
            (known, source) => known.is_none() && source.is_none(),
        }
    }

    #[inline]
    pub fn pieces(&self) -> &PieceTrees {
        &self.pieces
    }

    /// The trees over a part of all obstacles.
    #[inline]
    pub fn trees(&self, part: ObstaclePart) -> &PieceTrees {
        match part {
            ObstaclePart::Elements => &self.pieces,
            ObstaclePart::Inside => &self.inside,
        }
    }

    /// True if an obstacle has an inside, as solid meshes have.
    #[inline]
    pub fn have_inside(&self) -> bool {
        !self.inside.is_empty()
    }

    /// Number of places.
    #[inline]
    pub fn place_count(&self) -> usize {
        self.places.len()
    }

    fn get(&self, id: ObstacleId) -> Option<&Arc<PlacedObstacle>> {
        self.places.get(id.0 as usize)?.as_ref()
    }

    /// The obstacle at a place.
    ///
    /// # Panics
    /// When there is none.
    #[inline]
    pub fn at(&self, place: usize) -> &PlacedObstacle {
        self.places[place].as_ref().expect("pairs name only obstacles that are there")
    }

    pub fn iter(&self) -> impl Iterator<Item = &PlacedObstacle> {
        self.places.iter().flatten().map(AsRef::as_ref)
    }
}
