//! Solid of a link, a primitive or a closed part of a mesh, and a test whether it contains a ball.

use clearance_geometry::math::{Extremes, MatrixPose, Point, Pose};
use clearance_geometry::{Primitive, Shape};
use std::sync::Arc;

use super::always_certificate::{ElementPoint, InnerBall};
use super::body::Body;
use super::closed_part::ClosedPart;
use super::separation_test::SeparationTest;

/// Least radius (m) of a ball: many times the rounding of positions.
const LEAST_RADIUS: f64 = 1e-9;

/// Error of the sum of three weights.
const WEIGHT_ROUNDING: f64 = 1e-14;

/// A solid in the frame of its link.
#[derive(Debug)]
pub(super) struct InnerSolid {
    pose: Pose,
    content: Content,
    /// Its elements: the faces of the part, or the primitive.
    pub body: Body,
}

#[derive(Debug)]
enum Content {
    Primitive(Primitive),
    Part(ClosedPart),
}

impl InnerSolid {
    /// The solid that a ball names; `None` if the shape has no inside there.
    pub fn new(shapes: &[(Pose, Shape)], ball: &InnerBall) -> Option<Self> {
        let (pose, shape) = shapes.get(ball.shape)?;
        match shape {
            Shape::Primitive(_) if ball.face != 0 => None,
            Shape::Primitive(primitive) => {
                let body = Body::new(&[(*pose, shape)], false);
                Some(Self { pose: *pose, content: Content::Primitive(*primitive), body })
            }
            Shape::Mesh(mesh) => {
                let part = ClosedPart::new(mesh, ball.face)?;
                let shape = Shape::Mesh(Arc::new(part.mesh.clone()));
                let body = Body::new(&[(*pose, &shape)], false);
                Some(Self { pose: *pose, content: Content::Part(part), body })
            }
            Shape::Plane(_) | Shape::Points(_) | Shape::Voxels(_) => None,
        }
    }

    /// True if the solid contains a ball.
    pub fn contains(&self, ball: &InnerBall) -> bool {
        let is_ball = ball.radius >= LEAST_RADIUS
            && ball.radius.is_finite()
            && ball.centre.iter().all(|c| c.is_finite());
        let centre = Point::from(ball.centre);
        let p = self.pose.inverse_transform_point(&centre);
        is_ball
            && match &self.content {
                Content::Primitive(primitive) => holds(primitive, &p, ball.radius),
                Content::Part(part) => {
                    let point = point_body(&centre);
                    SeparationTest::new(&self.body, &point, MatrixPose::identity(), ball.radius).prove()
                        && part.winds_around(&p, ball.radius)
                }
            }
    }

    /// True if another body inside this solid would be apart from it: only the surface of a mesh counts.
    pub fn is_hollow(&self, meshes_are_solid: bool) -> bool {
        match &self.content {
            Content::Primitive(_) => false,
            // the inside of one part may be a cavity of another
            Content::Part(part) => !(meshes_are_solid && part.is_whole),
        }
    }
}

/// A body of one point.
pub(super) fn point_body(p: &Point) -> Body {
    let point = Shape::Primitive(Primitive::Sphere { radius: 0.0 });
    Body::new(&[(Pose::translation(p.x, p.y, p.z), &point)], false)
}

/// A point of a shape, in the frame of its link; `None` if the shape does not contain it.
pub(super) fn point_of(shapes: &[(Pose, Shape)], point: &ElementPoint) -> Option<Point> {
    let (pose, shape) = shapes.get(point.shape)?;
    match shape {
        Shape::Primitive(primitive) => {
            let p = Point::from(point.at);
            holds(primitive, &p, 0.0).then(|| pose * p)
        }
        Shape::Mesh(mesh) if point.face < mesh.triangles().len() => {
            let [u, v, w] = point.at;
            let are_weights = [u, v, w].iter().all(|weight| *weight >= 0.0);
            let corners = mesh.triangle(point.face).corners();
            let p = corners[0].coords * u + corners[1].coords * v + corners[2].coords * w;
            (are_weights && (u + v + w - 1.0).abs() <= WEIGHT_ROUNDING).then(|| pose * Point::from(p))
        }
        _ => None,
    }
}

/// True if a primitive contains the ball around a point.
fn holds(primitive: &Primitive, p: &Point, radius: f64) -> bool {
    let from_axis = p.x.hypot(p.y);
    let [within_sides, within_ends] = match *primitive {
        Primitive::Box { half_extents: [x, y, z] } => [(x - p.x.abs()).lesser(y - p.y.abs()), z - p.z.abs()],
        Primitive::Sphere { radius } => [radius - p.coords.norm(); 2],
        Primitive::Cylinder { radius, half_length } => [radius - from_axis, half_length - p.z.abs()],
        Primitive::Capsule { radius, half_length } => {
            [radius - from_axis.hypot((p.z.abs() - half_length).greater(0.0)); 2]
        }
        Primitive::Cone { radius, half_length } => {
            let height = 2.0 * half_length;
            let slant = (radius * (half_length - p.z) - height * from_axis) / radius.hypot(height);
            [slant, p.z + half_length]
        }
    };
    within_sides >= radius && within_ends >= radius
}
