//! Proof that two links always collide: branch and bound with balls inside both links.
//!
//! A ball in a solid of each link overlap at the centre of a box, and the sum of their radii exceeds the motion of their centres: the solids
//! overlap in the whole box. Where meshes are surfaces, the solids must also stick out of each other's hulls by more than the motion: two
//! connected surfaces without common points are apart, or one is inside the other.

use clearance_geometry::math::{Point, Vector};
use clearance_verifier::{ContactEvidence, InnerBall};

use crate::inner_points::{ConcentricBalls, InnerPointSearch, OverlapBox, displacement};
use crate::joint_box::JointBox;
use crate::link_geometry::LinkGeometry;
use crate::never_proof::{ProofLimits, widest};
use crate::outline::{Outline, directions};
use crate::pair_problem::{PairProblem, PairWorkspace};
use crate::plane_direction::PlaneDirection;
use crate::relative_motion::PlacedBox;
use crate::solid_parts::{PartInside, SolidPart};
use crate::split_tree::{LeafProof, SplitTree};

/// Result of the search.
#[derive(Debug)]
pub enum AlwaysSearch {
    /// The links collide in all boxes.
    Proven(ContactEvidence),
    /// Values of the variables at which the links are apart.
    Free(Vec<f64>),
    /// The limits were reached first.
    Exhausted,
}

/// Largest number of balls of one link: three digits of 6 bits name them.
const MOST_BALLS: usize = 1 << 18;

/// Number of the last balls that are tried again in the next box.
const TRIED_AGAIN: usize = 16;

/// Number of directions whose motion is bounded to find whether a solid sticks out.
const MOST_DIRECTIONS: usize = 4;

/// Searches a proof that the links of a pair always collide, or a free state.
pub fn search(
    problem: &PairProblem,
    meshes_are_solid: bool,
    limits: ProofLimits,
    workspace: &mut PairWorkspace,
) -> AlwaysSearch {
    let (mut centre, mut half_widths) = (Vec::new(), Vec::new());
    let mut open = vec![(0, JointBox { ranges: problem.ranges() })];
    let (mut boxes, mut tree) = (0, SplitTree::default());
    let mut found = FoundBalls::default();
    let parts = problem.links.map(LinkGeometry::parts);
    let pairs = parts[0].iter().flat_map(|a| parts[1].iter().map(move |b| [a, b]));
    let mut overlaps: Vec<PartOverlap> =
        pairs.filter_map(|parts| PartOverlap::new(parts, meshes_are_solid)).collect();
    while let Some((node, ranges)) = open.pop() {
        if limits.are_reached(boxes) || limits.options.is_over() || found.is_full() {
            return AlwaysSearch::Exhausted;
        }
        boxes += 1;
        ranges.centre(&mut centre, &mut half_widths);
        if !problem.collides(&centre, workspace) {
            return AlwaysSearch::Free(centre);
        }
        if !problem.bound_motion(&half_widths, workspace) {
            return AlwaysSearch::Exhausted;
        }
        let is_proven = |overlap: &mut PartOverlap| overlap.proof(&half_widths, workspace, &mut found);
        if let Some(proof) = overlaps.iter_mut().find_map(is_proven) {
            tree.prove(node, proof);
            continue;
        }
        let Some(variable) = widest(&workspace.motion.shares, &half_widths) else {
            return AlwaysSearch::Exhausted;
        };
        let lower = tree.split(node, variable);
        let [low, high] = ranges.halves(variable);
        open.extend([(lower + 1, high), (lower, low)]);
    }
    let [balls1, balls2] = found.balls;
    AlwaysSearch::Proven(ContactEvidence { balls1, balls2, contact: None, proof: tree.text() })
}

/// Balls of both links that prove boxes.
#[derive(Default)]
struct FoundBalls {
    balls: [Vec<InnerBall>; 2],
}

impl FoundBalls {
    fn is_full(&self) -> bool {
        self.balls.iter().any(|balls| balls.len() >= MOST_BALLS)
    }

    /// Adds balls; returns their numbers.
    fn add(&mut self, parts: [&SolidPart; 2], found: &ConcentricBalls) -> [u32; 2] {
        [0, 1].map(|side| {
            let SolidPart { shape, face, .. } = *parts[side];
            let (centre, radius) = (found.centres[side].into(), found.radii[side]);
            let ball = InnerBall { shape, face, centre, radius };
            self.balls[side].push(ball);
            u32::try_from(self.balls[side].len() - 1).unwrap_or(u32::MAX)
        })
    }
}

/// Two solids, one of each link.
struct PartOverlap<'p> {
    parts: [&'p SolidPart; 2],
    points: InnerPointSearch,
    meshes_are_solid: bool,
    /// Numbers of the balls that were found.
    known: Vec<[u32; 2]>,
    directions: Vec<PlaneDirection>,
}

impl<'p> PartOverlap<'p> {
    fn new(parts: [&'p SolidPart; 2], meshes_are_solid: bool) -> Option<Self> {
        let directions = directions().map(|n| PlaneDirection::nearest(&n)).collect();
        Some(Self {
            parts,
            points: InnerPointSearch::new()?,
            meshes_are_solid,
            known: Vec::new(),
            directions,
        })
    }

    /// True if another surface inside a solid would be apart from it.
    fn is_hollow(&self, side: usize) -> bool {
        match self.parts[side].inside {
            PartInside::Solid => false,
            PartInside::WholeMesh => !self.meshes_are_solid,
            PartInside::PartOfMesh => true,
        }
    }

    /// Directions along which each solid sticks out of the other in the whole box, where the other is hollow; `None` if there is none.
    fn outside(
        &self,
        half_widths: &[f64],
        workspace: &mut PairWorkspace,
    ) -> Option<[Option<PlaneDirection>; 2]> {
        let placed = self.parts[1].outline.placed(&workspace.placed.pose_ab);
        let outlines = [&self.parts[0].outline, &placed];
        let mut outside = [None; 2];
        for (side, outside) in outside.iter_mut().enumerate() {
            if self.is_hollow(1 - side) {
                let [one, other] = [outlines[side], outlines[1 - side]];
                let found = self.sticking_out([one, other], outlines, half_widths, workspace)?;
                *outside = Some(found);
            }
        }
        Some(outside)
    }

    fn sticking_out(
        &self,
        [one, other]: [&Outline; 2],
        outlines: [&Outline; 2],
        half_widths: &[f64],
        workspace: &mut PairWorkspace,
    ) -> Option<PlaneDirection> {
        let beyond = |n: &Vector| one.extent_along(n)[0] - other.extent_along(n)[1];
        let mut gaps: Vec<(f64, PlaneDirection)> =
            self.directions.iter().map(|n| (beyond(&n.vector()), *n)).collect();
        gaps.sort_by(|a, b| b.0.total_cmp(&a.0));
        let PairWorkspace { placed, motion, .. } = workspace;
        let is_enough = |(gap, n): &&(f64, PlaneDirection)| {
            *gap > 0.0
                && (*gap > motion.bound
                    || *gap > motion.along(&n.vector(), PlacedBox { placed, outlines, half_widths }))
        };
        gaps.iter().take(MOST_DIRECTIONS).find(is_enough).map(|(_, n)| *n)
    }

    /// Balls that prove that the solids touch in the whole box.
    fn proof(
        &mut self,
        half_widths: &[f64],
        workspace: &mut PairWorkspace,
        found: &mut FoundBalls,
    ) -> Option<LeafProof> {
        let outside = self.outside(half_widths, workspace)?;
        let known = self.known.iter().rev().take(TRIED_AGAIN);
        let overlap = |balls: &&[u32; 2]| overlap(found, **balls, half_widths, workspace);
        if let Some(&balls) = known.clone().find(overlap) {
            return Some(LeafProof::Overlap { balls, outside });
        }
        let [a, b] = self.parts;
        let region = common_box(&a.outline, &b.outline.placed(&workspace.placed.pose_ab))?;
        let PairWorkspace { placed, scratch, .. } = workspace;
        let overlap = OverlapBox { depths: [&a.depths, &b.depths], placed, half_widths, region };
        let balls = found.add(self.parts, &self.points.find(&overlap, scratch)?);
        self.known.push(balls);
        Some(LeafProof::Overlap { balls, outside })
    }
}

/// True if two balls overlap in the whole box.
fn overlap(found: &FoundBalls, balls: [u32; 2], half_widths: &[f64], workspace: &PairWorkspace) -> bool {
    let [a, b] = [0, 1].map(|side| &found.balls[side][balls[side] as usize]);
    let placed = &workspace.placed;
    let [p, q] = [Point::from(a.centre), &placed.pose_ab * Point::from(b.centre)];
    (p - q).norm() + displacement(placed, half_widths, [&p, &q]) < a.radius + b.radius
}

/// The box (m) that two outlines have in common.
fn common_box(a: &Outline, b: &Outline) -> Option<[Point; 2]> {
    let largest = |n: Vector| a.extent_along(&n)[1].min(b.extent_along(&n)[1]);
    let ends = |sign: f64| [0, 1, 2].map(|axis| sign * largest(Vector::ith(axis, sign)));
    let [low, high] = [Point::from(ends(-1.0)), Point::from(ends(1.0))];
    (0..3).all(|axis| low[axis] < high[axis]).then_some([low, high])
}
