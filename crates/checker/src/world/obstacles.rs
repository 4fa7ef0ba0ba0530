//! The obstacles of a world by place, and the trees of their pieces.

use std::sync::Arc;

use clearance_scene::{ObstacleId, Settings, World};
use rayon::prelude::*;

use super::inside_index::InsideIndex;
use super::piece_trees::PieceTrees;
use super::placed_obstacle::PlacedObstacle;
use super::reachable_regions::ReachableRegions;
use crate::settings_error::SettingsError;

/// All obstacles of a world.
#[derive(Clone, Debug, Default)]
pub struct Obstacles {
    /// By id; `None` at gaps.
    places: Vec<Option<Arc<PlacedObstacle>>>,
    pieces: PieceTrees,
    inside: InsideIndex,
    /// True if obstacles with an inside have changed since `inside` was built.
    inside_is_outdated: bool,
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
        let pieces =
            places.iter().map(|place| place.as_deref().map_or_else(Vec::new, PlacedObstacle::placed_pieces));
        let pieces = PieceTrees::new(pieces.collect(), reachable);
        let mut obstacles = Self { pieces, places, inside_is_outdated: true, ..Self::default() };
        obstacles.renew_inside();
        Ok(obstacles)
    }

    /// Renews the index of the inside of obstacles after changes.
    pub fn renew_inside(&mut self) {
        if self.inside_is_outdated {
            let known = self.places.iter().enumerate();
            self.inside =
                InsideIndex::new(known.filter_map(|(place, known)| Some((place, known.as_deref()?))));
            self.inside_is_outdated = false;
        }
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

    /// Updates one place and no other; [`Self::renew_inside`] has to follow.
    pub fn set(&mut self, PlaceChange { id, obstacle }: PlaceChange, reachable: &ReachableRegions) {
        let place = id.0 as usize;
        if self.places.len() <= place {
            self.places.resize(place + 1, None);
        }
        let placed = obstacle.as_deref().map_or_else(Vec::new, PlacedObstacle::placed_pieces);
        self.pieces.set(id.0, placed, reachable);
        let have_inside = [&self.places[place], &obstacle];
        self.inside_is_outdated |= have_inside.iter().any(|o| o.as_ref().is_some_and(|o| o.has_inside()));
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

    /// The inside of all obstacles.
    #[inline]
    pub fn inside(&self) -> &InsideIndex {
        &self.inside
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
