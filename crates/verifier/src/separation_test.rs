//! Separation test: are two bodies proven to be at least a given distance apart?

use clearance_geometry::Plane;
use clearance_geometry::math::{Extremes, MatrixPose, UnitVector, Vector};

use super::body::{Body, Content, Node};
use super::element::{gap, gap_of_supports};
use super::separating_direction;

/// Maximum number of steps of the search for a direction between two nodes: beyond it, their children are tested instead.
const MOST_STEPS: usize = 30;

/// State of a separation test.
pub(super) struct SeparationTest<'b> {
    a: &'b Body,
    b: &'b Body,
    pose_ab: MatrixPose,
    /// Absolute values of the rotation's components.
    spread: clearance_geometry::math::RotationMatrix,
    target: f64,
    /// Unit direction along which elements were last found apart, in the frame of a and in the frame of b; and the absolute values of its
    /// components.
    n: [Vector; 2],
    n_abs: [Vector; 2],
    pub element_tests: u64,
}

impl<'b> SeparationTest<'b> {
    /// Two bodies at a pose.
    pub fn new(a: &'b Body, b: &'b Body, pose_ab: MatrixPose, target: f64) -> Self {
        let spread = pose_ab.rotation.abs();
        let zero = [Vector::zeros(); 2];
        let mut test = Self { a, b, pose_ab, spread, target, n: zero, n_abs: zero, element_tests: 0 };
        if let (Some(x), Some(y)) = (a.root(), b.root()) {
            let between = &test.pose_ab * y.centre - x.centre;
            test.look_along(between.try_normalize(0.0).unwrap_or(Vector::x()));
        }
        test
    }

    /// True if all elements and planes are proven at least the target apart.
    pub fn prove(&mut self) -> bool {
        self.planes() && (self.a.root().is_none() || self.b.root().is_none() || self.nodes(0, 0))
    }

    /// As above, for planes; nothing is proven for two planes.
    fn planes(&self) -> bool {
        let Self { a, b, target, .. } = *self;
        let pose_ba = self.pose_ab.inverse();
        (a.planes().is_empty() || b.planes().is_empty())
            && a.planes().iter().all(|plane| b.is_clear_of(&placed(plane, &pose_ba), target))
            && b.planes().iter().all(|plane| a.is_clear_of(&placed(plane, &self.pose_ab), target))
    }

    fn look_along(&mut self, n: Vector) {
        self.n = [n, self.pose_ab.rotation.tr_mul(&n)];
        self.n_abs = self.n.map(|n| n.abs());
    }

    fn nodes(&mut self, i: usize, j: usize) -> bool {
        let (x, y) = (self.a.node(i), self.b.node(j));
        if self.volumes_apart(x, y) {
            return true;
        }
        if let (Content::Element(e), Content::Element(f)) = (x.content, y.content) {
            return self.elements(e, f);
        }
        if self.hulls_apart(i, j) {
            return true;
        }
        let pairs = match (x.content, y.content) {
            (Content::Element(_), Content::Element(_)) => return false,
            (Content::Children([l, r]), Content::Element(_)) => [(l, j), (r, j)],
            (Content::Children([l, r]), _) if x.radius >= y.radius => [(l, j), (r, j)],
            (_, Content::Children([l, r])) => [(i, l), (i, r)],
        };
        // the nearer first: its direction often separates the rest, too
        let between = |(i, j): (usize, usize)| self.between(self.a.node(i), self.b.node(j)).norm_squared();
        let first = usize::from(between(pairs[1]) < between(pairs[0]));
        [first, 1 - first].iter().all(|k| self.nodes(pairs[*k].0, pairs[*k].1))
    }

    /// Vector from one centre to the other, in the frame of a.
    fn between(&self, x: &Node, y: &Node) -> Vector {
        &self.pose_ab * y.centre - x.centre
    }

    /// True if the balls, or the boxes along the last direction or along their own axes, are the target apart.
    fn volumes_apart(&self, x: &Node, y: &Node) -> bool {
        let between = self.between(x, y);
        let reach = x.radius + y.radius + self.target;
        if between.norm_squared() >= reach * reach {
            return true;
        }
        let along = between.dot(&self.n[0]) - self.n_abs[0].dot(&x.half) - self.n_abs[1].dot(&y.half);
        if along >= self.target {
            return true;
        }
        // the box around the other box, along one's own axes
        let squared = |gap: Vector| gap.map(|g| g.greater(0.0)).norm_squared();
        let enough = self.target * self.target;
        squared(between.abs() - x.half - self.spread * y.half) >= enough || {
            let between_b = self.pose_ab.rotation.tr_mul(&between);
            squared(between_b.abs() - y.half - self.spread.tr_mul(&x.half)) >= enough
        }
    }

    /// True if some direction separates all elements below one node from all below the other.
    fn hulls_apart(&mut self, i: usize, j: usize) -> bool {
        let found =
            separating_direction::steps(|n| self.look(i, j, n), self.n[0], 0.0, self.target, MOST_STEPS);
        let Some(n) = found.filter(|n| self.look(i, j, n).0 >= self.target) else { return false };
        self.look_along(n);
        true
    }

    /// Separation of all elements below two nodes along a unit direction, and the vector between the foremost points.
    fn look(&self, i: usize, j: usize, n: &Vector) -> (f64, Vector) {
        let n_b = self.pose_ab.rotation.tr_mul(n);
        let (reach_a, e) = self.a.support(i, n);
        let (reach_b, f) = self.b.support(j, &-n_b);
        let p = e.extreme(n) + n * e.ball();
        let q = f.extreme(&-n_b) - n_b * f.ball();
        (gap_of_supports(reach_a, reach_b, &self.pose_ab, n), &self.pose_ab * q - p)
    }

    fn elements(&mut self, e: usize, f: usize) -> bool {
        self.element_tests += 1;
        let (e, f) = (self.a.element(e), self.b.element(f));
        if gap(e, f, &self.pose_ab, &self.n[0]) >= self.target {
            return true;
        }
        match separating_direction::find(e, f, &self.pose_ab, self.target) {
            Some(n) => self.look_along(n),
            None => return false,
        }
        true
    }
}

/// Transforms a plane from a frame at `pose` to the parent frame.
fn placed(plane: &Plane, pose: &MatrixPose) -> Plane {
    let normal = pose.rotation * plane.normal.into_inner();
    Plane { offset: plane.offset + normal.dot(&pose.translation), normal: UnitVector::new_unchecked(normal) }
}
