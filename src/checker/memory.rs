//! What a workspace remembers of the last states, so that a stream of states costs little.
//!
//! For each pair a distance that it certainly had at some pose. At another pose it has lost at most what the second body has
//! moved in the frame of the first (section 4 of the house's notes calls it the motion bound; here both poses are known, so
//! it is the largest displacement of the body's sphere). Only a pair whose bound has run out is asked again. And two points
//! of the bodies that were nearest bound the distance from above, so that the next search has little to look at.
//!
//! Neither changes an answer: the search's result does not depend on the limit that it is given, as long as the limit is
//! not below it.

use super::pair::Pair;
use super::report::PairDistance;
use crate::constants::CONTACT_DISTANCE;
use crate::math::{MatrixPose, Point};
use crate::query::{BoundingSphere, Scratch};

/// How far (m) beyond what was asked a pair's distance is looked for, to know it for some states to come.
const LOOK_AHEAD: f64 = 0.03;

/// Rounding (m, relative to the coordinates that enter) granted to displacements and remembered points.
const ROUNDING: f64 = 1e-13;

/// What is known about all pairs of one checker.
#[derive(Clone, Debug)]
pub(super) struct Memories {
    /// The checker that they are about.
    pub checker: u64,
    pub pairs: Vec<Option<Memory>>,
}

impl Memories {
    /// What is known about a pair of a checker; nothing if it is another one's.
    pub fn of_pair(&mut self, checker: u64, index: usize) -> Option<&mut Option<Memory>> {
        if self.checker == checker { self.pairs.get_mut(index) } else { None }
    }
}

/// What is known about a pair.
#[derive(Clone, Copy, Debug)]
pub(super) struct Memory {
    pose_ab: MatrixPose,
    /// The bodies were not nearer than this (m) at that pose, padding not taken off.
    lower: f64,
    /// A point of each body in its own frame, near each other at that pose.
    witnesses: Option<[Point; 2]>,
}

impl Memory {
    /// A number never larger than the bodies' distance (m) at another pose.
    fn lower_at(&self, pose_ab: &MatrixPose, sphere_b: &BoundingSphere) -> f64 {
        self.lower - displacement(&self.pose_ab, pose_ab, sphere_b) - CONTACT_DISTANCE
    }

    /// A number never smaller than the bodies' distance (m) at another pose.
    fn upper_at(&self, pose_ab: &MatrixPose) -> f64 {
        self.witnesses.map_or(f64::INFINITY, |[on_a, on_b]| {
            let moved = pose_ab * on_b;
            let rounding = ROUNDING * (on_a.coords.abs().sum() + moved.coords.abs().sum());
            nalgebra::distance(&on_a, &moved) + rounding + CONTACT_DISTANCE
        })
    }
}

/// The farthest (m) that a point of a sphere moves between two poses: what its centre moves, and what its radius turns. The
/// largest stretch of a matrix is at most its Frobenius norm.
fn displacement(from: &MatrixPose, to: &MatrixPose, sphere: &BoundingSphere) -> f64 {
    let (p, q) = (from * sphere.centre, to * sphere.centre);
    let turn = (to.rotation - from.rotation).norm();
    let rounding = ROUNDING * (p.coords.abs().sum() + q.coords.abs().sum() + sphere.radius);
    nalgebra::distance(&p, &q) + turn * sphere.radius + rounding
}

impl Pair<'_> {
    /// As [`Pair::touches`], with what is remembered.
    pub fn touches_remembering(&self, memory: &mut Option<Memory>, scratch: &mut Scratch) -> bool {
        let padding = self.info.padding;
        if self.is_known_beyond(padding, memory.as_ref()) {
            return false;
        }
        let limit = padding + LOOK_AHEAD;
        self.distance_remembering(limit - padding, memory, scratch).is_some_and(|found| found.distance == 0.0)
    }

    /// As [`Pair::distance`], with what is remembered.
    pub fn distance_remembering(
        &self,
        limit: f64,
        memory: &mut Option<Memory>,
        scratch: &mut Scratch,
    ) -> Option<PairDistance> {
        let padding = self.info.padding;
        if self.is_known_beyond(limit + padding, memory.as_ref()) {
            return None;
        }
        let upper = memory.as_ref().map_or(f64::INFINITY, |m| m.upper_at(&self.pose_ab));
        let tight = (upper - padding).max(0.0);
        let found = (tight < limit).then(|| self.distance(tight, scratch)).flatten();
        let found = found.or_else(|| self.distance(limit, scratch));
        let witnesses = found.map(|f| self.in_own_frames(&f));
        let lower = found.map_or(limit + padding, |f| f.distance + if f.distance > 0.0 { padding } else { 0.0 });
        *memory = Some(Memory { pose_ab: self.pose_ab, lower, witnesses });
        found
    }

    fn is_known_beyond(&self, limit: f64, memory: Option<&Memory>) -> bool {
        memory.is_some_and(|m| m.lower_at(&self.pose_ab, self.bodies.1.bounding_sphere()) > limit)
    }

    /// Witness points of the root frame in the frames of the bodies.
    fn in_own_frames(&self, found: &PairDistance) -> [Point; 2] {
        let in_a = self.pose_ra.inverse();
        let [on_a, on_b] = found.witness_points.map(|p| &in_a * p);
        [on_a, &self.pose_ab.inverse() * on_b]
    }
}
