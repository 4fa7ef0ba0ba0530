//! Data that a verifier derives from robot, world and settings before it reads a certificate: bodies and pairs.

use clearance_motion::{certificate_parts, model_fingerprint, world_fingerprint};
use clearance_robot::{LinkId, RobotModel};
use clearance_scene::{AllowedCollisionMatrix, Settings, World};
use std::sync::atomic::{AtomicBool, Ordering};

use super::body::Body;
use super::certificate_content::RequiredContent;
use super::segment_kinematics::link_paths;
use super::{Rejection, body_geometry, required_pairs};

/// Required content of a certificate, and the bodies with the steps that move them; the same for every certificate.
#[derive(Debug)]
pub(super) struct VerifierModel<'r> {
    pub robot: &'r RobotModel,
    pub world: &'r World,
    pub required: RequiredContent,
    /// By link, by attached object, then by obstacle; `None` without shapes or without a pair.
    pub bodies: Vec<Option<Body>>,
    /// By link and attached object: the link whose pose it has.
    pub carriers: Vec<LinkId>,
    /// By link and attached object: indices of the steps that move it, the root's first.
    pub paths: Vec<Vec<usize>>,
    /// True once the verification is to end early.
    pub stop: Option<&'r AtomicBool>,
}

impl<'r> VerifierModel<'r> {
    pub fn new(
        robot: &'r RobotModel,
        world: &'r World,
        settings: &Settings,
        matrix: Option<&AllowedCollisionMatrix>,
    ) -> Result<Self, Rejection> {
        let pairs = required_pairs::pairs(robot, world, settings, matrix)?;
        let bodies = body_geometry::bodies(robot, world, settings, &pairs)?;
        let model = model_fingerprint(robot, settings, matrix);
        let parts = certificate_parts(robot, world, settings);
        let required = RequiredContent { model, world: world_fingerprint(world), parts, pairs };
        let carriers = body_geometry::carriers(robot, world)?;
        let of_links = link_paths(robot);
        let paths = carriers.iter().map(|link| of_links[link.index()].clone()).collect();
        Ok(Self { robot, world, required, bodies, carriers, paths, stop: None })
    }

    /// Called before each proof.
    ///
    /// # Errors
    /// If the verification is to end early.
    pub fn check_stop(&self) -> Result<(), Rejection> {
        let is_stopped = self.stop.is_some_and(|stop| stop.load(Ordering::Relaxed));
        if is_stopped { Err(Rejection::Stopped) } else { Ok(()) }
    }
}
