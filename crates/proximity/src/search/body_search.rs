//! Entry point of a search between two bodies: runs the search of each kind of elements (triangles, solids, cubes,
//! planes), then tests whether one body contains a point of the other.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, MatrixPose};

use super::best_so_far::BestSoFar;
use super::contained_point::{DeadlinePassed, contained_point};
use super::cube_search_state::CubeSearch;
use super::goal::Goal;
use super::nearest_cubes_cubes::CubesCubesVisitor;
use super::nearest_plane_body::nearest_to_planes;
use super::nearest_solid_cubes::SolidCubesVisitor;
use super::nearest_solid_solid::SolidSolidVisitor;
use super::nearest_surface_cubes::SurfaceCubesVisitor;
use super::nearest_surface_solid::SurfaceSolidVisitor;
use super::nearest_surface_surface::SurfaceSurfaceVisitor;
use super::scratch::{Scratch, ScratchParts};
use super::searched_pieces::SearchedPieces;
use super::tree_traversal::TreeTraversal;
use super::triangle_candidates::TriangleCandidates;
use crate::body::{BodyPair, CollisionBody, CubeSet};
use crate::bvh::TreePair;
use crate::elements::ElementPair;
use crate::narrow_phase::Separation;

/// Result of a search.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SearchResult {
    /// The nearest pair of points found within the limit.
    pub best: Option<Separation>,
    /// Its elements, where they matter.
    pub elements: Option<ElementPair>,
    /// Lower bound (m) on the distances of everything not searched; infinite if everything was searched.
    pub unseen: f64,
}

/// Searches all pairs of elements of two bodies that matter for `goal`. With `SEPARATE` only contact matters.
#[inline]
pub(crate) fn search<const SEPARATE: bool>(
    bodies: BodyPair,
    goal: Goal,
    scratch: &mut Scratch,
) -> SearchResult {
    search_pieces::<SEPARATE>(bodies, SearchedPieces::All, goal, scratch)
}

/// As [`search`], for a and some pieces of b.
pub(crate) fn search_pieces<const SEPARATE: bool>(
    bodies: BodyPair,
    pieces: SearchedPieces,
    goal: Goal,
    scratch: &mut Scratch,
) -> SearchResult {
    let BodyPair { a, b, pose_ab } = bodies;
    let ScratchParts { work, traversal, candidates, ties } = scratch.begin();
    let ties = goal.ties.map(|(tolerance, most)| ties.begin(tolerance, most));
    candidates.begin(None);
    // the test of bounding spheres costs a tenth of the start of a search
    if a.sphere_bound(b, pose_ab) > goal.limit.greater(CONTACT_DISTANCE) {
        work.volume_tests += 1;
        return SearchResult { best: None, elements: None, unseen: f64::INFINITY };
    }
    let mut best_so_far = BestSoFar::new(goal, work).with_ties(ties);
    if pieces.has_elements() {
        let searched = SearchedElements { bodies, pieces, postpones: goal.postpones };
        search_elements::<SEPARATE>(searched, &mut best_so_far, traversal, candidates);
    }
    if traversal.uses_other_volumes() && best_so_far.is_settled() {
        let (best, elements, unseen) = (best_so_far.separation(), best_so_far.elements(), traversal.unseen());
        let found = SearchResult { best, elements, unseen };
        return repeated_with_boxes::<SEPARATE>(bodies, pieces, goal, scratch, found);
    }
    if !best_so_far.touches() {
        match contained_point(bodies, pieces, &mut best_so_far, traversal) {
            Ok(Some(point)) => best_so_far.touch_at(point),
            Ok(None) => {}
            // one may be inside the other
            Err(DeadlinePassed) => traversal.leave_all(),
        }
    }
    let (best, elements) = (best_so_far.separation(), best_so_far.elements());
    SearchResult { best, elements, unseen: traversal.unseen() }
}

/// Repeats a search that ended early, at something near enough that other volumes than boxes led to: the pair of points that is found first
/// depends on the volumes, and shall not. If the deadline passes meanwhile, `found` remains.
#[cold]
fn repeated_with_boxes<const SEPARATE: bool>(
    bodies: BodyPair,
    pieces: SearchedPieces,
    goal: Goal,
    scratch: &mut Scratch,
    found: SearchResult,
) -> SearchResult {
    scratch.set_boxes_only(true);
    let repeated = search_pieces::<SEPARATE>(bodies, pieces, goal, scratch);
    scratch.set_boxes_only(false);
    if repeated.best.is_some() { repeated } else { found }
}

/// Elements that are searched: all of a, and some pieces of b.
#[derive(Clone, Copy)]
struct SearchedElements<'s> {
    bodies: BodyPair<'s>,
    pieces: SearchedPieces<'s>,
    /// True if triangles that may be nearest are left among the candidates.
    postpones: bool,
}

/// Searches all kinds of elements.
fn search_elements<const SEPARATE: bool>(
    SearchedElements { bodies, pieces, postpones }: SearchedElements,
    best_so_far: &mut BestSoFar,
    traversal: &mut TreeTraversal,
    candidates: &mut TriangleCandidates,
) {
    let BodyPair { a, b, pose_ab } = bodies;
    if a.has_solids() || b.has_solids() {
        search_solids::<SEPARATE>(bodies, pieces, best_so_far, traversal);
    }
    if let (Some(a), Some(b)) = (a.surface(), b.surface()) {
        let relative = &a.tree().relative(b.tree(), pose_ab);
        candidates.begin(if SEPARATE { None } else { Some(relative) });
        let best_so_far = &mut *best_so_far;
        let mut visitor =
            SurfaceSurfaceVisitor::<SEPARATE> { a, b, pose_ab, relative, best_so_far, candidates };
        pieces.of_surface(b.tree().root(), traversal.starts());
        traversal.run_from_starts(TreePair { a: a.tree(), b: b.tree(), relative }, &mut visitor, 0.0);
        if postpones {
            visitor.postpone_candidates();
        } else {
            visitor.measure_candidates();
        }
    }
    if a.has_planes() || b.has_planes() {
        nearest_to_planes(bodies, best_so_far, traversal);
    }
    if a.has_cubes() || b.has_cubes() {
        search_cubes(bodies, pieces, best_so_far, traversal);
    }
}

/// Searches all solids of either body.
fn search_solids<const SEPARATE: bool>(
    bodies: BodyPair,
    pieces: SearchedPieces,
    best_so_far: &mut BestSoFar,
    traversal: &mut TreeTraversal,
) {
    let BodyPair { a, b, pose_ab } = bodies;
    let solids_of_b = b.solids().filter(|_| pieces.has_solids());
    if let (Some(a), Some(b)) = (a.solids(), solids_of_b) {
        let visitor = &mut SolidSolidVisitor::<SEPARATE> { pose_ab, best_so_far };
        match (a.leaves(), b.leaves()) {
            // a first approximation is no more expensive than the trees
            ([a], [b]) if SEPARATE => visitor.test(&a.content, &b.content),
            _ => traversal.run(TreePair { a, b, relative: &a.relative(b, pose_ab) }, visitor),
        }
    }
    if let (Some(solids), Some(surface)) = (a.solids(), b.surface()) {
        let relative = &solids.relative(surface.tree(), pose_ab);
        let visitor = &mut SurfaceSolidVisitor::<SEPARATE> {
            surface,
            solid_is_a: true,
            pose_ab,
            relative,
            best_so_far,
        };
        visitor.test_samples(traversal.level(), solids);
        pieces.of_surface(surface.tree().root(), traversal.starts());
        traversal.run_from_starts(TreePair { a: solids, b: surface.tree(), relative }, visitor, 0.0);
    }
    if let (Some(surface), Some(solids)) = (a.surface(), solids_of_b) {
        let relative = &solids.relative(surface.tree(), &pose_ab.inverse());
        let visitor = &mut SurfaceSolidVisitor::<SEPARATE> {
            surface,
            solid_is_a: false,
            pose_ab,
            relative,
            best_so_far,
        };
        visitor.test_samples(traversal.level(), solids);
        traversal.run(TreePair { a: solids, b: surface.tree(), relative }, visitor);
    }
}

/// Searches all cubes of either body.
fn search_cubes(
    bodies: BodyPair,
    pieces: SearchedPieces,
    best_so_far: &mut BestSoFar,
    traversal: &mut TreeTraversal,
) {
    let BodyPair { a, b, pose_ab } = bodies;
    for cubes in b.cube_sets() {
        pieces.of_cubes(cubes.index(), cubes.tree().root(), traversal.starts());
        if traversal.starts().is_empty() {
            continue;
        }
        let pose_as = pose_ab.compose(cubes.pose_bs());
        let placed = PlacedCubes { cubes, cubes_are_a: false, pose_ab, pose_in_other: &pose_as };
        search_placed_cubes(placed, a, best_so_far, traversal);
        for others in a.cube_sets() {
            let relative = &others.tree().relative(cubes.tree(), &others.pose_bs().relative(&pose_as));
            let radius = others.radius() + cubes.radius();
            let search = CubeSearch { cubes, cubes_are_a: false, pose_ab, relative, radius, best_so_far };
            let visitor = &mut CubesCubesVisitor { others, search };
            traversal.run_from_starts(
                TreePair { a: others.tree(), b: cubes.tree(), relative },
                visitor,
                radius,
            );
        }
    }
    let pose_ba = pose_ab.inverse();
    for cubes in a.cube_sets() {
        traversal.start_at(cubes.tree().root());
        let pose_bs = pose_ba.compose(cubes.pose_bs());
        let placed = PlacedCubes { cubes, cubes_are_a: true, pose_ab, pose_in_other: &pose_bs };
        search_placed_cubes(placed, b, best_so_far, traversal);
    }
}

/// Cubes of one body, placed in the frame of the other body.
#[derive(Clone, Copy)]
struct PlacedCubes<'s> {
    cubes: &'s CubeSet,
    /// True if the cubes belong to body a.
    cubes_are_a: bool,
    pose_ab: &'s MatrixPose,
    /// Pose of the cubes' frame in the other body.
    pose_in_other: &'s MatrixPose,
}

/// Searches cubes, from the start nodes, against the surface and the solids of the other body.
fn search_placed_cubes(
    placed: PlacedCubes,
    other: &CollisionBody,
    best_so_far: &mut BestSoFar,
    traversal: &mut TreeTraversal,
) {
    let PlacedCubes { cubes, cubes_are_a, pose_ab, pose_in_other } = placed;
    let radius = cubes.radius();
    if let Some(solids) = other.solids() {
        let relative = &solids.relative(cubes.tree(), pose_in_other);
        let search = CubeSearch { cubes, cubes_are_a, pose_ab, relative, radius, best_so_far };
        let trees = TreePair { a: solids, b: cubes.tree(), relative };
        traversal.run_from_starts(trees, &mut SolidCubesVisitor(search), radius);
    }
    if let Some(surface) = other.surface() {
        let relative = &surface.tree().relative(cubes.tree(), pose_in_other);
        let search = CubeSearch { cubes, cubes_are_a, pose_ab, relative, radius, best_so_far };
        let trees = TreePair { a: surface.tree(), b: cubes.tree(), relative };
        traversal.run_from_starts(trees, &mut SurfaceCubesVisitor { surface, search }, radius);
    }
}
