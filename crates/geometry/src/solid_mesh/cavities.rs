//! Detects closed shells wound inward that are cavities.

use super::closed_surface::ClosedSurface;
use crate::Triangle;
use crate::math::{Extremes, Point, Vector};

/// Shells are in contact where their distance is at most this fraction of the largest shell's size: faces that a program wrote twice, the
/// second time with different rounding, bound no cavity.
const CONTACT: f64 = 1e-4;

/// Maximum number of shells that are compared with each other.
const MOST_SHELLS: usize = 64;

/// Maximum number of search steps for contact, as a multiple of the faces: adjacent long slivers need more, since all their boxes
/// overlap.
const MOST_STEPS: usize = 512;

/// Cost of a test of two triangles in steps; a test of two boxes costs one.
const TRIANGLE_STEPS: usize = 8;

/// True if shells with their winding bound one solid with cavities: no two are in contact, shells wound outward are in no other, and
/// shells wound inward are wholly inside exactly one. Also false if the search takes too long.
pub(super) fn are_cavities(vertices: &[Point], shells: &[ClosedSurface]) -> bool {
    if shells.len() > MOST_SHELLS {
        return false;
    }
    let sizes = shells.iter().map(|shell| (shell.bounds()[1] - shell.bounds()[0]).norm());
    let contact = CONTACT * sizes.fold(0.0, f64::greater);
    let trees: Vec<BoxTree> = shells.iter().map(|shell| BoxTree::new(vertices, shell)).collect();
    let faces: usize = shells.iter().map(|shell| shell.triangles().len()).sum();
    let mut steps_left = MOST_STEPS * (faces + 64);
    let mut are_apart =
        |i: usize, j: usize| trees[i].is_near(&trees[j], contact, &mut steps_left) == Some(false);
    (0..shells.len()).all(|i| (0..i).all(|j| are_apart(i, j)))
        && (0..shells.len()).all(|i| is_nested_as_wound(vertices, shells, i))
}

fn is_nested_as_wound(vertices: &[Point], shells: &[ClosedSurface], own: usize) -> bool {
    let point = vertices[shells[own].triangles()[0][0] as usize];
    let others = shells.iter().enumerate().filter(|(i, _)| *i != own);
    let around: f64 = others.map(|(_, other)| other.winding_number(vertices, &point)).sum();
    around == if shells[own].volume(vertices) < 0.0 { 1.0 } else { 0.0 }
}

/// Triangles in a binary tree of boxes.
struct BoxTree {
    triangles: Vec<Triangle>,
    nodes: Vec<Node>,
}

struct Node {
    low: Point,
    high: Point,
    content: Content,
}

#[derive(Clone, Copy)]
enum Content {
    Triangle(usize),
    Children([usize; 2]),
}

impl BoxTree {
    fn new(vertices: &[Point], shell: &ClosedSurface) -> Self {
        let corners = shell.triangles().iter().map(|t| t.map(|v| vertices[v as usize]));
        let triangles: Vec<Triangle> = corners.map(|[a, b, c]| Triangle { a, b, c }).collect();
        let mut tree = Self { nodes: Vec::with_capacity(2 * triangles.len()), triangles };
        let mut order: Vec<usize> = (0..tree.triangles.len()).collect();
        tree.build(&mut order);
        tree
    }

    /// Halves are as equal as possible: the depth of the tree is the number of bits of the count.
    fn build(&mut self, order: &mut [usize]) -> usize {
        let corners = || order.iter().flat_map(|i| self.triangles[*i].corners());
        let start = Point::from(Vector::repeat(f64::INFINITY));
        let low = corners().fold(start, |low, p| low.inf(&p));
        let high = corners().fold(-start, |high, p| high.sup(&p));
        let number = self.nodes.len();
        self.nodes.push(Node { low, high, content: Content::Triangle(order[0]) });
        if order.len() > 1 {
            let axis = (high - low).imax();
            let middle = order.len() / 2;
            let place = |i: usize| self.triangles[i].corners().map(|p| p[axis]).iter().sum::<f64>();
            order.select_nth_unstable_by(middle, |x, y| place(*x).total_cmp(&place(*y)));
            let (first, second) = order.split_at_mut(middle);
            self.nodes[number].content = Content::Children([self.build(first), self.build(second)]);
        }
        number
    }

    /// True if the triangles of two trees come within a distance (m); `None` if the search takes too many steps.
    fn is_near(&self, other: &Self, distance: f64, steps_left: &mut usize) -> Option<bool> {
        let mut open = vec![(0, 0)];
        while let Some((i, j)) = open.pop() {
            *steps_left = steps_left.checked_sub(1)?;
            let (a, b) = (&self.nodes[i], &other.nodes[j]);
            if (0..3).any(|k| a.low[k] - b.high[k] > distance || b.low[k] - a.high[k] > distance) {
                continue;
            }
            match (a.content, b.content) {
                (Content::Triangle(x), Content::Triangle(y)) => {
                    *steps_left = steps_left.checked_sub(TRIANGLE_STEPS)?;
                    let [p, q] = self.triangles[x].nearest_points(&other.triangles[y]);
                    if nalgebra::distance(&p, &q) <= distance {
                        return Some(true);
                    }
                }
                (Content::Children(children), Content::Triangle(_)) => open.extend(children.map(|c| (c, j))),
                (Content::Children(children), _) if (a.high - a.low).norm() > (b.high - b.low).norm() => {
                    open.extend(children.map(|c| (c, j)));
                }
                (_, Content::Children(children)) => open.extend(children.map(|c| (i, c))),
            }
        }
        Some(false)
    }
}
