//! Triangles and segments: exact nearest points and intersection, in f64.
//!
//! Nearest points follow Ericson, *Real-Time Collision Detection* (2005), 5.1.5 and 5.1.9; two triangles are at their
//! least distance at a vertex of one and the face of the other, at two edges, or they cross (Larsen, Gottschalk, Lin &
//! Manocha 1999, *Fast proximity queries with swept sphere volumes*, 4.2).

use crate::constants::CONTACT_DISTANCE;
use crate::math::{Point, Pose, Vector};

/// Three corners; it may be degenerate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    pub a: Point,
    pub b: Point,
    pub c: Point,
}

/// Squared sine of a corner angle below which barycentric coordinates are too rough to stand alone.
const SLIVER: f64 = 1e-8;

/// Squared sine of an angle below which two segments count as parallel: over a metre they part by 1e-10 m.
const PARALLEL: f64 = 1e-20;

/// Two points, one on each of two solids.
pub type PointPair = [Point; 2];

impl Triangle {
    #[must_use]
    pub fn corners(&self) -> [Point; 3] {
        [self.a, self.b, self.c]
    }

    #[must_use]
    pub fn edges(&self) -> [[Point; 2]; 3] {
        [[self.a, self.b], [self.b, self.c], [self.c, self.a]]
    }

    #[must_use]
    pub fn transformed(&self, pose: &Pose) -> Self {
        Self { a: pose * self.a, b: pose * self.b, c: pose * self.c }
    }

    /// Unit normal by the right-hand rule; zero for a degenerate triangle.
    #[must_use]
    pub fn normal(&self) -> Vector {
        (self.b - self.a).cross(&(self.c - self.a)).try_normalize(0.0).unwrap_or_else(Vector::zeros)
    }

    /// The point of the triangle nearest to `p` (Ericson 5.1.5: walk the Voronoi regions of corners, edges, face).
    #[must_use]
    pub fn nearest_point(&self, p: &Point) -> Point {
        let (ab, ac, ap) = (self.b - self.a, self.c - self.a, p - self.a);
        let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
        if d1 <= 0.0 && d2 <= 0.0 {
            return self.a;
        }
        let bp = p - self.b;
        let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
        if d3 >= 0.0 && d4 <= d3 {
            return self.b;
        }
        let cp = p - self.c;
        let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
        if d6 >= 0.0 && d5 <= d6 {
            return self.c;
        }
        let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
        if [va, vb, vc].iter().any(|v| *v <= 0.0) {
            return nearest_of(p, self.edges().map(|e| nearest_on_segment(p, &e)));
        }
        let sum = va + vb + vc;
        let inside = self.a + ab * (vb / sum) + ac * (vc / sum);
        if sum > SLIVER * ab.norm_squared() * ac.norm_squared() {
            return inside;
        }
        let on_edge = nearest_of(p, self.edges().map(|e| nearest_on_segment(p, &e)));
        nearest_pair([[*p, inside], [*p, on_edge]].into_iter())[1]
    }

    /// Nearest points of two triangles in one frame; the same point twice where they cross.
    #[must_use]
    pub fn nearest_points(&self, other: &Self) -> PointPair {
        let apart = self.plane_separates(other, 0.0) || other.plane_separates(self, 0.0);
        let crossing = if apart { None } else { self.crossing_point(other) };
        crossing.map_or_else(|| self.nearest_features(other), |p| [p, p])
    }

    /// A common point, if the triangles come within [`CONTACT_DISTANCE`].
    #[must_use]
    pub fn contact_point(&self, other: &Self) -> Option<Point> {
        let clear = CONTACT_DISTANCE;
        if self.plane_separates(other, clear) || other.plane_separates(self, clear) {
            return None;
        }
        self.crossing_point(other).or_else(|| {
            let [p, q] = self.nearest_features(other);
            (nalgebra::distance(&p, &q) <= CONTACT_DISTANCE).then_some(p)
        })
    }

    /// Whether all of `other` lies more than `clear` (m) and what rounding may hide on one side of this triangle's plane.
    fn plane_separates(&self, other: &Self, clear: f64) -> bool {
        let normal = (self.b - self.a).cross(&(self.c - self.a));
        let offsets = other.corners().map(|p| p - self.a);
        let heights = offsets.map(|o| normal.dot(&o));
        let reach = offsets.iter().fold(0.0, |m: f64, o| m.max(o.abs().sum()));
        let needed = normal.norm() * (clear + 1e-15 * reach) + self.normal_error() * reach;
        heights.iter().all(|h| *h > needed) || heights.iter().all(|h| *h < -needed)
    }

    /// How far rounding may have moved the normal: each of its components is a difference of products.
    fn normal_error(&self) -> f64 {
        1e-15 * (self.b - self.a).abs().sum() * (self.c - self.a).abs().sum()
    }

    /// A point where an edge of one triangle pierces the other: in general position every crossing has one, and where
    /// rounding hides it, the edges concerned are nearer than any tolerance.
    fn crossing_point(&self, other: &Self) -> Option<Point> {
        let pierced = |t: &Self, by: &Self| by.edges().iter().find_map(|e| t.pierced_by(e));
        pierced(self, other).or_else(|| pierced(other, self))
    }

    /// Where the segment passes through the triangle (Ericson 5.3.6, with both ends on opposite sides of the plane).
    #[must_use]
    pub fn pierced_by(&self, [p, q]: &[Point; 2]) -> Option<Point> {
        let (pq, pa, pb, pc) = (q - p, self.a - p, self.b - p, self.c - p);
        let volume = |u: &Vector, v: &Vector| pq.dot(&u.cross(v));
        let (u, v, w) = (volume(&pc, &pb), volume(&pa, &pc), volume(&pb, &pa));
        let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
        let sum = u + v + w;
        if !inside || sum == 0.0 {
            return None;
        }
        let normal = (self.b - self.a).cross(&(self.c - self.a));
        let (height_p, height_q) = (-normal.dot(&pa), normal.dot(&(q - self.a)));
        (height_p * height_q <= 0.0)
            .then(|| Point::from((self.a.coords * u + self.b.coords * v + self.c.coords * w) / sum))
    }

    /// Nearest points over vertex–face and edge–edge pairs, until a pair is proven to be the nearest; right unless the
    /// triangles cross.
    fn nearest_features(&self, other: &Self) -> PointPair {
        let (ours, theirs) = (self.corners(), other.corners());
        let from_ours = ours.iter().map(|p| [*p, other.nearest_point(p)]);
        let to_theirs = theirs.iter().map(|q| [self.nearest_point(q), *q]);
        let mut best = nearest_pair(from_ours.chain(to_theirs));
        let mut least = nalgebra::distance_squared(&best[0], &best[1]);
        if separated_across(&best, &ours, &theirs) {
            return best;
        }
        for e in self.edges() {
            for f in other.edges() {
                let pair = nearest_on_segments(&e, &f);
                let d = nalgebra::distance_squared(&pair[0], &pair[1]);
                if d < least {
                    (least, best) = (d, pair);
                    if separated_across(&best, &ours, &theirs) {
                        return best;
                    }
                }
            }
        }
        best
    }

    /// Nearest points of the triangle and a segment; the same point twice where it pierces.
    #[must_use]
    pub fn nearest_to_segment(&self, segment: &[Point; 2]) -> PointPair {
        if let Some(p) = self.pierced_by(segment) {
            return [p, p];
        }
        let ends = segment.map(|q| [self.nearest_point(&q), q]);
        let edges = self.edges().map(|e| nearest_on_segments(&e, segment));
        nearest_pair(ends.into_iter().chain(edges))
    }
}

/// Whether the planes through two points, normal to the line between them, have one polygon on each outer side: then no
/// points of the polygons are nearer (the early exit of PQP's triangle distance, Larsen et al. 1999).
#[must_use]
pub fn separated_across([p, q]: &PointPair, ours: &[Point], theirs: &[Point]) -> bool {
    let n = q - p;
    n != Vector::zeros()
        && ours.iter().all(|c| n.dot(&(c - p)) <= 0.0)
        && theirs.iter().all(|c| n.dot(&(c - q)) >= 0.0)
}

/// The point of a segment nearest to `p`.
#[must_use]
pub fn nearest_on_segment(p: &Point, [a, b]: &[Point; 2]) -> Point {
    let ab = b - a;
    let length_squared = ab.norm_squared();
    if length_squared == 0.0 {
        return *a;
    }
    let t = ((p - a).dot(&ab) / length_squared).clamp(0.0, 1.0);
    if t == 1.0 { *b } else { a + ab * t }
}

/// Nearest points of two segments: inside both, or at an end of one.
#[must_use]
pub fn nearest_on_segments(first: &[Point; 2], second: &[Point; 2]) -> PointPair {
    nearest_inside_segments(first, second).unwrap_or_else(|| {
        nearest_pair(
            [
                [first[0], nearest_on_segment(&first[0], second)],
                [first[1], nearest_on_segment(&first[1], second)],
                [nearest_on_segment(&second[0], first), second[0]],
                [nearest_on_segment(&second[1], first), second[1]],
            ]
            .into_iter(),
        )
    })
}

/// Nearest points of the two lines, if they lie inside both segments and the lines are not parallel. The cross product
/// of the directions keeps its accuracy down to [`PARALLEL`]; below, an end of a segment is as near.
fn nearest_inside_segments([p, q]: &[Point; 2], [r, s]: &[Point; 2]) -> Option<PointPair> {
    let (d1, d2, pr) = (q - p, s - r, r - p);
    let n = d1.cross(&d2);
    let n2 = n.norm_squared();
    if n2 <= PARALLEL * d1.norm_squared() * d2.norm_squared() {
        return None;
    }
    let t1 = pr.cross(&d2).dot(&n) / n2;
    let t2 = pr.cross(&d1).dot(&n) / n2;
    let inside = (0.0..=1.0).contains(&t1) && (0.0..=1.0).contains(&t2);
    inside.then(|| [p + d1 * t1, r + d2 * t2])
}

fn nearest_of(p: &Point, candidates: [Point; 3]) -> Point {
    let pairs = candidates.map(|c| [*p, c]);
    nearest_pair(pairs.into_iter())[1]
}

fn nearest_pair(pairs: impl Iterator<Item = PointPair>) -> PointPair {
    let mut best = [Point::origin(); 2];
    let mut least = f64::INFINITY;
    for pair in pairs {
        let d = nalgebra::distance_squared(&pair[0], &pair[1]);
        if d < least {
            (least, best) = (d, pair);
        }
    }
    best
}
