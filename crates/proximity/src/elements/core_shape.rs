//! Core shapes with support points, nearest points and depths: every convex element is a core swept by a sphere. The
//! core of a sphere is a point, that of a capsule a segment; other elements are their own cores. Round shapes therefore
//! need no iteration and lose no accuracy.

use clearance_geometry::math::{Extremes, MatrixPose, Point, Vector};
use clearance_geometry::{Primitive, Triangle};

use super::element::Element;

/// A convex solid in its own frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum CoreShape {
    Point,
    /// Along z; the value is half of the length.
    Segment(f64),
    Triangle(Triangle),
    /// Half extents.
    Cuboid(Vector),
    /// Along z.
    Cylinder {
        radius: f64,
        half_length: f64,
    },
    /// Along z, the apex at `half_length`.
    Cone {
        radius: f64,
        half_length: f64,
    },
}

/// A core with its pose, and the radius of the swept sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RoundedShape {
    pub core: CoreShape,
    pub pose: MatrixPose,
    pub radius: f64,
}

impl From<&Element> for RoundedShape {
    fn from(element: &Element) -> Self {
        match element {
            Element::Triangle(t) => {
                Self { core: CoreShape::Triangle(*t), pose: MatrixPose::identity(), radius: 0.0 }
            }
            Element::Primitive { primitive, pose } => {
                let (core, radius) = match *primitive {
                    Primitive::Box { half_extents } => (CoreShape::Cuboid(Vector::from(half_extents)), 0.0),
                    Primitive::Sphere { radius } => (CoreShape::Point, radius),
                    Primitive::Capsule { radius, half_length } => (CoreShape::Segment(half_length), radius),
                    Primitive::Cylinder { radius, half_length } => {
                        (CoreShape::Cylinder { radius, half_length }, 0.0)
                    }
                    Primitive::Cone { radius, half_length } => (CoreShape::Cone { radius, half_length }, 0.0),
                };
                Self { core, pose: pose.into(), radius }
            }
        }
    }
}

impl RoundedShape {
    #[inline]
    pub fn point(point: &Point) -> Self {
        let pose = MatrixPose { translation: point.coords, ..MatrixPose::identity() };
        Self { core: CoreShape::Point, pose, radius: 0.0 }
    }

    /// Upper bound (m) on the distance of its points from a point of its body.
    #[inline]
    pub fn farthest_from(&self, point: &Point) -> f64 {
        let to = |p: Point| nalgebra::distance(&(&self.pose * p), point);
        let of_core = match self.core {
            CoreShape::Point => to(Point::origin()),
            CoreShape::Segment(half_length) => {
                CoreShape::segment(half_length).map(to).into_iter().fold(0.0, f64::greater)
            }
            CoreShape::Triangle(t) => t.corners().map(to).into_iter().fold(0.0, f64::greater),
            CoreShape::Cuboid(half) => to(Point::origin()) + half.norm(),
            CoreShape::Cylinder { radius, half_length } | CoreShape::Cone { radius, half_length } => {
                to(Point::origin()) + radius.hypot(half_length)
            }
        };
        of_core + self.radius
    }
}

impl CoreShape {
    /// The ends of a segment core.
    #[inline]
    pub fn segment(half_length: f64) -> [Point; 2] {
        [Point::new(0.0, 0.0, -half_length), Point::new(0.0, 0.0, half_length)]
    }

    /// A core and a radius around it that contain this core: for a cylinder its axis, for others the core itself.
    #[inline]
    pub fn capsule(&self) -> (Self, f64) {
        match *self {
            Self::Cylinder { radius, half_length } => (Self::Segment(half_length), radius),
            other => (other, 0.0),
        }
    }

    /// Triangles that together are the surface; `None` where it is curved.
    #[inline]
    pub fn faces(&self) -> Option<Faces> {
        match *self {
            Self::Point | Self::Cylinder { .. } | Self::Cone { .. } => None,
            Self::Segment(half_length) => {
                let [a, b] = Self::segment(half_length);
                Some(Faces::of(&[Triangle { a, b, c: b }]))
            }
            Self::Triangle(t) => Some(Faces::of(&[t])),
            Self::Cuboid(half) => Some(Faces::of_cuboid(&half)),
        }
    }

    /// The point farthest along `direction`.
    pub fn support(&self, direction: &Vector) -> Point {
        match *self {
            Self::Point => Point::origin(),
            Self::Segment(half_length) => Point::new(0.0, 0.0, half_length.copysign(direction.z)),
            Self::Triangle(t) => {
                let [a, b, c] = t.corners().map(|p| p.coords.dot(direction));
                if a >= b && a >= c {
                    t.a
                } else if b >= c {
                    t.b
                } else {
                    t.c
                }
            }
            Self::Cuboid(half) => Point::from(half.zip_map(direction, f64::copysign)),
            Self::Cylinder { radius, half_length } => {
                let across = (direction.x * direction.x + direction.y * direction.y).sqrt();
                // no side for a direction almost along the axis
                let (x, y) = if across > f64::MIN_POSITIVE {
                    (direction.x / across, direction.y / across)
                } else {
                    (0.0, 0.0)
                };
                Point::new(radius * x, radius * y, half_length.copysign(direction.z))
            }
            Self::Cone { radius, half_length } => {
                let across = (direction.x * direction.x + direction.y * direction.y).sqrt();
                if 2.0 * half_length * direction.z >= radius * across {
                    return Point::new(0.0, 0.0, half_length);
                }
                let scale = if across > f64::MIN_POSITIVE { radius / across } else { 0.0 };
                Point::new(direction.x * scale, direction.y * scale, -half_length)
            }
        }
    }

    /// The point of the core nearest to `p`; `p` itself when inside.
    #[inline]
    pub fn nearest_point(&self, p: &Point) -> Point {
        match *self {
            Self::Point => Point::origin(),
            Self::Segment(half_length) => Point::new(0.0, 0.0, p.z.clamp(-half_length, half_length)),
            Self::Triangle(t) => t.nearest_point(p),
            Self::Cuboid(half) => Point::from(p.coords.zip_map(&half, |c, h| c.clamp(-h, h))),
            Self::Cylinder { radius, half_length } => {
                let across = (p.x * p.x + p.y * p.y).sqrt();
                let scale = if across > radius { radius / across } else { 1.0 };
                Point::new(p.x * scale, p.y * scale, p.z.clamp(-half_length, half_length))
            }
            Self::Cone { radius, half_length } => {
                let across = (p.x * p.x + p.y * p.y).sqrt();
                let [r, z] = nearest_in_section(radius, half_length, [across, p.z]);
                let scale = if across > 0.0 { r / across } else { 0.0 };
                Point::new(p.x * scale, p.y * scale, z)
            }
        }
    }

    /// Depth of `p` inside, and the nearest point of the surface; `None` outside, or for a core without volume.
    pub fn depth(&self, p: &Point) -> Option<(f64, Point)> {
        match *self {
            Self::Point | Self::Segment(_) | Self::Triangle(_) => None,
            Self::Cuboid(half) => {
                let room = half - p.coords.abs();
                let axis = room.imin();
                let mut surface = *p;
                surface[axis] = half[axis].copysign(p[axis]);
                (room[axis] >= 0.0).then_some((room[axis], surface))
            }
            Self::Cylinder { radius, half_length } => {
                let across = (p.x * p.x + p.y * p.y).sqrt();
                let (side, end) = (radius - across, half_length - p.z.abs());
                if side < 0.0 || end < 0.0 {
                    None
                } else if end <= side {
                    let z = half_length.copysign(p.z);
                    Some((end, Point::new(p.x, p.y, z)))
                } else if across > 0.0 {
                    let scale = radius / across;
                    Some((side, Point::new(p.x * scale, p.y * scale, p.z)))
                } else {
                    Some((side, Point::new(radius, 0.0, p.z)))
                }
            }
            Self::Cone { radius, half_length } => cone_depth(radius, half_length, p),
        }
    }
}

/// The nearest point of a cone in the half plane through its axis, for a point at this distance from the axis and this height.
fn nearest_in_section(radius: f64, half_length: f64, [r, z]: [f64; 2]) -> [f64; 2] {
    let length = 2.0 * half_length;
    let up = z + half_length;
    // below the side, measured from the rim; without a radius all of the axis is on the side
    let inside = up <= length && length * (r - radius) + radius * up <= 0.0;
    if up <= 0.0 {
        return [r.lesser(radius), -half_length];
    }
    if inside {
        return [r, z];
    }
    let slant = length * length + radius * radius;
    let share =
        if slant > 0.0 { ((length * up - radius * (r - radius)) / slant).clamp(0.0, 1.0) } else { 0.0 };
    [radius * (1.0 - share), half_length - length * (1.0 - share)]
}

/// Depth of a point inside a cone, and the nearest point of its surface.
fn cone_depth(radius: f64, half_length: f64, p: &Point) -> Option<(f64, Point)> {
    let across = (p.x * p.x + p.y * p.y).sqrt();
    let (length, up) = (2.0 * half_length, p.z + half_length);
    let slant = length.hypot(radius);
    if slant == 0.0 {
        return None;
    }
    let side = (length * (radius - across) - radius * up) / slant;
    if side < 0.0 || up < 0.0 || up > length {
        return None;
    }
    if up <= side {
        return Some((up, Point::new(p.x, p.y, -half_length)));
    }
    let (x, y) = if across > 0.0 { (p.x / across, p.y / across) } else { (1.0, 0.0) };
    let r = across + side * length / slant;
    Some((side, Point::new(r * x, r * y, p.z + side * radius / slant)))
}

/// The triangles of a flat core.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Faces {
    triangles: [Triangle; 12],
    count: usize,
}

impl Faces {
    fn of(triangles: &[Triangle]) -> Self {
        let mut all = [triangles[0]; 12];
        all[..triangles.len()].copy_from_slice(triangles);
        Self { triangles: all, count: triangles.len() }
    }

    /// Two triangles a face.
    fn of_cuboid(half: &Vector) -> Self {
        let corner = |axis: usize, side: f64, u: f64, v: f64| {
            let mut p = Vector::zeros();
            (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, u, v);
            Point::from(p.component_mul(half))
        };
        let triangles: [Triangle; 12] = std::array::from_fn(|i| {
            let (axis, side, turn) = (i / 4, [-1.0, 1.0][i / 2 % 2], [-1.0, 1.0][i % 2]);
            let at = |u, v| corner(axis, side, u, v);
            Triangle { a: at(turn, turn), b: at(-turn, turn), c: at(turn, -turn) }
        });
        Self::of(&triangles)
    }

    #[inline]
    pub fn iter(&self) -> impl Iterator<Item = &Triangle> {
        self.triangles[..self.count].iter()
    }
}
