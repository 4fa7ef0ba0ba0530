//! Processes motion requests: converts names and numbers to motions, and results to messages. No I/O.

use std::time::{Duration, Instant};

use clearance_checker::{
    CollisionChecker, MotionOptions, MotionOrder, MotionVerdict, TrajectoryReport, Watch, Workspace,
};
use clearance_monitor::Evaluation;
use clearance_motion::{
    Certificate, ContinuousDirection, ContinuousTurn, HeldTurn, MotionSegment, Trajectory, TrajectoryPoint,
    shortest_turns,
};
use clearance_robot::{Configuration, RobotModel};
use ros2_interfaces_jazzy_serde::trajectory_msgs::msg::JointTrajectoryPoint;
use ros2_interfaces_jazzy_serde::visualization_msgs::msg::MarkerArray;

use crate::messages::clearance_srvs::{
    CheckMotionRequest, CheckTrajectoryRequest, CheckTrajectoryResponse, ContinuousTurns, MotionFindings,
    MotionTerms,
};
use crate::messages::collision_state::pair_message;
use crate::messages::time_and_geometry::point_message;
use crate::services::motion_distances::DistanceRequest;
use crate::services::request_context::{RequestContext, revisions};
use crate::services::request_fields::{deadline, not_negative, of_equal_length};
use crate::services::request_rejection::{RequestRejection, bad_request, shortened};
use crate::services::requested_obstacles::with_requested_obstacles;
use crate::topics::swept_volume_markers::{most_intervals, no_markers, swept_volume_markers};

/// Maximum size of a certificate that is sent (bytes): `RustDDS` loses messages of more than about 250 kB.
const LONGEST_CERTIFICATE: usize = 200_000;

/// Minimum size of one proof in a certificate (bytes): `[0,0.0,1.0,0.1,0.1],`.
const SHORTEST_PROOF: usize = 20;

/// Maximum number of pair evaluations per segment: some seconds, and memory that an ordinary machine has.
const LOOKS: u64 = 2_000_000;

/// Default timeout of checks that cannot be canceled, because other requests wait in the queue.
pub const LONGEST: Duration = Duration::from_secs(60);

/// Response with the optional results that the request selects.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionResponse {
    /// For a straight motion, only the first part of this response is sent.
    pub response: CheckTrajectoryResponse,
    pub certificate: Option<String>,
    pub swept_volume: Option<MarkerArray>,
}

impl From<&RequestRejection> for MotionResponse {
    fn from(rejection: &RequestRejection) -> Self {
        let motion = MotionFindings {
            verdict: MotionFindings::ERROR,
            message: rejection.message(),
            reason_code: rejection.code().to_owned(),
            distance_upper: f64::INFINITY,
            ..MotionFindings::default()
        };
        Self { response: CheckTrajectoryResponse::unchecked(motion), certificate: None, swept_volume: None }
    }
}

/// Responds to a request for a straight motion. From the current state, continuous joints move in the direction
/// `default_direction`, unless the request contains another one. The workspace is memory that is reused to make later
/// checks faster.
#[must_use]
pub fn evaluate_motion(
    request: &CheckMotionRequest,
    default_direction: ContinuousDirection,
    evaluation: Option<&Evaluation>,
    workspace: &mut Option<Workspace>,
) -> MotionResponse {
    evaluate(&request.terms, None, evaluation, workspace, |context| {
        context.straight(request, default_direction)
    })
}

/// Responds to a request for a trajectory. With `watch`, the check can be observed and canceled.
#[must_use]
pub fn evaluate_trajectory(
    request: &CheckTrajectoryRequest,
    watch: Option<Watch>,
    evaluation: Option<&Evaluation>,
    workspace: &mut Option<Workspace>,
) -> MotionResponse {
    evaluate(&request.terms, watch, evaluation, workspace, |context| context.trajectory(request))
}

fn evaluate(
    terms: &MotionTerms,
    watch: Option<Watch>,
    evaluation: Option<&Evaluation>,
    workspace: &mut Option<Workspace>,
    motion: impl FnOnce(&RequestContext) -> Result<RequestedMotion, RequestRejection>,
) -> MotionResponse {
    let started = Instant::now();
    let found = RequestContext::of(evaluation).and_then(|context| {
        // a watched check can be canceled, so it needs no default timeout
        let default_timeout = watch.is_none().then_some(LONGEST);
        let options = MotionOptions { watch, ..options(terms, default_timeout, started)? };
        let requested = motion(&context)?;
        check_intervals(terms.swept_volume_intervals, &requested.trajectory, context.robot())?;
        let workspace = workspace.get_or_insert_with(|| context.checker.workspace());
        Ok(check(context.checker, requested, &options, terms, workspace))
    });
    let mut response = found.unwrap_or_else(|rejection| MotionResponse::from(&rejection));
    if terms.swept_volume_intervals > 0 {
        // a request without volumes of its own still deletes the volumes of the last request
        response.swept_volume.get_or_insert_with(no_markers);
    }
    let motion = &mut response.response.motion;
    (motion.model_revision, motion.world_revision) = revisions(evaluation);
    motion.compute_time = started.elapsed().as_secs_f64();
    response
}

pub fn options(
    terms: &MotionTerms,
    default_timeout: Option<Duration>,
    started: Instant,
) -> Result<MotionOptions, RequestRejection> {
    let standard = MotionOptions::default();
    not_negative("tolerance", "m", terms.tolerance)?;
    not_negative("event_distance", "m", terms.event_distance)?;
    not_negative("margin", "m", terms.margin)?;
    Ok(MotionOptions {
        tolerance: if terms.tolerance > 0.0 { terms.tolerance } else { standard.tolerance },
        margin: terms.margin,
        order: if terms.any_contact { MotionOrder::Any } else { MotionOrder::Earliest },
        deadline: deadline(terms.timeout, default_timeout, started)?,
        budget: LOOKS,
        ..standard
    })
}

/// Motion in a request.
struct RequestedMotion {
    trajectory: Trajectory,
    /// Notes for the client.
    notes: Vec<String>,
}

/// Direction of continuous joints, if the request contains one.
pub fn direction(terms: &MotionTerms) -> Result<Option<ContinuousDirection>, RequestRejection> {
    match terms.continuous_joint_direction {
        MotionTerms::DEFAULT => Ok(None),
        MotionTerms::SHORTEST => Ok(Some(ContinuousDirection::Shortest)),
        MotionTerms::AS_GIVEN => Ok(Some(ContinuousDirection::AsGiven)),
        other => Err(bad_request(format!(
            "continuous_joint_direction is {other}, but must be DEFAULT (0), SHORTEST (1) or AS_GIVEN (2)"
        ))),
    }
}

impl RequestContext<'_> {
    fn straight(
        &self,
        request: &CheckMotionRequest,
        default_direction: ContinuousDirection,
    ) -> Result<RequestedMotion, RequestRejection> {
        let CheckMotionRequest { joint_names, start, goal, terms, duration } = request;
        if joint_names.is_empty() {
            return Err(bad_request("joint_names is empty"));
        }
        let named = self.named("joint_names", joint_names)?;
        let (rest, note) = self.rest(&named)?;
        let end = |what: &str, numbers: &[f64]| {
            of_equal_length(what, numbers, joint_names)?;
            named.configuration(&rest, numbers).map_err(|error| bad_request(format!("{what}: {error}")))
        };
        let from = match (start.as_slice(), &self.now) {
            ([], Ok(now)) => (*now).clone(),
            ([], Err(why)) => return Err(RequestRejection::NoJointState(why.clone())),
            (start, _) => end("start", start)?,
        };
        let requested_direction = direction(terms)?;
        let from_now = if start.is_empty() { default_direction } else { ContinuousDirection::AsGiven };
        let mut notes = Vec::from_iter(note);
        let mut ends = vec![from, end("goal", goal)?];
        if requested_direction.unwrap_or(from_now) == ContinuousDirection::Shortest {
            let (short, held) = self.shortest(ends)?;
            ends = short;
            if requested_direction.is_some()
                && let Some(held) = held.first()
            {
                return Err(bad_request(format!("continuous_joint_direction: {held}")));
            }
            notes.extend(held.iter().map(|held| format!("{held}; it is checked as given")));
        }
        let segment = MotionSegment::straight(self.robot(), &ends[0], &ends[1]);
        let trajectory = timed(segment, *duration)?;
        let trajectory = self.loosened(trajectory, joint_names, &terms.joint_tolerances)?;
        Ok(RequestedMotion { trajectory: self.among_moving_obstacles(trajectory, terms)?, notes })
    }

    /// The ends of a motion by half a turn at most, and the joints that cannot move so.
    pub fn shortest(
        &self,
        ends: Vec<Configuration>,
    ) -> Result<(Vec<Configuration>, Vec<HeldTurn>), RequestRejection> {
        shortest_turns(self.robot(), ends).map_err(|error| bad_request(format!("the shortest way: {error}")))
    }

    fn trajectory(&self, request: &CheckTrajectoryRequest) -> Result<RequestedMotion, RequestRejection> {
        let joints = &request.trajectory.joint_names;
        if joints.is_empty() {
            return Err(bad_request("trajectory.joint_names is empty"));
        }
        let (rest, note) = self.rest(&self.named("trajectory.joint_names", joints)?)?;
        let point = |p: &JointTrajectoryPoint| {
            let time = &p.time_from_start;
            TrajectoryPoint {
                positions: p.positions.clone(),
                velocities: p.velocities.clone(),
                accelerations: p.accelerations.clone(),
                time_from_start: TrajectoryPoint::seconds(time.sec, time.nanosec.into()),
            }
        };
        let points: Vec<TrajectoryPoint> = request.trajectory.points.iter().map(point).collect();
        let direction = direction(&request.terms)?.unwrap_or_default();
        let trajectory =
            Trajectory::from_points_with_direction(self.robot(), joints, &points, &rest, direction)
                .map_err(|error| bad_request(format!("trajectory: {error}")))?;
        let trajectory = self.loosened(trajectory, joints, &request.terms.joint_tolerances)?;
        let trajectory = self.among_moving_obstacles(trajectory, &request.terms)?;
        let notes = note.into_iter().chain(trajectory.late_start_note()).collect();
        Ok(RequestedMotion { trajectory, notes })
    }

    /// Lets obstacles move as the request says.
    fn among_moving_obstacles(
        &self,
        trajectory: Trajectory,
        terms: &MotionTerms,
    ) -> Result<Trajectory, RequestRejection> {
        with_requested_obstacles(trajectory, terms, self.checker.world())
    }

    /// Adds tolerances (rad, m), one for each of `joints`; an empty list keeps the motion exact.
    fn loosened(
        &self,
        trajectory: Trajectory,
        joints: &[String],
        tolerances: &[f64],
    ) -> Result<Trajectory, RequestRejection> {
        if tolerances.is_empty() {
            return Ok(trajectory);
        }
        of_equal_length("joint_tolerances", tolerances, joints)?;
        let named = self.named("joint_names", joints)?;
        let reject = |error: &dyn std::fmt::Display| bad_request(format!("joint_tolerances: {error}"));
        let tube = named.tolerances(tolerances).map_err(|error| reject(&error))?;
        trajectory
            .map(|segment| segment.with_tube(self.robot(), tube.clone()))
            .map_err(|error| reject(&error))
    }
}

/// A motion that takes so many seconds; 0: it has no times.
fn timed(segment: MotionSegment, duration: f64) -> Result<Trajectory, RequestRejection> {
    not_negative("duration", "s", duration)?;
    let trajectory =
        Trajectory::of_segments(vec![segment]).map_err(|error| bad_request(error.to_string()))?;
    if duration == 0.0 {
        return Ok(trajectory);
    }
    trajectory.with_times(vec![0.0, duration]).map_err(|error| bad_request(format!("duration: {error}")))
}

/// Rejects more volumes than fit into one message.
fn check_intervals(
    intervals: u32,
    trajectory: &Trajectory,
    robot: &RobotModel,
) -> Result<(), RequestRejection> {
    let segments = trajectory.segments().len();
    let most = most_intervals(robot, segments);
    if intervals as usize <= most {
        return Ok(());
    }
    let instead = if most == 0 { "ask about fewer points at a time" } else { "ask for fewer" };
    Err(bad_request(format!(
        "swept_volume_intervals is {intervals}, but the volumes of at most {most} intervals in each of {segments} segments fit into one \
         message: {instead}"
    )))
}

fn check(
    checker: &CollisionChecker,
    RequestedMotion { trajectory, notes: of_request }: RequestedMotion,
    options: &MotionOptions,
    terms: &MotionTerms,
    workspace: &mut Workspace,
) -> MotionResponse {
    let (trajectory, certificate) = (&trajectory, terms.certificate);
    let ends: Vec<Configuration> = trajectory.segments().iter().flat_map(MotionSegment::ends).collect();
    let limits = checker.robot().limits_note("way", [&ends]);
    // a long message is truncated at its end: the note about the checked motion comes first
    let long_turn = trajectory.long_turn_note(checker.robot());
    let mut notes: Vec<String> = long_turn.into_iter().chain(limits).chain(of_request).collect();
    let segments = trajectory.segments().len();
    let is_too_long = segments * checker.pairs().len() * SHORTEST_PROOF > LONGEST_CERTIFICATE;
    let (report, proof) = if certificate && !is_too_long {
        checker.certify_trajectory(trajectory, options, workspace)
    } else {
        (checker.check_trajectory(trajectory, options, workspace), None)
    };
    let mut response = response(checker, trajectory, &report, options.margin);
    response.distances = DistanceRequest { checker, options, terms }.along(trajectory, workspace);
    let motion = &mut response.motion;
    let text = proof.as_ref().map(Certificate::to_json).filter(|t| t.len() <= LONGEST_CERTIFICATE);
    if certificate && report.is_free() && text.is_none() {
        notes.push(format!(
            "the certificate is longer than the {LONGEST_CERTIFICATE} bytes that can be sent: \
             use clearance motion --certificate, or ask about fewer points at a time"
        ));
    }
    let swept_volume = (terms.swept_volume_intervals > 0).then(|| {
        swept_volume_markers(checker, trajectory, &report, terms.swept_volume_intervals as usize, workspace)
    });
    if matches!(swept_volume, Some(None)) {
        notes.push("the volumes swept over are too large to be shown".to_owned());
    }
    if checker.pairs().is_empty() {
        notes.push("there is no pair to check: every motion counts as free".to_owned());
    }
    if !motion.message.is_empty() {
        notes.insert(0, std::mem::take(&mut motion.message));
    }
    motion.message = shortened(notes.join("; "));
    if let (Some(text), Some(proof)) = (&text, proof) {
        motion.certificate_digest = proof.digest;
        motion.certificate.clone_from(text);
    }
    MotionResponse { response, certificate: text, swept_volume: swept_volume.flatten() }
}

/// Content of a report as a response, without the revisions and the compute time.
fn response(
    checker: &CollisionChecker,
    trajectory: &Trajectory,
    report: &TrajectoryReport,
    margin: f64,
) -> CheckTrajectoryResponse {
    let mut motion = MotionFindings::default();
    let mut t = [1.0, 1.0];
    match report.verdict {
        MotionVerdict::Free => {
            motion.verdict = MotionFindings::FREE;
            motion.distance_upper = f64::INFINITY;
        }
        MotionVerdict::Contact { t: found, pair: (a, b), witness } => {
            motion.verdict = MotionFindings::CONTACT;
            motion.distance_upper = margin;
            motion.pair = pair_message(checker, a, b);
            motion.witness_known = witness.is_some();
            motion.witness_point = witness.as_ref().map(point_message).unwrap_or_default();
            t = found;
        }
        MotionVerdict::Undecided { t: found, pair, distance, reason } => {
            motion.verdict = MotionFindings::UNDECIDED;
            motion.message = reason.to_string();
            if let Some((a, b)) = pair {
                motion.pair = pair_message(checker, a, b);
                motion.message = format!("{} and {}: {reason}", motion.pair.body_a, motion.pair.body_b);
            }
            reason.code().clone_into(&mut motion.reason_code);
            [motion.distance_lower, motion.distance_upper] = distance;
            t = found;
        }
    }
    let time = |t| trajectory.time(report.segment, t).unwrap_or(f64::NAN);
    let [time_free, time_contact] = report.time.unwrap_or_else(|| t.map(time));
    // moving obstacles may have split segments of the request
    let [(segment, t_free), (_, t_contact)] = t.map(|t| trajectory.origin(report.segment, t));
    [motion.t_free, motion.t_contact] = [t_free, t_contact];
    let segment = u32::try_from(segment).unwrap_or(u32::MAX);
    let turns = turns(trajectory.continuous_turns(checker.robot()));
    CheckTrajectoryResponse { motion, segment, time_free, time_contact, turns, ..Default::default() }
}

fn turns(turns: Vec<ContinuousTurn>) -> ContinuousTurns {
    let mut message = ContinuousTurns::default();
    for ContinuousTurn { joint, from, to } in turns {
        message.continuous_joints.push(joint);
        message.continuous_starts.push(from);
        message.continuous_goals.push(to);
    }
    message
}

#[cfg(test)]
mod tests;
