//! Context of a request: the robot, its world, and its current configuration. No I/O.

use clearance_checker::CollisionChecker;
use clearance_monitor::{Evaluation, Reason};
use clearance_robot::quoted_list;
use clearance_robot::{Configuration, NamedJoints, RobotModel};

use crate::services::request_fields::of_equal_length;
use crate::services::request_rejection::{RequestRejection, bad_request};

/// Context of a request: the robot, its world, and its current configuration.
pub struct RequestContext<'a> {
    pub checker: &'a CollisionChecker,
    /// Current configuration, or the reason why it is unknown.
    pub now: Result<&'a Configuration, String>,
    /// Whether the received joint states are contradictory: then the robot is not at its default configuration, but at
    /// an unknown one.
    pub is_contradicted: bool,
}

impl<'a> RequestContext<'a> {
    pub fn of(evaluation: Option<&'a Evaluation>) -> Result<Self, RequestRejection> {
        let reason = evaluation.and_then(|evaluation| evaluation.status.reason());
        let why = reason.unwrap_or(&Reason::NoModel { fault: None });
        let revision = evaluation.and_then(|evaluation| evaluation.revision.as_ref());
        // while another robot is being built, no robot is valid, even if checking is disabled
        if evaluation.is_some_and(|evaluation| evaluation.is_swapping) {
            return Err(RequestRejection::NoModel(Reason::ModelSwap.to_string()));
        }
        let revision = revision.ok_or_else(|| RequestRejection::NoModel(why.to_string()))?;
        if !revision.has_geometry() {
            return Err(RequestRejection::NoModel(Reason::NoGeometry.to_string()));
        }
        if let Some(stale) = evaluation.and_then(|evaluation| evaluation.stale_world.as_ref()) {
            return Err(RequestRejection::of_world(stale));
        }
        let robot_state = evaluation.and_then(|evaluation| evaluation.robot_state.as_ref());
        let now =
            robot_state.map(|checked_state| &checked_state.configuration).ok_or_else(|| why.to_string());
        let is_contradicted = now.is_err() && why.is_about_positions();
        Ok(Self { checker: &revision.checker, now, is_contradicted })
    }

    pub fn robot(&self) -> &'a RobotModel {
        self.checker.robot()
    }

    /// Finds the joints that a request names.
    pub fn named(&self, field: &str, names: &[String]) -> Result<NamedJoints<'a>, RequestRejection> {
        let named = self.robot().named_joints(names.iter().map(String::as_str));
        named.map_err(|error| bad_request(format!("{field}: {error}")))
    }

    /// The state of a request about one state, and a note for the client. Without names it is the current one.
    pub fn state(
        &self,
        joint_names: &[String],
        positions: &[f64],
    ) -> Result<(Configuration, Option<String>), RequestRejection> {
        of_equal_length("positions", positions, joint_names)?;
        match &self.now {
            Err(why) if joint_names.is_empty() => Err(RequestRejection::NoJointState(why.clone())),
            _ => {
                let named = self.named("joint_names", joint_names)?;
                let (rest, note) = self.rest(&named)?;
                let state = named.configuration(&rest, positions);
                Ok((state.map_err(|error| bad_request(format!("positions: {error}")))?, note))
            }
        }
    }

    /// Configuration for the joints that the request does not name, and a note if it is unknown.
    ///
    /// # Errors
    /// Fails if a joint is not named and the joint states contradict each other.
    pub fn rest(&self, named: &NamedJoints) -> Result<(Configuration, Option<String>), RequestRejection> {
        let robot = self.robot();
        let why = match &self.now {
            Ok(now) => return Ok(((*now).clone(), None)),
            Err(why) => why,
        };
        let others = undecided(robot, named);
        if self.is_contradicted && !others.is_empty() {
            return Err(RequestRejection::NoJointState(why.clone()));
        }
        let note = (!others.is_empty()).then(|| {
            format!("{} stand at their defaults, for there is no joint state: {why}", quoted_list(&others))
        });
        Ok((robot.default_configuration(), note))
    }
}

/// Names of the positions that the named joints do not determine.
pub fn undecided(robot: &RobotModel, named: &NamedJoints) -> Vec<String> {
    let names = robot.position_names().iter().enumerate();
    names.filter(|(position, _)| !named.decides(*position)).map(|(_, name)| name.clone()).collect()
}

/// Revisions of the robot and the world in an evaluation.
pub fn revisions(evaluation: Option<&Evaluation>) -> (u64, u64) {
    let revision = evaluation.and_then(|evaluation| evaluation.revision.as_ref());
    revision.map_or((0, 0), |revision| (revision.model, revision.world))
}
