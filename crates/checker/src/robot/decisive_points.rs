//! Points of the robot that decide whether it is inside obstacles.

use clearance_geometry::math::Point;
use clearance_robot::{Chain, Frame};

use super::robot_body::RobotBody;

/// A point of a robot body, in the frame of its chain body. Where surfaces are apart, the body is outside of an obstacle if all of its
/// points are ([`CollisionBody::decisive_points`](clearance_proximity::CollisionBody::decisive_points)).
#[derive(Clone, Copy, Debug)]
pub struct DecisivePoint {
    /// Index of the robot body.
    pub part: usize,
    /// Index of its chain body.
    pub chain_body: usize,
    pub point: Point,
}

/// The points of all robot bodies.
#[derive(Clone, Debug, Default)]
pub struct DecisivePoints {
    /// Those of moving bodies come first.
    points: Vec<DecisivePoint>,
    moving: usize,
    /// Bodies with clouds or voxels, of which every point decides for itself.
    bodies_with_cubes: Vec<usize>,
}

impl DecisivePoints {
    pub fn new(robot_bodies: &[RobotBody]) -> Self {
        let points = robot_bodies.iter().enumerate().flat_map(|(part, robot_body)| {
            let chain_body = robot_body.chain_body();
            let points = robot_body.solid().decisive_points().iter();
            points.map(move |point| DecisivePoint { part, chain_body, point: *point })
        });
        let (mut points, fixed): (Vec<_>, Vec<_>) = points.partition(|point| point.chain_body != Chain::ROOT);
        let moving = points.len();
        points.extend(fixed);
        let has_cubes = |part: &usize| robot_bodies[*part].solid().cube_count() > 0;
        let bodies_with_cubes = (0..robot_bodies.len()).filter(has_cubes).collect();
        Self { points, moving, bodies_with_cubes }
    }

    /// The points of all bodies.
    #[inline]
    pub fn all(&self) -> &[DecisivePoint] {
        &self.points
    }

    /// The points of the bodies that joints move.
    #[inline]
    pub fn moving(&self) -> &[DecisivePoint] {
        &self.points[..self.moving]
    }

    /// The points of the bodies that no joint moves.
    #[inline]
    pub fn fixed(&self) -> &[DecisivePoint] {
        &self.points[self.moving..]
    }

    /// Bodies with clouds or voxels.
    #[inline]
    pub fn bodies_with_cubes(&self) -> &[usize] {
        &self.bodies_with_cubes
    }
}

impl DecisivePoint {
    /// The point in the root frame, for the frame of its chain body.
    #[inline]
    pub fn in_root(&self, frame: &Frame<f64>) -> Point {
        Point::from(frame.point(self.point.coords.into()))
    }
}
