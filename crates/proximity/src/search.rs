//! Search through all pairs of elements of two bodies.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, MatrixPose};
use clearance_geometry::simd::{Level, dispatch};

use super::body::CollisionBody;
use super::containment::{DeadlinePassed, contained_point};
use super::distance::Effort;
use super::element::ElementNumber;
use super::element_pair::Separation;
use super::grain_grains::GrainGrains;
use super::grains::{GrainSearch, Grains};
use super::incumbent::Incumbent;
use super::piece::Piece;
use super::planes::planes;
use super::scratch::Scratch;
use super::solid_grains::SolidGrains;
use super::solid_solid::SolidSolid;
use super::surface_grains::SurfaceGrains;
use super::surface_solid::SurfaceSolid;
use super::surface_surface::SurfaceSurface;
use crate::bounding_volume::{BoundingVolume, Relative};
use crate::bvh::{Entry, NodeRef, PlaneVisitor, Tree, TreePlane, Visitor, descend_from, descend_to_plane};

/// Goal of a search.
#[derive(Clone, Copy, Debug)]
pub(super) struct Goal {
    /// Elements farther apart than this (m) do not matter.
    pub limit: f64,
    /// True if something this near is already known: tolerances then apply to this limit, even before anything is found.
    pub is_reached: bool,
    /// The search ends at a distance of at most this (m).
    pub enough: f64,
    pub effort: Effort,
    /// True if triangles that may be nearest are left among the candidates, to be measured by the caller.
    pub postpones: bool,
}

impl Goal {
    /// Finds the least distance, however large.
    pub const EXACT: Self = Self {
        limit: f64::INFINITY,
        is_reached: false,
        enough: 0.0,
        effort: Effort {
            relative_tolerance: 0.0,
            absolute_tolerance: 0.0,
            exact_within: 0.0,
            exact_cost: 0,
            deadline: None,
        },
        postpones: false,
    };

    /// Finds anything that touches.
    pub const CONTACT: Self = Self { limit: CONTACT_DISTANCE, enough: CONTACT_DISTANCE, ..Self::EXACT };
}

/// The part of the second body that is searched.
#[derive(Clone, Copy, Debug)]
pub(super) enum Pieces<'p> {
    All,
    Some(&'p [Piece]),
}

impl Pieces<'_> {
    fn has_solids(self) -> bool {
        match self {
            Self::All => true,
            Self::Some(pieces) => pieces.contains(&Piece::Solids),
        }
    }

    /// Start nodes in the tree over triangles.
    fn of_surface(self, root: NodeRef, starts: &mut Vec<NodeRef>) {
        self.starts(root, starts, |piece| match piece {
            Piece::Surface(node) => Some(node),
            _ => None,
        });
    }

    /// Start nodes in the tree over a set of grains.
    fn of_grains(self, of: u32, root: NodeRef, starts: &mut Vec<NodeRef>) {
        self.starts(root, starts, |piece| match piece {
            Piece::Grains { set, node } if set == of => Some(node),
            _ => None,
        });
    }

    fn starts(self, root: NodeRef, starts: &mut Vec<NodeRef>, node: impl Fn(Piece) -> Option<NodeRef>) {
        starts.clear();
        match self {
            Self::All => starts.push(root),
            Self::Some(pieces) => starts.extend(pieces.iter().filter_map(|piece| node(*piece))),
        }
    }
}

/// Result of a search.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    /// The nearest pair found within the limit.
    pub best: Option<Separation>,
    /// Its elements, where they matter.
    pub numbers: Option<(ElementNumber, ElementNumber)>,
    /// Lower bound (m) on the distances of everything not searched; infinite if everything was searched.
    pub unseen: f64,
}

/// Searches all pairs of elements of two bodies that matter for `goal`. With `SEPARATE` only contact matters.
#[inline]
pub(super) fn search<B: BoundingVolume, const SEPARATE: bool>(
    bodies: (&CollisionBody<B>, &CollisionBody<B>),
    pose_ab: &MatrixPose,
    goal: Goal,
    scratch: &mut Scratch,
) -> Found {
    search_pieces::<B, SEPARATE>(bodies, Pieces::All, pose_ab, goal, scratch)
}

/// As [`search`], for a and some pieces of b.
pub(super) fn search_pieces<B: BoundingVolume, const SEPARATE: bool>(
    (a, b): (&CollisionBody<B>, &CollisionBody<B>),
    pieces: Pieces,
    pose_ab: &MatrixPose,
    goal: Goal,
    scratch: &mut Scratch,
) -> Found {
    let pieces = match pieces {
        Pieces::Some(some) if some.contains(&Piece::Whole) => Pieces::All,
        other => other,
    };
    let Scratch { work, stack, starts, candidates, level } = scratch;
    candidates.begin(None);
    // the test of bounding spheres costs a tenth of the start of a search
    if a.sphere_bound(b, pose_ab) > goal.limit.greater(CONTACT_DISTANCE) {
        work.volume_tests += 1;
        return Found { best: None, numbers: None, unseen: f64::INFINITY };
    }
    let mut descent = Descent::new(*level, stack, starts);
    let mut incumbent = Incumbent::new(goal, work);
    if a.has_solids() || b.has_solids() {
        solids::<B, SEPARATE>((a, b), pieces, pose_ab, &mut incumbent, &mut descent);
    }
    if let (Some(a), Some(b)) = (&a.surface, &b.surface) {
        let relative = &a.tree.relative(&b.tree, pose_ab);
        let incumbent = &mut incumbent;
        candidates.begin(if SEPARATE { None } else { Some(relative) });
        let mut visitor = SurfaceSurface::<B, SEPARATE> { a, b, pose_ab, relative, incumbent, candidates };
        pieces.of_surface(b.tree.root(), descent.starts);
        descent.run_from_starts((&a.tree, &b.tree), relative, &mut visitor, 0.0);
        if goal.postpones {
            visitor.postpone_candidates();
        } else {
            visitor.measure_candidates();
        }
    }
    if a.has_planes() || b.has_planes() {
        planes((a, b), pose_ab, &mut incumbent, &mut descent);
    }
    if a.has_grains() || b.has_grains() {
        grains((a, b), pieces, pose_ab, &mut incumbent, &mut descent);
    }
    if !incumbent.touches() {
        match contained_point((a, b), pose_ab, &mut incumbent, &mut descent) {
            Ok(Some(point)) => incumbent.touch_at(point),
            Ok(None) => {}
            // one may be inside the other
            Err(DeadlinePassed) => descent.unseen = 0.0,
        }
    }
    Found { best: incumbent.best, numbers: incumbent.numbers, unseen: descent.unseen }
}

fn solids<B: BoundingVolume, const SEPARATE: bool>(
    (a, b): (&CollisionBody<B>, &CollisionBody<B>),
    pieces: Pieces,
    pose_ab: &MatrixPose,
    incumbent: &mut Incumbent,
    descent: &mut Descent,
) {
    let solids_of_b = b.solids.as_ref().filter(|_| pieces.has_solids());
    if let (Some(a), Some(b)) = (&a.solids, solids_of_b) {
        let visitor = &mut SolidSolid::<SEPARATE> { pose_ab, incumbent };
        match (a.leaves(), b.leaves()) {
            // a first approximation is no more expensive than the trees
            ([a], [b]) if SEPARATE => visitor.meet(&a.content, &b.content),
            _ => descent.run((a, b), &a.relative(b, pose_ab), visitor),
        }
    }
    if let (Some(solids), Some(surface)) = (&a.solids, &b.surface) {
        let relative = &solids.relative(&surface.tree, pose_ab);
        let visitor =
            &mut SurfaceSolid::<B, SEPARATE> { surface, solid_is_a: true, pose_ab, relative, incumbent };
        visitor.glance(descent.level, solids);
        pieces.of_surface(surface.tree.root(), descent.starts);
        descent.run_from_starts((solids, &surface.tree), relative, visitor, 0.0);
    }
    if let (Some(surface), Some(solids)) = (&a.surface, solids_of_b) {
        let relative = &solids.relative(&surface.tree, &pose_ab.inverse());
        let visitor =
            &mut SurfaceSolid::<B, SEPARATE> { surface, solid_is_a: false, pose_ab, relative, incumbent };
        visitor.glance(descent.level, solids);
        descent.run((solids, &surface.tree), relative, visitor);
    }
}

/// Searches all grains of either body.
fn grains<B: BoundingVolume>(
    (a, b): (&CollisionBody<B>, &CollisionBody<B>),
    pieces: Pieces,
    pose_ab: &MatrixPose,
    incumbent: &mut Incumbent,
    descent: &mut Descent,
) {
    for grains in &b.grains {
        pieces.of_grains(grains.set, grains.tree.root(), descent.starts);
        if descent.starts.is_empty() {
            continue;
        }
        let pose_og = pose_ab.compose(&grains.pose_bg);
        grains_of((grains, false), a, (pose_ab, &pose_og), incumbent, descent);
        for others in &a.grains {
            let relative = &others.tree.relative(&grains.tree, &others.pose_bg.relative(&pose_og));
            let radius = others.radius + grains.radius;
            let search = GrainSearch { grains, grains_are_a: false, pose_ab, relative, radius, incumbent };
            let visitor = &mut GrainGrains { others, search };
            descent.run_from_starts((&others.tree, &grains.tree), relative, visitor, radius);
        }
    }
    let pose_ba = pose_ab.inverse();
    for grains in &a.grains {
        descent.begin_at(grains.tree.root());
        let pose_og = pose_ba.compose(&grains.pose_bg);
        grains_of((grains, true), b, (pose_ab, &pose_og), incumbent, descent);
    }
}

/// Searches grains, from the start nodes, against the surface and the solids of another body, in whose frame they are at `pose_og`.
fn grains_of<B: BoundingVolume>(
    (grains, grains_are_a): (&Grains<B>, bool),
    other: &CollisionBody<B>,
    (pose_ab, pose_og): (&MatrixPose, &MatrixPose),
    incumbent: &mut Incumbent,
    descent: &mut Descent,
) {
    let radius = grains.radius;
    if let Some(solids) = &other.solids {
        let relative = &solids.relative(&grains.tree, pose_og);
        let search = GrainSearch { grains, grains_are_a, pose_ab, relative, radius, incumbent };
        descent.run_from_starts((solids, &grains.tree), relative, &mut SolidGrains(search), radius);
    }
    if let Some(surface) = &other.surface {
        let relative = &surface.tree.relative(&grains.tree, pose_og);
        let search = GrainSearch { grains, grains_are_a, pose_ab, relative, radius, incumbent };
        let visitor = &mut SurfaceGrains { surface, search };
        descent.run_from_starts((&surface.tree, &grains.tree), relative, visitor, radius);
    }
}

/// The traversal of two trees, with its scratch memory.
pub(super) struct Descent<'s> {
    level: Level,
    stack: &'s mut Vec<Entry>,
    /// Start nodes in the second tree.
    starts: &'s mut Vec<NodeRef>,
    unseen: f64,
}

impl<'s> Descent<'s> {
    #[inline]
    pub fn new(level: Level, stack: &'s mut Vec<Entry>, starts: &'s mut Vec<NodeRef>) -> Self {
        Self { level, stack, starts, unseen: f64::INFINITY }
    }
}

impl Descent<'_> {
    /// Searches all of both trees.
    fn run<B: BoundingVolume, LA, LB, V: Visitor<LA, LB>>(
        &mut self,
        trees: (&Tree<B, LA>, &Tree<B, LB>),
        relative: &Relative,
        visitor: &mut V,
    ) {
        self.begin_at(trees.1.root());
        self.run_from_starts(trees, relative, visitor, 0.0);
    }

    fn begin_at(&mut self, node: NodeRef) {
        self.starts.clear();
        self.starts.push(node);
    }

    /// Searches the whole first tree, and the second from its start nodes. Balls around the trees' elements reduce distances by `radius`
    /// (m).
    fn run_from_starts<B: BoundingVolume, LA, LB, V: Visitor<LA, LB>>(
        &mut self,
        trees: (&Tree<B, LA>, &Tree<B, LB>),
        relative: &Relative,
        visitor: &mut V,
        radius: f64,
    ) {
        if visitor.threshold() == f32::NEG_INFINITY || self.starts.is_empty() {
            return;
        }
        let (stack, starts) = (&mut *self.stack, &*self.starts);
        dispatch!(self.level, simd => descend_from(simd, trees, starts, relative, stack, visitor));
        self.note_unseen(radius);
    }

    /// Passes the leaves of a tree that may be near a plane to a visitor.
    #[inline]
    pub fn run_to_plane<B: BoundingVolume, L, V: PlaneVisitor<L>>(
        &mut self,
        tree: &Tree<B, L>,
        plane: &TreePlane,
        visitor: &mut V,
        radius: f64,
    ) {
        if visitor.threshold() == f32::NEG_INFINITY {
            return;
        }
        let stack = &mut *self.stack;
        dispatch!(self.level, simd => descend_to_plane(simd, tree, plane, stack, visitor));
        self.note_unseen(radius);
    }

    /// Lower bound on what an interrupted search left: the distance of the volumes, minus the balls around their elements.
    fn note_unseen(&mut self, radius: f64) {
        for left in self.stack.iter() {
            self.unseen = self.unseen.lesser((f64::from(left.lower) - radius).greater(0.0));
        }
    }
}
