//! Winding number of a surface by a hierarchy over its faces (Barill, Dickson, Schmidt, Levin & Jacobson 2018, *Fast winding numbers for
//! soups and clouds*): faces far from a point count by their far field, those near it one by one.

use super::angle_sum::AngleSum;
use super::far_field::{FarField, SolidAngle};
use super::inside_work::InsideWork;
use super::moments::Moments;
use crate::math::{Extremes, Point, Vector};

/// Maximum number of faces in a leaf.
const LEAF_FACES: usize = 8;

/// Squares of factors on the least distance of far fields: one after the other is tried until the error is small enough.
const SHARPNESSES: [f64; 2] = [1.0, 2.5];

/// Maximum number of nodes visited to find a box without faces.
const CLEARANCE_NODES: u32 = 512;

/// Faces of a surface in a binary tree of boxes.
#[derive(Clone, Debug)]
pub(super) struct WindingTree {
    /// Each node comes after those below it; the last is the root.
    nodes: Vec<Node>,
    /// In the order of the leaves.
    triangles: Vec<[u32; 3]>,
}

#[derive(Clone, Debug)]
struct Node {
    far_field: FarField,
    /// Smallest and largest corner of the box around its faces.
    bounds: [Point; 2],
    /// Range of its faces among all.
    faces: [u32; 2],
    /// Index of the first of the nodes below it; its own index if there are none.
    begin: u32,
}

/// A winding number, and a bound on its error.
#[derive(Clone, Copy, Debug)]
pub(super) struct WindingNumber {
    pub value: f64,
    pub error: f64,
}

impl WindingTree {
    /// The tree over some triangles, of which there must be at least one.
    pub fn new(vertices: &[Point], triangles: &[[u32; 3]]) -> Self {
        let mut tree = Self { nodes: Vec::new(), triangles: triangles.to_vec() };
        tree.build(vertices, [0, triangles.len()]);
        tree
    }

    /// Adds the node over a range of triangles, and those below it; returns its moments. Halves are as equal as possible: the depth of the
    /// tree is the number of bits of the count.
    #[allow(clippy::cast_possible_truncation)] // a mesh has fewer than 2³² faces, and a tree not more nodes
    fn build(&mut self, vertices: &[Point], [first, end]: [usize; 2]) -> Moments {
        let corners_of = |t: &[u32; 3]| t.map(|v| vertices[v as usize]);
        let begin = self.nodes.len() as u32;
        let bounds = bounds_of(self.triangles[first..end].iter().flat_map(corners_of));
        let faces = &mut self.triangles[first..end];
        let moments = if faces.len() <= LEAF_FACES {
            Moments::joined(faces.iter().map(|t| Moments::of_triangle(corners_of(t))))
        } else {
            let axis = (bounds[1] - bounds[0]).imax();
            let place = |t: &[u32; 3]| corners_of(t).map(|p| p[axis]).iter().sum::<f64>();
            let middle = faces.len() / 2;
            faces.select_nth_unstable_by(middle, |x, y| place(x).total_cmp(&place(y)));
            let halves = [[first, first + middle], [first + middle, end]];
            Moments::joined(halves.map(|half| self.build(vertices, half)).into_iter())
        };
        let moments = moments.expect("there are triangles");
        let corners = self.triangles[first..end].iter().flat_map(corners_of);
        let radius = corners.map(|p| nalgebra::distance_squared(&p, &moments.centre)).fold(0.0, f64::greater);
        let far_field = FarField::new(&moments, radius.sqrt());
        self.nodes.push(Node { far_field, bounds, faces: [first as u32, end as u32], begin });
        moments
    }

    /// The first winding number around a point whose error is small enough for a decision; `None` if even the sharpest has too large an
    /// error.
    pub fn decide<T>(
        &self,
        vertices: &[Point],
        point: &Point,
        work: &mut InsideWork,
        decision: impl Fn(WindingNumber) -> Option<T>,
    ) -> Option<T> {
        let mut numbers =
            SHARPNESSES.iter().map(|sharpness| self.winding_number(vertices, point, *sharpness, work));
        numbers.find_map(decision)
    }

    fn winding_number(
        &self,
        vertices: &[Point],
        point: &Point,
        sharpness: f64,
        work: &mut InsideWork,
    ) -> WindingNumber {
        let (mut far, mut half_angles, mut near_faces) = (SolidAngle::default(), AngleSum::default(), 0);
        let mut left = self.nodes.len();
        while left > 0 {
            left -= 1;
            let node = &self.nodes[left];
            work.visited += 1;
            if node.far_field.add_to(&mut far, point, sharpness) {
                left = node.begin as usize;
            } else if node.begin as usize == left {
                let faces = &self.triangles[node.faces[0] as usize..node.faces[1] as usize];
                near_faces += faces.len();
                for triangle in faces {
                    half_angles.add(with_half_solid_angle(vertices, triangle, point));
                }
            }
        }
        work.visited += near_faces as u64;
        #[allow(clippy::cast_precision_loss)] // a bound
        let near_magnitude = near_faces as f64 * std::f64::consts::TAU;
        let all = SolidAngle { magnitude: far.magnitude + near_magnitude, ..far };
        WindingNumber {
            value: (half_angles.value() + 0.5 * far.value) / std::f64::consts::TAU,
            error: all.error(self.triangles.len()) / (2.0 * std::f64::consts::TAU),
        }
    }

    /// True if a box certainly contains no part of the surface.
    pub fn is_clear(&self, vertices: &[Point], bounds: &[Point; 2], work: &mut InsideWork) -> bool {
        let (mut left, mut visits_left) = (self.nodes.len(), CLEARANCE_NODES);
        let is_near = |t: &[u32; 3]| overlap(bounds, &bounds_of(t.map(|v| vertices[v as usize]).into_iter()));
        while left > 0 {
            left -= 1;
            let node = &self.nodes[left];
            work.visited += 1;
            if !overlap(bounds, &node.bounds) {
                left = node.begin as usize;
                continue;
            }
            if visits_left == 0 {
                return false;
            }
            visits_left -= 1;
            let faces = node.faces[0] as usize..node.faces[1] as usize;
            if node.begin as usize == left && self.triangles[faces].iter().any(is_near) {
                return false;
            }
        }
        true
    }
}

/// The box around some points.
fn bounds_of(points: impl Iterator<Item = Point>) -> [Point; 2] {
    let start = Point::from(Vector::repeat(f64::INFINITY));
    points.fold([start, -start], |[low, high], p| [low.inf(&p), high.sup(&p)])
}

/// Whether boxes have a point in common.
fn overlap(a: &[Point; 2], b: &[Point; 2]) -> bool {
    (0..3).all(|i| a[0][i] <= b[1][i] && b[0][i] <= a[1][i])
}

/// Half the solid angle of a triangle around a point (van Oosterom & Strackee 1983).
pub(super) fn half_solid_angle(vertices: &[Point], triangle: &[u32; 3], point: &Point) -> f64 {
    let [re, im] = with_half_solid_angle(vertices, triangle, point);
    im.atan2(re)
}

/// The complex number, `[re, im]`, that has this angle.
fn with_half_solid_angle(vertices: &[Point], triangle: &[u32; 3], point: &Point) -> [f64; 2] {
    let [a, b, c] = triangle.map(|v| vertices[v as usize] - point);
    let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
    let below = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
    [below, a.dot(&b.cross(&c))]
}
