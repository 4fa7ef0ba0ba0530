//! Winding numbers of a surface in a hierarchy (Jacobson, Kavan & Sorkine-Hornung 2013, section 4.3).
//!
//! For a point outside of a box, the faces in the box have the same winding number as any other surface in the box with the same
//! boundary: here a cone over the boundary. A box of n faces then costs about √n triangles. Nothing is approximated.

use crate::math::{Point, Vector};

/// Maximum number of faces in a leaf.
const LEAF_FACES: usize = 8;

/// Minimum distance of a point from a box for its cone to be used, as a fraction of the box's diagonal: rounding then has no effect.
const MARGIN: f64 = 1e-3;

/// Maximum number of nodes visited to find a box without faces.
const CLEARANCE_NODES: u32 = 512;

/// Faces of a surface in a binary tree of boxes.
#[derive(Clone, Debug)]
pub(super) struct WindingTree {
    /// The first child of a node follows it.
    nodes: Vec<Node>,
    /// In the order of the leaves.
    triangles: Vec<[u32; 3]>,
    /// Boundaries of all nodes that have a cone.
    edges: Vec<Edge>,
}

#[derive(Clone, Debug)]
struct Node {
    low: Point,
    high: Point,
    /// Range of its faces among all.
    faces: [usize; 2],
    second_child: Option<usize>,
    /// Range of its boundary among all edges, if the boundary is short.
    cone: Option<[usize; 2]>,
}

/// A directed edge, and its multiplicity in a boundary: negative in the other direction.
#[derive(Clone, Copy, Debug)]
struct Edge {
    ends: [u32; 2],
    times: i64,
}

impl WindingTree {
    pub fn new(vertices: &[Point], triangles: &[[u32; 3]]) -> Self {
        let mut tree = Self { nodes: Vec::new(), triangles: triangles.to_vec(), edges: Vec::new() };
        tree.build(vertices, [0, triangles.len()]);
        tree
    }

    /// Halves are as equal as possible: the depth of the tree is the number of bits of the count. Returns the boundary of the node's
    /// faces.
    fn build(&mut self, vertices: &[Point], [first, end]: [usize; 2]) -> Vec<Edge> {
        let faces = &mut self.triangles[first..end];
        let corners = || faces.iter().flatten().map(|v| vertices[*v as usize]);
        let start = Point::from(Vector::repeat(f64::INFINITY));
        let low = corners().fold(start, |low, p| low.inf(&p));
        let high = corners().fold(-start, |high, p| high.sup(&p));
        let number = self.nodes.len();
        let boundary = if faces.len() <= LEAF_FACES {
            self.nodes.push(Node { low, high, faces: [first, end], second_child: None, cone: None });
            boundary_of(faces)
        } else {
            let axis = (high - low).imax();
            let place = |t: &[u32; 3]| t.map(|v| vertices[v as usize][axis]).iter().sum::<f64>();
            let middle = faces.len() / 2;
            faces.select_nth_unstable_by(middle, |x, y| place(x).total_cmp(&place(y)));
            self.nodes.push(Node { low, high, faces: [first, end], second_child: None, cone: None });
            let of_first = self.build(vertices, [first, first + middle]);
            self.nodes[number].second_child = Some(self.nodes.len());
            let of_second = self.build(vertices, [first + middle, end]);
            merged(&of_first, &of_second)
        };
        if 2 * boundary.len() <= end - first {
            let begin = self.edges.len();
            self.edges.extend(&boundary);
            self.nodes[number].cone = Some([begin, self.edges.len()]);
        }
        boundary
    }

    /// Winding number of the surface around a point; `cost` counts triangles and boxes.
    pub fn winding_number(&self, vertices: &[Point], point: &Point, cost: &mut u64) -> f64 {
        self.half_angles(0, vertices, point, cost) / std::f64::consts::TAU
    }

    /// Half the solid angle of a node's faces.
    fn half_angles(&self, number: usize, vertices: &[Point], point: &Point, cost: &mut u64) -> f64 {
        let node = &self.nodes[number];
        *cost += 1;
        if node.is_outside(point) {
            if let Some([begin, end]) = node.cone {
                *cost += (end - begin) as u64;
                return cone_half_angles(&self.edges[begin..end], vertices, point);
            }
        } else if let Some(second) = node.second_child {
            return self.half_angles(number + 1, vertices, point, cost)
                + self.half_angles(second, vertices, point, cost);
        }
        let faces = &self.triangles[node.faces[0]..node.faces[1]];
        *cost += faces.len() as u64;
        faces.iter().map(|t| half_angle(t.map(|v| vertices[v as usize] - point))).sum()
    }

    /// True if a box certainly contains no part of the surface.
    pub fn is_clear(&self, vertices: &[Point], bounds: &[Point; 2], cost: &mut u64) -> bool {
        let mut nodes_left = CLEARANCE_NODES;
        let clear = self.is_clear_of(0, vertices, bounds, &mut nodes_left);
        *cost += u64::from(CLEARANCE_NODES - nodes_left);
        clear
    }

    fn is_clear_of(
        &self,
        number: usize,
        vertices: &[Point],
        bounds: &[Point; 2],
        nodes_left: &mut u32,
    ) -> bool {
        let node = &self.nodes[number];
        if !overlap(bounds, &[node.low, node.high]) {
            return true;
        }
        if *nodes_left == 0 {
            return false;
        }
        *nodes_left -= 1;
        match node.second_child {
            Some(second) => [number + 1, second]
                .into_iter()
                .all(|child| self.is_clear_of(child, vertices, bounds, nodes_left)),
            None => self.triangles[node.faces[0]..node.faces[1]].iter().all(|t| {
                let [a, b, c] = t.map(|v| vertices[v as usize]);
                !overlap(bounds, &[a.inf(&b).inf(&c), a.sup(&b).sup(&c)])
            }),
        }
    }
}

impl Node {
    /// True if a point is outside of the box by its margin.
    fn is_outside(&self, point: &Point) -> bool {
        let margin = MARGIN * (self.high - self.low).norm();
        (0..3).any(|i| point[i] < self.low[i] - margin || point[i] > self.high[i] + margin)
    }
}

/// Whether boxes have a point in common.
fn overlap(a: &[Point; 2], b: &[Point; 2]) -> bool {
    (0..3).all(|i| a[0][i] <= b[1][i] && b[0][i] <= a[1][i])
}

/// Half the solid angle of the triangles from one corner of a boundary to its edges.
fn cone_half_angles(edges: &[Edge], vertices: &[Point], point: &Point) -> f64 {
    let Some(first) = edges.first() else { return 0.0 };
    let apex = first.ends[0];
    let to_apex = vertices[apex as usize] - point;
    let of_edge = |edge: &Edge| {
        let [a, b] = edge.ends.map(|v| vertices[v as usize] - point);
        #[allow(clippy::cast_precision_loss)] // how often faces are there is small
        let times = edge.times as f64;
        times * half_angle([to_apex, a, b])
    };
    edges.iter().filter(|edge| !edge.ends.contains(&apex)).map(of_edge).sum()
}

/// Edges that do not cancel, sorted.
fn boundary_of(faces: &[[u32; 3]]) -> Vec<Edge> {
    let edges = faces.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]);
    let mut edges: Vec<Edge> =
        edges.map(|[a, b]| Edge { ends: [a.min(b), a.max(b)], times: if a < b { 1 } else { -1 } }).collect();
    edges.sort_unstable_by_key(|edge| edge.ends);
    summed(&edges)
}

fn merged(a: &[Edge], b: &[Edge]) -> Vec<Edge> {
    let mut edges = [a, b].concat();
    // two sorted runs
    edges.sort_by_key(|edge| edge.ends);
    summed(&edges)
}

fn summed(sorted: &[Edge]) -> Vec<Edge> {
    let same = sorted.chunk_by(|a, b| a.ends == b.ends);
    let sums = same.map(|same| Edge { ends: same[0].ends, times: same.iter().map(|edge| edge.times).sum() });
    sums.filter(|edge| edge.times != 0).collect()
}

/// Half the solid angle of a triangle, from the vectors from a point to its corners (van Oosterom & Strackee 1983).
fn half_angle([a, b, c]: [Vector; 3]) -> f64 {
    let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
    let below = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
    a.dot(&b.cross(&c)).atan2(below)
}
