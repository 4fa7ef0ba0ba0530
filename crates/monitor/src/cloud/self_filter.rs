//! Self-filter: finds the points that belong to the robot or its attached objects.

use std::sync::Arc;

use clearance_geometry::math::{Point, Pose};
use clearance_geometry::{Primitive, Shape};
use clearance_proximity::{CollisionBody, Scratch, within_margin};
use clearance_robot::{LinkId, LinkPoses, RobotModel};
use clearance_scene::{AttachedObject, World};
use rayon::prelude::*;

/// Number of points that one thread processes together.
const CHUNK: usize = 1024;

/// Collision bodies of the robot, for distance queries with points.
#[derive(Clone, Debug)]
pub struct SelfFilter {
    robot: Arc<RobotModel>,
    links: Vec<Part>,
    held: Vec<(Arc<AttachedObject>, Option<Part>)>,
    /// A ball of radius 0: a point.
    point: CollisionBody,
}

/// The body of one link or attached object, in the frame of its link.
#[derive(Clone, Debug)]
struct Part {
    link: LinkId,
    body: CollisionBody,
}

/// A body at a link pose.
struct Placed<'p> {
    body: &'p CollisionBody,
    pose_lr: Pose,
    /// Bounding sphere with the padding, in the root frame.
    centre: Point,
    reach: f64,
}

impl SelfFilter {
    /// Creates the filter of a robot without attached objects.
    #[must_use]
    #[expect(clippy::missing_panics_doc, reason = "a body of one shape exists")]
    pub fn new(robot: Arc<RobotModel>) -> Self {
        let links = robot.link_ids().filter_map(|link| {
            let shapes: Vec<(Pose, &Shape)> =
                robot.link(link).collisions.iter().map(|c| (c.pose_ls, &c.shape)).collect();
            Part::new(link, &shapes)
        });
        let links = links.collect();
        let ball = Shape::Primitive(Primitive::Sphere { radius: 0.0 });
        let point = CollisionBody::new([(&Pose::identity(), &ball)]).expect("there is a shape");
        Self { robot, links, held: Vec::new(), point }
    }

    /// The robot whose points are removed.
    #[must_use]
    pub fn robot(&self) -> &Arc<RobotModel> {
        &self.robot
    }

    /// Sets the attached objects. Objects that were attached before are reused at no cost.
    pub fn hold(&mut self, world: &World) {
        let mut before = std::mem::take(&mut self.held);
        self.held = (world.attached().iter())
            .map(|object| match before.iter().position(|(known, _)| Arc::ptr_eq(known, object)) {
                Some(known) => before.swap_remove(known),
                None => (Arc::clone(object), self.part_of(object)),
            })
            .collect();
    }

    fn part_of(&self, object: &AttachedObject) -> Option<Part> {
        let shapes: Vec<(Pose, &Shape)> =
            object.shapes.iter().map(|s| (object.pose_lo * s.pose_os, &s.shape)).collect();
        Part::new(self.robot.link_by_name(&object.link)?, &shapes)
    }

    /// For each point (root frame), whether it is nearer than `padding` (m) to the robot at these poses.
    #[must_use]
    pub fn is_robot(&self, points: &[Point], poses: &LinkPoses, padding: f64) -> Vec<bool> {
        let parts = self.links.iter().chain(self.held.iter().filter_map(|(_, part)| part.as_ref()));
        let placed: Vec<Placed> = parts.map(|part| part.placed(poses.pose(part.link), padding)).collect();
        let is_near = |p: &Point, scratch: &mut Scratch| {
            let near =
                |part: &&Placed| nalgebra::distance_squared(&part.centre, p) <= part.reach * part.reach;
            placed.iter().filter(near).any(|part| {
                let pose_lp = Pose::from((part.pose_lr * p).coords);
                within_margin(part.body, &self.point, &pose_lp, padding, scratch).is_some()
            })
        };
        (points.par_chunks(CHUNK))
            .map_init(Scratch::default, |scratch, chunk| {
                chunk.iter().map(|p| is_near(p, scratch)).collect::<Vec<bool>>()
            })
            .flatten_iter()
            .collect()
    }
}

impl Part {
    fn new(link: LinkId, shapes: &[(Pose, &Shape)]) -> Option<Self> {
        // a plane is virtual: no sensor measures it
        let seen = shapes.iter().filter(|(_, shape)| !matches!(shape, Shape::Plane(_)));
        // the inside of a closed mesh is part of the robot too
        let body = CollisionBody::with_solid_meshes(seen.map(|(pose, shape)| (pose, *shape)))?;
        Some(Self { link, body })
    }

    fn placed(&self, pose_rl: &Pose, padding: f64) -> Placed<'_> {
        let sphere = self.body.bounding_sphere();
        // slightly enlarged because of rounding
        let reach = (sphere.radius + padding) * (1.0 + 1e-9) + 1e-9;
        Placed { body: &self.body, pose_lr: pose_rl.inverse(), centre: pose_rl * sphere.centre, reach }
    }
}
