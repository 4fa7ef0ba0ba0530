//! Elements: the convex parts of bodies. Everything trusted about them is here: their extent in a direction, and corners whose hull
//! contains them.

use std::f64::consts::PI;

use clearance_geometry::math::{Extremes, MatrixPose, Point, Pose, Vector};
use clearance_geometry::{Primitive, Triangle};

/// A triangle of a mesh, or a convex solid, in the frame of its body.
#[derive(Clone, Debug)]
pub(super) enum Element {
    Triangle(Triangle),
    Solid(Box<Solid>),
    Cone(Box<Cone>),
}

/// A primitive as a Minkowski sum: a centre, up to three segments through it, a disc, and a ball. Missing parts are zero.
#[derive(Clone, Debug)]
pub(super) struct Solid {
    centre: Point,
    /// Half of each segment.
    halves: [Vector; 3],
    /// Two radii of the disc, square to each other.
    disc: [Vector; 2],
    ball: f64,
    /// Their hull holds all but the ball.
    corners: Vec<Point>,
}

/// The hull of a disc and an apex.
#[derive(Clone, Debug)]
pub(super) struct Cone {
    apex: Point,
    centre: Point,
    /// Two radii of the disc, square to each other.
    disc: [Vector; 2],
    /// Their hull holds all of it.
    corners: Vec<Point>,
}

/// Corners of the polygon around a disc; a multiple of four, so that the square around the disc holds it.
const POLYGON: u32 = 16;

impl Element {
    pub fn triangle(triangle: &Triangle, pose: &Pose) -> Self {
        Self::Triangle(triangle.transformed(pose))
    }

    pub fn primitive(primitive: &Primitive, pose: &Pose) -> Self {
        let along = |x: f64, y: f64, z: f64| pose.rotation * Vector::new(x, y, z);
        let zero = Vector::zeros();
        let centre = Point::from(pose.translation.vector);
        let (halves, disc, ball) = match *primitive {
            Primitive::Box { half_extents: [x, y, z] } => {
                ([along(x, 0.0, 0.0), along(0.0, y, 0.0), along(0.0, 0.0, z)], [zero; 2], 0.0)
            }
            Primitive::Sphere { radius } => ([zero; 3], [zero; 2], radius),
            Primitive::Capsule { radius, half_length } => {
                ([along(0.0, 0.0, half_length), zero, zero], [zero; 2], radius)
            }
            Primitive::Cone { radius, half_length } => {
                let up = along(0.0, 0.0, half_length);
                let disc = [along(radius, 0.0, 0.0), along(0.0, radius, 0.0)];
                let (apex, centre) = (centre + up, centre - up);
                let mut corners = corners(&centre, &[zero; 3], &disc);
                corners.push(apex);
                return Self::Cone(Box::new(Cone { apex, centre, disc, corners }));
            }
            Primitive::Cylinder { radius, half_length } => {
                let disc = [along(radius, 0.0, 0.0), along(0.0, radius, 0.0)];
                ([along(0.0, 0.0, half_length), zero, zero], disc, 0.0)
            }
        };
        let corners = corners(&centre, &halves, &disc);
        Self::Solid(Box::new(Solid { centre, halves, disc, ball, corners }))
    }

    /// The largest n·x of its points x.
    pub fn support(&self, n: &Vector) -> f64 {
        match self {
            Self::Triangle(Triangle { a, b, c }) => {
                n.dot(&a.coords).greater(n.dot(&b.coords)).greater(n.dot(&c.coords))
            }
            Self::Solid(solid) => {
                let segments: f64 = solid.halves.iter().map(|half| n.dot(half).abs()).sum();
                let disc = n.dot(&solid.disc[0]).hypot(n.dot(&solid.disc[1]));
                n.dot(&solid.centre.coords) + segments + disc + solid.ball * n.norm()
            }
            Self::Cone(cone) => {
                let disc = n.dot(&cone.disc[0]).hypot(n.dot(&cone.disc[1]));
                n.dot(&cone.apex.coords).greater(n.dot(&cone.centre.coords) + disc)
            }
        }
    }

    /// A point, the ball left out, whose n·x is the largest.
    pub fn extreme(&self, n: &Vector) -> Point {
        match self {
            Self::Triangle(triangle) => {
                let corners = triangle.corners();
                let heights = corners.map(|p| n.dot(&p.coords));
                let first = usize::from(heights[1] > heights[0]);
                corners[if heights[2] > heights[first] { 2 } else { first }]
            }
            Self::Solid(solid) => {
                let mut point = solid.centre;
                for half in &solid.halves {
                    point += if n.dot(half) < 0.0 { -half } else { *half };
                }
                point + rim(&solid.disc, n)
            }
            Self::Cone(cone) => {
                let rim = cone.centre + rim(&cone.disc, n);
                if n.dot(&(cone.apex - rim)) > 0.0 { cone.apex } else { rim }
            }
        }
    }

    /// Radius of the ball in the sum.
    pub fn ball(&self) -> f64 {
        if let Self::Solid(solid) = self { solid.ball } else { 0.0 }
    }

    /// The largest value of a convex function that changes by no more than `slope` a metre, or more.
    pub fn greatest(&self, slope: f64, function: impl Fn(&Point) -> f64) -> f64 {
        match self {
            Self::Triangle(Triangle { a, b, c }) => function(a).greater(function(b)).greater(function(c)),
            Self::Solid(solid) => {
                solid.corners.iter().map(function).fold(0.0, f64::greater) + slope * solid.ball
            }
            Self::Cone(cone) => cone.corners.iter().map(function).fold(0.0, f64::greater),
        }
    }

    /// Smallest and largest coordinates.
    pub fn bounds(&self) -> [Point; 2] {
        match self {
            Self::Triangle(Triangle { a, b, c }) => [a.inf(b).inf(c), a.sup(b).sup(c)],
            Self::Solid(_) | Self::Cone(_) => {
                let axes = [Vector::x(), Vector::y(), Vector::z()];
                let high = axes.map(|axis| self.support(&axis));
                let low = axes.map(|axis| -self.support(&-axis));
                [Point::from(low), Point::from(high)]
            }
        }
    }
}

/// From the centre of a disc to where it is farthest along n.
fn rim([u, v]: &[Vector; 2], n: &Vector) -> Vector {
    let (x, y) = (n.dot(u), n.dot(v));
    let length = x.hypot(y);
    if length > 0.0 { u * (x / length) + v * (y / length) } else { Vector::zeros() }
}

fn corners(centre: &Point, halves: &[Vector; 3], disc: &[Vector; 2]) -> Vec<Point> {
    let mut corners = vec![*centre];
    for half in halves.iter().filter(|half| **half != Vector::zeros()) {
        corners = corners.iter().flat_map(|c| [c - half, c + half]).collect();
    }
    if disc[0] == Vector::zeros() {
        return corners;
    }
    let half_angle = PI / f64::from(POLYGON);
    let polygon: Vec<Vector> = (0..POLYGON)
        .map(|i| f64::from(2 * i + 1) * half_angle)
        .map(|angle| (disc[0] * angle.cos() + disc[1] * angle.sin()) / half_angle.cos())
        .collect();
    corners.iter().flat_map(|c| polygon.iter().map(move |p| c + p)).collect()
}

/// Lower bound on the distance of two elements, from the two planes normal to `n`, a unit direction in the frame of `a`. Negative if the
/// planes do not lie between them.
pub(super) fn gap(a: &Element, b: &Element, pose_ab: &MatrixPose, n: &Vector) -> f64 {
    let n_b = pose_ab.rotation.tr_mul(n);
    gap_of_supports(a.support(n), b.support(&-n_b), pose_ab, n)
}

/// The same of any two things, from how far they reach towards each other.
pub(super) fn gap_of_supports(a: f64, b: f64, pose_ab: &MatrixPose, n: &Vector) -> f64 {
    let is_unit = (n.norm_squared() - 1.0).abs() <= 1e-14;
    if is_unit { n.dot(&pose_ab.translation) - b - a } else { f64::NEG_INFINITY }
}
