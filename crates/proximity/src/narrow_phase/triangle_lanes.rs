//! Triangles in SIMD lanes, in f32: tests of eight pairs at once, with guaranteed separation and distance bounds.
//!
//! Coordinates have an error of at most `slack` (m). Every test allows for this error in both triangles, scaled by the edges that it
//! uses, and never by their product, which vanishes for slivers. Pairs that are not excluded are decided in f64.

use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{LANES, Simd, Vectors, f32x8, not_beyond};

use super::single_precision::shortened;
use crate::bounding_volume::Relative;
use crate::bvh::TriangleLeaf;

/// Bit mask of the lanes.
const ALL: u64 = (1 << LANES) - 1;

/// The corners of eight triangles of a, in the frame of b's tree.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub(crate) struct MovedTriangles {
    corners: [[[f32; LANES]; 3]; 3],
}

impl MovedTriangles {
    /// The triangles, and a bit mask of those whose box is not farther than `margin` from a box with corners `low` and `high`.
    #[inline(always)]
    pub fn new<S: Simd>(
        simd: S,
        a: &TriangleLeaf,
        relative: &Relative,
        (low, high): (&[f32; 3], &[f32; 3]),
        margin: f32,
    ) -> (Self, u64) {
        let (r, t) = (&relative.r, &relative.t);
        let p = Vectors::load(simd, &a.corners[0]).placed(r, t);
        let q = Vectors::load(simd, &a.corners[1]).placed(r, t);
        let s = Vectors::load(simd, &a.corners[2]).placed(r, t);
        let above = p.min(q).min(s).minus(Vectors::splat(simd, high));
        let below = Vectors::splat(simd, low).minus(p.max(q).max(s));
        let gap = above.max(below).max(Vectors::splat(simd, &[0.0; 3])).norm();
        let near = not_beyond(gap, margin) & a.mask();
        (Self { corners: [p.store(), q.store(), s.store()] }, near)
    }

    /// Bit mask of the triangles that are not farther than `margin` from all eight others along a direction of length at most one.
    #[inline(always)]
    pub fn near_along<S: Simd>(
        &self,
        simd: S,
        eight: &LaneTriangles<S>,
        direction: &[f32; 3],
        margin: f32,
    ) -> u64 {
        let [p, q, r] = &self.corners;
        let own = [Vectors::load(simd, p), Vectors::load(simd, q), Vectors::load(simd, r)];
        let [from, to] = span(own, direction);
        let [low, high] = span(eight.corners, direction);
        let (low, high) = (simd.reduce_min_f32x8(low), simd.reduce_max_f32x8(high));
        not_beyond((from - high).max(f32x8::splat(simd, low) - to), margin)
    }

    /// The corners of triangle `lane`.
    #[inline]
    pub fn corners(&self, lane: usize) -> [[f32; 3]; 3] {
        let taken = |[x, y, z]: &[[f32; LANES]; 3]| [x[lane & 7], y[lane & 7], z[lane & 7]];
        [taken(&self.corners[0]), taken(&self.corners[1]), taken(&self.corners[2])]
    }

    /// Triangle `lane`, in all lanes.
    #[inline(always)]
    pub fn one<S: Simd>(&self, simd: S, lane: usize) -> LaneTriangles<S> {
        let [p, q, r] = &self.corners;
        LaneTriangles::new(
            Vectors::splat(simd, &[p[0][lane & 7], p[1][lane & 7], p[2][lane & 7]]),
            Vectors::splat(simd, &[q[0][lane & 7], q[1][lane & 7], q[2][lane & 7]]),
            Vectors::splat(simd, &[r[0][lane & 7], r[1][lane & 7], r[2][lane & 7]]),
        )
    }
}

/// Range of the triangles' coordinates along a direction.
#[inline(always)]
fn span<S: Simd>([p, q, r]: [Vectors<S>; 3], direction: &[f32; 3]) -> [f32x8<S>; 2] {
    let (p, q, r) = (p.along(direction), q.along(direction), r.along(direction));
    [p.min(q).min(r), p.max(q).max(r)]
}

/// Squared lengths of edges, but at least `least`.
#[inline(always)]
fn squares<S: Simd>([d, e, f]: &[Vectors<S>; 3], least: f32x8<S>) -> [f32x8<S>; 3] {
    [d.dot(*d).max(least), e.dot(*e).max(least), f.dot(*f).max(least)]
}

/// A triangle in every lane, with the values used by the tests.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LaneTriangles<S: Simd> {
    corners: [Vectors<S>; 3],
    /// Edges, each from the corner with its index to the next one.
    edges: [Vectors<S>; 3],
    normal: Vectors<S>,
    /// 1-norm of the normal.
    area: f32x8<S>,
    /// 1-norms of all edges.
    size: f32x8<S>,
    low: Vectors<S>,
    high: Vectors<S>,
}

impl<S: Simd> LaneTriangles<S> {
    #[inline(always)]
    pub fn of_leaf(simd: S, leaf: &TriangleLeaf) -> Self {
        Self::load(simd, &leaf.corners)
    }

    /// Loads components, ordered by corner, coordinate and lane.
    #[inline(always)]
    pub fn load(simd: S, [p, q, r]: &[[[f32; LANES]; 3]; 3]) -> Self {
        Self::new(Vectors::load(simd, p), Vectors::load(simd, q), Vectors::load(simd, r))
    }

    /// As [`Self::load`], transformed from the frame of one tree to another's.
    #[inline(always)]
    pub fn placed(simd: S, [p, q, s]: &[[[f32; LANES]; 3]; 3], relative: &Relative) -> Self {
        let (r, t) = (&relative.r, &relative.t);
        Self::new(
            Vectors::load(simd, p).placed(r, t),
            Vectors::load(simd, q).placed(r, t),
            Vectors::load(simd, s).placed(r, t),
        )
    }

    #[inline(always)]
    fn new(p: Vectors<S>, q: Vectors<S>, r: Vectors<S>) -> Self {
        let edges = [q.minus(p), r.minus(q), p.minus(r)];
        let normal = edges[0].cross(edges[1]);
        Self {
            corners: [p, q, r],
            edges,
            normal,
            area: normal.one_norm(),
            size: edges[0].one_norm() + edges[1].one_norm() + edges[2].one_norm(),
            low: p.min(q).min(r),
            high: p.max(q).max(r),
        }
    }

    /// Bit mask of the lanes whose triangles may touch.
    #[inline(always)]
    pub fn may_touch(&self, simd: S, other: &Self, slack: f32) -> u64 {
        let near = not_beyond(self.box_gaps(other).largest(), 2.0 * slack) & ALL;
        if near == 0 {
            return 0;
        }
        // if boxes touch, no two corners are farther apart than this
        let span = self.size + other.size + 8.0 * slack;
        let across = self.plane_gap(simd, other, span, slack).max(other.plane_gap(simd, self, span, slack));
        let near = near & not_beyond(across, 0.0);
        if near == 0 {
            return 0;
        }
        near & not_beyond(self.edge_gap(simd, other, span, slack), 0.0)
    }

    /// Gaps of the boxes along the three axes.
    #[inline(always)]
    fn box_gaps(&self, other: &Self) -> Vectors<S> {
        self.low.minus(other.high).max(other.low.minus(self.high))
    }

    /// Distance of the other triangle from this one's plane, minus the rounding error, in units of the normal's length. No corners are
    /// farther apart than `span`.
    #[inline(always)]
    fn plane_gap(&self, simd: S, other: &Self, span: f32x8<S>, slack: f32) -> f32x8<S> {
        let h0 = self.normal.dot(other.corners[0].minus(self.corners[0]));
        let h1 = self.normal.dot(other.corners[1].minus(self.corners[0]));
        let h2 = self.normal.dot(other.corners[2].minus(self.corners[0]));
        let over = h0.min(h1).min(h2).max(f32x8::splat(simd, 0.0) - h0.max(h1).max(h2));
        over - (self.area + self.size * span) * (2.0 * slack)
    }

    /// The largest gap along the nine axes normal to an edge of each, minus the rounding error.
    #[inline(always)]
    fn edge_gap(&self, simd: S, other: &Self, span: f32x8<S>, slack: f32) -> f32x8<S> {
        let mut gap = f32x8::splat(simd, f32::NEG_INFINITY);
        for i in 0..3 {
            for j in 0..3 {
                gap = gap.max(self.gap_across_edges(simd, other, [i, j], span, slack));
            }
        }
        gap
    }

    /// The gap along the axis normal to edge `i` of this triangle and edge `j` of the other, minus the rounding error.
    ///
    /// Along this axis both ends of each edge project to the same value, so each triangle extends from there to its
    /// opposite corner.
    #[inline(always)]
    fn gap_across_edges(
        &self,
        simd: S,
        other: &Self,
        [i, j]: [usize; 2],
        span: f32x8<S>,
        slack: f32,
    ) -> f32x8<S> {
        let zero = f32x8::splat(simd, 0.0);
        let axis = self.edges[i].cross(other.edges[j]);
        let from = other.corners[j];
        let u = axis.dot(self.corners[i].minus(from));
        let v = axis.dot(self.corners[(i + 2) % 3].minus(from));
        let w = axis.dot(other.corners[(j + 2) % 3].minus(from));
        let apart = (u.min(v) - w.max(zero)).max(w.min(zero) - u.max(v));
        apart - (axis.one_norm() + span * (self.size + other.size)) * (2.0 * slack)
    }

    /// Upper bounds (m) on the distances of the triangle's points from a point.
    #[inline(always)]
    pub fn farthest_from(&self, simd: S, point: &[f32; 3], slack: f32) -> f32x8<S> {
        let point = Vectors::splat(simd, point);
        let [p, q, r] = self.corners;
        let farthest = p.minus(point).norm().max(q.minus(point).norm()).max(r.minus(point).norm());
        farthest + farthest * (16.0 * f32::EPSILON) + 8.0 * slack
    }

    /// Lower bounds (m) on the distances: from the boxes, and along a `direction` of length at most one in which near elements were
    /// found.
    #[inline(always)]
    pub fn coarse_bounds(&self, simd: S, other: &Self, direction: &[f32; 3], slack: f32) -> f32x8<S> {
        let across_boxes = self.box_gaps(other).max(Vectors::splat(simd, &[0.0; 3])).norm();
        let [from, to] = span(self.corners, direction);
        let [low, high] = span(other.corners, direction);
        across_boxes.max(low - to).max(from - high) - 4.0 * slack
    }

    /// Lower and upper bounds (m) on the distances; where triangles cross, the upper one is not tight.
    ///
    /// Approximately nearest points are computed over edges and edges, corners and faces (Larsen et al. 1999, 4.2). Whatever their
    /// rounding errors, they are points of the triangles, and the gap along the direction between them is a lower bound.
    #[inline(always)]
    pub fn bounds(&self, simd: S, other: &Self, slack: f32) -> DistanceLanes<S> {
        let zero = f32x8::splat(simd, 0.0);
        let start = other.corners[0].minus(self.corners[0]);
        let mut nearest = Nearest { between: start, squared: start.dot(start) };
        self.edges_and_edges(simd, other, &mut nearest);
        self.corners_and_face(simd, other, &mut nearest);
        other.corners_and_face(simd, self, &mut nearest);
        let (n, length) = (nearest.between, nearest.squared.sqrt());
        let scale = f32x8::splat(simd, 1.0) / n.norm().max(f32x8::splat(simd, 1e-18));
        let (q0, q1, q2) = (
            n.dot(start),
            n.dot(other.corners[1].minus(self.corners[0])),
            n.dot(other.corners[2].minus(self.corners[0])),
        );
        let (p1, p2) = (n.dot(self.edges[0]), zero - n.dot(self.edges[2]));
        // n may point either way
        let ahead = q0.min(q1).min(q2) - p1.max(p2).max(zero);
        let behind = p1.min(p2).min(zero) - q0.max(q1).max(q2);
        let lower = ahead.max(behind) * scale;
        let rounding = (self.size + other.size + length) * (16.0 * f32::EPSILON) + 4.0 * slack;
        let signed = ahead.simd_ge(behind).select(scale, zero - scale);
        DistanceLanes {
            lower: lower.min(length) - rounding,
            upper: length + rounding,
            between: n,
            towards: n.scaled(signed),
        }
    }

    /// Nearest points of every edge of each (Ericson, *Real-Time Collision Detection*, 5.1.9).
    #[inline(always)]
    fn edges_and_edges(&self, simd: S, other: &Self, nearest: &mut Nearest<S>) {
        let (zero, unit) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
        let tiny = f32x8::splat(simd, 1e-36);
        let (squares_d, squares_f) = (squares(&self.edges, tiny), squares(&other.edges, tiny));
        // each divisor is inverted only once
        let over = |[a, b, c]: [f32x8<S>; 3]| [unit / a, unit / b, unit / c];
        let (over_d, over_f) = (over(squares_d), over(squares_f));
        for i in 0..3 {
            let (d, a) = (self.edges[i], squares_d[i]);
            for j in 0..3 {
                let (f, e) = (other.edges[j], squares_f[j]);
                let w = self.corners[i].minus(other.corners[j]);
                let (b, c, g) = (d.dot(f), d.dot(w), f.dot(w));
                let s = ((b * g - c * e) / (a * e - b * b).max(tiny)).max(zero).min(unit);
                let t = ((b * s + g) * over_f[j]).max(zero).min(unit);
                let s = ((b * t - c) * over_d[i]).max(zero).min(unit);
                nearest.offer(f.scaled(t).minus(d.scaled(s)).minus(w));
            }
        }
    }

    /// Nearest points for the other's corners that lie above or below this face.
    ///
    /// The normal of a sliver is noise in f32. So the distance of a corner from the face is measured to a weighted mean of the face's
    /// corners, which lies in the face for any weights. The normal is only used as the direction of a lower bound.
    #[inline(always)]
    fn corners_and_face(&self, simd: S, other: &Self, nearest: &mut Nearest<S>) {
        let (zero, least) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1e-30));
        let n = self.normal;
        let [p, q, r] = self.corners;
        let sides = [n.cross(self.edges[0]), n.cross(self.edges[1]), n.cross(self.edges[2])];
        for corner in other.corners {
            let (u, v, w) = (p.minus(corner), q.minus(corner), r.minus(corner));
            // the part of the face's area across each edge, opposite the third corner
            let (of_r, of_p, of_q) = (zero - sides[0].dot(u), zero - sides[1].dot(v), zero - sides[2].dot(w));
            let whole = of_p + of_q + of_r;
            let share = f32x8::splat(simd, 1.0) / whole.max(least);
            let mean = u.scaled(of_p * share).plus(v.scaled(of_q * share)).plus(w.scaled(of_r * share));
            // weights that nearly underflow are no longer proportional
            let over = of_r.min(of_p).min(of_q).min(whole - least).simd_gt(zero);
            nearest.offer_where(over, mean.dot(mean), n);
        }
    }
}

/// Eight pairs of triangles in one frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TrianglePairs<'l, S: Simd> {
    pub one: &'l LaneTriangles<S>,
    pub other: &'l LaneTriangles<S>,
    /// Error (m) of the coordinates.
    pub slack: f32,
    /// Bit mask of the lanes that hold a pair.
    pub mask: u64,
}

/// Bounds on the distances (m) of pairs of triangles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DistanceLanes<S: Simd> {
    pub lower: f32x8<S>,
    pub upper: f32x8<S>,
    /// The direction along which the lower bound holds, from one to the other, of length one up to rounding.
    pub towards: Vectors<S>,
    /// From a point of one to a point of the other, or back; they are approximately the nearest.
    between: Vectors<S>,
}

impl<S: Simd> DistanceLanes<S> {
    /// The direction between the points of a lane, of length at most one.
    #[inline]
    pub fn direction(&self, lane: usize) -> [f32; 3] {
        let [x, y, z] = self.between.store();
        shortened([x[lane & 7], y[lane & 7], z[lane & 7]])
    }
}

/// The shortest distances found so far from a point of one triangle to a point of the other.
struct Nearest<S: Simd> {
    squared: f32x8<S>,
    /// Direction of the line between the points, of either sign and any length.
    between: Vectors<S>,
}

impl<S: Simd> Nearest<S> {
    #[inline(always)]
    fn offer(&mut self, between: Vectors<S>) {
        let squared = between.dot(between);
        self.between = between.or(squared.simd_lt(self.squared), self.between);
        self.squared = squared.min(self.squared);
    }

    #[inline(always)]
    fn offer_where(&mut self, holds: impl Select<f32x8<S>>, squared: f32x8<S>, between: Vectors<S>) {
        let squared = holds.select(squared, self.squared);
        self.between = between.or(squared.simd_lt(self.squared), self.between);
        self.squared = squared.min(self.squared);
    }
}
