//! Winding number of a closed surface around a point: signed count of the faces that a ray crosses.
//!
//! The ray is parallel to the x axis. The count is an integer and exact: the signs of all determinants are proven by bounds on their
//! rounding (Shewchuk 1997, *Adaptive precision floating-point arithmetic and fast robust geometric predicates*, sections 4.3 and 4.4).
//! Where a sign is not proven, as next to an edge or to the surface, there is no result.

use clearance_geometry::math::{Extremes, Point};

/// Bound on the rounding of a determinant, relative to the sum of the absolute values of its terms: a term is a product of three
/// differences, and six are added, which is 10 roundings.
const ROUNDING: f64 = 4e-15;

/// The faces of a closed surface in a binary tree of boxes.
#[derive(Debug)]
pub(super) struct RayCrossings {
    /// A node comes before those below it.
    nodes: Vec<Node>,
    /// In the order of the leaves.
    faces: Vec<[Point; 3]>,
}

/// A box around the faces of a range.
#[derive(Debug)]
struct Node {
    low: Point,
    high: Point,
    faces: [usize; 2],
    /// Index of the first node after those below it.
    end: usize,
}

/// Maximum number of faces in a leaf.
const LEAF: usize = 8;

impl RayCrossings {
    pub fn new(faces: Vec<[Point; 3]>) -> Self {
        let mut all = Self { nodes: Vec::new(), faces };
        all.build([0, all.faces.len()]);
        all
    }

    /// Splits at the median across the ray, so that the depth is the number of bits of the count.
    fn build(&mut self, [first, end]: [usize; 2]) {
        let faces = &mut self.faces[first..end];
        let corners = || faces.iter().flatten();
        let least = |i: usize| corners().map(|p| p[i]).fold(f64::INFINITY, f64::lesser);
        let most = |i: usize| corners().map(|p| p[i]).fold(f64::NEG_INFINITY, f64::greater);
        let (low, high) = (Point::from([0, 1, 2].map(least)), Point::from([0, 1, 2].map(most)));
        let number = self.nodes.len();
        self.nodes.push(Node { low, high, faces: [first, end], end: 0 });
        if end - first > LEAF {
            let axis = if high.y - low.y > high.z - low.z { 1 } else { 2 };
            let place = |t: &[Point; 3]| t[0][axis] + t[1][axis] + t[2][axis];
            let middle = (end - first) / 2;
            faces.select_nth_unstable_by(middle, |s, t| place(s).total_cmp(&place(t)));
            self.build([first, first + middle]);
            self.build([first + middle, end]);
        }
        self.nodes[number].end = self.nodes.len();
    }

    /// The winding number around a point; `None` where rounding might change it.
    pub fn winding_number(&self, p: &Point) -> Option<i64> {
        let (mut number, mut turns) = (0, 0);
        while let Some(node) = self.nodes.get(number) {
            let Node { low, high, faces, end } = node;
            let is_met = p.x <= high.x && [1, 2].iter().all(|i| (low[*i]..=high[*i]).contains(&p[*i]));
            if !is_met {
                number = *end;
                continue;
            }
            number += 1;
            if *end == number {
                for face in &self.faces[faces[0]..faces[1]] {
                    turns += crossing(face, p)?;
                }
            }
        }
        Some(turns)
    }
}

/// 1 if the ray from a point leaves through a face, -1 if it enters, 0 if it misses the face.
fn crossing([a, b, c]: &[Point; 3], p: &Point) -> Option<i64> {
    let sides = [[a, b], [b, c], [c, a]].map(|[from, to]| side(from, to, p));
    let [left, right] = [1, -1].map(|sign| sides.contains(&Some(sign)));
    if left && right {
        return Some(0);
    }
    if sides.contains(&None) {
        return None;
    }
    // as seen along the ray, a face that turns to the left is left from inside
    let turn = if left { 1 } else { -1 };
    let ahead = height([a, b, c], p)? * turn;
    Some(if ahead > 0 { turn } else { 0 })
}

/// The side of a line that a point is on, in the plane of y and z: positive to the left.
fn side(from: &Point, to: &Point, p: &Point) -> Option<i64> {
    let terms = [(to.y - from.y) * (p.z - from.z), -(to.z - from.z) * (p.y - from.y)];
    sign(&terms)
}

/// The side of a face's plane that a point is on: positive opposite to the normal.
fn height([a, b, c]: [&Point; 3], p: &Point) -> Option<i64> {
    let [a, b, c] = [a - p, b - p, c - p];
    let terms = [
        a.x * (b.y * c.z),
        -a.x * (b.z * c.y),
        b.x * (c.y * a.z),
        -b.x * (c.z * a.y),
        c.x * (a.y * b.z),
        -c.x * (a.z * b.y),
    ];
    sign(&terms)
}

/// The sign of a sum, if it is not rounding.
fn sign(terms: &[f64]) -> Option<i64> {
    let (sum, magnitude) = (terms.iter().sum::<f64>(), terms.iter().map(|term| term.abs()).sum::<f64>());
    // products may also be below the smallest numbers
    let proven = sum.abs() > ROUNDING * magnitude + f64::MIN_POSITIVE;
    proven.then_some(if sum > 0.0 { 1 } else { -1 })
}
