//! Tests of certificates of motions: an accepted one is free, and is of the requested motion; test helpers.

mod bases;
mod brute_force;
mod command_line;
mod joins;
mod margins;
mod mutations;
mod obstacle_limits;

use clearance::checker::{CollisionChecker, MotionOptions};
use clearance::geometry::math::{Point, Pose, Vector};
use clearance::geometry::{Primitive, Shape, TriangleMesh};
use clearance::motion::{Certificate, MotionSegment, Trajectory};
use clearance::robot::{MeshFiles, RobotModel};
use clearance::scene::Settings;
use clearance::scene::{Obstacle, World};
use clearance::verifier::{Rejection, VerificationStatistics, verify};
use std::sync::Arc;

/// A robot in a world.
pub struct Scene {
    pub robot: Arc<RobotModel>,
    pub world: World,
    pub settings: Settings,
    pub checker: CollisionChecker,
}

impl Scene {
    pub fn new(urdf: &str, world: World) -> Self {
        Self::with_settings(urdf, world, Settings::default())
    }

    pub fn with_settings(urdf: &str, world: World, settings: Settings) -> Self {
        let robot = Arc::new(RobotModel::from_urdf(urdf, &MeshFiles::default()).unwrap());
        let checker = CollisionChecker::new(robot.clone(), &world, settings.clone()).unwrap();
        Self { robot, world, settings, checker }
    }

    pub fn straight(&self, from: &[f64], to: &[f64]) -> MotionSegment {
        let [from, to] = [from, to].map(|q| self.robot.configuration(q).unwrap());
        MotionSegment::straight(&self.robot, &from, &to)
    }

    /// The certificate of a trajectory, if it is free.
    pub fn certify(&self, trajectory: &Trajectory) -> Option<Certificate> {
        let options = MotionOptions::default();
        self.checker.certify_trajectory(trajectory, &options, &mut self.checker.workspace()).1
    }

    /// A document with one honest segment after the other, however these join.
    pub fn spliced(&self, segments: &[MotionSegment]) -> Certificate {
        let mut parts = segments.iter().map(|segment| {
            let options = MotionOptions::default();
            let (report, certificate) =
                self.checker.certify_motion(segment, &options, &mut self.checker.workspace());
            certificate.unwrap_or_else(|| panic!("{report:?}"))
        });
        let mut whole = parts.next().unwrap();
        whole.segments.extend(parts.flat_map(|part| part.segments));
        resign(&mut whole);
        whole
    }

    pub fn verify(&self, certificate: &Certificate) -> Result<VerificationStatistics, Rejection> {
        verify(&self.robot, &self.world, &self.settings, None, certificate)
    }
}

/// Hashes that fit what a document says now, as a forger would write them.
pub fn resign(certificate: &mut Certificate) {
    certificate.motion = certificate.motion_hash();
    certificate.digest = certificate.content_hash();
}

/// A square of two triangles, a metre wide, square to the x axis.
pub fn sheet() -> Shape {
    let p = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(|[y, z]| Point::new(0.0, y, z));
    Shape::Mesh(Arc::new(TriangleMesh::new(p.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap()))
}

pub fn obstacle(name: &str, shape: Shape, centre: [f64; 3]) -> Obstacle {
    Obstacle::of_shape(
        name,
        Pose::from_parts(Vector::from(centre).into(), nalgebra::UnitQuaternion::identity()),
        shape,
    )
}

/// A wall a tenth of a metre thick at x = 0.5.
pub fn wall() -> World {
    let mut world = World::default();
    let shape = Shape::Primitive(Primitive::cuboid([0.05, 1.0, 1.0]).unwrap());
    world.add(obstacle("wall", shape, [0.5, 0.0, 0.0])).unwrap();
    world
}
