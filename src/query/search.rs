//! One search through all pairs of parts of two bodies.

use super::body::CollisionBody;
use super::containment::Interior;
use super::distance::Effort;
use super::element_pair::Separation;
use super::incumbent::Incumbent;
use super::scratch::Scratch;
use super::solid_solid::SolidSolid;
use super::surface_solid::SurfaceSolid;
use super::surface_surface::SurfaceSurface;
use crate::bounding_volume::{BoundingVolume, Relative};
use crate::bvh::{Entry, Tree, Visitor, descend};
use crate::constants::CONTACT_DISTANCE;
use crate::math::{MatrixPose, Pose};
use crate::simd::{Level, dispatch_lean};

/// What is looked for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Goal {
    /// Nothing farther than this (m) matters.
    pub limit: f64,
    /// Nothing nearer than this (m) is looked for.
    pub enough: f64,
    pub effort: Effort,
}

impl Goal {
    /// The least distance, however large.
    pub const EXACT: Self = Self {
        limit: f64::INFINITY,
        enough: 0.0,
        effort: Effort { relative_tolerance: 0.0, absolute_tolerance: 0.0, deadline: None },
    };
}

/// What was found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    /// The nearest within the limit that was seen.
    pub best: Option<Separation>,
    /// Nothing that was not looked at is nearer than this (m); infinite when everything was.
    pub unseen: f64,
}

/// Looks at all pairs of parts of two bodies that matter for `goal`. With `SEPARATE` only contact matters.
pub(super) fn search<B: BoundingVolume, const SEPARATE: bool>(
    (a, b): (&CollisionBody<B>, &CollisionBody<B>),
    pose_ab: &MatrixPose,
    goal: Goal,
    scratch: &mut Scratch,
) -> Found {
    // spheres cost a tenth of what it takes to begin
    if a.bounding_sphere().lower_bound(b.bounding_sphere(), pose_ab) > goal.limit.max(CONTACT_DISTANCE) {
        scratch.work.volume_tests += 1;
        return Found { best: None, unseen: f64::INFINITY };
    }
    let Scratch { work, stack, candidates, level } = scratch;
    let mut descent = Descent { level: *level, stack, unseen: f64::INFINITY };
    let mut incumbent = Incumbent::new(goal, work);
    if a.has_solids() || b.has_solids() {
        solids::<B, SEPARATE>((a, b), pose_ab, &mut incumbent, &mut descent);
    }
    if let (Some(a), Some(b)) = (&a.surface, &b.surface) {
        let relative = &a.tree.relative(&b.tree, pose_ab);
        let incumbent = &mut incumbent;
        candidates.begin(if SEPARATE { None } else { Some(relative) });
        let mut visitor = SurfaceSurface::<B, SEPARATE> { a, b, pose_ab, relative, incumbent, candidates };
        descent.run((&a.tree, &b.tree), relative, &mut visitor);
        visitor.measure_candidates();
    }
    let touching = incumbent.best.is_some_and(|best| best.distance == 0.0);
    if !touching && let Some((a, b)) = a.interior.as_ref().zip(b.interior.as_ref()) {
        let inside = Interior::contained_point(a, b, &Pose::from(pose_ab));
        incumbent.best = inside.map(Separation::touching_at).or(incumbent.best);
    }
    Found { best: incumbent.best, unseen: descent.unseen }
}

fn solids<B: BoundingVolume, const SEPARATE: bool>(
    (a, b): (&CollisionBody<B>, &CollisionBody<B>),
    pose_ab: &MatrixPose,
    incumbent: &mut Incumbent,
    descent: &mut Descent,
) {
    if let (Some(a), Some(b)) = (&a.solids, &b.solids) {
        let relative = &a.relative(b, pose_ab);
        descent.run((a, b), relative, &mut SolidSolid::<SEPARATE> { pose_ab, incumbent });
    }
    if let (Some(solids), Some(surface)) = (&a.solids, &b.surface) {
        let relative = &solids.relative(&surface.tree, pose_ab);
        let visitor =
            &mut SurfaceSolid::<B, SEPARATE> { surface, solid_is_a: true, pose_ab, relative, incumbent };
        descent.run((solids, &surface.tree), relative, visitor);
    }
    if let (Some(surface), Some(solids)) = (&a.surface, &b.solids) {
        let relative = &solids.relative(&surface.tree, &pose_ab.inverse());
        let visitor =
            &mut SurfaceSolid::<B, SEPARATE> { surface, solid_is_a: false, pose_ab, relative, incumbent };
        descent.run((solids, &surface.tree), relative, visitor);
    }
}

/// The traversal with its scratch memory.
struct Descent<'s> {
    level: Level,
    stack: &'s mut Vec<Entry>,
    unseen: f64,
}

impl Descent<'_> {
    fn run<B: BoundingVolume, LA, LB, V: Visitor<LA, LB>>(
        &mut self,
        trees: (&Tree<B, LA>, &Tree<B, LB>),
        relative: &Relative,
        visitor: &mut V,
    ) {
        if visitor.threshold() == f32::NEG_INFINITY {
            return;
        }
        let stack = &mut *self.stack;
        dispatch_lean!(self.level, simd => descend(simd, trees, relative, stack, visitor));
        for left in self.stack.iter() {
            self.unseen = self.unseen.min(f64::from(left.lower.max(0.0)));
        }
    }
}
