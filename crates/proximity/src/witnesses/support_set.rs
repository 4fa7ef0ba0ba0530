//! Support set of a convex core: the face, edge or corner that is farthest along a direction.

use clearance_geometry::math::{Extremes, MatrixPose, Point, UnitVector, Vector};

use super::facing_sets::edges;
use crate::elements::CoreShape;

/// Number of points that represent a circle.
const CIRCLE: u8 = 32;

/// The corners, in a common frame, of a convex polygon, segment or point; a circle is represented by points on it.
#[derive(Clone, Debug, Default)]
pub(crate) struct SupportSet {
    points: Vec<Point>,
    sides: Vec<Side>,
}

/// A half-space that contains the set; its boundary is parallel to an edge.
#[derive(Clone, Copy, Debug)]
struct Side {
    /// Unit vector in the plane of the polygon, out of the half-space.
    outward: Vector,
    /// Largest height (m) of a point of the set along that vector.
    height: f64,
}

impl SupportSet {
    /// The points, around the polygon.
    #[inline]
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// The points of a core, posed in the common frame, whose height along `n` is less than the largest by at most `tolerance` (m).
    #[inline]
    pub fn set_to_core(&mut self, core: &CoreShape, pose: &MatrixPose, n: &Vector, tolerance: f64) {
        self.points.clear();
        let along = pose.rotation.tr_mul(n);
        match core {
            CoreShape::Point => self.points.push(Point::origin()),
            CoreShape::Segment(half_length) => {
                self.of_corners(&CoreShape::segment(*half_length), &along, tolerance);
            }
            CoreShape::Triangle(t) => self.of_corners(&t.corners(), &along, tolerance),
            CoreShape::Cuboid(half) => self.of_cuboid(half, &along, tolerance),
            CoreShape::Cylinder { radius, half_length } => {
                let side = side_of_circle(*radius, &along);
                if 2.0 * side.dot(&along) <= tolerance {
                    self.of_circle(*radius, half_length.copysign(along.z));
                } else {
                    let up = Vector::new(0.0, 0.0, *half_length);
                    self.of_corners(&[Point::from(side + up), Point::from(side - up)], &along, tolerance);
                }
            }
            CoreShape::Cone { radius, half_length } => {
                let side = side_of_circle(*radius, &along);
                if along.z < 0.0 && 2.0 * side.dot(&along) <= tolerance {
                    self.of_circle(*radius, -half_length);
                } else {
                    let up = Vector::new(0.0, 0.0, *half_length);
                    self.of_corners(&[Point::from(up), Point::from(side - up)], &along, tolerance);
                }
            }
        }
        for point in &mut self.points {
            *point = pose * *point;
        }
    }

    /// The points among the corners of a convex polyhedron, in the common frame, as above.
    pub fn set_to_hull(&mut self, corners: &[Point], n: &Vector, tolerance: f64) {
        self.points.clear();
        self.of_corners(corners, n, tolerance);
        self.sort_around(n);
    }

    /// Computes the half-spaces of [`Self::is_beyond`] for the present points; a segment has none.
    pub fn bound_sides(&mut self) {
        let Self { points, sides } = self;
        let from = points.first().copied().unwrap_or_else(Point::origin);
        let area: Vector = points.windows(2).map(|edge| (edge[0] - from).cross(&(edge[1] - from))).sum();
        sides.clear();
        sides.extend(edges(points).filter_map(|[p, q]| {
            let outward = (q - p).cross(&area).try_normalize(0.0)?;
            let heights = points.iter().map(|p| p.coords.dot(&outward));
            Some(Side { outward, height: heights.fold(f64::NEG_INFINITY, f64::greater) })
        }));
    }

    /// True if all these points are proven farther from the set than `distance` (m): they are outside of one of its half-spaces.
    pub fn is_beyond(&self, distance: f64, points: &[Point]) -> bool {
        let is_outside = |side: &Side, x: &Point| x.coords.dot(&side.outward) > side.height + distance;
        self.sides.iter().any(|side| points.iter().all(|x| is_outside(side, x)))
    }

    /// Transforms the points from a frame posed in another to that frame.
    pub fn transform(&mut self, pose: &MatrixPose) {
        for point in &mut self.points {
            *point = pose * *point;
        }
    }

    #[inline]
    fn of_corners(&mut self, corners: &[Point], n: &Vector, tolerance: f64) {
        let height = |p: &Point| p.coords.dot(n);
        let highest = corners.iter().map(height).fold(f64::NEG_INFINITY, f64::greater);
        self.points.extend(corners.iter().filter(|p| height(p) >= highest - tolerance));
    }

    /// Along an axis that is nearly normal to the direction, both ends of the box count.
    fn of_cuboid(&mut self, half: &Vector, n: &Vector, tolerance: f64) {
        let top = half.zip_map(n, f64::copysign);
        let mut free = [0, 1, 2].into_iter().filter(|k| 2.0 * half[*k] * n[*k].abs() <= tolerance);
        let (first, second) = (free.next(), free.next());
        let mirrored = |p: Vector, axis: usize| {
            let mut p = p;
            p[axis] = -p[axis];
            p
        };
        self.points.push(Point::from(top));
        let Some(first) = first else { return };
        self.points.push(Point::from(mirrored(top, first)));
        let Some(second) = second else { return };
        self.points.push(Point::from(mirrored(mirrored(top, first), second)));
        self.points.push(Point::from(mirrored(top, second)));
    }

    fn of_circle(&mut self, radius: f64, z: f64) {
        self.points.extend((0..CIRCLE).map(|i| {
            let (sin, cos) = (f64::from(i) / f64::from(CIRCLE) * std::f64::consts::TAU).sin_cos();
            Point::new(radius * cos, radius * sin, z)
        }));
    }

    /// Sorts the corners of a polygon normal to `n` around its middle.
    fn sort_around(&mut self, n: &Vector) {
        if self.points.len() <= 3 {
            return;
        }
        #[allow(clippy::cast_precision_loss)] // few corners
        let middle = self.points.iter().map(|p| p.coords).sum::<Vector>() / self.points.len() as f64;
        let mut axis = Vector::zeros();
        axis[n.iamin()] = 1.0;
        let u = UnitVector::new_normalize(n.cross(&axis));
        let v = n.cross(&u);
        let angle = |p: &Point| (p.coords - middle).dot(&v).atan2((p.coords - middle).dot(&u));
        self.points.sort_unstable_by(|p, q| angle(p).total_cmp(&angle(q)));
    }
}

/// The vector from the axis, z, to the point of a circle that is farthest along a direction.
fn side_of_circle(radius: f64, along: &Vector) -> Vector {
    let across = along.x.hypot(along.y);
    let scale = if across > f64::MIN_POSITIVE { radius / across } else { 0.0 };
    Vector::new(along.x * scale, along.y * scale, 0.0)
}
