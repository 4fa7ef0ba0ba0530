//! Test oracle: parts of bodies (triangles and solid primitives), and the distance of two parts.

use clearance::geometry::Primitive;
use clearance::geometry::math::{Point, Vector};

use super::double_double::{ExactPose, Vec3};
use super::outline::Outline;
use super::triangle_oracle::{Nearest, triangle_distance};
use super::turned_oracle::Turned;

type Corners = [Vec3; 3];

/// A convex set swept by a sphere.
#[derive(Clone, Debug)]
pub struct Part {
    pub core: Core,
    pub radius: f64,
    pub outline: Outline,
}

#[derive(Clone, Debug)]
pub enum Core {
    /// Also a point or a segment: corners may be equal.
    Triangle(Corners),
    Cuboid(Box<Cuboid>),
    Turned(Turned, ExactPose),
}

/// A solid box: its half extents, where it is, and two triangles for each of its faces.
#[derive(Clone, Debug)]
pub struct Cuboid {
    half: [f64; 3],
    pose: ExactPose,
    faces: [Corners; 12],
}

impl Part {
    pub fn triangle(corners: Corners, radius: f64) -> Self {
        Self { core: Core::Triangle(corners), radius, outline: Outline::triangle(&corners) }
    }

    pub fn primitive(primitive: &Primitive, pose: &ExactPose) -> Self {
        let along_z = |h: f64| pose.point(&Vec3::from(&Point::new(0.0, 0.0, h)));
        match *primitive {
            Primitive::Sphere { radius } => Self::triangle([along_z(0.0); 3], radius),
            Primitive::Capsule { radius, half_length: h } => {
                Self::triangle([along_z(-h), along_z(h), along_z(h)], radius)
            }
            Primitive::Box { half_extents } => Self {
                core: Core::Cuboid(Cuboid::new(half_extents, *pose).into()),
                radius: 0.0,
                outline: Outline::cuboid(half_extents, pose),
            },
            Primitive::Cylinder { radius, half_length } => {
                Self::turned(Turned { foot: radius, top: radius, half_length }, pose)
            }
            Primitive::Cone { radius, half_length } => {
                Self::turned(Turned { foot: radius, top: 0.0, half_length }, pose)
            }
        }
    }

    fn turned(turned: Turned, pose: &ExactPose) -> Self {
        let outline = Outline::cylinder(turned.foot.max(turned.top), turned.half_length, pose);
        Self { core: Core::Turned(turned, *pose), radius: 0.0, outline }
    }

    /// Least and largest number along a unit vector.
    pub fn extent(&self, n: &Vector) -> (f64, f64) {
        let along = |p: &Vec3| p.rounded().dot(n);
        let corners: Vec<f64> = match &self.core {
            Core::Turned(Turned { foot, top, half_length }, pose) => {
                let axis = pose.turned(&Vec3::from(&Point::new(0.0, 0.0, 1.0))).rounded();
                let across = axis.cross(n).norm();
                let disc = |z: f64, r: f64| {
                    let centre = along(&pose.point(&Vec3::from(&Point::new(0.0, 0.0, z))));
                    [centre - r * across, centre + r * across]
                };
                [disc(-half_length, *foot), disc(*half_length, *top)].concat()
            }
            core => core.faces().iter().flatten().map(along).collect(),
        };
        let low = corners.iter().copied().fold(f64::INFINITY, f64::min);
        let high = corners.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        (low - self.radius, high + self.radius)
    }
}

impl Cuboid {
    fn new(half: [f64; 3], pose: ExactPose) -> Self {
        let faces = std::array::from_fn(|i| {
            let at = |u: f64, v: f64| {
                let (axis, next, last) = (i / 4, (i / 4 + 1) % 3, (i / 4 + 2) % 3);
                let mut p = Point::origin();
                p[axis] = if i % 2 == 0 { half[axis] } else { -half[axis] };
                (p[next], p[last]) = (u * half[next], v * half[last]);
                pose.point(&Vec3::from(&p))
            };
            [at(-1.0, -1.0), at(1.0, 1.0), if i % 4 < 2 { at(1.0, -1.0) } else { at(-1.0, 1.0) }]
        });
        Self { half, pose, faces }
    }

    fn holds(&self, p: &Vec3) -> bool {
        let local = in_frame(&self.pose, p);
        (0..3).all(|i| local[i].abs() <= self.half[i])
    }
}

impl Core {
    pub fn moved(&self, pose: &ExactPose) -> Self {
        match self {
            Self::Triangle(t) => Self::Triangle(t.map(|c| pose.point(&c))),
            Self::Cuboid(cuboid) => Self::Cuboid(Cuboid::new(cuboid.half, pose.then(&cuboid.pose)).into()),
            Self::Turned(turned, own) => Self::Turned(*turned, pose.then(own)),
        }
    }

    fn faces(&self) -> &[Corners] {
        match self {
            Self::Triangle(t) => std::slice::from_ref(t),
            Self::Cuboid(cuboid) => &cuboid.faces,
            Self::Turned(..) => &[],
        }
    }

    /// Whether a box holds a point.
    fn holds(&self, p: &Vec3) -> bool {
        matches!(self, Self::Cuboid(cuboid) if cuboid.holds(p))
    }

    fn some_point(&self) -> Vec3 {
        match self {
            Self::Turned(_, pose) => pose.point(&Vec3::ZERO),
            _ => self.faces()[0][0],
        }
    }

    /// Where two cores in one frame are nearest. If their surfaces do not meet, one holds all of the other or nothing.
    pub fn nearest(&self, other: &Self) -> Nearest {
        if self.holds(&other.some_point()) || other.holds(&self.some_point()) {
            return Nearest { squared: 0.0, direction: Vector::zeros() };
        }
        match (self, other) {
            (Self::Turned(x, pose_x), Self::Turned(y, pose_y)) => {
                let into = |p: &Point| in_frame(pose_x, &pose_y.point(&Vec3::from(p)));
                // the composed motion is rounded once, not at each of the search's points
                let origin = into(&Point::origin());
                let axes = [Vector::x(), Vector::y(), Vector::z()].map(|a| into(&Point::from(a)) - origin);
                let into = |p: &Point| origin + axes[0] * p.x + axes[1] * p.y + axes[2] * p.z;
                seen_from(x.nearest_of_turned(y, into), pose_x)
            }
            (Self::Turned(turned, pose), hull) | (hull, Self::Turned(turned, pose)) => {
                let local = |t: &Corners| t.map(|c| in_frame(pose, &c));
                let found = hull.faces().iter().map(|t| turned.nearest_of_triangle(&local(t)));
                seen_from(found.reduce(nearer).expect("a hull has faces"), pose)
            }
            _ => nearest_faces(self.faces(), other.faces()),
        }
    }
}

fn nearest_faces(ours: &[Corners], theirs: &[Corners]) -> Nearest {
    let pairs = ours.iter().flat_map(|s| theirs.iter().map(move |t| (s, t)));
    pairs.map(|(s, t)| triangle_distance(s, t)).reduce(nearer).expect("a hull has faces")
}

fn nearer(x: Nearest, y: Nearest) -> Nearest {
    if y.squared < x.squared { y } else { x }
}

fn in_frame(pose: &ExactPose, p: &Vec3) -> Point {
    Point::from(pose.inverse_point(p).rounded())
}

/// The same, its direction turned out of a frame.
fn seen_from(found: Nearest, pose: &ExactPose) -> Nearest {
    let direction = pose.turned(&Vec3::from(&Point::from(found.direction))).rounded();
    Nearest { direction, ..found }
}
