//! One pair of links: distances and motions as functions of the joint positions between them.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::Vector;
use clearance_proximity::{BodyPair, Effort, Scratch, Separation, distance, distance_bounds};

use crate::joint_path::{JointPath, PlacedPath};
use crate::link_geometry::LinkGeometry;
use crate::outline::Outline;
use crate::plane_direction::PlaneDirection;
use crate::relative_motion::{PlacedBox, RelativeMotion};
use crate::split_tree::LeafProof;

/// A pair of links whose collisions are searched or excluded.
#[derive(Debug)]
pub struct PairProblem<'g> {
    /// First and second link.
    pub links: [&'g LinkGeometry; 2],
    /// The joints between them.
    pub path: JointPath,
}

/// Memory of the queries of one thread on one pair.
#[derive(Debug)]
pub struct PairWorkspace {
    /// The path at the last state.
    pub placed: PlacedPath,
    /// Its motion within the last box.
    pub motion: RelativeMotion,
    /// Outline of the second link in the frame of the first.
    outline: Option<Outline>,
    /// Memory of distance queries.
    pub scratch: Scratch,
}

/// Relative error that distances may have where they only order the search.
const ROUGH: f64 = 0.25;

impl PairProblem<'_> {
    /// Memory for queries.
    #[must_use]
    pub fn workspace(&self, scratch: Scratch) -> PairWorkspace {
        let outline = self.links[1].outline.clone();
        PairWorkspace { placed: self.path.placed(), motion: RelativeMotion::default(), outline, scratch }
    }

    /// Sum (m) of the paddings of the links.
    #[must_use]
    pub fn padding(&self) -> f64 {
        self.links[0].padding + self.links[1].padding
    }

    /// Distance (m) at or below which the links collide: the sum of their paddings, and that of contact.
    #[must_use]
    pub fn threshold(&self) -> f64 {
        self.padding() + CONTACT_DISTANCE
    }

    /// Ranges of the variables.
    pub fn ranges(&self) -> Vec<[f64; 2]> {
        self.path.variables().iter().map(|variable| variable.range).collect()
    }

    /// True if the links collide at a state.
    pub fn collides(&self, values: &[f64], workspace: &mut PairWorkspace) -> bool {
        self.path.place(values, &mut workspace.placed);
        let [a, b] = self.links;
        let limit = self.threshold();
        distance(&a.body, &b.body, workspace.placed.pose_ab, limit, &mut workspace.scratch).is_some()
    }

    /// The distance (m) of the links at a state within a relative error, an upper bound.
    pub fn rough_distance(&self, values: &[f64], workspace: &mut PairWorkspace) -> f64 {
        self.path.place(values, &mut workspace.placed);
        self.placed_distance(f64::INFINITY, workspace).map_or(f64::INFINITY, |nearest| nearest.distance)
    }

    /// Near points at the placed state, or `None` if the distance is proven larger than `limit` (m).
    pub fn placed_distance(&self, limit: f64, workspace: &mut PairWorkspace) -> Option<Separation> {
        let [a, b] = self.links;
        let PairWorkspace { placed, scratch, .. } = workspace;
        let bodies = BodyPair { a: &a.body, b: &b.body, pose_ab: &placed.pose_ab };
        let effort =
            Effort { relative_tolerance: ROUGH, exact_within: self.threshold(), ..Effort::default() };
        distance_bounds(bodies, limit, &effort, scratch).upper
    }

    /// The distance (m) at a state and its derivative by each variable.
    pub fn distance_and_gradient(
        &self,
        values: &[f64],
        gradient: &mut [f64],
        workspace: &mut PairWorkspace,
    ) -> f64 {
        self.path.place(values, &mut workspace.placed);
        let [a, b] = self.links;
        let PairWorkspace { placed, scratch, .. } = workspace;
        gradient.fill(0.0);
        let Some(nearest) = distance(&a.body, &b.body, placed.pose_ab, f64::INFINITY, scratch) else {
            return f64::INFINITY;
        };
        let [p, q] = nearest.witness_points;
        let Some(out) = (q - p).try_normalize(0.0) else { return nearest.distance };
        for axis in &placed.axes {
            let velocity: Vector = if axis.turns { axis.axis.cross(&(q - axis.origin)) } else { axis.axis };
            gradient[axis.variable] += axis.factor * out.dot(&velocity);
        }
        nearest.distance
    }

    /// Bounds the motion of the links within a box around the placed state; false if a link has no bounds.
    pub fn bound_motion(&self, half_widths: &[f64], workspace: &mut PairWorkspace) -> bool {
        let PairWorkspace { placed, motion, outline, .. } = workspace;
        let [Some(of_a), Some(of_b)] = [&self.links[0].outline, &self.links[1].outline] else { return false };
        let Some(outline) = outline else { return false };
        of_b.place(&placed.pose_ab, outline);
        motion.compute(PlacedBox { placed, outlines: [of_a, outline], half_widths }, self.path.size());
        true
    }

    /// A proof that the links are apart in the box of the last [`Self::bound_motion`], by the gap along the direction between two near
    /// points or along a joint axis.
    pub fn gap_proof(
        &self,
        near: &Separation,
        half_widths: &[f64],
        workspace: &mut PairWorkspace,
    ) -> Option<LeafProof> {
        let between = near.witness_points[1] - near.witness_points[0];
        let between = between.try_normalize(0.0)?;
        let coded = PlaneDirection::nearest(&between);
        if self.gap_exceeds_motion(&coded.vector(), half_widths, workspace) {
            return Some(LeafProof::GapAlong(coded));
        }
        for k in 0..workspace.placed.axes.len() {
            let axis = workspace.placed.axes[k].axis;
            let along = axis.dot(&between);
            let direction = if along < 0.0 { -axis } else { axis };
            if along.abs() > 0.9 && self.gap_exceeds_motion(&direction, half_widths, workspace) {
                return Some(LeafProof::GapAlongAxis);
            }
        }
        None
    }

    fn gap_exceeds_motion(
        &self,
        direction: &Vector,
        half_widths: &[f64],
        workspace: &mut PairWorkspace,
    ) -> bool {
        let [Some(of_a), Some(of_b)] = [&self.links[0].outline, &self.links[1].outline] else { return false };
        let PairWorkspace { placed, motion, outline: Some(outline), .. } = workspace else { return false };
        let (pose, back) = (&placed.pose_ab, placed.pose_ab.rotation.tr_mul(direction));
        let least_of_b = direction.dot(&pose.translation) - of_b.exact_extent(&-back);
        let gap = least_of_b - of_a.exact_extent(direction) - self.threshold();
        gap > 0.0
            && gap > motion.along(direction, PlacedBox { placed, outlines: [of_a, outline], half_widths })
    }
}
