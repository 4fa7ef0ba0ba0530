//! Triangles and segments: exact nearest points and intersection, in f64.
//!
//! Nearest points on segments follow Ericson, *Real-Time Collision Detection* (2005), 5.1.9; two triangles are at their
//! least distance at a vertex of one and the face of the other, at two edges, or they cross (Larsen, Gottschalk, Lin &
//! Manocha 1999, *Fast proximity queries with swept sphere volumes*, 4.2).

use crate::constants::CONTACT_DISTANCE;
use crate::math::{Extremes, Point, Pose, Vector};

/// Three corners; it may be degenerate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// First corner.
    pub a: Point,
    /// Second corner.
    pub b: Point,
    /// Third corner.
    pub c: Point,
}

/// Squared sine of an angle below which two segments count as parallel: over a metre they diverge by 1e-10 m.
const PARALLEL: f64 = 1e-20;

/// Squared sine of an angle below which the nearest points of two lines are inexact along the lines.
const NARROW: f64 = 1e-6;

/// Two points, one on each of two solids.
pub type PointPair = [Point; 2];

impl Triangle {
    /// The three corners.
    #[must_use]
    pub fn corners(&self) -> [Point; 3] {
        [self.a, self.b, self.c]
    }

    /// The three edges, each from its first to its second corner.
    #[must_use]
    pub fn edges(&self) -> [[Point; 2]; 3] {
        [[self.a, self.b], [self.b, self.c], [self.c, self.a]]
    }

    /// The triangle of a frame placed at `pose`, in the parent frame.
    #[must_use]
    pub fn transformed(&self, pose: &Pose) -> Self {
        Self { a: pose * self.a, b: pose * self.b, c: pose * self.c }
    }

    /// Unit normal by the right-hand rule; zero for a degenerate triangle.
    #[must_use]
    pub fn normal(&self) -> Vector {
        (self.b - self.a).cross(&(self.c - self.a)).try_normalize(0.0).unwrap_or_else(Vector::zeros)
    }

    /// The point of the triangle nearest to `p`.
    #[must_use]
    pub fn nearest_point(&self, p: &Point) -> Point {
        Face::of(self).nearest_point(p)
    }

    /// Nearest points of two triangles in one frame; the same point twice where they cross.
    #[must_use]
    pub fn nearest_points(&self, other: &Self) -> PointPair {
        let (ours, theirs) = (Face::of(self), Face::of(other));
        let apart = ours.plane_separates(other, 0.0) || theirs.plane_separates(self, 0.0);
        let crossing = if apart { None } else { self.crossing(other) };
        if crossing.is_none() {
            return nearest_features(&ours, &theirs);
        }
        [self.common_point(other, crossing); 2]
    }

    /// A common point, if the triangles come within [`CONTACT_DISTANCE`].
    #[must_use]
    pub fn contact_point(&self, other: &Self) -> Option<Point> {
        let clear = CONTACT_DISTANCE;
        let (ours, theirs) = (Face::of(self), Face::of(other));
        if ours.plane_separates(other, clear) || theirs.plane_separates(self, clear) {
            return None;
        }
        let crossing = self.crossing(other);
        let touching = crossing.is_some() || {
            let [p, q] = nearest_features(&ours, &theirs);
            nalgebra::distance(&p, &q) <= CONTACT_DISTANCE
        };
        touching.then(|| self.common_point(other, crossing))
    }

    /// A point where an edge of one triangle pierces the other, the first in their order: in general position every crossing has one. The
    /// signs of heights are exact.
    fn crossing(&self, other: &Self) -> Option<Point> {
        let one_side =
            |heights: &[f64; 3]| heights.iter().all(|h| *h > 0.0) || heights.iter().all(|h| *h < 0.0);
        let pierced = |t: &Self, by: &Self, [a, b, c]: [f64; 3]| {
            let [e, f, g] = by.edges();
            (t.pierced_at(&e, [a, b]))
                .or_else(|| t.pierced_at(&f, [b, c]))
                .or_else(|| t.pierced_at(&g, [c, a]))
        };
        let theirs = self.heights(other);
        if one_side(&theirs) {
            return None;
        }
        let ours = other.heights(self);
        if one_side(&ours) {
            return None;
        }
        pierced(self, other, theirs).or_else(|| pierced(other, self, ours))
    }

    /// A common point of two touching triangles, given their first crossing. For nearly coplanar triangles, rounding may move the
    /// piercing points far along the triangles; then their edges meet, or a corner of one lies on the other.
    fn common_point(&self, other: &Self, crossing: Option<Point>) -> Point {
        let on_both = |p: &Point| {
            let off = |t: &Self| nalgebra::distance(p, &t.nearest_point(p));
            off(self).greater(off(other)) <= CONTACT_DISTANCE
        };
        let pierced = |t: &Self, by: &Self| by.edges().iter().filter_map(|e| t.pierced_by(e)).find(on_both);
        let any = || pierced(self, other).or_else(|| pierced(other, self));
        crossing
            .and_then(|first| Some(first).filter(on_both).or_else(any))
            .unwrap_or_else(|| nearest_features(&Face::of(self), &Face::of(other))[0])
    }

    /// The heights of another triangle's corners over this one, up to a factor.
    fn heights(&self, other: &Self) -> [f64; 3] {
        [self.height(&other.a), self.height(&other.b), self.height(&other.c)]
    }

    /// The height of a point over the triangle, up to a factor; its sign is exact (Shewchuk 1997, *Adaptive precision
    /// floating-point arithmetic and fast robust geometric predicates*).
    fn height(&self, x: &Point) -> f64 {
        orientation(&self.a, &self.b, &self.c, x)
    }

    /// The point where a segment whose ends have these heights passes through the triangle. For a segment in the triangle's plane there
    /// is none: common points are found at edges and corners instead.
    fn pierced_at(&self, [p, q]: &[Point; 2], [height_p, height_q]: [f64; 2]) -> Option<Point> {
        let one_side = (height_p > 0.0 && height_q > 0.0) || (height_p < 0.0 && height_q < 0.0);
        if one_side || (height_p == 0.0 && height_q == 0.0) {
            return None;
        }
        let sides = self.edges().map(|[from, to]| orientation(p, q, &from, &to));
        let inside = sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0);
        let on_segment = || p + (q - p) * (height_p / (height_p - height_q)).clamp(0.0, 1.0);
        inside.then(|| self.nearest_point(&on_segment()))
    }

    /// The point where a segment passes through the triangle; none for a segment in the triangle's plane.
    #[must_use]
    pub fn pierced_by(&self, segment: &[Point; 2]) -> Option<Point> {
        let [p, q] = segment;
        self.pierced_at(segment, [self.height(p), self.height(q)])
    }

    /// Points where edges of either triangle pierce the other: in general position, the two ends of the segment that both have in common.
    pub fn crossing_points(&self, other: &Self) -> impl Iterator<Item = Point> {
        let theirs = other.edges().into_iter().filter_map(|edge| self.pierced_by(&edge));
        theirs.chain(self.edges().into_iter().filter_map(|edge| other.pierced_by(&edge)))
    }

    /// Nearest points of the triangle and a segment; the same point twice where it pierces.
    #[must_use]
    pub fn nearest_to_segment(&self, segment: &[Point; 2]) -> PointPair {
        if let Some(p) = self.pierced_by(segment) {
            return [p, p];
        }
        let face = Face::of(self);
        let mut nearest = NearestPair::default();
        for q in segment {
            nearest.offer([face.nearest_point(q), *q]);
        }
        for e in &face.edges {
            nearest.offer(nearest_on_segments(e, segment));
        }
        nearest.pair
    }
}

/// Nearest points of two triangles over vertex–face and edge–edge pairs, until a pair is proven to be the nearest; correct unless they
/// cross.
fn nearest_features(our_face: &Face, their_face: &Face) -> PointPair {
    let (ours, theirs) = (our_face.corners(), their_face.corners());
    let mut nearest = NearestPair::default();
    for p in &ours {
        nearest.offer([*p, their_face.nearest_point(p)]);
    }
    for q in &theirs {
        nearest.offer([our_face.nearest_point(q), *q]);
    }
    if separated_across(&nearest.pair, &ours, &theirs) {
        return nearest.pair;
    }
    for e in &our_face.edges {
        for f in &their_face.edges {
            if nearest.offer(nearest_on_segments(e, f)) && separated_across(&nearest.pair, &ours, &theirs) {
                return nearest.pair;
            }
        }
    }
    nearest.pair
}

/// Precomputed values of a triangle for nearest-point queries.
struct Face {
    edges: [[Point; 2]; 3],
    /// Edge vectors, and their squared lengths.
    ways: [Vector; 3],
    squares: [f64; 3],
    normal: Vector,
    /// Vectors in the plane normal to each edge, pointing inside.
    inward: [Vector; 3],
    normal_squared: f64,
    longest: f64,
}

impl Face {
    fn of(triangle: &Triangle) -> Self {
        let edges = triangle.edges();
        let ways = [edges[0][1] - edges[0][0], edges[1][1] - edges[1][0], edges[2][1] - edges[2][0]];
        let squares = [ways[0].norm_squared(), ways[1].norm_squared(), ways[2].norm_squared()];
        let normal = ways[0].cross(&(triangle.c - triangle.a));
        Self {
            inward: [normal.cross(&ways[0]), normal.cross(&ways[1]), normal.cross(&ways[2])],
            normal_squared: normal.norm_squared(),
            longest: squares[0].greater(squares[1]).greater(squares[2]),
            edges,
            ways,
            squares,
            normal,
        }
    }

    fn corners(&self) -> [Point; 3] {
        let [[a, _], [b, _], [c, _]] = self.edges;
        [a, b, c]
    }

    /// True if all of `other` lies more than `clear` (m) plus the rounding error on one side of the plane.
    fn plane_separates(&self, other: &Triangle, clear: f64) -> bool {
        let from = self.edges[0][0];
        let [p, q, r] = [other.a - from, other.b - from, other.c - from];
        let reach = p.abs().sum().greater(q.abs().sum()).greater(r.abs().sum());
        // rounding may have moved the normal: each of its components is a difference of products
        let normal_error = 1e-15 * self.ways[0].abs().sum() * self.ways[2].abs().sum();
        let needed = self.normal.norm() * (clear + 1e-15 * reach) + normal_error * reach;
        let heights = [self.normal.dot(&p), self.normal.dot(&q), self.normal.dot(&r)];
        heights.iter().all(|h| *h > needed) || heights.iter().all(|h| *h < -needed)
    }

    /// The point nearest to `p`: its projection if that is inside the face, else a point on an edge.
    ///
    /// The height over the face is measured from the nearest edge, so that slivers keep their accuracy: the normal of a sliver is
    /// inexact, but where `p` is near the sliver it is near an edge.
    #[inline]
    fn nearest_point(&self, p: &Point) -> Point {
        let (mut on_edge, mut least) = (Point::origin(), f64::INFINITY);
        let mut over_face = self.normal_squared != 0.0;
        for (i, edge) in self.edges.iter().enumerate() {
            let found = nearest_along(p, edge, &self.ways[i], self.squares[i]);
            let squared = nalgebra::distance_squared(p, &found);
            if squared < least {
                (on_edge, least) = (found, squared);
            }
            over_face &= self.inward[i].dot(&(p - edge[0])) >= 0.0;
        }
        if !over_face {
            return on_edge;
        }
        let foot = p - self.normal * (self.normal.dot(&(p - on_edge)) / self.normal_squared);
        // inside, the distance to the nearest edge is at most the triangle's height; an inexact normal may give more
        let inside = (foot - on_edge).norm_squared() * self.longest <= 4.0 * self.normal_squared;
        if inside { foot } else { on_edge }
    }
}

/// The nearest of all given pairs of points, the first of equal ones; the origin twice if none was given.
struct NearestPair {
    pair: PointPair,
    squared: f64,
}

impl Default for NearestPair {
    fn default() -> Self {
        Self { pair: [Point::origin(); 2], squared: f64::INFINITY }
    }
}

impl NearestPair {
    /// Whether it is the nearest so far.
    #[inline]
    fn offer(&mut self, pair: PointPair) -> bool {
        let squared = nalgebra::distance_squared(&pair[0], &pair[1]);
        let is_nearer = squared < self.squared;
        if is_nearer {
            *self = Self { pair, squared };
        }
        is_nearer
    }
}

/// Positive, negative or zero as `d` lies below, above or on the plane through the others; the sign is exact.
fn orientation(a: &Point, b: &Point, c: &Point, d: &Point) -> f64 {
    let coordinates = |p: &Point| robust::Coord3D { x: p.x, y: p.y, z: p.z };
    robust::orient3d(coordinates(a), coordinates(b), coordinates(c), coordinates(d))
}

/// True if the planes through two points, normal to the line between them, have one polygon on each outer side: then no points of the
/// polygons are nearer (the early exit of PQP's triangle distance, Larsen et al. 1999).
#[must_use]
pub fn separated_across([p, q]: &PointPair, ours: &[Point], theirs: &[Point]) -> bool {
    let n = q - p;
    n != Vector::zeros()
        && ours.iter().all(|c| n.dot(&(c - p)) <= 0.0)
        && theirs.iter().all(|c| n.dot(&(c - q)) >= 0.0)
}

/// The point of a segment nearest to `p`.
#[must_use]
#[inline]
pub fn nearest_on_segment(p: &Point, segment: &[Point; 2]) -> Point {
    let way = segment[1] - segment[0];
    nearest_along(p, segment, &way, way.norm_squared())
}

/// As above, for a segment with known end-to-end vector and squared length.
#[inline]
fn nearest_along(p: &Point, [a, b]: &[Point; 2], way: &Vector, length_squared: f64) -> Point {
    if length_squared == 0.0 {
        return *a;
    }
    let t = ((p - a).dot(way) / length_squared).clamp(0.0, 1.0);
    if t == 1.0 { *b } else { a + way * t }
}

/// Nearest points of two segments: inside both, or at an end of one.
#[must_use]
pub fn nearest_on_segments(first: &[Point; 2], second: &[Point; 2]) -> PointPair {
    let inside = nearest_inside_segments(first, second);
    if let Some((pair, Angle::Wide)) = inside {
        return pair;
    }
    let mut nearest = NearestPair::default();
    for p in first {
        nearest.offer([*p, nearest_on_segment(p, second)]);
    }
    for q in second {
        nearest.offer([nearest_on_segment(q, first), *q]);
    }
    if let Some((pair, _)) = inside {
        nearest.offer(pair);
    }
    nearest.pair
}

/// How well the crossing of two lines is conditioned.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Angle {
    Wide,
    /// The lines are nearly parallel: an end of a segment may be nearer than the result inside.
    Narrow,
}

/// Nearest points of the two lines, if they lie inside both segments and the lines are not parallel. For nearly parallel lines their
/// position along the lines is inexact, but each is the projection of the other, so their distance is exact.
fn nearest_inside_segments(first: &[Point; 2], second: &[Point; 2]) -> Option<(PointPair, Angle)> {
    let ([p, q], [r, s]) = (first, second);
    let (d1, d2, pr) = (q - p, s - r, r - p);
    let n = d1.cross(&d2);
    let (n2, lengths) = (n.norm_squared(), d1.norm_squared() * d2.norm_squared());
    if n2 <= PARALLEL * lengths {
        return None;
    }
    let t1 = pr.cross(&d2).dot(&n) / n2;
    let t2 = pr.cross(&d1).dot(&n) / n2;
    let slack = if n2 > NARROW * lengths { 0.0 } else { 1.0 };
    let inside = |t: f64| (-slack..=1.0 + slack).contains(&t);
    (inside(t1) && inside(t2)).then(|| {
        if slack == 0.0 {
            return ([p + d1 * t1, r + d2 * t2], Angle::Wide);
        }
        let on_second = nearest_on_segment(&(p + d1 * t1.clamp(0.0, 1.0)), second);
        ([nearest_on_segment(&on_second, first), on_second], Angle::Narrow)
    })
}

/// The pair whose points are nearest; the origin twice of none.
#[must_use]
pub fn nearest_pair(pairs: impl Iterator<Item = PointPair>) -> PointPair {
    let mut nearest = NearestPair::default();
    for pair in pairs {
        nearest.offer(pair);
    }
    nearest.pair
}
