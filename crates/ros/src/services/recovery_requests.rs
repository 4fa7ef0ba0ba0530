//! Processes requests for free states: reads joints and limits of the search, runs it, and reports the result. No I/O.

use std::time::{Duration, Instant};

use clearance_checker::{CollisionChecker, NoFreeState, Recovery, RecoveryOptions, Workspace};
use clearance_monitor::Evaluation;
use clearance_robot::{Configuration, JointId, JointKind, quoted_list};

use crate::messages::clearance_srvs::{FindFreeStateRequest, FindFreeStateResponse};
use crate::messages::collision_state::pair_message;
use crate::services::request_context::{RequestContext, revisions};
use crate::services::request_fields::{deadline, not_negative};
use crate::services::request_rejection::{RequestRejection, bad_request};
use crate::services::state_requests::{MANY_PAIRS, message};

/// Default timeout of a search.
const LONGEST_SEARCH: Duration = Duration::from_secs(1);

/// Responds to a request for a free state.
#[must_use]
pub fn search_free_state(
    request: &FindFreeStateRequest,
    evaluation: Option<&Evaluation>,
    workspace: &mut Option<Workspace>,
) -> FindFreeStateResponse {
    let started = Instant::now();
    let found = RequestContext::of(evaluation).and_then(|context| {
        let options = context.recovery_options(request, started)?;
        let (start, note) = context.state(&request.joint_names, &request.positions)?;
        let memory = workspace.get_or_insert_with(|| context.checker.workspace());
        let recovery = context.checker.find_free_state(&start, &options, memory);
        let recovery = recovery.map_err(|error| bad_request(error.to_string()))?;
        if options.clearance > 0.0 && context.checker.pairs().len() > MANY_PAIRS {
            *workspace = None;
        }
        let limits = context.robot().limits_note("state", [[&start]]);
        Ok(response(context.checker, &start, recovery, [limits, note]))
    });
    let mut response = found.unwrap_or_else(|rejection| rejected_search(&rejection));
    (response.model_revision, response.world_revision) = revisions(evaluation);
    response.compute_time = started.elapsed().as_secs_f64();
    response
}

/// Response to a request for which nothing was searched.
#[must_use]
pub fn rejected_search(rejection: &RequestRejection) -> FindFreeStateResponse {
    FindFreeStateResponse {
        result: FindFreeStateResponse::ERROR,
        message: rejection.message(),
        reason_code: rejection.code().to_owned(),
        ..FindFreeStateResponse::default()
    }
}

impl RequestContext<'_> {
    /// Recovery options of a request: joints, distance, clearance, and the deadline of a search that starts at `started`.
    fn recovery_options(
        &self,
        request: &FindFreeStateRequest,
        started: Instant,
    ) -> Result<RecoveryOptions, RequestRejection> {
        not_negative("max_distance", "rad or m", request.max_distance)?;
        not_negative("clearance", "m", request.clearance)?;
        let deadline = deadline(request.timeout, Some(LONGEST_SEARCH), started)?;
        let options = if request.group.is_empty() {
            RecoveryOptions::default()
        } else {
            let of_group = RecoveryOptions::of_group(self.robot(), &request.group);
            of_group.map_err(|error| bad_request(format!("group: {error}")))?
        };
        let is_default = request.max_distance == 0.0;
        Ok(RecoveryOptions {
            locked: self.locked_joints(&request.locked_joints)?,
            largest_distance: if is_default {
                RecoveryOptions::LARGEST_DISTANCE
            } else {
                request.max_distance
            },
            clearance: request.clearance,
            // only the timeout ends a search
            most_checks: u64::MAX,
            deadline,
            ..options
        })
    }

    fn locked_joints(&self, names: &[String]) -> Result<Vec<JointId>, RequestRejection> {
        let robot = self.robot();
        let unknown = |name: &String| {
            let movable = robot.joints().iter().filter(|joint| joint.kind != JointKind::Fixed);
            let known: Vec<String> = movable.map(|joint| joint.name.clone()).collect();
            let (name, known) = (quoted_list(std::slice::from_ref(name)), quoted_list(&known));
            bad_request(format!("locked_joints: the robot has no joint {name}; it has {known}"))
        };
        names.iter().map(|name| robot.joint_by_name(name).ok_or_else(|| unknown(name))).collect()
    }
}

fn response(
    checker: &CollisionChecker,
    start: &Configuration,
    recovery: Recovery,
    notes: [Option<String>; 2],
) -> FindFreeStateResponse {
    let with_notes = |reason: Option<String>| message(checker, [reason].into_iter().chain(notes));
    let response = FindFreeStateResponse {
        joint_names: checker.robot().position_names().to_vec(),
        start: start.positions().to_vec(),
        ..FindFreeStateResponse::default()
    };
    match recovery {
        Recovery::AlreadyFree => FindFreeStateResponse {
            result: FindFreeStateResponse::ALREADY_FREE,
            message: with_notes(None),
            ..response
        },
        Recovery::Found(found) => FindFreeStateResponse {
            result: FindFreeStateResponse::FOUND,
            message: with_notes(None),
            free_state: found.state.positions().to_vec(),
            distance: found.distance,
            exit: found.exit,
            ..response
        },
        Recovery::NoneFound(none) => FindFreeStateResponse {
            result: FindFreeStateResponse::NONE_FOUND,
            message: with_notes(Some(reason(checker, &none))),
            reason_code: none.reason().to_owned(),
            unmoved_pair: none.unmoved.map(|(a, b)| pair_message(checker, a, b)).unwrap_or_default(),
            ..response
        },
    }
}

/// Why no free state was found, and what the client can do.
fn reason(checker: &CollisionChecker, none: &NoFreeState) -> String {
    let checks = none.checks;
    match none.unmoved {
        Some((a, b)) => {
            let pair = quoted_list(&[a, b].map(|body| checker.body_name(body).to_owned()));
            format!(
                "no joint that may move moves {pair} apart by the clearance: change group, locked_joints or clearance, or the world"
            )
        }
        None if none.is_unfinished => {
            format!("the timeout ended the search after {checks} checked states: allow a longer timeout")
        }
        None => format!(
            "none of {checks} checked states up to max_distance is free with this clearance and has a way out: allow a larger max_distance or less clearance"
        ),
    }
}

#[cfg(test)]
mod tests;
