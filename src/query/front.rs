//! The triangles of two surfaces that may be nearest in all poses near one: found once, looked at again while the bodies
//! move little (Ehmann & Lin 2001 call such a set a front).

use super::body::CollisionBody;
use super::element_pair::Separation;
use super::incumbent::Incumbent;
use super::scratch::Scratch;
use super::search::Goal;
use super::surface::Surface;
use super::surface_surface::{SurfaceSurface, triangle_slack};
use super::triangle_lanes::{LaneTriangles, MovedTriangles};
use super::work::Work;
use crate::bounding_volume::{BoundingVolume, Obb, Relative};
use crate::bvh::{TriangleLeaf, Visitor, descend};
use crate::math::{MatrixPose, Point};
use crate::simd::{LANES, Simd, dispatch_lean, not_beyond};

/// The nearest pairs that are kept; more would cost as much as a search.
const MOST: usize = 512;

/// Pairs of triangles of two bodies.
#[derive(Clone, Debug, Default)]
pub struct Front {
    /// Where b was in the frame of a.
    pose_ab: Option<MatrixPose>,
    /// Triangles that are not listed were farther apart than this (m).
    beyond: f64,
    /// A lower bound of the distance (m) there, and the numbers of a triangle of a and one of b; the nearest first.
    pairs: Vec<(f32, u32, u32)>,
}

impl Front {
    /// Forgets everything.
    pub fn clear(&mut self) {
        self.pose_ab = None;
        self.pairs.clear();
    }

    /// Lists the triangles of two bodies that may be within `beyond` (m) of each other, or the nearest of these if they are
    /// many. Bodies with primitives or solid meshes have no front.
    pub fn collect(
        &mut self,
        (a, b): (&CollisionBody, &CollisionBody),
        pose_ab: &MatrixPose,
        beyond: f64,
        scratch: &mut Scratch,
    ) {
        self.clear();
        let Some((surface_a, surface_b)) = only_surfaces(a, b) else { return };
        let relative = &surface_a.tree.relative(&surface_b.tree, pose_ab);
        let level = scratch.level();
        let Scratch { work, stack, .. } = scratch;
        let mut collector = Collector { beyond: round_up(beyond), relative, pairs: &mut self.pairs, work };
        dispatch_lean!(level, simd => {
            descend(simd, (&surface_a.tree, &surface_b.tree), relative, stack, &mut collector);
        });
        collector.keep_nearest();
        self.beyond = f64::from(collector.beyond).min(beyond);
        self.pairs.sort_unstable_by(nearer);
        self.pose_ab = Some(*pose_ab);
    }

    /// The distance of the bodies at another pose, as a search would find it: `Some(None)` if it is proven larger than
    /// `limit` (m). `None` where the front does not suffice, or they touch.
    #[must_use]
    pub fn distance(
        &self,
        (a, b): (&CollisionBody, &CollisionBody),
        pose_ab: &MatrixPose,
        limit: f64,
        scratch: &mut Scratch,
    ) -> Option<Option<Separation>> {
        let (a_surface, b_surface) = only_surfaces(a, b)?;
        let moved = b.bounding_sphere().displacement(self.pose_ab.as_ref()?, pose_ab);
        let certain = self.beyond - moved;
        if certain <= 0.0 {
            return None;
        }
        let relative = &a_surface.tree.relative(&b_surface.tree, pose_ab);
        let level = scratch.level();
        let Scratch { work, candidates, .. } = scratch;
        candidates.clear();
        let goal = Goal { limit: limit.min(certain), ..Goal::EXACT };
        let incumbent = &mut Incumbent::new(goal, work);
        let mut visitor = SurfaceSurface::<_, false> {
            a: a_surface,
            b: b_surface,
            pose_ab,
            relative,
            incumbent,
            candidates,
        };
        dispatch_lean!(level, simd => look_again(simd, &self.pairs, moved, &mut visitor));
        visitor.measure_candidates();
        match incumbent.best {
            Some(found) if found.distance > 0.0 => Some(Some(found)),
            None if limit <= certain => Some(None),
            _ => None,
        }
    }
}

/// Screens listed pairs eight at a time, until none that follows can be nearer than what was found.
#[inline(always)]
#[allow(clippy::cast_possible_truncation)] // rounded up
fn look_again<S: Simd>(
    simd: S,
    pairs: &[(f32, u32, u32)],
    moved: f64,
    visitor: &mut SurfaceSurface<'_, '_, Obb, false>,
) {
    let moved = (moved as f32).next_up();
    let slack = triangle_slack(visitor.relative);
    for eight in pairs.chunks(LANES) {
        if eight[0].0 - moved > visitor.threshold() {
            return;
        }
        let (one, other) = gathered(simd, visitor, eight);
        visitor.screen(simd, &one, &other, slack, u64::from(u8::MAX >> (LANES - eight.len())), |lane| {
            let (_, i, j) = eight[lane];
            (i, j)
        });
    }
}

/// The triangles of eight pairs in lanes, in the frame of b's tree; fewer repeat the last.
#[inline(always)]
fn gathered<S: Simd>(
    simd: S,
    visitor: &SurfaceSurface<'_, '_, Obb, false>,
    pairs: &[(f32, u32, u32)],
) -> (LaneTriangles<S>, LaneTriangles<S>) {
    let anchor = visitor.b.tree.anchor();
    let pose_ba = visitor.pose_ab.inverse();
    let (mut of_a, mut of_b) = ([[[0.0; LANES]; 3]; 3], [[[0.0; LANES]; 3]; 3]);
    for lane in 0..LANES {
        let (_, i, j) = pairs[lane.min(pairs.len() - 1)];
        let (s, t) = (visitor.a.triangle(i), visitor.b.triangle(j));
        for (corner, p) in [s.a, s.b, s.c].into_iter().enumerate() {
            set(&mut of_a[corner], lane, &(&pose_ba * p), anchor);
        }
        for (corner, p) in [t.a, t.b, t.c].into_iter().enumerate() {
            set(&mut of_b[corner], lane, &p, anchor);
        }
    }
    (LaneTriangles::load(simd, &of_a), LaneTriangles::load(simd, &of_b))
}

#[inline(always)]
#[allow(clippy::cast_possible_truncation)] // rounding is meant
fn set(components: &mut [[f32; LANES]; 3], lane: usize, p: &Point, anchor: &Point) {
    components[0][lane] = (p.x - anchor.x) as f32;
    components[1][lane] = (p.y - anchor.y) as f32;
    components[2][lane] = (p.z - anchor.z) as f32;
}

fn only_surfaces<'b, B: BoundingVolume>(
    a: &'b CollisionBody<B>,
    b: &'b CollisionBody<B>,
) -> Option<(&'b Surface<B>, &'b Surface<B>)> {
    Some((a.only_surface()?, b.only_surface()?))
}

#[allow(clippy::cast_possible_truncation)] // rounded up right after
fn round_up(x: f64) -> f32 {
    (x as f32).next_up()
}

fn nearer(x: &(f32, u32, u32), y: &(f32, u32, u32)) -> std::cmp::Ordering {
    x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2)))
}

/// Lists the pairs of triangles whose bounds are not beyond a distance.
struct Collector<'s> {
    beyond: f32,
    relative: &'s Relative,
    pairs: &'s mut Vec<(f32, u32, u32)>,
    work: &'s mut Work,
}

impl Collector<'_> {
    /// Lets the farthest go, if there are too many: what is then not listed is not nearer than those.
    fn keep_nearest(&mut self) {
        if self.pairs.len() > MOST {
            let (_, farthest, _) = self.pairs.select_nth_unstable_by(MOST, nearer);
            self.beyond = self.beyond.min(farthest.0);
            self.pairs.truncate(MOST);
        }
    }
}

impl Visitor<TriangleLeaf, TriangleLeaf> for Collector<'_> {
    const SEPARATE: bool = false;

    fn threshold(&self) -> f32 {
        self.beyond
    }

    fn volume_tests(&mut self, count: u32) {
        self.work.volume_tests += u64::from(count);
    }

    fn interrupted(&mut self) -> bool {
        false
    }

    #[inline(always)]
    #[allow(clippy::cast_possible_truncation)] // lanes are few
    fn leaves<S: Simd>(&mut self, simd: S, a: &TriangleLeaf, b: &TriangleLeaf) {
        let slack = triangle_slack(self.relative);
        let (moved, mut lanes) =
            MovedTriangles::new(simd, a, self.relative, b, self.threshold() + 4.0 * slack);
        if lanes == 0 {
            return;
        }
        if self.pairs.len() > 4 * MOST {
            self.keep_nearest();
        }
        let eight = LaneTriangles::of_leaf(simd, b);
        while lanes != 0 {
            let lane = lanes.trailing_zeros();
            lanes &= lanes - 1;
            self.work.screened_pairs += u64::from(b.count);
            let lower = moved.one(simd, lane as usize).bounds(simd, &eight, slack).lower;
            let mut near = not_beyond(lower, self.threshold()) & b.mask();
            let lower: [f32; LANES] = lower.into();
            while near != 0 {
                let other = near.trailing_zeros();
                near &= near - 1;
                self.pairs.push((lower[other as usize & 7], a.first + lane, b.first + other));
            }
        }
    }
}
