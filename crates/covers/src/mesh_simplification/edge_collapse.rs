//! Simplification by edge collapses in the order of their errors (Garland and Heckbert 1997).
//!
//! The quadric of both ends places the new vertex; its largest distance from the planes of both is the error.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use clearance_geometry::math::{Extremes, Point, Vector};

use super::plane_sets::PlaneSets;
use super::quadric::Quadric;
use super::surface_complex::{Place, SurfaceComplex};
use crate::search_limit::SearchLimit;

/// Part of the length of an edge that is added to its error, so that short edges of plane faces collapse first.
const SHORT_FIRST: f64 = 1e-5;

/// Least cosine of the angle by which a collapse turns a face.
const LEAST_COSINE: f64 = 0.2;

/// Twice the area of a triangle, relative to the square of its longest edge, below which a collapse must not make it narrower.
const NARROW: f64 = 1e-3;

/// Number of candidates, or of vertices, between two looks at the clock.
const STEPS_PER_CLOCK: usize = 64;

/// A collapse of an edge, by its cost.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    /// Largest distance (m) from a plane, and a little for the length.
    cost: f64,
    ends: [u32; 2],
    /// Numbers of changes of the ends for which it was computed.
    changes: [u32; 2],
    position: Point,
    /// The next position to try, where this one would turn a face over.
    next: u8,
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Candidate {}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Candidate {
    /// The candidate with the least cost is the largest.
    fn cmp(&self, other: &Self) -> Ordering {
        let rest = |c: &Self| (c.ends, c.next);
        other.cost.total_cmp(&self.cost).then_with(|| rest(other).cmp(&rest(self)))
    }
}

/// A simplification that can go on.
#[derive(Clone, Debug)]
pub struct EdgeCollapse {
    complex: SurfaceComplex,
    planes: PlaneSets,
    quadrics: Vec<Quadric>,
    changes: Vec<u32>,
    queue: BinaryHeap<Candidate>,
}

impl EdgeCollapse {
    pub fn new(complex: SurfaceComplex) -> Self {
        let planes = PlaneSets::new(&complex);
        let quadrics = (0..complex.vertices()).map(|v| planes.quadric(v)).collect();
        let changes = vec![0; complex.vertices() as usize];
        Self { complex, planes, quadrics, changes, queue: BinaryHeap::new() }
    }

    /// The faces.
    pub fn complex(&self) -> &SurfaceComplex {
        &self.complex
    }

    /// Collapses edges until there are at most `count` faces. False if no more edges can collapse, or the limit ends it.
    pub fn reduce_to(&mut self, count: usize, limit: &SearchLimit) -> bool {
        let mut steps = 0_usize;
        // rejected candidates may be possible after others: the queue is filled until nothing collapses any more
        let mut count_at_last_fill = None;
        while self.complex.count() > count {
            if steps.is_multiple_of(STEPS_PER_CLOCK) && limit.is_over() {
                return false;
            }
            steps += 1;
            if let Some(candidate) = self.queue.pop() {
                self.try_collapse(&candidate);
            } else if count_at_last_fill == Some(self.complex.count()) || !self.fill_queue(limit) {
                return false;
            } else {
                count_at_last_fill = Some(self.complex.count());
            }
        }
        true
    }

    /// Adds all edges to the queue; false if the limit ends it.
    fn fill_queue(&mut self, limit: &SearchLimit) -> bool {
        for u in 0..self.complex.vertices() {
            if (u as usize).is_multiple_of(STEPS_PER_CLOCK) && limit.is_over() {
                return false;
            }
            for v in self.complex.neighbours(u) {
                if u < v {
                    self.add([u, v], 0);
                }
            }
        }
        true
    }

    /// Adds a collapse of an edge to the queue: to the best position, or to its ends.
    fn add(&mut self, ends: [u32; 2], number: u8) {
        let [u, v] = ends;
        let Some(place) = self.complex.place(u, v) else { return };
        let quadric = self.quadrics[u as usize].plus(&self.quadrics[v as usize]);
        let [p, q] = ends.map(|end| self.complex.position(end));
        let position = match (place, number) {
            (Place::At(end), 0) => self.complex.position(end),
            (Place::Anywhere, 0) => best_position(&quadric, &p, &q),
            (Place::Anywhere, 1) => p,
            (Place::Anywhere, 2) => q,
            _ => return,
        };
        let [of_u, of_v] = ends.map(|end| self.planes.largest_distance(end, &position));
        let cost = of_u.greater(of_v) + SHORT_FIRST * (q - p).norm();
        let changes = ends.map(|end| self.changes[end as usize]);
        self.queue.push(Candidate { cost, ends, changes, position, next: number + 1 });
    }

    /// Collapses an edge, unless that would turn a face over.
    fn try_collapse(&mut self, candidate: &Candidate) {
        let Candidate { ends: [u, v], changes, position, next, .. } = *candidate;
        let is_current = changes == [u, v].map(|end| self.changes[end as usize]);
        if !is_current {
            return;
        }
        let Some(place) = self.complex.place(u, v) else { return };
        if self.turns_a_face([u, v], &position) || self.turns_a_face([v, u], &position) {
            self.add([u, v], next);
            return;
        }
        let [kept, gone] = if place == Place::At(v) { [v, u] } else { [u, v] };
        self.quadrics[kept as usize] = self.quadrics[u as usize].plus(&self.quadrics[v as usize]);
        self.planes.join(kept, gone);
        self.complex.collapse(kept, gone, position);
        for end in [kept, gone] {
            self.changes[end as usize] += 1;
        }
        for neighbour in self.complex.neighbours(kept) {
            self.add([kept.min(neighbour), kept.max(neighbour)], 0);
        }
    }

    /// True if a face of the first end, without the second, would turn over or become narrow if the end moved to a position.
    fn turns_a_face(&self, [end, other]: [u32; 2], position: &Point) -> bool {
        let mut faces = self.complex.faces_at(end).filter(|face| !face.contains(&other));
        faces.any(|face| {
            let at = |v: u32| self.complex.position(v);
            let before = Shape::of(face.map(at));
            let after = Shape::of(face.map(|v| if v == end { *position } else { at(v) }));
            let is_turned =
                before.normal.dot(&after.normal) < LEAST_COSINE * before.normal.norm() * after.normal.norm();
            is_turned || (after.width < NARROW && after.width < before.width)
        })
    }
}

/// Orientation and width of a triangle, which a collapse must keep.
struct Shape {
    /// With twice the area as its length (m²).
    normal: Vector,
    /// Twice the area relative to the square of the longest edge.
    width: f64,
}

impl Shape {
    fn of([a, b, c]: [Point; 3]) -> Self {
        let normal = (b - a).cross(&(c - a));
        let longest = [b - a, c - b, a - c].iter().map(Vector::norm_squared).fold(0.0, Extremes::greater);
        let width = if longest > 0.0 { normal.norm() / longest } else { 0.0 };
        Self { normal, width }
    }
}

/// The position with the least value near an edge.
fn best_position(quadric: &Quadric, p: &Point, q: &Point) -> Point {
    let middle = p + (q - p) * 0.5;
    let best = quadric.least(&middle);
    // nearly parallel planes meet far away
    if (best - middle).norm_squared() <= 4.0 * (q - p).norm_squared() { best } else { middle }
}
