//! Broad phase: finds obstacles that may be near a robot part, first by boxes in a tree, then by capsules.

use clearance_geometry::constants::{CONTACT_DISTANCE, MOTION_SLACK};
use clearance_geometry::math::{Extremes, MatrixPose};
use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{LANES, Level, Simd, dispatch, f32x8};
use clearance_proximity::bvh::{AxisBox, Child, SelectedBoxes};
use clearance_proximity::{Piece, Scratch, Work};
use clearance_robot::{Configuration, Frame, Reach};
use clearance_scene::ObstacleId;

use super::capsules::{PlacedSegment, Segment, gather, up};
use super::collision_checker::CollisionChecker;
use super::root_volume::RootCapsule;
use super::workspace::{QueuedPair, Workspace};

/// Scratch memory of a search.
#[derive(Clone, Debug, Default)]
pub(super) struct NearbyScratch {
    stack: Vec<u32>,
    found: Vec<u32>,
    /// As `stack` and `found`, for eight capsules at once; each entry has a bit mask.
    eight_stack: Vec<(u32, u8)>,
    eight_found: Vec<(u32, u8)>,
    /// Capsules around the robot parts, by part; used by the search for the least distance.
    pub capsules: Vec<RootCapsule>,
    /// Pieces of obstacles that may be near, grouped by obstacle.
    pub near: Vec<NearPiece>,
    /// As `near`, for eight capsules.
    pub near_eight: Vec<NearEight>,
    /// Pieces of one obstacle.
    pub pieces: Vec<Piece>,
}

/// A piece of an obstacle that may be near a part.
#[derive(Clone, Copy, Debug)]
pub(super) struct NearPiece {
    pub place: u32,
    pub piece: Piece,
    /// Lower bound (m) on its padded distance.
    pub lower: f32,
}

/// A piece of an obstacle that may be near some of eight capsules.
#[derive(Clone, Copy, Debug)]
pub(super) struct NearEight {
    pub place: u32,
    pub piece: Piece,
    /// Bit mask of these capsules.
    pub lanes: u8,
}

impl NearbyScratch {
    /// Bit mask of the capsules that anything may be near.
    pub fn lanes_near(&self) -> u8 {
        self.near_eight.iter().fold(0, |lanes, near| lanes | near.lanes)
    }
}

impl NearEight {
    const NONE: Self = Self { place: 0, piece: Piece::Whole, lanes: 0 };
}

/// Candidate of the search: something that may be near a robot part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Near {
    /// A pair with an obstacle or with another robot part.
    Pair(usize),
    /// A piece of an obstacle for which only the box was tested.
    Boxed { part: usize, piece: u32 },
    /// A piece whose bounding volume was tested, too.
    Piece { part: usize, piece: u32 },
    /// The pieces in a node of the tree.
    Node { part: usize, node: u32 },
}

impl CollisionChecker {
    /// Capsule around a part at its pose, without padding.
    pub(super) fn reach_of(&self, part: usize, frame: &Frame<f64>) -> Reach {
        self.robot_bodies[part].reach_at(&MatrixPose::from(frame))
    }

    /// Capsule around a part at its pose, grown by the part's padding.
    pub(super) fn capsule_of(&self, part: usize, frame: &Frame<f64>) -> RootCapsule {
        RootCapsule::of_reach(&self.reach_of(part, frame), self.robot_bodies[part].padding)
    }

    /// As above, from level 0's data: the segments of eight states, relative to `origins`.
    #[inline(always)]
    pub(super) fn capsule_in_eight<S: Simd>(
        &self,
        simd: S,
        part: usize,
        (segment, origins): (Segment<f32x8<S>>, [f32x8<S>; 3]),
    ) -> RootCapsule<f32x8<S>> {
        let (radius, offset) = (self.padded_radii[part], self.capsules.offset());
        RootCapsule::new(simd, segment, origins, (f32x8::splat(simd, radius), f32x8::splat(simd, offset)))
    }

    /// As above, for up to eight parts in one state.
    #[inline(always)]
    pub(super) fn eight_capsules<S: Simd>(
        &self,
        simd: S,
        parts: &[usize],
        (segments, [x, y, z]): (&[PlacedSegment], [f32; 3]),
    ) -> RootCapsule<f32x8<S>> {
        let part = |lane: usize| *parts.get(lane).unwrap_or(&parts[0]);
        let parts = [part(0), part(1), part(2), part(3), part(4), part(5), part(6), part(7)];
        let radius = |lane: usize| self.padded_radii[parts[lane]];
        let [a, b, c, d] = [radius(0), radius(1), radius(2), radius(3)];
        let radii = f32x8::simd_from(simd, [a, b, c, d, radius(4), radius(5), radius(6), radius(7)]);
        let origin = [f32x8::splat(simd, x), f32x8::splat(simd, y), f32x8::splat(simd, z)];
        let offset = f32x8::splat(simd, self.capsules.offset());
        RootCapsule::new(simd, gather(simd, segments, &parts), origin, (radii, offset))
    }

    /// Axis-aligned boxes around the robot's parts with their paddings, in states where they are placed: the queries of the broad phase.
    #[must_use]
    pub fn part_boxes(&self, q: &Configuration, workspace: &mut Workspace) -> Vec<AxisBox> {
        self.suit(workspace);
        self.place(q, workspace);
        let parts = self.robot_bodies.iter().enumerate();
        parts
            .map(|(part, robot_body)| {
                self.capsule_of(part, &workspace.frames[robot_body.body].frame()).axis_box(0.0)
            })
            .collect()
    }

    /// Content of the broad phase: numbered boxes around obstacles, or around their pieces if the obstacles are large.
    #[must_use]
    pub fn world_boxes(&self) -> Vec<(u32, AxisBox)> {
        self.obstacles.pieces.boxes()
    }

    /// Pairs of a part with obstacles whose padded distance may be within `limit` (m), in the order of their numbers, with lower bounds
    /// (m) on those distances.
    pub(super) fn obstacles_near(
        &self,
        part: usize,
        capsule: &RootCapsule,
        limit: f64,
        (level, scratch, work): (Level, &mut NearbyScratch, &mut Work),
        near: &mut Vec<QueuedPair>,
    ) {
        if self.pairs().world_len() == 0 {
            return;
        }
        dispatch!(level, simd => self.find_near(simd, part, capsule, up(limit), scratch, work));
        for pieces in scratch.near.chunk_by(|a, b| a.place == b.place) {
            let lower = pieces.iter().map(|piece| piece.lower).fold(f32::INFINITY, f32::lesser);
            let index = self.world_pair(part, pieces[0].place as usize);
            near.push(QueuedPair { lower: f64::from(lower), index });
        }
    }

    /// Fills `near` with the pieces of obstacles whose padded distance from a part may be within `limit` (m).
    #[inline(always)]
    pub(super) fn find_near<S: Simd>(
        &self,
        simd: S,
        part: usize,
        capsule: &RootCapsule,
        limit: f32,
        NearbyScratch { stack, found, near, .. }: &mut NearbyScratch,
        work: &mut Work,
    ) {
        let pieces = &self.obstacles.pieces;
        near.clear();
        found.clear();
        work.volume_tests += pieces.find(simd, &capsule.axis_box(limit), stack, found);
        work.volume_tests += found.len() as u64;
        for &number in &*found {
            let placed = pieces.at(number);
            if self.pairs().checks(part, ObstacleId(placed.place)) {
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

    /// True if a piece of an obstacle may be within `limit` (m) of a part.
    pub(super) fn anything_near(
        &self,
        part: usize,
        capsule: &RootCapsule,
        limit: f64,
        (level, NearbyScratch { stack, found, .. }, work): (Level, &mut NearbyScratch, &mut Work),
    ) -> bool {
        let (pieces, limit) = (&self.obstacles.pieces, up(limit));
        found.clear();
        let around = capsule.axis_box(limit);
        work.volume_tests += dispatch!(level, simd => pieces.find(simd, &around, stack, found));
        found.iter().any(|&number| {
            work.volume_tests += 1;
            let placed = pieces.at(number);
            self.pairs().checks(part, ObstacleId(placed.place)) && placed.lower_bound(capsule) <= limit
        })
    }

    /// Fills `near_eight` with the pieces of obstacles whose padded distance from some of eight parts may be within `limit` (m). `among`
    /// selects the parts; they belong to states that are either all expected or not. `checks` reduces a bit mask to the parts that are to
    /// be checked against the obstacle at a place.
    #[inline(always)]
    pub(super) fn find_near_eight<S: Simd>(
        &self,
        simd: S,
        (capsules, among, is_as_expected): (&RootCapsule<f32x8<S>>, u8, bool),
        (limit, checks): (f32, impl Fn(ObstacleId, u8) -> u8),
        NearbyScratch { eight_stack, eight_found, near_eight, .. }: &mut NearbyScratch,
        work: &mut Work,
    ) {
        let pieces = &self.obstacles.pieces;
        eight_found.clear();
        let boxes = capsules.axis_boxes(limit);
        let selected = SelectedBoxes { boxes: &boxes, mask: among };
        work.volume_tests += pieces.find_any(simd, selected, is_as_expected, eight_stack, eight_found);
        // which pieces are near is hard to predict: without a branch the next iteration starts before this one ends
        near_eight.resize(eight_found.len(), NearEight::NONE);
        let mut kept = 0;
        for &(number, lanes) in &*eight_found {
            let placed = pieces.at(number);
            let asked = checks(ObstacleId(placed.place), lanes);
            work.volume_tests += u64::from(asked.count_ones());
            let lanes = asked & placed.near(simd, capsules, limit);
            near_eight[kept] = NearEight { place: placed.place, piece: placed.piece, lanes };
            kept += usize::from(lanes != 0);
        }
        near_eight.truncate(kept);
        near_eight.sort_unstable_by_key(|near| (near.place, near.piece));
    }

    /// Fills `pieces` with the pieces of the obstacle at a place whose padded distance from a part may be within `limit` (m).
    pub(super) fn pieces_near(
        &self,
        (part, place): (usize, usize),
        capsule: &RootCapsule,
        limit: f64,
        (scratch, nearby): (&mut Scratch, &mut NearbyScratch),
    ) {
        let (level, work) = (scratch.level(), &mut scratch.work);
        dispatch!(level, simd => self.find_near(simd, part, capsule, up(limit), nearby, work));
        nearby.pieces.clear();
        let of_place = nearby.near.iter().filter(|near| near.place as usize == place);
        nearby.pieces.extend(of_place.map(|near| near.piece));
    }

    /// Obstacles whose padded distance from a part may be within `motion` (m) in some of eight states: their places, and a bit mask of
    /// these states.
    pub(super) fn each_obstacle_near(
        &self,
        part: usize,
        at: &[RootCapsule; LANES],
        motion: f64,
        workspace: &mut Workspace,
        mut found: impl FnMut(usize, u8),
    ) {
        let Workspace { nearby: NearbyScratch { stack, found: numbers, .. }, scratch, .. } = workspace;
        let limit = up(motion + CONTACT_DISTANCE + MOTION_SLACK);
        let within = at[1..].iter().fold(at[0].axis_box(limit), |all, c| all.union(&c.axis_box(limit)));
        let pieces = &self.obstacles.pieces;
        numbers.clear();
        let level = scratch.level();
        let work = &mut scratch.work;
        work.volume_tests += dispatch!(level, simd => pieces.find(simd, &within, stack, numbers));
        numbers.sort_unstable_by_key(|number| pieces.at(*number).place);
        for of_one in numbers.chunk_by(|a, b| pieces.at(*a).place == pieces.at(*b).place) {
            let place = pieces.at(of_one[0]).place;
            if !self.pairs().checks(part, ObstacleId(place)) {
                continue;
            }
            let mut states = 0_u8;
            for (lane, capsule) in at.iter().enumerate() {
                work.volume_tests += 1;
                let near = of_one.iter().any(|number| pieces.at(*number).lower_bound(capsule) <= limit);
                states |= u8::from(near) << lane;
            }
            if states != 0 {
                found(place as usize, states);
            }
        }
    }

    /// Root of the search for the nearest obstacle of a part.
    pub(super) fn whole_world(&self, part: usize) -> impl Iterator<Item = Near> {
        let pieces = &self.obstacles.pieces;
        let roots = pieces.roots().map(move |node| Near::Node { part, node });
        let unbounded = pieces.unbounded.iter().map(move |&piece| Near::Boxed { part, piece });
        roots.chain(unbounded).filter(|_| self.pairs().world_len() > 0)
    }

    /// The children of a node, with lower bounds (m) on their padded distances from a part, negative where boxes overlap; NaN is no
    /// bound.
    pub(super) fn opened(
        &self,
        node: u32,
        (capsule, level): (&RootCapsule, Level),
    ) -> ([f32; LANES], [Child; LANES]) {
        let (boxes, children) = self.obstacles.pieces.node(node);
        (dispatch!(level, simd => capsule.bounds_of_boxes(simd, boxes)), children)
    }

    pub(super) fn piece(&self, number: u32) -> Piece {
        self.obstacles.pieces.at(number).piece
    }

    /// The place of the obstacle that a piece belongs to.
    pub(super) fn place_of(&self, piece: u32) -> usize {
        self.obstacles.pieces.at(piece).place as usize
    }

    /// Tests the bounding volumes of a piece and a part: returns the candidate with a lower bound (m) on its padded distance, or `None`
    /// if the pair is not checked.
    pub(super) fn looked_at(&self, part: usize, piece: u32, capsule: &RootCapsule) -> Option<(f64, Near)> {
        let placed = self.obstacles.pieces.at(piece);
        if !self.pairs().checks(part, ObstacleId(placed.place)) {
            return None;
        }
        let near = match placed.piece {
            // pieces of an obstacle are no nearer to an infinite part than the whole obstacle
            _ if !self.robot_bodies[part].capsule.radius.is_finite() => {
                Near::Pair(self.world_pair(part, placed.place as usize))
            }
            Piece::Whole | Piece::Solids => Near::Pair(self.world_pair(part, placed.place as usize)),
            Piece::Surface(_) | Piece::Cubes { .. } => Near::Piece { part, piece },
        };
        Some((f64::from(placed.lower_bound(capsule).greater(0.0)), near))
    }
}

/// Lower bound (m) on the distance between two capsules: the separation of their axes along the line between approximately nearest
/// points, as at level 0, but in f64.
pub(super) fn capsule_bound([a, b]: &[Reach; 2]) -> f64 {
    let (c, u) = ((a.ends[0] + a.ends[1]) * 0.5, (a.ends[1] - a.ends[0]) * 0.5);
    let (d, v) = ((b.ends[0] + b.ends[1]) * 0.5, (b.ends[1] - b.ends[0]) * 0.5);
    let w = d - c;
    let (uu, vv, uv) = (u.norm_squared(), v.norm_squared(), u.dot(&v));
    let (uw, vw) = (u.dot(&w), v.dot(&w));
    let over = |numerator: f64, denominator: f64| {
        if denominator > 0.0 { (numerator / denominator).clamp(-1.0, 1.0) } else { 0.0 }
    };
    let determinant = uu * vv - uv * uv;
    let s = if determinant > 1e-12 * uu * vv { over(uw * vv - uv * vw, determinant) } else { 0.0 };
    let t = over(uv * s - vw, vv);
    let s = over(uv * t + uw, uu);
    let n = w + v * t - u * s;
    let rounding = MOTION_SLACK * (1.0 + c.amax() + d.amax());
    let length = n.norm();
    if length > 0.0 {
        (n.dot(&w) - n.dot(&u).abs() - n.dot(&v).abs()) / length - a.radius - b.radius - rounding
    } else if length == 0.0 {
        -a.radius - b.radius
    } else {
        f64::NEG_INFINITY
    }
}
