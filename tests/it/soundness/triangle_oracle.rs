//! Test oracle: distance of two triangles in 106-bit arithmetic.
//!
//! Two triangles cross, or are nearest at a corner of one over the face of the other, at a corner and an edge, or at two
//! edges. Every squared distance is a quotient whose numerator and denominator are sums of few products, so that one
//! rounding to f64 at the end is all that is lost.

use clearance::geometry::math::Vector;

use super::double_double::Vec3;

/// Squared sine of an angle below which a triangle counts as its edges and two edges as parallel: what that leaves out
/// is nearer to an edge or a corner than 1e-13 of the length.
const DEGENERATE: f64 = 1e-26;

/// A squared distance, and the direction from the second triangle to the first or against it, of any length.
#[derive(Clone, Copy, Debug)]
pub struct Nearest {
    pub squared: f64,
    pub direction: Vector,
}

impl Nearest {
    fn improve(&mut self, squared: f64, direction: impl FnOnce() -> Vector) {
        if squared < self.squared {
            *self = Self { squared, direction: direction() };
        }
    }
}

/// A triangle with what every question about it needs.
struct Face {
    corners: [Vec3; 3],
    /// Edge `i` leads from corner `i` to the next.
    edges: [Vec3; 3],
    edges_squared: [f64; 3],
    normal: Vec3,
    normal_squared: f64,
    /// In the plane, normal to each edge, towards the inside.
    inward: [Vec3; 3],
    has_area: bool,
}

impl Face {
    fn new(corners: &[Vec3; 3]) -> Self {
        let edges = [0, 1, 2].map(|i| corners[(i + 1) % 3] - corners[i]);
        let edges_squared = edges.map(|e| e.norm_squared().rounded());
        let normal = edges[0].cross(&edges[1]);
        let normal_squared = normal.norm_squared().rounded();
        let longest = edges_squared.iter().fold(0.0, |m: f64, e| m.max(*e));
        let has_area = normal_squared > DEGENERATE * longest * longest;
        let inward = edges.map(|e| normal.cross(&e));
        Self { corners: *corners, edges, edges_squared, normal, normal_squared, inward, has_area }
    }

    /// A point straight over the face.
    fn over(&self, p: &Vec3, best: &mut Nearest) {
        let inside = |i: usize| self.inward[i].dot(&(*p - self.corners[i])).rounded() >= 0.0;
        if self.has_area && (0..3).all(inside) {
            let height = self.normal.dot(&(*p - self.corners[0])).rounded();
            best.improve(height * height / self.normal_squared, || self.normal.rounded());
        }
    }

    /// A point beside the edges or at the corners.
    fn beside(&self, p: &Vec3, best: &mut Nearest) {
        for i in 0..3 {
            let offset = *p - self.corners[i];
            best.improve(offset.norm_squared().rounded(), || offset.rounded());
            let along = offset.dot(&self.edges[i]).rounded();
            if along > 0.0 && along < self.edges_squared[i] {
                let across = offset.cross(&self.edges[i]);
                let squared = across.norm_squared().rounded() / self.edges_squared[i];
                best.improve(squared, || self.edges[i].cross(&across).rounded());
            }
        }
    }

    /// Whether the edge from `p` to `q` passes through the face.
    fn pierced(&self, p: &Vec3, q: &Vec3) -> bool {
        let height = |x: &Vec3| self.normal.dot(&(*x - self.corners[0])).rounded();
        let (above_p, above_q) = (height(p), height(q));
        if !self.has_area || above_p * above_q > 0.0 || (above_p == 0.0 && above_q == 0.0) {
            return false;
        }
        let [a, b, c] = self.corners.map(|corner| corner - *p);
        let edge = *q - *p;
        let sides = [(a, b), (b, c), (c, a)].map(|(from, to)| edge.dot(&from.cross(&to)).rounded());
        sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0)
    }

    fn pierced_by_edge_of(&self, other: &Self) -> bool {
        (0..3).any(|i| self.pierced(&other.corners[i], &other.corners[(i + 1) % 3]))
    }
}

/// Two edges that are nearest inside both.
fn between_edges(s: &Face, i: usize, t: &Face, j: usize, best: &mut Nearest) {
    let (d, e) = (&s.edges[i], &t.edges[j]);
    let normal = d.cross(e);
    let squared = normal.norm_squared().rounded();
    if squared <= DEGENERATE * s.edges_squared[i] * t.edges_squared[j] {
        return;
    }
    let offset = t.corners[j] - s.corners[i];
    let inside = |along: &Vec3| (0.0..=squared).contains(&offset.cross(along).dot(&normal).rounded());
    if inside(e) && inside(d) {
        let height = offset.dot(&normal).rounded();
        best.improve(height * height / squared, || normal.rounded());
    }
}

/// Least distance of two triangles, degenerate ones too: three equal corners are a point, two a segment.
pub fn triangle_distance(s: &[Vec3; 3], t: &[Vec3; 3]) -> Nearest {
    let (s, t) = (Face::new(s), Face::new(t));
    let mut best = Nearest { squared: f64::INFINITY, direction: Vector::zeros() };
    for (face, points) in [(&s, &t), (&t, &s)] {
        for p in &points.corners {
            face.beside(p, &mut best);
            face.over(p, &mut best);
        }
    }
    for i in 0..3 {
        for j in 0..3 {
            between_edges(&s, i, &t, j, &mut best);
        }
    }
    // what touches at a corner needs no piercing
    if best.squared > 0.0 && (s.pierced_by_edge_of(&t) || t.pierced_by_edge_of(&s)) {
        best.squared = 0.0;
    }
    best
}
