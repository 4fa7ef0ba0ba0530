//! Test helper: parts of oracle bodies in f64, and lower bounds on their distances.
//! They only prove that distant parts are apart; near parts need double-double arithmetic.

use clearance::geometry::math::{Point, Pose, RotationMatrix, Vector};

use super::double_double::{ExactPose, Vec3};

/// A convex set. Only its extents along directions are used.
#[derive(Clone, Copy, Debug)]
pub enum Outline {
    Triangle([Point; 3]),
    /// From the centre, half of each edge.
    Cuboid(Point, [Vector; 3]),
    /// Unit axis, radius, half length.
    Cylinder(Point, Vector, f64, f64),
}

impl Outline {
    pub fn triangle(corners: &[Vec3; 3]) -> Self {
        Self::Triangle(corners.map(|c| Point::from(c.rounded())))
    }

    pub fn cuboid(half: [f64; 3], pose: &ExactPose) -> Self {
        Self::Cuboid(centre(pose), [0, 1, 2].map(|i| axis(pose, i) * half[i]))
    }

    pub fn cylinder(radius: f64, half_length: f64, pose: &ExactPose) -> Self {
        Self::Cylinder(centre(pose), axis(pose, 2), radius, half_length)
    }

    pub fn moved(&self, pose: &Pose) -> Self {
        match *self {
            Self::Triangle(corners) => Self::Triangle(corners.map(|c| pose * c)),
            Self::Cuboid(centre, spans) => Self::Cuboid(pose * centre, spans.map(|s| pose * s)),
            Self::Cylinder(centre, axis, r, h) => Self::Cylinder(pose * centre, pose * axis, r, h),
        }
    }

    /// Directions in which it is flat.
    fn normals(&self) -> [Vector; 3] {
        match self {
            Self::Triangle([a, b, c]) => [(b - a).cross(&(c - a)), Vector::zeros(), Vector::zeros()],
            Self::Cuboid(_, spans) => *spans,
            Self::Cylinder(_, axis, ..) => [*axis, Vector::zeros(), Vector::zeros()],
        }
    }

    fn centre(&self) -> Point {
        match self {
            Self::Triangle([a, b, c]) => nalgebra::center(a, &nalgebra::center(b, c)),
            Self::Cuboid(centre, _) | Self::Cylinder(centre, ..) => *centre,
        }
    }

    /// Least and largest coordinate along a unit vector, counted from `origin`.
    fn extent(&self, n: &Vector, origin: &Point) -> (f64, f64) {
        let around = |centre: &Point, half: f64| {
            let middle = n.dot(&(centre - origin));
            (middle - half, middle + half)
        };
        match self {
            Self::Triangle(corners) => {
                let [a, b, c] = corners.map(|p| n.dot(&(p - origin)));
                (a.min(b).min(c), a.max(b).max(c))
            }
            Self::Cuboid(centre, spans) => around(centre, spans.iter().map(|s| s.dot(n).abs()).sum()),
            Self::Cylinder(centre, axis, radius, half_length) => {
                around(centre, half_length * axis.dot(n).abs() + radius * axis.cross(n).norm())
            }
        }
    }

    /// Whether some direction proves a gap of at least `gap`: the given one, where one is flat, or between the centres.
    pub fn apart(&self, other: &Self, gap: f64, direction: &Vector) -> bool {
        let between = other.centre() - self.centre();
        let directions = [*direction, between].into_iter().chain(self.normals()).chain(other.normals());
        directions.filter_map(|d| d.try_normalize(f64::MIN_POSITIVE)).any(|n| {
            // counted from a point of the one, so that no large coordinates enter the products
            let origin = self.centre();
            let ((lo, hi), (from, to)) = (self.extent(&n, &origin), other.extent(&n, &origin));
            (from - hi).max(lo - to) >= gap
        })
    }

    /// A box along the axes around it, and around a sphere of `radius` that sweeps it.
    pub fn bounds(&self, radius: f64) -> Bounds {
        let origin = Point::origin();
        let sides = [Vector::x(), Vector::y(), Vector::z()].map(|n| self.extent(&n, &origin));
        let lo = Point::from(sides.map(|s| s.0 - radius));
        let hi = Point::from(sides.map(|s| s.1 + radius));
        Bounds { centre: nalgebra::center(&lo, &hi), half: (hi - lo) * 0.5 }
    }
}

fn centre(pose: &ExactPose) -> Point {
    Point::from(pose.point(&Vec3::ZERO).rounded())
}

fn axis(pose: &ExactPose, i: usize) -> Vector {
    let mut unit = Point::origin();
    unit[i] = 1.0;
    pose.turned(&Vec3::from(&unit)).rounded()
}

/// A box along its frame's axes.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    pub centre: Point,
    pub half: Vector,
}

impl Bounds {
    pub fn joined(&self, other: &Self) -> Self {
        let lo = (self.centre - self.half).inf(&(other.centre - other.half));
        let hi = (self.centre + self.half).sup(&(other.centre + other.half));
        Self { centre: nalgebra::center(&lo, &hi), half: (hi - lo) * 0.5 }
    }

    pub fn radius(&self) -> f64 {
        self.half.norm()
    }
}

/// A motion between two frames of bounds.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    rotation: RotationMatrix,
    /// The sizes of the matrix's entries.
    sizes: RotationMatrix,
    origin: Vector,
}

impl From<&Pose> for Motion {
    fn from(pose: &Pose) -> Self {
        let rotation = *pose.rotation.to_rotation_matrix().matrix();
        Self { rotation, sizes: rotation.abs(), origin: pose.translation.vector }
    }
}

impl Motion {
    /// A number not larger than the distance of two boxes: what their own axes and `direction` (a unit vector or zero)
    /// prove (Gottschalk, Lin & Manocha 1996).
    pub fn lower_bound(&self, a: &Bounds, b: &Bounds, direction: &Vector) -> f64 {
        let offset = self.rotation * b.centre.coords + self.origin - a.centre.coords;
        let along_a = offset.abs() - a.half - self.sizes * b.half;
        let along_b = self.rotation.tr_mul(&offset).abs() - b.half - self.sizes.tr_mul(&a.half);
        let reach = direction.abs().dot(&a.half) + self.rotation.tr_mul(direction).abs().dot(&b.half);
        let positive = |gaps: Vector| gaps.sup(&Vector::zeros()).norm();
        positive(along_a).max(positive(along_b)).max(direction.dot(&offset).abs() - reach)
    }
}
