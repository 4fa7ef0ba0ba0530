//! Tree of boxes around triangles: distance of a point from the nearest triangle.

use clearance_geometry::Triangle;
use clearance_geometry::math::{Extremes, Point};

/// Largest number of triangles in a leaf.
const LEAF: usize = 4;

/// Binary tree of axis-aligned boxes.
#[derive(Clone, Debug)]
pub struct TriangleTree {
    nodes: Vec<Node>,
    triangles: Vec<Triangle>,
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
        Self { nodes, triangles }
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
                for triangle in &self.triangles[first..first + node.count as usize] {
                    best = best.lesser((triangle.nearest_point(p) - p).norm_squared());
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
