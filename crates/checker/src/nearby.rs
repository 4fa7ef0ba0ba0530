//! Which obstacles may be near a part of the robot: boxes in a tree first, then capsules.

use clearance_geometry::constants::{CONTACT_DISTANCE, MOTION_SLACK};
use clearance_geometry::math::{Extremes, MatrixPose};
use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{LANES, Level, Simd, dispatch, f32x8};
use clearance_proximity::bvh::{AxisBox, Child};
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
    /// As those, of eight capsules at once: with a bit for each.
    eight_stack: Vec<(u32, u8)>,
    eight_found: Vec<(u32, u8)>,
    /// Around the parts, by part, while the least distance is looked for.
    pub capsules: Vec<RootCapsule>,
    /// What may be near, one obstacle's pieces after the other's.
    pub near: Vec<NearPiece>,
    /// The same of eight capsules.
    pub near_eight: Vec<NearEight>,
    /// Of one obstacle.
    pub pieces: Vec<Piece>,
}

/// A piece of an obstacle that may be near a part.
#[derive(Clone, Copy, Debug)]
pub(super) struct NearPiece {
    pub place: u32,
    pub piece: Piece,
    /// Its padded distance (m) is not less than this.
    pub lower: f32,
}

/// A piece of an obstacle that may be near some of eight capsules.
#[derive(Clone, Copy, Debug)]
pub(super) struct NearEight {
    pub place: u32,
    pub piece: Piece,
    /// A bit for each of them.
    pub lanes: u8,
}

impl NearbyScratch {
    /// Which of eight capsules anything may be near.
    pub fn lanes_near(&self) -> u8 {
        self.near_eight.iter().fold(0, |lanes, near| lanes | near.lanes)
    }
}

impl NearEight {
    const NONE: Self = Self { place: 0, piece: Piece::Whole, lanes: 0 };
}

/// Something of the world that may be near a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Near {
    /// An obstacle or another part.
    Pair(usize),
    /// A piece of an obstacle of which only the box is known.
    Boxed { part: usize, piece: u32 },
    /// A piece that was looked at.
    Piece { part: usize, piece: u32 },
    /// Pieces in a node of the tree.
    Node { part: usize, node: u32 },
}

impl CollisionChecker {
    /// All that a part reaches, where it is.
    pub(super) fn reach_of(&self, part: usize, frame: &Frame<f64>) -> Reach {
        self.robot_bodies[part].reach_at(&MatrixPose::from(frame))
    }

    /// All that a part reaches with its padding, where it is.
    pub(super) fn capsule_of(&self, part: usize, frame: &Frame<f64>) -> RootCapsule {
        RootCapsule::of_reach(&self.reach_of(part, frame), self.robot_bodies[part].padding)
    }

    /// The same, made of what level 0 knows: of eight states the segments as seen from `origins`.
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

    /// The same of one state, of up to eight parts.
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

    /// Boxes around the robot's parts with their paddings, where a state has them: what the broad phase asks about.
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

    /// What the broad phase knows: boxes around obstacles, or around their pieces where they are large, each with a number.
    #[must_use]
    pub fn world_boxes(&self) -> Vec<(u32, AxisBox)> {
        self.obstacles.pieces.boxes()
    }

    /// Obstacles whose padded distance from a part may be within `limit` (m): their pairs, in the order of their numbers, with
    /// numbers (m) never larger than those distances.
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

    /// Whether a piece of an obstacle may be within `limit` (m) of a part.
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

    /// Fills `near_eight` with the pieces of obstacles whose padded distance from some of eight parts may be within `limit` (m), of
    /// those `among` them, which are parts of states as expected or not; `checks` leaves of some bits those to be checked against
    /// what is at a place.
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
        work.volume_tests += pieces.find_any(simd, (&boxes, among), is_as_expected, eight_stack, eight_found);
        // which are near hangs on chance: without a branch the next is begun before the last is known
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

    /// Fills `pieces` with those of the obstacle at a place whose padded distance from a part may be within `limit` (m).
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

    /// Obstacles whose padded distance from a part may be within `motion` (m) where it is in some of eight states: their places, and a
    /// bit for each of these states.
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

    /// Where the search for the nearest obstacle of a part begins.
    pub(super) fn whole_world(&self, part: usize) -> impl Iterator<Item = Near> {
        let pieces = &self.obstacles.pieces;
        let roots = pieces.roots().map(move |node| Near::Node { part, node });
        let unbounded = pieces.unbounded.iter().map(move |&piece| Near::Boxed { part, piece });
        roots.chain(unbounded).filter(|_| self.pairs().world_len() > 0)
    }

    /// What is in a node, and numbers never larger than the padded distances (m) from a part, less than zero where boxes overlap;
    /// what is no number bounds nothing.
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

    /// The place of a piece's obstacle.
    pub(super) fn place_of(&self, piece: u32) -> usize {
        self.obstacles.pieces.at(piece).place as usize
    }

    /// A piece that may be near a part, once their volumes were looked at: what to ask, with a number (m) never larger than its
    /// padded distance; `None` if the pair is not checked.
    pub(super) fn looked_at(&self, part: usize, piece: u32, capsule: &RootCapsule) -> Option<(f64, Near)> {
        let placed = self.obstacles.pieces.at(piece);
        if !self.pairs().checks(part, ObstacleId(placed.place)) {
            return None;
        }
        let near = match placed.piece {
            // to what has no end pieces are no nearer than the whole
            _ if !self.robot_bodies[part].capsule.radius.is_finite() => {
                Near::Pair(self.world_pair(part, placed.place as usize))
            }
            Piece::Whole | Piece::Solids => Near::Pair(self.world_pair(part, placed.place as usize)),
            Piece::Surface(_) | Piece::Grains { .. } => Near::Piece { part, piece },
        };
        Some((f64::from(placed.lower_bound(capsule).greater(0.0)), near))
    }
}

/// A number (m) never larger than the distance of two capsules: that of their axes along the line between about nearest
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
