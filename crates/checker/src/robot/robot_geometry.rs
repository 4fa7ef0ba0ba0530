//! The robot's kinematic chain, with the bodies that it carries.

use std::collections::HashMap;
use std::ops::Index;
use std::sync::Arc;

use clearance_geometry::math::{Extremes, Point};
use clearance_robot::{
    Chain, Deviations, DisplacementRates, Frame, KinematicPath, LinkPoses, PathsToRoot, Reach, RobotModel,
    SideMotion,
};
use clearance_robot::{Configuration, PlacedFrame};
use clearance_scene::{BodyId, World};

use super::decisive_points::DecisivePoints;
use super::path_sums::PathSums;
use super::robot_body::{RobotBody, SceneOfRobot, robot_bodies};
use crate::capsules::RootCapsule;
use crate::settings_error::SettingsError;

/// A robot with its attached objects: kinematic chain, collision bodies, and bounds on their motion.
///
/// A *part* is the index of a robot body, in the order of the pair list. A *body* is the index of a chain body.
#[derive(Clone, Debug)]
pub struct RobotGeometry {
    model: Arc<RobotModel>,
    chain: Chain,
    parts: Vec<RobotBody>,
    paths_to_root: PathsToRoot,
    path_sums: PathSums,
    decisive_points: DecisivePoints,
    /// Bounds on how far bodies move when joints move.
    displacement_rates: DisplacementRates,
}

impl Index<usize> for RobotGeometry {
    type Output = RobotBody;

    #[inline]
    fn index(&self, part: usize) -> &RobotBody {
        &self.parts[part]
    }
}

impl RobotGeometry {
    /// Collision bodies in `known`, from the same robot, are reused.
    pub fn new(
        model: Arc<RobotModel>,
        scene: SceneOfRobot,
        known: &[RobotBody],
    ) -> Result<Self, SettingsError> {
        let chain = chain(&model, scene.world);
        let parts = robot_bodies(&model, &chain, scene, known)?;
        let paths_to_root = chain.paths_to_root();
        let path_sums = PathSums::new(&paths_to_root, &parts);
        let displacement_rates = displacement_rates(&model, &chain, &parts);
        let decisive_points = DecisivePoints::new(&parts);
        Ok(Self { model, chain, parts, paths_to_root, path_sums, decisive_points, displacement_rates })
    }

    pub fn model(&self) -> &Arc<RobotModel> {
        &self.model
    }

    #[inline]
    pub fn chain(&self) -> &Chain {
        &self.chain
    }

    #[inline]
    pub fn parts(&self) -> &[RobotBody] {
        &self.parts
    }

    /// The part with this id, if there is one.
    pub fn part_of(&self, id: BodyId) -> Option<usize> {
        self.parts.iter().position(|robot_body| robot_body.id() == id)
    }

    /// The parts whose chain bodies fulfil a condition.
    pub fn parts_on(&self, bodies: impl Fn(usize) -> bool) -> impl DoubleEndedIterator<Item = usize> {
        (0..self.parts.len()).filter(move |part| bodies(self.parts[*part].chain_body()))
    }

    /// Points that decide whether parts are inside obstacles.
    #[inline]
    pub fn decisive_points(&self) -> &DecisivePoints {
        &self.decisive_points
    }

    pub fn displacement_rates(&self) -> &DisplacementRates {
        &self.displacement_rates
    }

    pub fn paths_to_root(&self) -> &PathsToRoot {
        &self.paths_to_root
    }

    /// The joints between a part and the root.
    pub fn path_to_root(&self, part: usize) -> KinematicPath<'_> {
        self.paths_to_root.to_root(self.parts[part].chain_body())
    }

    pub fn path_sums(&self) -> &PathSums {
        &self.path_sums
    }

    /// For each part, the values of its paths, for [`PathSums`]: upper bounds on the motion of the part by the first
    /// joints of the path. `range` gives the maximum absolute value of a position.
    pub fn stretched_motions(
        &self,
        deviations: &impl Deviations,
        range: impl Fn(usize) -> f64,
        motions: &mut Vec<f64>,
    ) {
        motions.clear();
        for (robot_body, radius) in self.parts.iter().zip(self.path_sums.radii()) {
            self.chain.stretched_ways(robot_body.chain_body(), *radius, deviations, &range, motions);
        }
    }

    /// The motion of a part relative to the root, from the frames on its path, for points within `reach`.
    pub fn part_motion(
        &self,
        part: usize,
        reach: &Reach,
        frames: &[PlacedFrame],
        deviations: &impl Deviations,
    ) -> SideMotion {
        self.chain.side_motion(self.path_to_root(part).side(0), reach, frames, deviations)
    }

    /// Capsules of all parts with their paddings, in the root frame.
    pub fn padded_capsules(&self, frame: impl Fn(usize) -> Frame<f64>) -> impl Iterator<Item = RootCapsule> {
        self.parts.iter().map(move |robot_body| robot_body.padded_capsule(&frame(robot_body.chain_body())))
    }

    /// Transforms a point from the frame of a part's chain body to the root frame, in a configuration.
    pub fn point_in_root(&self, part: usize, point: &Point, q: &Configuration) -> Point {
        let link = self.parts[part].link();
        let mut poses = LinkPoses::new(&self.model);
        self.model.forward_kinematics(q, &mut poses);
        // the pose of the link in its body gives the frame of the body
        let pose_lb = self.parts[part].pose_bl().inverse();
        poses.pose(link) * pose_lb * point
    }
}

/// The kinematic chain of a robot that carries its attached objects.
fn chain(robot: &RobotModel, world: &World) -> Chain {
    let mut has_geometry: Vec<bool> = robot.links().iter().map(|l| !l.collisions.is_empty()).collect();
    for object in world.attached() {
        if let Some(link) = robot.link_by_name(&object.link) {
            has_geometry[link.index()] = true;
        }
    }
    robot.chain(&has_geometry)
}

/// Bounds on the motion of bodies when joints move, relative to each other and to the world.
fn displacement_rates(robot: &RobotModel, chain: &Chain, parts: &[RobotBody]) -> DisplacementRates {
    let mut reach = vec![0.0_f64; chain.body_count()];
    for robot_body in parts {
        let body = robot_body.chain_body();
        reach[body] = reach[body].greater(robot_body.farther_end() + robot_body.capsule().radius);
    }
    let limited = robot.joint_ids().filter_map(|j| {
        let limits = robot.joint(j).limits?;
        Some((robot.first_position(j)?, [limits.lower, limits.upper]))
    });
    let ranges: HashMap<usize, [f64; 2]> = limited.collect();
    chain.displacement_rates(&reach, |index| ranges.get(&index).copied())
}
