//! How far two bodies are apart: every part against every part, less what a tree of spheres proves too far.

use clearance::geometry::{Primitive, Shape};
use clearance::math::{Point, Pose, Vector};

use super::cylinder_oracle::Cylinder;
use super::double_double::{ExactPose, Vec3};
use super::triangle_oracle::{Nearest, triangle_distance};

/// What rounding may hide where f64 prunes, relative to the largest coordinate.
const PRUNING_SLACK: f64 = 1e-14;

type Corners = [Vec3; 3];

/// A convex set without its rounding.
#[derive(Clone, Debug)]
enum Core {
    /// Also a point or a segment: corners may be equal.
    Triangle(Corners),
    Cuboid(Box<Cuboid>),
    Cylinder(Cylinder, ExactPose),
}

/// A solid box: its half extents, where it is, and two triangles for each of its faces.
#[derive(Clone, Debug)]
struct Cuboid {
    half: [f64; 3],
    pose: ExactPose,
    faces: [Corners; 12],
}

/// A core swept by a sphere, and a sphere around all of that.
#[derive(Clone, Debug)]
struct Part {
    core: Core,
    radius: f64,
    ball: Ball,
}

#[derive(Clone, Copy, Debug)]
struct Ball {
    centre: Point,
    radius: f64,
}

#[derive(Clone, Debug)]
struct Node {
    ball: Ball,
    content: Content,
}

#[derive(Clone, Copy, Debug)]
enum Content {
    Part(usize),
    Children(usize, usize),
}

/// The oracle's own copy of a body.
#[derive(Clone, Debug)]
pub struct Solid {
    parts: Vec<Part>,
    nodes: Vec<Node>,
    root: usize,
    /// Largest coordinate (m).
    pub reach: f64,
}

impl Solid {
    pub fn new<'a>(shapes: impl IntoIterator<Item = (&'a Pose, &'a Shape)>) -> Self {
        let mut parts = vec![];
        for (pose, shape) in shapes {
            let exact = ExactPose::from(pose);
            match shape {
                Shape::Primitive(primitive) => parts.push(Part::primitive(primitive, &exact)),
                Shape::Mesh(mesh) => parts.extend(mesh.triangles().iter().map(|t| {
                    Part::triangle(t.map(|v| exact.point(&Vec3::from(&mesh.vertices()[v as usize]))), 0.0)
                })),
            }
        }
        Self::of(parts)
    }

    fn of(parts: Vec<Part>) -> Self {
        let farthest = |p: &Part| p.ball.centre.coords.amax() + p.ball.radius;
        let reach = parts.iter().map(farthest).fold(0.0, f64::max);
        let mut order: Vec<usize> = (0..parts.len()).collect();
        let mut solid = Self { nodes: Vec::with_capacity(2 * parts.len()), parts, root: 0, reach };
        solid.root = solid.build(&mut order);
        solid
    }

    pub fn triangle(corners: &[Point; 3]) -> Self {
        Self::of(vec![Part::triangle([0, 1, 2].map(|i| Vec3::from(&corners[i])), 0.0)])
    }

    /// A sphere around the body, in its frame.
    pub fn ball(&self) -> (Point, f64) {
        let ball = self.nodes[self.root].ball;
        (ball.centre, ball.radius)
    }

    pub fn part_count(&self) -> usize {
        self.parts.len()
    }

    /// Splits at the median of the longest side, down to single parts.
    fn build(&mut self, order: &mut [usize]) -> usize {
        let content = if let [part] = order {
            Content::Part(*part)
        } else {
            let centre = |i: &usize| self.parts[*i].ball.centre;
            let lo = order.iter().map(centre).reduce(|x, y| x.inf(&y)).unwrap_or_default();
            let hi = order.iter().map(centre).reduce(|x, y| x.sup(&y)).unwrap_or_default();
            let axis = (hi - lo).imax();
            let middle = order.len() / 2;
            order.select_nth_unstable_by(middle, |i, j| centre(i)[axis].total_cmp(&centre(j)[axis]));
            let (left, right) = order.split_at_mut(middle);
            Content::Children(self.build(left), self.build(right))
        };
        self.nodes.push(Node { ball: self.ball_around(order), content });
        self.nodes.len() - 1
    }

    fn ball_around(&self, parts: &[usize]) -> Ball {
        if let [only] = parts {
            return self.parts[*only].ball;
        }
        let balls = || parts.iter().map(|i| self.parts[*i].ball);
        let reach = |b: Ball| Vector::repeat(b.radius);
        let lo = balls().map(|b| b.centre - reach(b)).reduce(|x, y| x.inf(&y)).unwrap_or_default();
        let hi = balls().map(|b| b.centre + reach(b)).reduce(|x, y| x.sup(&y)).unwrap_or_default();
        let centre = nalgebra::center(&lo, &hi);
        let radius = balls().map(|b| nalgebra::distance(&centre, &b.centre) + b.radius).fold(0.0, f64::max);
        Ball { centre, radius }
    }

    /// The distance of a point (in the body's frame) from the body.
    pub fn distance_to(&self, point: &Point) -> f64 {
        let probe = Self::triangle(&[*point; 3]);
        solid_distance(self, &probe, &Pose::identity(), f64::INFINITY).unwrap_or(f64::INFINITY)
    }
}

impl Part {
    fn triangle(corners: Corners, radius: f64) -> Self {
        let points = corners.map(|c| Point::from(c.rounded()));
        let centre = nalgebra::center(&points[0], &nalgebra::center(&points[1], &points[2]));
        let farthest = points.iter().map(|p| nalgebra::distance(&centre, p)).fold(0.0, f64::max);
        Self { core: Core::Triangle(corners), radius, ball: Ball { centre, radius: farthest + radius } }
    }

    fn primitive(primitive: &Primitive, pose: &ExactPose) -> Self {
        let along_z = |h: f64| pose.point(&Vec3::from(&Point::new(0.0, 0.0, h)));
        let core = match *primitive {
            Primitive::Sphere { radius } => return Self::triangle([along_z(0.0); 3], radius),
            Primitive::Capsule { radius, half_length: h } => {
                return Self::triangle([along_z(-h), along_z(h), along_z(h)], radius);
            }
            Primitive::Box { half_extents } => Core::Cuboid(Cuboid::new(half_extents, *pose).into()),
            Primitive::Cylinder { radius, half_length } => {
                Core::Cylinder(Cylinder { radius, half_length }, *pose)
            }
        };
        let centre = Point::from(along_z(0.0).rounded());
        Self { core, radius: 0.0, ball: Ball { centre, radius: primitive.bounding_radius() } }
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
    fn moved(&self, pose: &ExactPose) -> Self {
        match self {
            Self::Triangle(t) => Self::Triangle(t.map(|c| pose.point(&c))),
            Self::Cuboid(cuboid) => Self::Cuboid(Cuboid::new(cuboid.half, pose.then(&cuboid.pose)).into()),
            Self::Cylinder(cylinder, own) => Self::Cylinder(*cylinder, pose.then(own)),
        }
    }

    fn faces(&self) -> &[Corners] {
        match self {
            Self::Triangle(t) => std::slice::from_ref(t),
            Self::Cuboid(cuboid) => &cuboid.faces,
            Self::Cylinder(..) => &[],
        }
    }

    /// Whether a box holds a point.
    fn holds(&self, p: &Vec3) -> bool {
        matches!(self, Self::Cuboid(cuboid) if cuboid.holds(p))
    }

    fn some_point(&self) -> Vec3 {
        match self {
            Self::Cylinder(_, pose) => pose.point(&Vec3::ZERO),
            _ => self.faces()[0][0],
        }
    }

    fn nearest(&self, other: &Self) -> Nearest {
        if self.holds(&other.some_point()) || other.holds(&self.some_point()) {
            return Nearest { squared: 0.0, direction: Vector::zeros() };
        }
        match (self, other) {
            (Self::Cylinder(x, pose_x), Self::Cylinder(y, pose_y)) => {
                let into = |p: &Point| in_frame(pose_x, &pose_y.point(&Vec3::from(p)));
                // the composed motion is rounded once, not at each of the search's points
                let origin = into(&Point::origin());
                let axes = [Vector::x(), Vector::y(), Vector::z()].map(|a| into(&Point::from(a)) - origin);
                along_nothing(
                    x.distance_to_cylinder(y, |p| origin + axes[0] * p.x + axes[1] * p.y + axes[2] * p.z),
                )
            }
            (Self::Cylinder(cylinder, pose), hull) | (hull, Self::Cylinder(cylinder, pose)) => {
                let local = |t: &Corners| t.map(|c| in_frame(pose, &c));
                let from_face = |t: &Corners| cylinder.distance_to_triangle(&local(t));
                along_nothing(hull.faces().iter().map(from_face).fold(f64::INFINITY, f64::min))
            }
            _ => {
                let pairs = self.faces().iter().flat_map(|s| other.faces().iter().map(move |t| (s, t)));
                let found = pairs.map(|(s, t)| triangle_distance(s, t));
                found.reduce(|x, y| if y.squared < x.squared { y } else { x }).expect("a hull has faces")
            }
        }
    }
}

fn in_frame(pose: &ExactPose, p: &Vec3) -> Point {
    Point::from(pose.inverse_point(p).rounded())
}

/// A distance whose direction is not known.
fn along_nothing(distance: f64) -> Nearest {
    Nearest { squared: distance * distance, direction: Vector::zeros() }
}

/// The least distance (m) of two bodies if it is less than `below`; b is posed in the frame of a.
pub fn solid_distance(a: &Solid, b: &Solid, pose_ab: &Pose, below: f64) -> Option<f64> {
    let reach = a.reach + b.reach + pose_ab.translation.vector.amax();
    let exact = ExactPose::from(pose_ab);
    let slack = PRUNING_SLACK * reach;
    let mut search = Search { a, b, pose_ab, exact, slack, best: below, direction: Vector::zeros() };
    search.nodes(a.root, b.root);
    (search.best < below).then_some(search.best)
}

struct Search<'s> {
    a: &'s Solid,
    b: &'s Solid,
    pose_ab: &'s Pose,
    exact: ExactPose,
    slack: f64,
    best: f64,
    /// Of the nearest parts so far.
    direction: Vector,
}

impl Search<'_> {
    fn lower_bound(&self, i: usize, j: usize) -> f64 {
        let (x, y) = (&self.a.nodes[i].ball, &self.b.nodes[j].ball);
        nalgebra::distance(&x.centre, &(self.pose_ab * y.centre)) - x.radius - y.radius - self.slack
    }

    fn nodes(&mut self, i: usize, j: usize) {
        if self.best <= 0.0 || self.lower_bound(i, j) >= self.best {
            return;
        }
        let (x, y) = (&self.a.nodes[i], &self.b.nodes[j]);
        let mut pairs = match (x.content, y.content) {
            (Content::Part(i), Content::Part(j)) => return self.parts(i, j),
            (Content::Children(l, r), Content::Part(_)) => [(l, j), (r, j)],
            (Content::Children(l, r), _) if x.ball.radius >= y.ball.radius => [(l, j), (r, j)],
            (_, Content::Children(l, r)) => [(i, l), (i, r)],
        };
        if self.lower_bound(pairs[1].0, pairs[1].1) < self.lower_bound(pairs[0].0, pairs[0].1) {
            pairs.swap(0, 1);
        }
        for (i, j) in pairs {
            self.nodes(i, j);
        }
    }

    fn parts(&mut self, i: usize, j: usize) {
        let (x, y) = (&self.a.parts[i], &self.b.parts[j]);
        let radii = x.radius + y.radius;
        if self.separated(&x.core, &y.core, self.best + radii) {
            return;
        }
        let found = x.core.nearest(&y.core.moved(&self.exact));
        let distance = (found.squared.sqrt() - radii).max(0.0);
        if distance < self.best {
            self.best = distance;
            self.direction = found.direction;
        }
    }

    /// Whether two triangles lie at least `gap` apart along the best direction so far or one of their normals.
    fn separated(&self, x: &Core, y: &Core, gap: f64) -> bool {
        let (Core::Triangle(x), Core::Triangle(y)) = (x, y) else { return false };
        let x = x.map(|c| Point::from(c.rounded()));
        let y = y.map(|c| self.pose_ab * Point::from(c.rounded()));
        let normal = |[a, b, c]: &[Point; 3]| (b - a).cross(&(c - a));
        [self.direction, normal(&x), normal(&y)].iter().any(|n| gap_along(n, &x, &y) - self.slack >= gap)
    }
}

/// How far apart two triangles lie along a direction: negative where they overlap.
fn gap_along(direction: &Vector, x: &[Point; 3], y: &[Point; 3]) -> f64 {
    let Some(n) = direction.try_normalize(f64::MIN_POSITIVE) else { return f64::NEG_INFINITY };
    // from a corner, so that no large coordinates enter the products
    let along = |p: &Point| n.dot(&(p - x[0]));
    let (x, y) = (x.map(|p| along(&p)), y.map(|p| along(&p)));
    let least = |v: [f64; 3]| v[0].min(v[1]).min(v[2]);
    let most = |v: [f64; 3]| v[0].max(v[1]).max(v[2]);
    (least(y) - most(x)).max(least(x) - most(y))
}
