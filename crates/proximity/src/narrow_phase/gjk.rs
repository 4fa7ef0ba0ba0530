//! GJK: the least distance of two convex cores by their support points (Gilbert, Johnson & Keerthi 1988, *A fast procedure for computing
//! the distance between complex objects in three-dimensional space*).
//!
//! Every tested direction gives two supporting planes, whose gap is a lower bound. Every simplex gives two points, whose distance is an
//! upper bound. The search ends when the bounds meet, or as soon as the lower bound exceeds the limit.

use clearance_geometry::PointPair;
use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, MatrixPose, Point, Vector};

use crate::elements::CoreShape;

/// Accuracy (m) at which the search ends: a tenth of the contact distance.
pub(crate) const ACCURACY: f64 = 1e-10;

/// Rounding error allowed for a gap between supporting planes, relative to the coordinates used.
const ROUNDING: f64 = 1e-14;

const MOST_STEPS: usize = 100;

/// Number of steps without progress before the search ends. A nearest point with an error of one rounding in distance may be off sideways
/// by the square root of that error, which affects the lower bound.
const MOST_IDLE_STEPS: u32 = 8;

/// Loss of a step by rounding, as a fraction of the distance.
const IDLE: f64 = 1.0 + 1e-14;

/// Cosine above which the normal of a simplex counts as the direction to its nearest point.
const ALIGNED: f64 = 0.999;

/// Two cores, the second posed in the frame of the first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CorePair<'c> {
    pub a: &'c CoreShape,
    pub b: &'c CoreShape,
    pub pose_ab: &'c MatrixPose,
}

/// Two points of the cores, and a lower bound on the distance of the cores.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nearest {
    pub points: PointPair,
    pub proven: f64,
}

/// A vertex of the Minkowski difference: a point of a, and this point minus a point of b.
#[derive(Clone, Copy, Debug)]
struct Vertex {
    on_a: Vector,
    difference: Vector,
}

/// Simplex of up to four vertices; its point nearest to the origin is searched.
struct Simplex {
    vertices: [Vertex; 4],
    count: usize,
}

impl CorePair<'_> {
    /// The point of b nearest to a given point, both in the frame of a.
    #[inline]
    pub fn nearest_on_b(&self, p: &Point) -> Point {
        self.pose_ab * self.b.nearest_point(&self.in_b(p))
    }

    /// Transforms a point to the frame of b.
    #[inline]
    pub fn in_b(&self, p: &Point) -> Point {
        let MatrixPose { rotation, translation } = self.pose_ab;
        Point::from(rotation.tr_mul(&(p.coords - translation)))
    }

    /// Approximately nearest points of both cores: one is projected on the other, and back.
    #[inline]
    pub fn nearly_nearest(&self, start: &Point) -> PointPair {
        let q = self.nearest_on_b(&self.a.nearest_point(start));
        let p = self.a.nearest_point(&q);
        [p, self.nearest_on_b(&p)]
    }

    /// True if the closed formula for the nearest points costs more than a first approximation.
    #[inline]
    pub fn has_slow_formula(&self) -> bool {
        matches!(
            (self.a, self.b),
            (CoreShape::Triangle(_), CoreShape::Segment(_)) | (CoreShape::Segment(_), CoreShape::Triangle(_))
        )
    }

    /// The support vertex of a direction: of a along it, of b against it.
    fn support(&self, n: &Vector) -> Vertex {
        let on_a = self.a.support(n).coords;
        let MatrixPose { rotation, translation } = self.pose_ab;
        let on_b = rotation * self.b.support(&-rotation.tr_mul(n)).coords + translation;
        Vertex { on_a, difference: on_a - on_b }
    }
}

impl Nearest {
    /// Result for points from a closed formula.
    #[inline]
    pub fn exactly(points: PointPair) -> Self {
        Self { points, proven: nalgebra::distance(&points[0], &points[1]) }
    }
}

/// True if the direction between two points of the cores proves them farther apart than `limit` (m).
#[inline]
pub(crate) fn are_beyond(pair: &CorePair, [p, q]: PointPair, limit: f64) -> bool {
    let Some(outward) = (q - p).try_normalize(CONTACT_DISTANCE) else { return false };
    let vertex = pair.support(&outward);
    -outward.dot(&vertex.difference) - vertex.rounding() > limit
}

/// Nearest points, starting from any two points of the cores; `None` once the distance is proven larger than `limit` (m).
///
/// The result does not depend on the limit.
pub(crate) fn nearest_points(pair: &CorePair, start: PointPair, limit: f64) -> Option<Nearest> {
    let mut points = start;
    let mut between = start[0] - start[1];
    let mut apart = between.norm();
    let mut proven = 0.0_f64;
    let mut idle = 0;
    let mut simplex = Simplex::new(Vertex { on_a: start[0].coords, difference: between });
    for _ in 0..MOST_STEPS {
        if apart <= CONTACT_DISTANCE {
            break;
        }
        let outward = simplex.outward(&(between / -apart));
        let vertex = pair.support(&outward);
        let gap = -outward.dot(&vertex.difference);
        if gap - vertex.rounding() > limit {
            return None;
        }
        proven = proven.greater(gap);
        if apart - proven <= ACCURACY || simplex.has(&vertex) {
            break;
        }
        simplex.push(vertex);
        let weights = simplex.nearest_to_origin();
        let nearest = simplex.weighted(&weights, |v| v.difference);
        let norm = nearest.norm();
        idle += u32::from(norm >= apart);
        if norm > apart * IDLE || idle > MOST_IDLE_STEPS {
            break;
        }
        let on_a = Point::from(simplex.weighted(&weights, |v| v.on_a));
        (points, between, apart) = ([on_a, on_a - nearest], nearest, norm);
        simplex.retain(&weights);
        if simplex.count == 4 {
            // the origin lies inside
            return Some(Nearest { points: [on_a, on_a], proven: 0.0 });
        }
    }
    Some(Nearest { points, proven: proven.lesser(apart) })
}

impl Vertex {
    /// Rounding error (m) of a gap.
    fn rounding(&self) -> f64 {
        ROUNDING * (self.on_a.abs().sum() + self.difference.abs().sum())
    }
}

impl Simplex {
    fn new(vertex: Vertex) -> Self {
        Self { vertices: [vertex; 4], count: 1 }
    }

    fn has(&self, vertex: &Vertex) -> bool {
        self.vertices[..self.count].iter().any(|v| v.difference == vertex.difference)
    }

    fn push(&mut self, vertex: Vertex) {
        self.vertices[self.count] = vertex;
        self.count += 1;
    }

    /// Removes the vertices without weight.
    fn retain(&mut self, weights: &[f64; 4]) {
        let mut kept = 0;
        for (i, weight) in weights.iter().enumerate().take(self.count) {
            if *weight > 0.0 {
                self.vertices[kept] = self.vertices[i];
                kept += 1;
            }
        }
        self.count = kept;
    }

    fn weighted(&self, weights: &[f64; 4], of: fn(&Vertex) -> Vector) -> Vector {
        let terms = self.vertices[..self.count].iter().zip(weights).map(|(v, w)| of(v) * *w);
        terms.sum()
    }

    /// The search direction, about `n`. Near contact the nearest point alone determines the direction badly; the normal of the face that
    /// it lies in is used instead.
    fn outward(&self, n: &Vector) -> Vector {
        if self.count == 3 {
            let [p, q, r] = [0, 1, 2].map(|i| self.vertices[i].difference);
            let normal = (q - p).cross(&(r - p));
            let (length, along) = (normal.norm(), normal.dot(n));
            if along.abs() > ALIGNED * length {
                return normal * (along.signum() / length);
            }
        }
        *n
    }

    /// Weights of the simplex's point nearest to the origin: the best over all faces that contain their nearest point. The newest vertex
    /// belongs to every such face, or the previous simplex would have had a nearer point.
    fn nearest_to_origin(&self) -> [f64; 4] {
        let newest = self.count - 1;
        let corner = self.vertices[newest].difference;
        let edge = |i: usize| self.vertices[i].difference - corner;
        let mut best = Best { weights: [0.0; 4], squared: corner.norm_squared() };
        best.weights[newest] = 1.0;
        for i in 0..newest {
            let e = edge(i);
            best.offer(&corner, newest, [(i, e, -corner.dot(&e) / e.norm_squared())]);
        }
        for i in 1..newest {
            for j in 0..i {
                let (e, f) = (edge(i), edge(j));
                let n = e.cross(&f);
                let n2 = n.norm_squared();
                let (u, v) = (f.cross(&corner).dot(&n) / n2, corner.cross(&e).dot(&n) / n2);
                best.offer(&corner, newest, [(i, e, u), (j, f, v)]);
            }
        }
        if newest == 3 {
            let (e, f, g) = (edge(0), edge(1), edge(2));
            let volume = -e.dot(&f.cross(&g));
            let (u, v, w) = (corner.dot(&f.cross(&g)), corner.dot(&g.cross(&e)), corner.dot(&e.cross(&f)));
            best.offer(&corner, newest, [(0, e, u / volume), (1, f, v / volume), (2, g, w / volume)]);
        }
        best.weights
    }
}

/// The point of a simplex nearest to the origin so far.
struct Best {
    weights: [f64; 4],
    squared: f64,
}

impl Best {
    /// Uses the point with these weights along edges from a corner, if it lies inside their face and is nearer.
    fn offer<const N: usize>(&mut self, corner: &Vector, newest: usize, along: [(usize, Vector, f64); N]) {
        let rest = 1.0 - along.iter().map(|(.., w)| w).sum::<f64>();
        // NaN is not a valid weight
        if !(rest > 0.0 && along.iter().all(|(.., w)| *w > 0.0)) {
            return;
        }
        let point = along.iter().fold(*corner, |point, (_, edge, w)| point + edge * *w);
        // if equal, the larger face: it includes the points on its edges, and gives a better direction
        if point.norm_squared() <= self.squared * IDLE {
            self.squared = point.norm_squared();
            self.weights = [0.0; 4];
            self.weights[newest] = rest;
            for (i, _, w) in along {
                self.weights[i] = w;
            }
        }
    }
}
