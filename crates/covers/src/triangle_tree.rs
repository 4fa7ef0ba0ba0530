//! Tree of boxes around triangles: distance of a point from the nearest triangle.

use clearance_geometry::Triangle;
use clearance_geometry::math::{Extremes, Point, Vector};

use crate::ball::ROUNDING;

/// Largest number of triangles in a leaf.
const LEAF: usize = 4;

/// Binary tree of axis-aligned boxes.
#[derive(Clone, Debug)]
pub struct TriangleTree {
    nodes: Vec<Node>,
    triangles: Vec<Triangle>,
    /// In the order of the triangles.
    prepared: Vec<PreparedTriangle>,
}

/// A triangle is narrow if the rounding of its normal, times its longest edge, may exceed a tenth of the rounding that proofs allow for.
const NARROW: f64 = 10.0 * 4.0 * f64::EPSILON / ROUNDING;

/// A triangle with the data for distances from points.
#[derive(Clone, Copy, Debug)]
struct PreparedTriangle {
    corners: [Point; 3],
    edges: [Vector; 3],
    /// By edge: 1 / squared length, 0 for an edge without length.
    inverse: [f64; 3],
    /// Unit normal; none for a narrow triangle.
    normal: Option<Vector>,
    /// By edge: a normal in the plane that points to the inside.
    inward: [Vector; 3],
}

impl PreparedTriangle {
    fn new(triangle: &Triangle) -> Self {
        let corners = triangle.corners();
        let edges = triangle.edges().map(|[p, q]| q - p);
        let inverse = edges.map(|e| if e.norm_squared() > 0.0 { e.norm_squared().recip() } else { 0.0 });
        let cross = edges[0].cross(&-edges[2]);
        let longest = edges.iter().map(Vector::norm).fold(0.0, Extremes::greater);
        let is_narrow = cross.norm() <= NARROW * longest.powi(3);
        let normal = (!is_narrow).then(|| cross / cross.norm());
        let inward = edges.map(|edge| normal.map_or(Vector::zeros(), |normal| normal.cross(&edge)));
        Self { corners, edges, inverse, normal, inward }
    }

    /// Squared distance (m²) of a point, or a value of at least `enough` if it is not smaller.
    #[inline]
    fn squared_distance(&self, p: &Point, enough: f64) -> f64 {
        let Some(normal) = &self.normal else {
            let [a, b, c] = self.corners;
            return (Triangle { a, b, c }.nearest_point(p) - p).norm_squared();
        };
        let height = normal.dot(&(p - self.corners[0]));
        let mut best = height * height;
        if best >= enough {
            return best;
        }
        let mut is_over = true;
        let mut least = f64::INFINITY;
        for i in 0..3 {
            let way = p - self.corners[i];
            // the nearest point is on an edge that the point is outside of
            if self.inward[i].dot(&way) >= 0.0 {
                continue;
            }
            is_over = false;
            let t = (way.dot(&self.edges[i]) * self.inverse[i]).greater(0.0).lesser(1.0);
            least = least.lesser((way - self.edges[i] * t).norm_squared());
        }
        if !is_over {
            best = least;
        }
        best
    }
}

#[derive(Clone, Copy, Debug)]
struct Node {
    low: Point,
    high: Point,
    /// First triangle of a leaf, else the first of two children.
    first: u32,
    /// Number of triangles; 0 for an inner node.
    count: u32,
}

impl Node {
    fn around(triangles: &[Triangle], first: usize) -> Self {
        let (mut low, mut high) = (triangles[0].a, triangles[0].a);
        for corner in triangles.iter().flat_map(Triangle::corners) {
            low = low.inf(&corner);
            high = high.sup(&corner);
        }
        Self { low, high, first: index(first), count: index(triangles.len()) }
    }

    fn squared_distance(&self, p: &Point) -> f64 {
        let mut sum = 0.0;
        for i in 0..3 {
            let off = (self.low[i] - p[i]).greater(p[i] - self.high[i]).greater(0.0);
            sum += off * off;
        }
        sum
    }
}

fn index(number: usize) -> u32 {
    u32::try_from(number).unwrap_or(u32::MAX)
}

impl TriangleTree {
    /// A tree of at least one triangle.
    pub fn new(mut triangles: Vec<Triangle>) -> Self {
        let mut nodes = vec![Node::around(&triangles, 0)];
        let mut open = vec![0];
        while let Some(number) = open.pop() {
            let Node { low, high, first, count } = nodes[number];
            let (first, count) = (first as usize, count as usize);
            if count <= LEAF {
                continue;
            }
            let (axis, middle) = ((high - low).imax(), count / 2);
            let part = &mut triangles[first..first + count];
            let key = |t: &Triangle| t.a[axis] + t.b[axis] + t.c[axis];
            part.select_nth_unstable_by(middle, |s, t| key(s).total_cmp(&key(t)));
            let children =
                [Node::around(&part[..middle], first), Node::around(&part[middle..], first + middle)];
            nodes[number] = Node { first: index(nodes.len()), count: 0, ..nodes[number] };
            open.extend([nodes.len(), nodes.len() + 1]);
            nodes.extend(children);
        }
        let prepared = triangles.iter().map(PreparedTriangle::new).collect();
        Self { nodes, triangles, prepared }
    }

    /// The triangles, in the order of the leaves.
    pub fn triangles(&self) -> &[Triangle] {
        &self.triangles
    }

    /// Smallest and largest corner of the box around all triangles.
    pub fn bounds(&self) -> [Point; 2] {
        [self.nodes[0].low, self.nodes[0].high]
    }

    /// Distance (m) of a point from the nearest triangle, or `limit` if none is nearer.
    pub fn distance(&self, p: &Point, limit: f64) -> f64 {
        let mut best = limit * limit;
        let mut stack = [(0_u32, 0.0_f64); 64];
        let mut size = 1;
        stack[0] = (0, self.nodes[0].squared_distance(p));
        while size > 0 {
            size -= 1;
            let (number, squared) = stack[size];
            if squared >= best {
                continue;
            }
            let node = &self.nodes[number as usize];
            if node.count > 0 {
                let first = node.first as usize;
                for triangle in &self.prepared[first..first + node.count as usize] {
                    best = best.lesser(triangle.squared_distance(p, best));
                }
                continue;
            }
            let squares = [0, 1].map(|i| self.nodes[node.first as usize + i].squared_distance(p));
            let far = usize::from(squares[0] <= squares[1]);
            // the tree is balanced: its height is below 33
            for child in [far, 1 - far] {
                stack[size] = (node.first + u32::from(child == 1), squares[child]);
                size += 1;
            }
        }
        best.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_agree_with_each_triangle() {
        let mut random = fastrand::Rng::with_seed(4);
        let mut vector = |size: f64| Vector::from_fn(|_, _| size * (random.f64() - 0.5));
        let triangles: Vec<Triangle> = (0..300)
            .map(|i| {
                let a = Point::from(vector(1.0));
                let b = a + vector(0.3);
                let c = match i % 4 {
                    0 => a + (b - a) * 0.3,
                    1 => a + (b - a) * 0.4 + vector(1e-8),
                    2 => b,
                    _ => a + vector(0.3),
                };
                Triangle { a, b, c }
            })
            .collect();
        let tree = TriangleTree::new(triangles.clone());
        for _ in 0..2000 {
            let p = Point::from(vector(1.5));
            let least =
                triangles.iter().map(|t| (t.nearest_point(&p) - p).norm()).fold(f64::INFINITY, f64::min);
            assert!((tree.distance(&p, f64::INFINITY) - least).abs() < 1e-9, "{p:?}");
            assert!((tree.distance(&p, 0.05) - least.min(0.05)).abs() < 1e-9, "{p:?}");
        }
    }
}
