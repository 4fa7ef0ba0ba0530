//! Kinematic path between two bodies: relative poses, and bounds on the relative motion.
//!
//! All quantities are relative to the bodies' lowest common ancestor; joints nearer to the root move both bodies alike. The bounds are
//! derived in `docs/derivations/motion-bound.md`; the symbols here are the same.

use std::ops::Range;

use clearance_geometry::math::{Extremes, UnitVector, Vector};
use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{Simd, f64x8, sin_cos};

use super::{Body, Chain, Columns, Frame, PlacedFrame, Step};

/// The path from each body up to the root. A body's path is the end of the path of a leaf below it, so that a serial chain stores one
/// path for all.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PathsToRoot {
    /// The paths from leaves to the root, one after the other.
    bodies: Vec<usize>,
    /// By body: the range of its path, from the body itself to the root.
    ways: Vec<Range<usize>>,
}

/// The paths of two bodies to their lowest common ancestor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KinematicPath<'w> {
    ancestor: usize,
    /// By side: bodies from the most distal one up to the ancestor, which is excluded.
    sides: [&'w [usize]; 2],
}

/// Bound on the deviation of a position, within an interval, from its value in the middle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// Velocity in the middle, per unit of t.
    pub velocity: f64,
    /// δ: the maximum deviation within the interval, to either side.
    pub most: f64,
    /// The part of δ beyond the motion at the velocity in the middle.
    pub curvature: f64,
    /// Tolerance that does not depend on the interval; not included in the others.
    pub tolerance: f64,
}

/// Deviation of positions within an interval.
pub trait Deviations {
    /// Deviation of a position; not used for quaternions.
    fn of(&self, position: usize) -> Deviation;

    /// Half the width of the interval, in t.
    fn half_width(&self) -> f64;

    /// The rotation of a floating joint whose positions begin at `first`: axis in the joint's frame, and angle per unit of t.
    fn turn(&self, first: usize) -> Option<(UnitVector, f64)>;
}

/// All points within `radius` of a segment, in the frame of the ancestor.
#[derive(Clone, Copy, Debug)]
pub struct Reach {
    /// End points (m) of the segment.
    pub ends: [Vector; 2],
    /// Radius (m).
    pub radius: f64,
}

/// Motion of one of the bodies, in the frame of the ancestor.
#[derive(Clone, Copy, Debug, Default)]
pub struct SideMotion {
    /// W, for the interval's width alone.
    pub path_length: f64,
    /// Contribution of tolerances to W.
    pub tolerance: f64,
    /// R.
    pub remainder: f64,
    /// K, for the interval's width alone.
    pub curvature: f64,
    /// Maximum distance (m) of the frames on the path from the ancestor's origin; rounding errors are proportional to it.
    pub extent: f64,
    /// Velocity (per unit of t) of the body point at the ancestor's origin, and angular velocity.
    pub velocity: Vector,
    /// Angular velocity (rad per unit of t).
    pub angular: Vector,
}

impl Chain {
    /// The kinematic paths of all bodies to the root.
    #[must_use]
    #[inline]
    pub fn paths_to_root(&self) -> PathsToRoot {
        let mut found = PathsToRoot { bodies: Vec::new(), ways: vec![0..0; self.body_count()] };
        // children before parents: a body that is not on any path yet is a leaf
        for leaf in (0..self.body_count()).rev() {
            if found.ways[leaf].is_empty() {
                found.add(leaf, |body| self.bodies[body - 1].parent);
            }
        }
        found
    }

    /// The positions of the joints on a path, which move one body relative to the other.
    pub fn positions_on(&self, path: KinematicPath) -> impl Iterator<Item = usize> {
        path.sides.into_iter().flatten().flat_map(|body| match self.bodies[body - 1].step {
            Step::Turn(_, source) | Step::Shift(_, source) => source.index..source.index + 1,
            Step::Float(_, first) => first..first + 7,
        })
    }

    /// Computes the frames of the bodies between two bodies, and of the two, in their lowest common ancestor.
    #[inline(always)]
    pub fn frames_between<S: Simd>(
        &self,
        simd: S,
        between: &KinematicPath,
        positions: &[f64],
        frames: &mut [PlacedFrame],
    ) {
        let q = |i: usize| positions[i];
        frames[between.ancestor] = PlacedFrame::IDENTITY;
        for side in between.sides {
            let mut last = Columns::of(simd, &PlacedFrame::IDENTITY);
            for eight in side.rchunks(8) {
                let mut angles = [0.0; 8];
                for (angle, body) in angles.iter_mut().zip(eight) {
                    *angle = self.bodies[body - 1].angle(q);
                }
                let (sin, cos) = sin_cos(f64x8::simd_from(simd, angles));
                for (lane, &i) in eight.iter().enumerate().rev() {
                    last = self.bodies[i - 1].columns(simd, positions, &last, (sin[lane], cos[lane]));
                    frames[i] = last.placed();
                }
            }
        }
    }

    /// The motion of one of two bodies, computed from their frames: the body at the end of a side, whose points lie within `reach`.
    #[must_use]
    #[inline]
    pub fn side_motion(
        &self,
        side: &[usize],
        reach: &Reach,
        frames: &[PlacedFrame],
        deviations: &impl Deviations,
    ) -> SideMotion {
        let mut motion = SideMotion::default();
        for &i in side {
            self.bodies[i - 1].add_motion(&mut motion, reach, &frames[i].frame(), frames, deviations);
        }
        motion
    }

    /// For each joint from a body up to the root: upper bound on the motion, by the joints before it, of all points within `reach` metres
    /// of the body's origin. These are bounds W with the reaches of fully stretched chains, so they hold for all joint positions. There
    /// is one more entry than joints. `range` gives the maximum absolute value of a position.
    #[inline]
    pub fn stretched_ways(
        &self,
        mut body: usize,
        reach: f64,
        deviations: &impl Deviations,
        range: impl Fn(usize) -> f64,
        ways: &mut Vec<f64>,
    ) {
        let (mut extent, mut path_length) = (reach, 0.0);
        ways.push(path_length);
        while body != 0 {
            let joint = &self.bodies[body - 1];
            let stretch = joint.add_stretched_path(&mut path_length, extent, deviations, &range);
            extent += norm(joint.origin) + stretch;
            ways.push(path_length);
            body = joint.parent;
        }
    }
}

impl PathsToRoot {
    /// Adds the path from a leaf.
    fn add(&mut self, leaf: usize, parent: impl Fn(usize) -> usize) {
        let mut body = leaf;
        let first = self.bodies.len();
        self.bodies.push(body);
        while body != Chain::ROOT {
            body = parent(body);
            self.bodies.push(body);
        }
        let end = self.bodies.len();
        for start in first..end {
            let body = self.bodies[start];
            if self.ways[body].is_empty() {
                self.ways[body] = start..end;
            }
        }
    }

    /// The bodies from one up to the root, both included.
    fn path_to_root(&self, body: usize) -> &[usize] {
        &self.bodies[self.ways[body].clone()]
    }

    /// Number of joints between a body and the root.
    #[must_use]
    #[inline]
    pub fn depth(&self, body: usize) -> usize {
        self.ways[body].len() - 1
    }

    /// For each body: the depth of its lowest common ancestor with this one.
    #[must_use]
    #[inline]
    pub fn common_depths(&self, body: usize) -> Vec<usize> {
        let mut depths = vec![usize::MAX; self.ways.len()];
        for above in self.path_to_root(body) {
            depths[*above] = self.depth(*above);
        }
        // parents come before their children
        for other in 0..depths.len() {
            if depths[other] == usize::MAX {
                depths[other] = depths[self.path_to_root(other)[1]];
            }
        }
        depths
    }

    /// The paths of two bodies, with the given numbers of joints on either side of their lowest common ancestor.
    #[must_use]
    #[inline]
    pub fn between(&self, bodies: [usize; 2], joints: [usize; 2]) -> KinematicPath<'_> {
        let side = |i: usize| &self.path_to_root(bodies[i])[..joints[i]];
        KinematicPath { ancestor: self.path_to_root(bodies[0])[joints[0]], sides: [side(0), side(1)] }
    }

    /// The path between a body and the root.
    #[must_use]
    #[inline]
    pub fn to_root(&self, body: usize) -> KinematicPath<'_> {
        self.between([body, Chain::ROOT], [self.depth(body), 0])
    }

    /// Number of bodies in all stored paths.
    #[must_use]
    #[inline]
    pub fn stored(&self) -> usize {
        self.bodies.len()
    }
}

impl KinematicPath<'_> {
    /// Bodies on the path from one of the two to the ancestor, which is excluded.
    #[must_use]
    #[inline]
    pub fn side(&self, side: usize) -> &[usize] {
        self.sides[side]
    }
}

impl Body {
    /// Adds the motion, by this joint, of points within `extent` of its origin; returns the translation by the joint itself.
    fn add_stretched_path(
        &self,
        path_length: &mut f64,
        extent: f64,
        deviations: &impl Deviations,
        range: impl Fn(usize) -> f64,
    ) -> f64 {
        match &self.step {
            Step::Turn(_, source) => {
                let d = deviations.of(source.index);
                *path_length += source.multiplier.abs() * (d.most + d.tolerance) * extent;
                0.0
            }
            Step::Shift(_, source) => {
                let d = deviations.of(source.index);
                *path_length += source.multiplier.abs() * (d.most + d.tolerance);
                source.multiplier.abs() * range(source.index) + source.offset.abs()
            }
            Step::Float(_, first) => {
                let shift = (0..3).map(|k| deviations.of(first + k).most).sum::<f64>();
                let turn = deviations.turn(*first).map_or(0.0, |(_, angle)| angle.abs());
                *path_length += shift + turn * deviations.half_width() * extent;
                (0..3).map(|k| range(first + k)).sum()
            }
        }
    }

    /// Adds the motion by this body's joint to the motion of a body further out.
    #[inline]
    fn add_motion(
        &self,
        motion: &mut SideMotion,
        reach: &Reach,
        frame: &Frame<f64>,
        frames: &[PlacedFrame],
        deviations: &impl Deviations,
    ) {
        motion.extent = motion.extent.greater(Vector::from(frame.t).abs().sum());
        match &self.step {
            Step::Turn(_, source) => {
                let deviation = deviations.of(source.index).times(source.multiplier);
                motion.turn(&Vector::from(frame.r[2]), &Vector::from(frame.t), &deviation, reach);
            }
            Step::Shift(axis, source) => {
                let deviation = deviations.of(source.index).times(source.multiplier);
                motion.shift(
                    Vector::from(frames[self.parent].frame().turn(*axis)) * deviation.velocity,
                    &deviation,
                );
            }
            Step::Float(columns, first) => {
                let joint = frames[self.parent].frame().then(&Frame { r: *columns, t: self.origin });
                let out = |v: [f64; 3]| Vector::from(joint.turn(v));
                if let Some((axis, angle)) = deviations.turn(*first) {
                    let most = angle.abs() * deviations.half_width();
                    let deviation = Deviation { velocity: angle, most, ..Deviation::default() };
                    motion.turn(&out(axis.into_inner().into()), &Vector::from(frame.t), &deviation, reach);
                }
                let along = [0, 1, 2].map(|k| deviations.of(first + k));
                let length =
                    |of: fn(&Deviation) -> f64| along.iter().map(|d| of(d).powi(2)).sum::<f64>().sqrt();
                let deviation = Deviation {
                    velocity: 0.0,
                    most: length(|d| d.most),
                    curvature: length(|d| d.curvature),
                    tolerance: length(|d| d.tolerance),
                };
                motion.shift(out(along.map(|d| d.velocity)), &deviation);
            }
        }
    }
}

impl Deviation {
    #[inline]
    fn times(&self, multiplier: f64) -> Self {
        let size = multiplier.abs();
        Self {
            velocity: self.velocity * multiplier,
            most: self.most * size,
            curvature: self.curvature * size,
            tolerance: self.tolerance * size,
        }
    }
}

impl Reach {
    /// Upper bound (m) on the distance of its points from an axis.
    #[inline]
    fn farthest_from(&self, axis: &Vector, origin: &Vector) -> f64 {
        let [p, q] = [axis.cross(&(self.ends[0] - origin)), axis.cross(&(self.ends[1] - origin))];
        p.norm_squared().greater(q.norm_squared()).sqrt() + self.radius
    }

    /// Upper bound on the distance of its points from the origin, in the 1-norm.
    #[must_use]
    #[inline]
    pub fn extent(&self) -> f64 {
        self.ends.iter().map(|p| p.abs().sum()).fold(0.0, f64::greater) + 2.0 * self.radius
    }

    /// Maximum speed of its points, per unit of t.
    #[inline]
    #[must_use]
    pub fn speed(&self, velocity: &Vector, angular: &Vector) -> f64 {
        let [p, q] = [velocity + angular.cross(&self.ends[0]), velocity + angular.cross(&self.ends[1])];
        p.norm_squared().greater(q.norm_squared()).sqrt() + angular.norm() * self.radius
    }
}

impl SideMotion {
    /// Adds a revolute joint, nearer to the ancestor than the joints so far.
    #[inline]
    pub fn turn(&mut self, axis: &Vector, origin: &Vector, deviation: &Deviation, reach: &Reach) {
        let Deviation { velocity, most, curvature, tolerance } = *deviation;
        let moved = self.path_length + self.tolerance;
        let far = reach.farthest_from(axis, origin) + moved;
        self.remainder += (most + tolerance) * (moved + 0.5 * (most + tolerance) * far);
        self.path_length += most * far;
        self.tolerance += tolerance * far;
        self.curvature += curvature * far;
        let angular = axis * velocity;
        self.angular += angular;
        self.velocity += origin.cross(&angular);
    }

    /// Adds a prismatic joint.
    #[inline]
    pub fn shift(&mut self, velocity: Vector, deviation: &Deviation) {
        self.path_length += deviation.most;
        self.tolerance += deviation.tolerance;
        self.curvature += deviation.curvature;
        self.velocity += velocity;
    }
}

fn norm(v: [f64; 3]) -> f64 {
    Vector::from(v).norm()
}

#[cfg(test)]
mod tests {
    use crate::Chain;
    use crate::chain::tests::random_tree;
    use clearance_geometry::testing::Random;

    /// The paths between all bodies of random trees equal those found by going up from both bodies.
    #[test]
    fn ways_meet_at_the_lowest_common_ancestor() {
        let mut random = Random::new(31);
        for _ in 0..100 {
            let (joints, _, needed) = random_tree(&mut random, 12);
            let chain = Chain::compile(0, &joints, &needed);
            let ways = chain.paths_to_root();
            let up = |mut body: usize| {
                let mut path = vec![body];
                while body != Chain::ROOT {
                    body = chain.bodies[body - 1].parent;
                    path.push(body);
                }
                path
            };
            for a in 0..chain.body_count() {
                let common = ways.common_depths(a);
                for (b, common) in common.iter().enumerate() {
                    let (mut first, mut second) = (up(a), up(b));
                    while first.len() > 1
                        && second.len() > 1
                        && first[first.len() - 2..] == second[second.len() - 2..]
                    {
                        first.pop();
                        second.pop();
                    }
                    let (ancestor, _) = (first.pop(), second.pop());
                    let between = ways.between([a, b], [a, b].map(|body| ways.depth(body) - common));
                    assert_eq!(
                        (Some(between.ancestor), between.side(0), between.side(1)),
                        (ancestor, &*first, &*second)
                    );
                }
                let (mut path, root) = (up(a), ways.to_root(a));
                path.pop();
                assert_eq!((root.side(0), root.side(1)), (&*path, &[][..]));
            }
        }
    }
}
