//! Every convex element as a core swept by a sphere: a sphere is a point, a capsule a segment, the others themselves.
//! What is round costs no iteration and loses no accuracy.

use super::element::Element;
use crate::geometry::{Primitive, Triangle};
use crate::math::{MatrixPose, Point, Vector};

/// A convex solid in its own frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Core {
    Point,
    /// Along z, half this long.
    Segment(f64),
    Triangle(Triangle),
    /// Half extents.
    Cuboid(Vector),
    /// Along z.
    Cylinder {
        radius: f64,
        half_length: f64,
    },
}

/// A core, where it is, and how far around it the element reaches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RoundedCore {
    pub core: Core,
    pub pose: MatrixPose,
    pub radius: f64,
}

impl From<&Element> for RoundedCore {
    fn from(element: &Element) -> Self {
        match element {
            Element::Triangle(t) => {
                Self { core: Core::Triangle(*t), pose: MatrixPose::identity(), radius: 0.0 }
            }
            Element::Primitive { primitive, pose } => {
                let (core, radius) = match *primitive {
                    Primitive::Box { half_extents } => (Core::Cuboid(Vector::from(half_extents)), 0.0),
                    Primitive::Sphere { radius } => (Core::Point, radius),
                    Primitive::Capsule { radius, half_length } => (Core::Segment(half_length), radius),
                    Primitive::Cylinder { radius, half_length } => {
                        (Core::Cylinder { radius, half_length }, 0.0)
                    }
                };
                Self { core, pose: pose.into(), radius }
            }
        }
    }
}

impl Core {
    /// The ends of a segment core.
    pub fn segment(half_length: f64) -> [Point; 2] {
        [Point::new(0.0, 0.0, -half_length), Point::new(0.0, 0.0, half_length)]
    }

    /// A core and a radius around it that hold this core: of a cylinder its axis, of anything else itself.
    pub fn capsule(&self) -> (Self, f64) {
        match *self {
            Self::Cylinder { radius, half_length } => (Self::Segment(half_length), radius),
            other => (other, 0.0),
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
                // a direction so nearly along the axis has no side to it
                let (x, y) = if across > f64::MIN_POSITIVE {
                    (direction.x / across, direction.y / across)
                } else {
                    (0.0, 0.0)
                };
                Point::new(radius * x, radius * y, half_length.copysign(direction.z))
            }
        }
    }

    /// The point of the core nearest to `p`; `p` itself when inside.
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
        }
    }

    /// How deep `p` lies inside, and the nearest point of the surface; `None` outside or for a core without volume.
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
        }
    }
}
