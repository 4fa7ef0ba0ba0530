//! Proof that two links always collide: branch and bound with lower bounds of penetration depth.
//!
//! Two connected solids, one of each link, overlap at the centre of a box. Either a point is so deep in both that it stays inside both. Or
//! the lower bound of the penetration depth, which is that of two convex sets, one in each solid, exceeds the motion: these sets still
//! overlap after any such motion, rotations included. Where meshes are surfaces, the solids must also stick out of each other's hulls by
//! more than the motion: two connected surfaces without common points are apart, or one is inside the other.

use clearance_geometry::math::{Point, Vector};
use clearance_proximity::penetration_depth;

use crate::inner_points::{InnerPointSearch, OverlapBox};
use crate::joint_box::JointBox;
use crate::link_geometry::LinkGeometry;
use crate::never_proof::{ProofLimits, widest};
use crate::outline::{Outline, directions};
use crate::pair_problem::{PairProblem, PairWorkspace};
use crate::solid_parts::SolidPart;

/// Result of the search.
#[derive(Debug)]
pub enum AlwaysSearch {
    /// The links collide in all boxes.
    Proven,
    /// Values of the variables at which the links are apart.
    Free(Vec<f64>),
    /// The limits were reached first.
    Exhausted,
}

/// Boxes in which penetration depths are computed: beyond, they cost too much.
const DEPTH_BOXES: u64 = 200;

/// Searches a proof that the links of a pair always collide, or a free state.
pub fn search(
    problem: &PairProblem,
    meshes_are_solid: bool,
    limits: ProofLimits,
    workspace: &mut PairWorkspace,
) -> AlwaysSearch {
    let (mut centre, mut half_widths) = (Vec::new(), Vec::new());
    let mut open = vec![JointBox { ranges: problem.ranges() }];
    let mut boxes = 0;
    let parts = problem.links.map(LinkGeometry::parts);
    let pairs = parts[0].iter().flat_map(|a| parts[1].iter().map(move |b| [a, b]));
    let mut overlaps: Vec<PartOverlap> = pairs
        .filter_map(|parts| Some(PartOverlap { parts, points: InnerPointSearch::new()?, meshes_are_solid }))
        .collect();
    while let Some(ranges) = open.pop() {
        if limits.are_reached(boxes) || limits.options.is_over() {
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
        let with_depth = boxes <= DEPTH_BOXES;
        if overlaps.iter_mut().any(|o| o.is_constant(&half_widths, with_depth, workspace)) {
            continue;
        }
        let Some(variable) = widest(&workspace.motion.shares, &half_widths) else {
            return AlwaysSearch::Exhausted;
        };
        open.extend(ranges.halves(variable));
    }
    AlwaysSearch::Proven
}

/// Two solids, one of each link.
struct PartOverlap<'p> {
    parts: [&'p SolidPart; 2],
    points: InnerPointSearch,
    meshes_are_solid: bool,
}

impl PartOverlap<'_> {
    /// True if neither solid can lie inside the surface of the other, anywhere in the box.
    fn sticks_out(&self, workspace: &PairWorkspace) -> bool {
        let [a, b] = self.parts;
        let placed = b.outline.placed(&workspace.placed.pose_ab);
        let sticks_out = |one: &Outline, other: &Outline| {
            let beyond = |n| one.extent_along(&n)[0] - other.extent_along(&n)[1];
            directions().any(|n| beyond(n) > workspace.motion.bound)
        };
        // only a surface can contain the other solid without contact
        self.meshes_are_solid
            || ((!b.is_mesh || sticks_out(&a.outline, &placed))
                && (!a.is_mesh || sticks_out(&placed, &a.outline)))
    }

    /// True if the solids are proven to touch in the whole box.
    fn is_constant(&mut self, half_widths: &[f64], with_depth: bool, workspace: &mut PairWorkspace) -> bool {
        if !self.sticks_out(workspace) {
            return false;
        }
        let [a, b] = self.parts;
        let placed = b.outline.placed(&workspace.placed.pose_ab);
        let Some(region) = common_box(&a.outline, &placed) else { return false };
        let PairWorkspace { placed, motion, scratch, .. } = workspace;
        let depths = [&a.depths, &b.depths];
        let overlap = OverlapBox { depths, placed, half_widths, region, contact: None };
        if self.points.finds_constant_overlap(&overlap, scratch) {
            return true;
        }
        with_depth
            && penetration_depth(&a.solid, &b.solid, placed.pose_ab, 0.0, scratch)
                .is_some_and(|depth| depth.unknown.is_none() && depth.lower > motion.bound)
    }
}

/// The box (m) that two outlines have in common.
fn common_box(a: &Outline, b: &Outline) -> Option<[Point; 2]> {
    let largest = |n: Vector| a.extent_along(&n)[1].min(b.extent_along(&n)[1]);
    let ends = |sign: f64| [0, 1, 2].map(|axis| sign * largest(Vector::ith(axis, sign)));
    let [low, high] = [Point::from(ends(-1.0)), Point::from(ends(1.0))];
    (0..3).all(|axis| low[axis] < high[axis]).then_some([low, high])
}
