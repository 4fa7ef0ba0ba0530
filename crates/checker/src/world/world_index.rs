//! Index of the world's obstacles: numbers their pairs with robot parts, and finds the obstacles that may be near a
//! part, first by boxes in a tree, then by capsules.

use clearance_geometry::math::Extremes;
use clearance_geometry::simd::{LANES, Level, Simd, dispatch};
use clearance_proximity::bvh::Child;
use clearance_proximity::{Piece, Scratch, Work};
use clearance_scene::{ObstacleId, PairList, Settings, World};

use super::broad_phase::{BroadPhaseScratch, EightQuery, EightStatesQuery, NearEight, NearPiece, PartQuery};
use super::inside_index::InsideIndex;
use super::obstacles::Obstacles;
use super::piece_trees::EightBoxQuery;
use super::placed_obstacle::PlacedObstacle;
use super::reachable_regions::ReachableRegions;
use super::search_node::SearchNode;
use crate::capsules::RootCapsule;
use crate::revision::Revision;
use crate::robot::{CandidatePair, RobotBody, RobotGeometry};
use crate::settings_error::SettingsError;

/// The obstacles of a world with their collision geometry, and their pairs with robot parts.
///
/// Obstacles are named by *place*: the index of their id. Pairs with obstacles are numbered after the self pairs: for
/// each part, one number per place.
#[derive(Clone, Debug)]
pub struct WorldIndex {
    world: World,
    /// Which parts are checked against which obstacles.
    pair_list: PairList,
    part_count: usize,
    reachable: ReachableRegions,
    obstacles: Obstacles,
    /// Unique among all worlds of all checkers.
    revision: Revision,
}

/// The bodies of a pair with an obstacle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WorldPair {
    pub part: usize,
    pub place: usize,
}

impl WorldIndex {
    /// Obstacles in `known` are reused where they are the same.
    pub fn new(
        world: &World,
        pair_list: PairList,
        settings: &Settings,
        robot: &RobotGeometry,
        known: Option<&Self>,
    ) -> Result<Self, SettingsError> {
        let reachable = ReachableRegions::new(robot);
        let none = Obstacles::default();
        let known = known.map_or(&none, |known| &known.obstacles);
        let obstacles = Obstacles::new(world, settings, known, &reachable)?;
        Ok(Self {
            world: world.clone(),
            pair_list,
            part_count: robot.parts().len(),
            reachable,
            obstacles,
            revision: Revision::next(),
        })
    }

    /// Replaces the world; only obstacles that differ are updated. If an error is returned, nothing has changed.
    pub fn set_world(&mut self, world: &World, settings: &Settings) -> Result<(), SettingsError> {
        // all fallible steps come before the first change
        for change in self.obstacles.outdated(world, settings)? {
            let name = world.place(change.id).map(|obstacle| obstacle.name.as_str());
            self.pair_list.set_obstacle(change.id, name);
            self.obstacles.set(change, &self.reachable);
        }
        self.obstacles.renew_inside();
        self.world = world.clone();
        self.revision = Revision::next();
        Ok(())
    }

    pub fn world(&self) -> &World {
        &self.world
    }

    #[inline]
    pub fn pair_list(&self) -> &PairList {
        &self.pair_list
    }

    #[inline]
    pub fn reachable(&self) -> &ReachableRegions {
        &self.reachable
    }

    pub fn obstacles(&self) -> &Obstacles {
        &self.obstacles
    }

    /// The inside of all obstacles.
    #[inline]
    pub fn inside(&self) -> &InsideIndex {
        self.obstacles.inside()
    }

    #[inline]
    pub fn revision(&self) -> Revision {
        self.revision
    }

    /// True if no pair with an obstacle is checked.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.pair_list.world_len() == 0
    }

    /// The obstacle at a place.
    ///
    /// # Panics
    /// When there is none.
    #[inline]
    pub fn obstacle(&self, place: usize) -> &PlacedObstacle {
        self.obstacles.at(place)
    }

    /// True if a part is checked against the obstacle at a place.
    #[inline]
    pub fn checks(&self, pair: WorldPair) -> bool {
        self.pair_list.checks(pair.part, obstacle_id(pair.place))
    }

    /// Number of the pair of a part and the obstacle at a place.
    #[inline]
    pub fn number(&self, pair: WorldPair) -> usize {
        self.first_number() + pair.part * self.obstacles.place_count() + pair.place
    }

    /// The bodies of a pair, given its number minus that of the first pair.
    #[inline]
    pub fn pair(&self, number: usize) -> WorldPair {
        let places = self.obstacles.place_count();
        WorldPair { part: number / places, place: number % places }
    }

    /// Number of all parts times all places.
    pub fn number_count(&self) -> usize {
        self.part_count * self.obstacles.place_count()
    }

    /// The pairs that are checked, in the order of their numbers.
    pub fn pairs(&self) -> impl Iterator<Item = WorldPair> {
        let places = self.obstacles.place_count();
        let all = (0..self.part_count)
            .flat_map(move |part| (0..places).map(move |place| WorldPair { part, place }));
        all.filter(|pair| self.checks(*pair))
    }

    #[inline]
    fn first_number(&self) -> usize {
        self.pair_list.self_pairs().len()
    }

    #[inline]
    fn number_with(&self, part: usize, place: u32) -> usize {
        self.number(WorldPair { part, place: place as usize })
    }

    /// Pairs of a part with obstacles that may be near, in the order of their numbers, with lower bounds (m) on their
    /// distances.
    pub fn candidates(
        &self,
        query: PartQuery,
        nearby: &mut BroadPhaseScratch,
        scratch: &mut Scratch,
        candidates: &mut Vec<CandidatePair>,
    ) {
        if self.is_empty() {
            return;
        }
        let (level, work) = (scratch.level(), &mut scratch.work);
        dispatch!(level, simd => self.find_near(simd, query, nearby, work));
        for pieces in nearby.near.chunk_by(|a, b| a.place == b.place) {
            let lower = pieces.iter().map(|piece| piece.lower).fold(f32::INFINITY, f32::lesser);
            let index = self.number_with(query.part, pieces[0].place);
            candidates.push(CandidatePair { lower: f64::from(lower), index });
        }
    }

    /// Fills `near` with the pieces of obstacles that may be near a part.
    #[inline(always)]
    pub fn find_near<S: Simd>(
        &self,
        simd: S,
        PartQuery { part, capsule, limit }: PartQuery,
        BroadPhaseScratch { stack, found, near, .. }: &mut BroadPhaseScratch,
        work: &mut Work,
    ) {
        let pieces = self.obstacles.pieces();
        near.clear();
        found.clear();
        work.volume_tests += pieces.find(simd, &capsule.axis_box(limit), stack, found);
        work.volume_tests += found.len() as u64;
        for &number in &*found {
            let placed = pieces.at(number);
            if self.pair_list.checks(part, ObstacleId(placed.place)) {
                let lower = placed.lower_bound(capsule);
                if lower <= limit {
                    near.push(NearPiece {
                        place: placed.place,
                        piece: placed.piece,
                        lower: lower.greater(0.0),
                    });
                }
            }
        }
        near.sort_unstable_by_key(|near| (near.place, near.piece));
    }

    /// True if a piece of an obstacle may be near a part.
    pub fn anything_near(
        &self,
        PartQuery { part, capsule, limit }: PartQuery,
        BroadPhaseScratch { stack, found, .. }: &mut BroadPhaseScratch,
        scratch: &mut Scratch,
    ) -> bool {
        let pieces = self.obstacles.pieces();
        found.clear();
        let around = capsule.axis_box(limit);
        let (level, work) = (scratch.level(), &mut scratch.work);
        work.volume_tests += dispatch!(level, simd => pieces.find(simd, &around, stack, found));
        found.iter().any(|&number| {
            work.volume_tests += 1;
            let placed = pieces.at(number);
            self.pair_list.checks(part, ObstacleId(placed.place)) && placed.lower_bound(capsule) <= limit
        })
    }

    /// Fills `near_eight` with the pieces of obstacles that may be near some of eight capsules.
    #[inline(always)]
    pub fn find_near_eight<S: Simd, C: Fn(ObstacleId, u8) -> u8>(
        &self,
        simd: S,
        EightQuery { capsules, among, are_expected, limit, checks }: EightQuery<S, C>,
        BroadPhaseScratch { eight_stack, eight_found, near_eight, .. }: &mut BroadPhaseScratch,
        work: &mut Work,
    ) {
        let pieces = self.obstacles.pieces();
        eight_found.clear();
        let boxes = capsules.axis_boxes(limit);
        let query = EightBoxQuery { boxes: &boxes, among, are_expected };
        work.volume_tests += pieces.find_any(simd, query, eight_stack, eight_found);
        // which pieces are near is hard to predict: without a branch the next iteration starts before this one ends
        near_eight.resize(eight_found.len(), NearEight::NONE);
        let mut kept = 0;
        for &(number, lanes) in &*eight_found {
            let placed = pieces.at(number);
            let checked = checks(ObstacleId(placed.place), lanes);
            work.volume_tests += u64::from(checked.count_ones());
            let lanes = checked & placed.near(simd, capsules, limit);
            near_eight[kept] = NearEight { place: placed.place, piece: placed.piece, lanes };
            kept += usize::from(lanes != 0);
        }
        near_eight.truncate(kept);
        near_eight.sort_unstable_by_key(|near| (near.place, near.piece));
    }

    /// Fills `pieces` with the pieces of the obstacle at a place that may be near a part.
    pub fn find_pieces_near(
        &self,
        query: PartQuery,
        place: usize,
        nearby: &mut BroadPhaseScratch,
        scratch: &mut Scratch,
    ) {
        let (level, work) = (scratch.level(), &mut scratch.work);
        dispatch!(level, simd => self.find_near(simd, query, nearby, work));
        nearby.pieces.clear();
        let of_place = nearby.near.iter().filter(|near| near.place as usize == place);
        nearby.pieces.extend(of_place.map(|near| near.piece));
    }

    /// Calls `visit` for each obstacle that may be near a part in some of eight states, with its place and a bit mask
    /// of these states.
    pub fn for_each_near_in_eight_states(
        &self,
        EightStatesQuery { part, capsules, limit }: EightStatesQuery,
        nearby: &mut BroadPhaseScratch,
        scratch: &mut Scratch,
        mut visit: impl FnMut(usize, u8),
    ) {
        let BroadPhaseScratch { stack, found: numbers, .. } = nearby;
        let around =
            capsules[1..].iter().fold(capsules[0].axis_box(limit), |all, c| all.union(&c.axis_box(limit)));
        let pieces = self.obstacles.pieces();
        numbers.clear();
        let level = scratch.level();
        let work = &mut scratch.work;
        work.volume_tests += dispatch!(level, simd => pieces.find(simd, &around, stack, numbers));
        numbers.sort_unstable_by_key(|number| pieces.at(*number).place);
        for of_one in numbers.chunk_by(|a, b| pieces.at(*a).place == pieces.at(*b).place) {
            let place = pieces.at(of_one[0]).place;
            if !self.pair_list.checks(part, ObstacleId(place)) {
                continue;
            }
            let mut states = 0_u8;
            for (lane, capsule) in capsules.iter().enumerate() {
                work.volume_tests += 1;
                let near = of_one.iter().any(|number| pieces.at(*number).lower_bound(capsule) <= limit);
                states |= u8::from(near) << lane;
            }
            if states != 0 {
                visit(place as usize, states);
            }
        }
    }

    /// Where the search for the nearest obstacle of a part starts.
    pub fn search_roots(&self, part: usize) -> impl Iterator<Item = SearchNode> {
        let pieces = self.obstacles.pieces();
        let roots = pieces.roots().map(move |node| SearchNode::TreeNode { part, node });
        let unbounded = pieces.unbounded().iter().map(move |&piece| SearchNode::BoxedPiece { part, piece });
        roots.chain(unbounded).filter(|_| !self.is_empty())
    }

    /// The children of a node, with lower bounds (m) on their padded distances from a part's capsule, negative where
    /// boxes overlap; NaN is no bound.
    pub fn node(&self, node: u32, capsule: &RootCapsule, level: Level) -> ([f32; LANES], [Child; LANES]) {
        let (boxes, children) = self.obstacles.pieces().node(node);
        (dispatch!(level, simd => capsule.bounds_of_boxes(simd, boxes)), children)
    }

    /// The piece with a number.
    pub fn piece(&self, number: u32) -> Piece {
        self.obstacles.pieces().at(number).piece
    }

    /// The pair of a part and the obstacle that a piece belongs to.
    pub fn pair_with_piece(&self, part: usize, piece: u32) -> WorldPair {
        WorldPair { part, place: self.obstacles.pieces().at(piece).place as usize }
    }

    /// Tests the bounding volumes of a piece and a part: returns the node with a lower bound (m) on its padded
    /// distance, or `None` if the pair is not checked.
    pub fn bounded_piece(
        &self,
        part: usize,
        piece: u32,
        robot_body: &RobotBody,
        capsule: &RootCapsule,
    ) -> Option<(f64, SearchNode)> {
        let placed = self.obstacles.pieces().at(piece);
        if !self.pair_list.checks(part, ObstacleId(placed.place)) {
            return None;
        }
        let node = match placed.piece {
            // pieces of an obstacle are no nearer to an infinite part than the whole obstacle
            _ if !robot_body.capsule().radius.is_finite() => {
                SearchNode::Pair(self.number_with(part, placed.place))
            }
            Piece::Whole | Piece::Solids => SearchNode::Pair(self.number_with(part, placed.place)),
            Piece::Surface(_) | Piece::Cubes { .. } | Piece::Inside => SearchNode::Piece { part, piece },
        };
        Some((f64::from(placed.lower_bound(capsule).greater(0.0)), node))
    }
}

/// The id of the obstacle at a place.
pub fn obstacle_id(place: usize) -> ObstacleId {
    ObstacleId(u32::try_from(place).expect("ids are of 32 bits"))
}
