//! Tree of axis-aligned boxes over triangles: nearest triangle of a point, and pairs of triangles whose boxes overlap.

use clearance_geometry::Triangle;
use clearance_geometry::math::{Extremes, Point};

/// Number of triangles below which a node is not split.
const LEAF_SIZE: usize = 4;

/// Axis-aligned box.
#[derive(Clone, Copy, Debug)]
struct AxisBox {
    low: Point,
    high: Point,
}

impl AxisBox {
    fn of(triangle: &Triangle) -> Self {
        let Triangle { a, b, c } = triangle;
        Self { low: a.inf(b).inf(c), high: a.sup(b).sup(c) }
    }

    fn joined(&self, other: &Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    fn distance_squared(&self, p: &Point) -> f64 {
        let along = |i: usize| (self.low[i] - p[i]).greater(p[i] - self.high[i]).greater(0.0);
        let [x, y, z] = [along(0), along(1), along(2)];
        x * x + y * y + z * z
    }

    fn overlaps(&self, other: &Self) -> bool {
        (0..3).all(|i| self.low[i] <= other.high[i] && other.low[i] <= self.high[i])
    }

    fn longest_axis(&self) -> usize {
        (self.high - self.low).imax()
    }
}

/// A node; its children follow each other in the list of nodes.
#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: AxisBox,
    /// Leaf: first position in the order. Inner node: index of its first child.
    first: u32,
    /// Number of triangles of a leaf; 0 for an inner node.
    count: u32,
}

/// The nearest triangle of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Nearest {
    /// Index of the triangle.
    pub triangle: u32,
    /// Squared distance (m²).
    pub squared: f64,
}

/// Triangles in one frame, with a tree over them.
#[derive(Debug)]
pub(crate) struct TriangleTree {
    triangles: Vec<Triangle>,
    order: Vec<u32>,
    nodes: Vec<Node>,
}

impl TriangleTree {
    pub fn new(triangles: Vec<Triangle>) -> Self {
        let boxes: Vec<AxisBox> = triangles.iter().map(AxisBox::of).collect();
        let count = u32::try_from(triangles.len()).unwrap_or(u32::MAX);
        let mut order: Vec<u32> = (0..count).collect();
        let mut nodes = Vec::new();
        if let Some(root) = bounds(&order, &boxes) {
            nodes.push(Node { bounds: root, first: 0, count });
            split(0, &mut order, &boxes, &mut nodes);
        }
        Self { triangles, order, nodes }
    }

    pub fn triangles(&self) -> &[Triangle] {
        &self.triangles
    }

    /// The triangle nearest to `p`, if it is nearer than `known`; `known` otherwise.
    pub fn nearest(&self, p: &Point, known: Option<Nearest>) -> Option<Nearest> {
        let mut best = known;
        let limit = |best: &Option<Nearest>| best.map_or(f64::INFINITY, |b| b.squared);
        let Some(root) = self.nodes.first() else { return best };
        let mut stack = vec![(0_u32, root.bounds.distance_squared(p))];
        while let Some((index, lower)) = stack.pop() {
            if lower >= limit(&best) {
                continue;
            }
            let node = &self.nodes[index as usize];
            if node.count > 0 {
                for &triangle in self.leaf(node) {
                    let found = self.triangles[triangle as usize].nearest_point(p);
                    let squared = squared_distance(p, &found);
                    if squared < limit(&best) {
                        best = Some(Nearest { triangle, squared });
                    }
                }
                continue;
            }
            let of_child = |child: u32| (child, self.nodes[child as usize].bounds.distance_squared(p));
            let (left, right) = (of_child(node.first), of_child(node.first + 1));
            let (near, far) = if left.1 <= right.1 { (left, right) } else { (right, left) };
            stack.extend([far, near]);
        }
        best
    }

    /// Calls `visit` with each triangle whose box overlaps that of `triangle`, until it returns false. False if it did, or if the search
    /// ended after `most_nodes`.
    pub fn overlapping(
        &self,
        triangle: &Triangle,
        most_nodes: usize,
        mut visit: impl FnMut(u32) -> bool,
    ) -> bool {
        let own = AxisBox::of(triangle);
        let mut stack = if self.nodes.is_empty() { vec![] } else { vec![0_u32] };
        let mut visited = 0;
        while let Some(index) = stack.pop() {
            let node = &self.nodes[index as usize];
            visited += 1;
            if visited > most_nodes {
                return false;
            }
            if !own.overlaps(&node.bounds) {
                continue;
            }
            if node.count == 0 {
                stack.extend([node.first, node.first + 1]);
                continue;
            }
            let overlaps = |t: &&u32| own.overlaps(&AxisBox::of(&self.triangles[**t as usize]));
            if !self.leaf(node).iter().filter(overlaps).all(|&t| visit(t)) {
                return false;
            }
        }
        true
    }

    /// Calls `visit` with each pair of different triangles whose boxes overlap, until it returns false. False if `go_on`, which is called
    /// now and then, ended the search.
    pub fn overlapping_pairs(
        &self,
        mut go_on: impl FnMut() -> bool,
        mut visit: impl FnMut(u32, u32) -> bool,
    ) -> bool {
        let mut stack = if self.nodes.is_empty() { vec![] } else { vec![(0_u32, 0_u32)] };
        while let Some((a, b)) = stack.pop() {
            if !go_on() {
                return false;
            }
            let (first, second) = (&self.nodes[a as usize], &self.nodes[b as usize]);
            if !first.bounds.overlaps(&second.bounds) {
                continue;
            }
            match (first.count > 0, second.count > 0) {
                (true, true) => {
                    if !self.leaf_pairs(a == b, first, second, &mut visit) {
                        return true;
                    }
                }
                (false, _) if a == b => {
                    let [left, right] = [first.first, first.first + 1];
                    stack.extend([(left, left), (right, right), (left, right)]);
                }
                (false, _) => stack.extend([(first.first, b), (first.first + 1, b)]),
                (true, false) => stack.extend([(a, second.first), (a, second.first + 1)]),
            }
        }
        true
    }

    fn leaf_pairs(
        &self,
        is_same: bool,
        first: &Node,
        second: &Node,
        visit: &mut impl FnMut(u32, u32) -> bool,
    ) -> bool {
        for (i, &s) in self.leaf(first).iter().enumerate() {
            let others = self.leaf(second);
            let others = if is_same { &others[i + 1..] } else { others };
            let own = AxisBox::of(&self.triangles[s as usize]);
            for &t in others {
                if own.overlaps(&AxisBox::of(&self.triangles[t as usize])) && !visit(s, t) {
                    return false;
                }
            }
        }
        true
    }

    fn leaf(&self, node: &Node) -> &[u32] {
        &self.order[node.first as usize..(node.first + node.count) as usize]
    }
}

/// Mean of the corners.
pub(crate) fn centroid(triangle: &Triangle) -> Point {
    Point::from((triangle.a.coords + triangle.b.coords + triangle.c.coords) / 3.0)
}

fn squared_distance(p: &Point, q: &Point) -> f64 {
    (p - q).norm_squared()
}

fn bounds(order: &[u32], boxes: &[AxisBox]) -> Option<AxisBox> {
    order.iter().map(|&t| boxes[t as usize]).reduce(|a, b| a.joined(&b))
}

/// Splits a leaf at the median of the centres along the longest axis, and its parts again.
fn split(root: usize, order: &mut [u32], boxes: &[AxisBox], nodes: &mut Vec<Node>) {
    let mut open = vec![root];
    while let Some(index) = open.pop() {
        let Node { bounds: all, first, count } = nodes[index];
        if count as usize <= LEAF_SIZE {
            continue;
        }
        let axis = all.longest_axis();
        let part = &mut order[first as usize..(first + count) as usize];
        let centre = |t: &u32| boxes[*t as usize].low[axis] + boxes[*t as usize].high[axis];
        let middle = part.len() / 2;
        part.select_nth_unstable_by(middle, |s, t| centre(s).total_cmp(&centre(t)).then(s.cmp(t)));
        let (left, right) = part.split_at(middle);
        let (Some(left_box), Some(right_box)) = (bounds(left, boxes), bounds(right, boxes)) else { continue };
        let left_count = count / 2;
        let child = nodes.len();
        nodes.push(Node { bounds: left_box, first, count: left_count });
        nodes.push(Node { bounds: right_box, first: first + left_count, count: count - left_count });
        nodes[index] = Node { bounds: all, first: u32::try_from(child).unwrap_or(u32::MAX), count: 0 };
        open.extend([child, child + 1]);
    }
}
