//! Contact manifold of two convex shapes: the faces that look at each other are clipped against each other, as in the ODE (Smith 2001) and
//! Box2D (Catto 2006); the depth at each corner is measured along the normal.

use clearance_geometry::Triangle;
use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, MatrixPose, Point, Vector};

use super::chord::{Chord, Line};
use super::polygon::{self, Flat};
use crate::penetration_depth::ConvexSolid;

/// How far corners are moved inward before their depth is measured, relative to the face: rounding must not put them beside the solid.
const INWARD: f64 = 1e-9;

/// A convex shape in the frame of the first body.
pub(super) trait ConvexShape {
    /// Points of the face that faces a direction most.
    fn support_face(&self, direction: &Vector) -> Vec<Point>;

    /// The part of a line inside. For flat shapes, where the line meets their plane, at or beside the shape.
    fn chord(&self, line: &Line) -> Option<Chord>;
}

/// A convex solid whose body is posed in the frame of the first body.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlacedSolid<'s> {
    pub solid: &'s ConvexSolid,
    pub pose: &'s MatrixPose,
}

impl ConvexShape for PlacedSolid<'_> {
    fn support_face(&self, direction: &Vector) -> Vec<Point> {
        let face = self.solid.support_face(&self.pose.rotation.tr_mul(direction));
        face.into_iter().map(|p| self.pose * p).collect()
    }

    fn chord(&self, line: &Line) -> Option<Chord> {
        self.solid.chord(&line.seen_from(self.pose))
    }
}

impl ConvexShape for Triangle {
    fn support_face(&self, _: &Vector) -> Vec<Point> {
        self.corners().into()
    }

    fn chord(&self, line: &Line) -> Option<Chord> {
        let normal = self.normal();
        let slope = normal.dot(&line.direction);
        let t = normal.dot(&(self.a - line.origin)) / slope;
        (slope.abs() > 1e-6).then_some(Chord { from: t, to: t })
    }
}

/// Two convex shapes that touch or come within the margin (m); the second moves away from the first along the normal.
#[derive(Clone, Copy, Debug)]
pub(super) struct ConvexContact<'s, A, B> {
    pub a: &'s A,
    pub b: &'s B,
    /// Unit vector.
    pub normal: Vector,
    pub margin: f64,
}

/// The corners of the region in which two shapes touch.
#[derive(Clone, Debug, Default)]
pub(super) struct Manifold {
    pub corners: Vec<ManifoldPoint>,
}

/// A point in both shapes, or between them, and how deep the shapes overlap there along the normal (m, margin included).
#[derive(Clone, Copy, Debug)]
pub(super) struct ManifoldPoint {
    pub position: Point,
    pub depth: f64,
}

impl<A: ConvexShape, B: ConvexShape> ConvexContact<'_, A, B> {
    pub fn manifold(&self) -> Manifold {
        let faces = [self.a.support_face(&self.normal), self.b.support_face(&-self.normal)];
        let Some(origin) = faces[0].first().copied() else { return Manifold::default() };
        let plane = AcrossNormal::new(origin, &self.normal);
        let [ours, theirs] =
            faces.map(|face| polygon::convex_hull(face.iter().map(|p| plane.flat(p)).collect()));
        let common = polygon::overlap(&ours, &theirs);
        if common.is_empty() {
            return Manifold::default();
        }
        let middle = polygon::middle(&common);
        let corners = common.iter().filter_map(|corner| self.point_at(&plane, corner, &middle));
        Manifold { corners: corners.collect() }
    }

    /// The contact on the line along the normal through a corner of a polygon around `middle`; `None` if the shapes are apart there.
    fn point_at(&self, plane: &AcrossNormal, corner: &Flat, middle: &Flat) -> Option<ManifoldPoint> {
        let inside = plane.point(&(corner + (middle - corner) * INWARD));
        let line = Line { origin: inside, direction: self.normal };
        let (of_a, of_b) = (self.a.chord(&line)?, self.b.chord(&line)?);
        let depth = of_a.to - of_b.from;
        let height = if depth >= 0.0 {
            let (low, high) = (of_a.from.greater(of_b.from), of_a.to.lesser(of_b.to));
            // a may be beyond b as a whole
            (low <= high + CONTACT_DISTANCE).then_some(0.5 * (low + high))?
        } else {
            0.5 * (of_a.to + of_b.from)
        };
        let depth = depth + self.margin;
        let position = plane.point(corner) + self.normal * height;
        (depth >= -CONTACT_DISTANCE).then_some(ManifoldPoint { position, depth: depth.greater(0.0) })
    }
}

/// Coordinates in a plane across a normal.
pub(super) struct AcrossNormal {
    origin: Point,
    axes: [Vector; 2],
}

impl AcrossNormal {
    pub fn new(origin: Point, normal: &Vector) -> Self {
        let first = normal.cross(&Vector::ith(normal.iamin(), 1.0)).normalize();
        Self { origin, axes: [first, normal.cross(&first)] }
    }

    pub fn flat(&self, p: &Point) -> Flat {
        let from = p - self.origin;
        Flat::new(from.dot(&self.axes[0]), from.dot(&self.axes[1]))
    }

    /// A unit vector in the plane.
    pub fn direction(&self, turn: f64) -> Vector {
        self.axes[0] * turn.cos() + self.axes[1] * turn.sin()
    }

    pub fn point(&self, flat: &Flat) -> Point {
        self.origin + self.axes[0] * flat.x + self.axes[1] * flat.y
    }
}
