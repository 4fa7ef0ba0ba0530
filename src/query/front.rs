//! The elements of two bodies that may be nearest in all poses near one: found once, looked at again while the bodies move
//! little (Ehmann & Lin 2001 call such a set a front).
//!
//! Each listed pair has a lower bound of its distance at one pose, and what is not listed has one together. At another pose
//! all of these have lost at most what body b has moved. The nearest pairs are kept apart, ready in lanes: mostly they are
//! enough.

mod collector;

use super::body::CollisionBody;
use super::element::ElementNumber;
use super::element_pair::{Separation, separation_within};
use super::incumbent::Incumbent;
use super::scratch::Scratch;
use super::search::Goal;
use super::surface::Surface;
use super::surface_surface::{Candidates, SurfaceSurface, triangle_slack};
use super::triangle_lanes::LaneTriangles;
use crate::bounding_volume::Obb;
use crate::bvh::Visitor;
use crate::math::MatrixPose;
use crate::simd::{LANES, Level, Simd, dispatch_lean, f32x8};
use collector::collect;

/// The nearest pairs that are kept; more would cost as much as a search.
const MOST: usize = 384;

/// So many pairs of triangles are ready in lanes.
const READY: usize = 3 * LANES;

/// Two elements, and a number (m) that their distance was not below.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Listed {
    lower: f32,
    a: ElementNumber,
    b: ElementNumber,
}

/// The corners of eight pairs of triangles, each in the frame of its own tree.
#[derive(Clone, Debug)]
#[repr(align(32))]
struct EightPairs {
    a: [[[f32; LANES]; 3]; 3],
    b: [[[f32; LANES]; 3]; 3],
}

/// Pairs of elements of two bodies.
#[derive(Clone, Debug, Default)]
pub struct Front {
    /// Where b was in the frame of a; `None` while nothing is known.
    pose_ab: Option<MatrixPose>,
    /// Elements that are not listed were farther apart than this (m).
    beyond: f64,
    /// Pairs with solids, the nearest first.
    of_solids: Vec<Listed>,
    /// Pairs of triangles: the nearest, in order, then the others.
    of_triangles: Vec<Listed>,
    /// The nearest pairs of triangles.
    ready: Vec<EightPairs>,
    /// No other pair of triangles was nearer than this (m).
    rest: f32,
}

impl Front {
    /// Forgets everything.
    pub fn clear(&mut self) {
        self.pose_ab = None;
        self.of_solids.clear();
        self.of_triangles.clear();
    }

    /// Lists the elements of two bodies that may be within `beyond` (m) of each other, or the nearest of these if they are
    /// many. Bodies with solid meshes have no front.
    pub fn collect(
        &mut self,
        (a, b): (&CollisionBody, &CollisionBody),
        pose_ab: &MatrixPose,
        beyond: f64,
        scratch: &mut Scratch,
    ) {
        self.clear();
        if a.interior.is_some() || b.interior.is_some() {
            return;
        }
        self.beyond = collect((a, b), pose_ab, beyond, scratch, &mut self.of_solids, &mut self.of_triangles);
        self.of_solids.sort_unstable_by(Listed::by_distance);
        self.pose_ab = Some(*pose_ab);
        self.make_ready((a, b));
    }

    /// The distance of the bodies at another pose, as a search would find it: `Some(None)` if it is proven larger than
    /// `limit` (m). `None` where the front does not suffice, or they touch.
    #[must_use]
    pub fn distance(
        &mut self,
        (a, b): (&CollisionBody, &CollisionBody),
        pose_ab: &MatrixPose,
        limit: f64,
        scratch: &mut Scratch,
    ) -> Option<Option<Separation>> {
        let moved = b.bounding_sphere().displacement(self.pose_ab.as_ref()?, pose_ab);
        let certain = self.beyond - moved;
        if certain <= 0.0 {
            return None;
        }
        let goal = Goal { limit: limit.min(certain), ..Goal::EXACT };
        let Scratch { work, candidates, level, .. } = scratch;
        let incumbent = &mut Incumbent::new(goal, work);
        let look = Look { bodies: (a, b), pose_ab, moved: round_up(moved) };
        let nearest = |listed: &[Listed]| listed.first().map_or(f32::INFINITY, |l| l.lower);
        let solids_first = nearest(&self.of_solids) < nearest(&self.of_triangles);
        if solids_first {
            look.at_solids(&self.of_solids, incumbent);
        }
        self.look_at_triangles(&look, *level, incumbent, candidates);
        if !solids_first {
            look.at_solids(&self.of_solids, incumbent);
        }
        match incumbent.best {
            Some(found) if found.distance > 0.0 => Some(Some(found)),
            None if limit <= certain => Some(None),
            _ => None,
        }
    }

    fn look_at_triangles(
        &mut self,
        look: &Look,
        level: Level,
        incumbent: &mut Incumbent,
        candidates: &mut Candidates,
    ) {
        let (Some(a), Some(b)) = (&look.bodies.0.surface, &look.bodies.1.surface) else { return };
        let relative = &a.tree.relative(&b.tree, look.pose_ab);
        candidates.clear();
        let mut visitor =
            SurfaceSurface::<_, false> { a, b, pose_ab: look.pose_ab, relative, incumbent, candidates };
        let renewed = dispatch_lean!(level, simd => {
            at_ready(simd, &self.ready, &self.of_triangles, look.moved, &mut visitor);
            let others = less(self.rest, look.moved) <= visitor.threshold();
            if others {
                at_all(simd, &mut self.of_triangles, look.moved, &mut visitor);
            }
            others
        });
        visitor.measure_candidates();
        if renewed {
            self.renew(look);
        }
    }

    /// Takes the bounds for those at the present pose.
    fn renew(&mut self, look: &Look) {
        self.pose_ab = Some(*look.pose_ab);
        self.beyond -= f64::from(look.moved);
        for listed in &mut self.of_solids {
            listed.lower = less(listed.lower, look.moved);
        }
        self.make_ready(look.bodies);
    }

    /// Brings the nearest pairs of triangles to the front, and into lanes.
    fn make_ready(&mut self, (a, b): (&CollisionBody, &CollisionBody)) {
        self.ready.clear();
        self.rest = f32::INFINITY;
        let (Some(a), Some(b)) = (&a.surface, &b.surface) else { return };
        if self.of_triangles.len() > READY {
            let (_, next, _) = self.of_triangles.select_nth_unstable_by(READY, Listed::by_distance);
            self.rest = next.lower;
        }
        let nearest = self.of_triangles.len().min(READY);
        self.of_triangles[..nearest].sort_unstable_by(Listed::by_distance);
        self.ready
            .extend(self.of_triangles[..nearest].chunks(LANES).map(|eight| EightPairs::new(a, b, eight)));
    }
}

/// What is looked at anew.
struct Look<'l> {
    bodies: (&'l CollisionBody, &'l CollisionBody),
    pose_ab: &'l MatrixPose,
    /// How far (m) any of b has moved since the bounds were true.
    moved: f32,
}

impl Look<'_> {
    /// Measures pairs with solids, the nearest first, until none that follows can be the nearest.
    fn at_solids(&self, listed: &[Listed], incumbent: &mut Incumbent) {
        for Listed { lower, a, b } in listed {
            if less(*lower, self.moved) > incumbent.threshold() {
                return;
            }
            incumbent.work.primitive_tests += 1;
            let (core_a, core_b) = (self.bodies.0.core(*a), self.bodies.1.core(*b));
            if let Some(found) = separation_within(&core_a, &core_b, self.pose_ab, incumbent.bound()) {
                incumbent.offer_numbered(found, (*a, *b));
            }
        }
    }
}

/// Screens the nearest pairs of triangles eight at a time, until none that follows can be the nearest.
#[inline(always)]
fn at_ready<S: Simd>(
    simd: S,
    ready: &[EightPairs],
    listed: &[Listed],
    moved: f32,
    visitor: &mut SurfaceSurface<'_, '_, Obb, false>,
) {
    for (pairs, eight) in ready.iter().zip(listed.chunks(LANES)) {
        if less(eight[0].lower, moved) > visitor.threshold() {
            return;
        }
        screen(simd, pairs, eight, visitor);
    }
}

/// Screens all pairs of triangles that may be the nearest, and leaves with each a bound for the present pose. The ready ones
/// are a second time among them: that they may be the nearest is known already.
#[inline(always)]
fn at_all<S: Simd>(
    simd: S,
    listed: &mut [Listed],
    moved: f32,
    visitor: &mut SurfaceSurface<'_, '_, Obb, false>,
) {
    let (mut eight, mut places) = ([Listed::NOTHING; LANES], [0; LANES]);
    let mut count = 0;
    for i in 0..listed.len() {
        listed[i].lower = less(listed[i].lower, moved);
        if listed[i].lower <= visitor.threshold() {
            (eight[count], places[count]) = (listed[i], i);
            count += 1;
        }
        if count == LANES || (count > 0 && i + 1 == listed.len()) {
            let pairs = EightPairs::new(visitor.a, visitor.b, &eight[..count]);
            let lower: [f32; LANES] = screen(simd, &pairs, &eight[..count], visitor).into();
            for (place, lower) in places[..count].iter().zip(lower) {
                listed[*place].lower = listed[*place].lower.max(lower);
            }
            count = 0;
        }
    }
}

/// Keeps those of eight pairs that may be the nearest; gives lower bounds of their distances.
#[inline(always)]
fn screen<S: Simd>(
    simd: S,
    pairs: &EightPairs,
    listed: &[Listed],
    visitor: &mut SurfaceSurface<'_, '_, Obb, false>,
) -> f32x8<S> {
    let one = LaneTriangles::placed(simd, &pairs.a, visitor.relative);
    let other = LaneTriangles::load(simd, &pairs.b);
    let slack = triangle_slack(visitor.relative);
    let mask = u64::from(u8::MAX >> (LANES - listed.len()));
    visitor.screen(simd, &one, &other, slack, mask, |lane| (listed[lane].a.index(), listed[lane].b.index()))
}

impl Listed {
    const NOTHING: Self =
        Self { lower: f32::INFINITY, a: ElementNumber::of_solid(0), b: ElementNumber::of_solid(0) };

    fn by_distance(x: &Self, y: &Self) -> std::cmp::Ordering {
        x.lower.total_cmp(&y.lower).then((x.a, x.b).cmp(&(y.a, y.b)))
    }
}

impl EightPairs {
    /// Of fewer than eight the last is repeated.
    fn new(a: &Surface<Obb>, b: &Surface<Obb>, pairs: &[Listed]) -> Self {
        let mut all = Self { a: [[[0.0; LANES]; 3]; 3], b: [[[0.0; LANES]; 3]; 3] };
        for lane in 0..LANES {
            let Listed { a: i, b: j, .. } = pairs[lane.min(pairs.len() - 1)];
            set(&mut all.a, lane, a, i);
            set(&mut all.b, lane, b, j);
        }
        all
    }
}

/// As the leaves of the surface's tree have them.
#[allow(clippy::cast_possible_truncation)] // rounding is meant
fn set(corners: &mut [[[f32; LANES]; 3]; 3], lane: usize, surface: &Surface<Obb>, number: ElementNumber) {
    let anchor = surface.tree.anchor();
    for (corner, p) in corners.iter_mut().zip(surface.triangle(number.index()).corners()) {
        for i in 0..3 {
            corner[i][lane] = (p[i] - anchor[i]) as f32;
        }
    }
}

/// What is left of a bound, rounded down.
fn less(lower: f32, moved: f32) -> f32 {
    (lower - moved).next_down()
}

#[allow(clippy::cast_possible_truncation)] // rounded up right after
fn round_up(x: f64) -> f32 {
    (x as f32).next_up()
}
