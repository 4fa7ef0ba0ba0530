//! Test oracle: rectangle swept spheres, all points within a radius of a rectangle (Larsen et al. 1999).

use super::bounding_volume::{BoundingVolume, principal_axes};
use clearance::geometry::constants::{CONTACT_DISTANCE, FIT_SLACK};

use super::bounding_volume::SEPARATION_SLACK;
use clearance::geometry::math::{Point, Pose, RotationMatrix, Vector};
use clearance::geometry::{PointPair, Primitive, nearest_on_segments, separated_across};

/// A rectangle and a radius around it.
#[derive(Clone, Debug, PartialEq)]
pub struct Rss {
    pub centre: Point,
    /// Axes as columns: the rectangle spans the first two.
    pub axes: RotationMatrix,
    /// Half the rectangle's edge lengths.
    pub half_lengths: [f64; 2],
    pub radius: f64,
}

impl Rss {
    /// Corners of the rectangle in turn.
    fn rectangle(&self) -> [Point; 4] {
        let u = self.axes.column(0) * self.half_lengths[0];
        let v = self.axes.column(1) * self.half_lengths[1];
        let c = self.centre;
        [c + u + v, c - u + v, c - u - v, c + u - v]
    }

    /// A point in the rectangle's own frame: centre at the origin, sides along x and y.
    fn local(&self, p: &Point) -> Vector {
        self.axes.tr_mul(&(p - self.centre))
    }

    /// Squared distance of a point from the rectangle.
    fn squared_distance_from_rectangle(&self, local: &Vector) -> f64 {
        let beyond = |i: usize| (local[i].abs() - self.half_lengths[i]).max(0.0);
        Vector::new(beyond(0), beyond(1), local[2]).norm_squared()
    }

    /// The point of the rectangle nearest to a point in the rectangle's own frame.
    fn nearest_on_rectangle(&self, local: &Vector) -> Point {
        let [u, v] = self.half_lengths;
        let inside = Vector::new(local.x.clamp(-u, u), local.y.clamp(-v, v), 0.0);
        self.centre + self.axes * inside
    }

    /// Whether a segment passes through the rectangle.
    fn pierced_by(&self, p: &Vector, q: &Vector) -> bool {
        p.z * q.z < 0.0 && {
            let at = p + (q - p) * (p.z / (p.z - q.z));
            at.x.abs() <= self.half_lengths[0] && at.y.abs() <= self.half_lengths[1]
        }
    }
}

/// The sides of a rectangle given by its corners in turn.
fn sides<T: Copy>(corners: &[T; 4]) -> [[T; 2]; 4] {
    std::array::from_fn(|i| [corners[i], corners[(i + 1) % 4]])
}

/// Distance of two rectangles in one frame: as for triangles, it is found at a corner of one and the face of the other,
/// at two sides, or is zero where a side pierces the other.
fn rectangle_distance(a: &Rss, corners_a: &[Point; 4], b: &Rss, corners_b: &[Point; 4]) -> f64 {
    let b_in_a = corners_b.map(|p| a.local(&p));
    let a_in_b = corners_a.map(|p| b.local(&p));
    let pierced = |r: &Rss, corners: &[Vector; 4]| sides(corners).iter().any(|[p, q]| r.pierced_by(p, q));
    if pierced(a, &b_in_a) || pierced(b, &a_in_b) {
        return 0.0;
    }
    let of_b = corners_b.iter().zip(&b_in_a).map(|(q, local)| [a.nearest_on_rectangle(local), *q]);
    let of_a = corners_a.iter().zip(&a_in_b).map(|(p, local)| [*p, b.nearest_on_rectangle(local)]);
    let squared = |pair: &PointPair| nalgebra::distance_squared(&pair[0], &pair[1]);
    let nearer = |x: PointPair, y: PointPair| if squared(&y) < squared(&x) { y } else { x };
    let start = [corners_a[0], corners_b[0]];
    let mut best = of_b.chain(of_a).fold(start, nearer);
    if !separated_across(&best, corners_a, corners_b) {
        for e in &sides(corners_a) {
            for f in &sides(corners_b) {
                best = nearer(best, nearest_on_segments(e, f));
            }
        }
    }
    squared(&best).sqrt()
}

impl BoundingVolume for Rss {
    /// The rectangle lies in the plane of largest spread, as short as the half thickness allows on each side; the
    /// radius is then the largest distance of a point from it.
    fn fit(points: &[Point]) -> Self {
        let axes = principal_axes(points);
        let local = || points.iter().map(|p| axes.tr_mul(&p.coords));
        let (lo, hi) =
            local().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), p| (lo.min(p.z), hi.max(p.z)));
        let (middle, thickness) = (0.5 * (lo + hi), 0.5 * (hi - lo));
        let span = |i: usize| {
            let cap = |p: &Vector| (thickness * thickness - (p.z - middle).powi(2)).max(0.0).sqrt();
            local().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), p| {
                (lo.min(p[i] + cap(&p)), hi.max(p[i] - cap(&p)))
            })
        };
        let spans = [span(0), span(1)];
        let [u, v] = spans.map(|(lo, hi)| 0.5 * (lo + hi));
        let mut fitted = Self {
            centre: Point::from(axes * Vector::new(u, v, middle)),
            axes,
            half_lengths: spans.map(|(lo, hi)| (0.5 * (hi - lo)).max(0.0)),
            radius: 0.0,
        };
        let reach = points.iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
        fitted.radius = (points.iter())
            .map(|p| fitted.squared_distance_from_rectangle(&fitted.local(p)))
            .fold(0.0, f64::max)
            .sqrt()
            + FIT_SLACK * reach;
        fitted
    }

    fn around(primitive: &Primitive, pose: &Pose) -> Self {
        let (half_lengths, radius, permutation) = match *primitive {
            Primitive::Box { half_extents: h } => {
                let mut order = [0, 1, 2];
                order.sort_by(|&i, &j| h[j].total_cmp(&h[i]));
                ([h[order[0]], h[order[1]]], h[order[2]], order)
            }
            Primitive::Sphere { radius } => ([0.0, 0.0], radius, [0, 1, 2]),
            Primitive::Cylinder { radius, half_length }
            | Primitive::Cone { radius, half_length }
            | Primitive::Capsule { radius, half_length } => ([half_length, 0.0], radius, [2, 0, 1]),
        };
        let rotation = pose.rotation.to_rotation_matrix();
        let reach = pose.translation.vector.amax() + primitive.bounding_radius();
        Self {
            centre: Point::from(pose.translation.vector),
            axes: RotationMatrix::from_columns(
                &permutation.map(|i| rotation.matrix().column(i).into_owned()),
            ),
            half_lengths,
            radius: radius + FIT_SLACK * reach,
        }
    }

    fn lower_bound(&self, other: &Self, pose_ab: &Pose) -> f64 {
        let moved = Self {
            centre: pose_ab * other.centre,
            axes: pose_ab.rotation.to_rotation_matrix().matrix() * other.axes,
            ..*other
        };
        let reach = self.centre.coords.abs().sum()
            + other.centre.coords.abs().sum()
            + pose_ab.translation.vector.abs().sum()
            + self.half_lengths.iter().sum::<f64>()
            + other.half_lengths.iter().sum::<f64>();
        let rectangles = rectangle_distance(self, &self.rectangle(), &moved, &moved.rectangle());
        let gap = rectangles - self.radius - other.radius;
        (gap - SEPARATION_SLACK * reach).max(0.0)
    }

    fn may_touch(&self, other: &Self, pose_ab: &Pose) -> bool {
        self.lower_bound(other, pose_ab) <= CONTACT_DISTANCE
    }

    fn size(&self) -> f64 {
        self.half_lengths[0].max(self.half_lengths[1]) + self.radius
    }
}
