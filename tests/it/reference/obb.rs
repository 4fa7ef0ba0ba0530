//! Test oracle: oriented bounding boxes and their separating-axis test (Gottschalk, Lin & Manocha 1996).
//! *OBBTree*, section 5.

use super::bounding_volume::{BoundingVolume, principal_axes};
use clearance::geometry::constants::{CONTACT_DISTANCE, FIT_SLACK};

use super::bounding_volume::SEPARATION_SLACK;
use clearance::geometry::Primitive;
use clearance::geometry::math::{Point, Pose, RotationMatrix, Vector};

/// A box with its own axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Obb {
    pub centre: Point,
    /// The box's axes as columns.
    pub axes: RotationMatrix,
    /// Half the edge lengths along the axes.
    pub half_extents: Vector,
}

/// One box seen from another: centre and axes of `b` in the frame of `a`'s own axes.
struct Relative {
    t: Vector,
    r: RotationMatrix,
    abs_r: RotationMatrix,
    slack: f64,
}

impl Obb {
    /// The box around `points` along given axes.
    #[must_use]
    pub fn along(axes: RotationMatrix, points: &[Point]) -> Self {
        let mut lo = Vector::repeat(f64::INFINITY);
        let mut hi = Vector::repeat(f64::NEG_INFINITY);
        for p in points {
            let local = axes.tr_mul(&p.coords);
            lo = lo.inf(&local);
            hi = hi.sup(&local);
        }
        let middle = (lo + hi) * 0.5;
        let slack = FIT_SLACK * lo.amax().max(hi.amax());
        Self {
            centre: Point::from(axes * middle),
            axes,
            half_extents: (hi - lo) * 0.5 + Vector::repeat(slack),
        }
    }

    #[must_use]
    pub fn corners(&self) -> [Point; 8] {
        std::array::from_fn(|i| {
            let sign = |bit: usize| if i & bit == 0 { -1.0 } else { 1.0 };
            let h = self.half_extents;
            self.centre + self.axes * Vector::new(sign(1) * h.x, sign(2) * h.y, sign(4) * h.z)
        })
    }

    fn relative(&self, other: &Self, pose_ab: &Pose) -> Relative {
        let rotation = pose_ab.rotation.to_rotation_matrix();
        let t = self.axes.tr_mul(&(pose_ab * other.centre - self.centre));
        let r = self.axes.tr_mul(&(rotation.matrix() * other.axes));
        let reach = t.abs().sum()
            + self.centre.coords.abs().sum()
            + other.centre.coords.abs().sum()
            + pose_ab.translation.vector.abs().sum()
            + self.half_extents.sum()
            + other.half_extents.sum();
        Relative { t, abs_r: r.abs(), r, slack: SEPARATION_SLACK * reach }
    }

    /// Gap along each box's face normals: the largest is a lower bound of the distance.
    fn face_gap(&self, other: &Self, rel: &Relative) -> f64 {
        let (ea, eb) = (self.half_extents, other.half_extents);
        let gaps_a = rel.t.abs() - ea - rel.abs_r * eb;
        let gaps_b = rel.r.tr_mul(&rel.t).abs() - eb - rel.abs_r.tr_mul(&ea);
        gaps_a.max().max(gaps_b.max()) - rel.slack
    }

    /// Whether one of the nine axes normal to an edge of each box separates them clearly.
    fn edge_axis_separates(&self, other: &Self, rel: &Relative) -> bool {
        let (ea, eb) = (self.half_extents, other.half_extents);
        let (t, r, q) = (rel.t, &rel.r, &rel.abs_r);
        (0..3).any(|i| {
            let (i1, i2) = ((i + 1) % 3, (i + 2) % 3);
            (0..3).any(|j| {
                let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
                let reach_a = ea[i1] * q[(i2, j)] + ea[i2] * q[(i1, j)];
                let reach_b = eb[j1] * q[(i, j2)] + eb[j2] * q[(i, j1)];
                let apart = (t[i2] * r[(i1, j)] - t[i1] * r[(i2, j)]).abs();
                // the axis is at most one long, so a clear gap along it is at least that clear a distance
                apart - reach_a - reach_b > CONTACT_DISTANCE + rel.slack
            })
        })
    }
}

impl BoundingVolume for Obb {
    fn fit(points: &[Point]) -> Self {
        Self::along(principal_axes(points), points)
    }

    fn around(primitive: &Primitive, pose: &Pose) -> Self {
        let half_extents = match *primitive {
            Primitive::Box { half_extents } => Vector::from(half_extents),
            Primitive::Sphere { radius } => Vector::repeat(radius),
            Primitive::Cylinder { radius, half_length } | Primitive::Cone { radius, half_length } => {
                Vector::new(radius, radius, half_length)
            }
            Primitive::Capsule { radius, half_length } => Vector::new(radius, radius, half_length + radius),
        };
        let slack = FIT_SLACK * (pose.translation.vector.amax() + half_extents.amax());
        Self {
            centre: Point::from(pose.translation.vector),
            axes: *pose.rotation.to_rotation_matrix().matrix(),
            half_extents: half_extents + Vector::repeat(slack),
        }
    }

    fn lower_bound(&self, other: &Self, pose_ab: &Pose) -> f64 {
        self.face_gap(other, &self.relative(other, pose_ab)).max(0.0)
    }

    fn may_touch(&self, other: &Self, pose_ab: &Pose) -> bool {
        let rel = self.relative(other, pose_ab);
        let separated =
            self.face_gap(other, &rel) > CONTACT_DISTANCE || self.edge_axis_separates(other, &rel);
        !separated
    }

    fn size(&self) -> f64 {
        self.half_extents.max()
    }
}
