//! Processes requests for many straight motions: `~/check_motions`. No I/O.

use std::time::Instant;

use clearance_checker::{
    CollisionChecker, MotionClearance, MotionOptions, MotionReport, MotionVerdict, UndecidedReason, Workspace,
};
use clearance_monitor::Evaluation;
use clearance_motion::{ContinuousDirection, MotionSegment, Trajectory};
use clearance_robot::{Configuration, NamedJoints};

use crate::messages::clearance_srvs::{CheckMotionsRequest, CheckMotionsResponse, MotionTerms};
use crate::services::batch_distances::{add_clearance, add_event, reason_constant};
use crate::services::body_list::{BodyList, NOBODY};
use crate::services::motion_distances::clearance_options;
use crate::services::motion_requests::{LONGEST, direction, options};
use crate::services::request_context::{RequestContext, revisions};
use crate::services::request_fields::of_equal_length;
use crate::services::request_rejection::{RequestRejection, bad_request, shortened};

/// Maximum number of motions per request: they take about a second, while other requests wait.
const MOTIONS: usize = 10_000;

/// Responds to a request for many motions. The workspace is memory that is reused to make later checks faster.
#[must_use]
pub fn evaluate_motions(
    request: &CheckMotionsRequest,
    evaluation: Option<&Evaluation>,
    workspace: &mut Option<Workspace>,
) -> CheckMotionsResponse {
    let started = Instant::now();
    let found = RequestContext::of(evaluation).and_then(|context| {
        let terms = request.terms();
        let options = options(&terms, Some(LONGEST), started)?;
        let batch = context.motions(request)?;
        let workspace = workspace.get_or_insert_with(|| context.checker.workspace());
        Ok(check(context.checker, batch, &options, &terms, workspace))
    });
    let mut response = found.unwrap_or_else(|rejection| rejected_motions(&rejection));
    (response.model_revision, response.world_revision) = revisions(evaluation);
    response.compute_time = started.elapsed().as_secs_f64();
    response
}

/// Response to a batch that was not checked.
#[must_use]
pub fn rejected_motions(rejection: &RequestRejection) -> CheckMotionsResponse {
    CheckMotionsResponse {
        verdict: CheckMotionsResponse::ERROR,
        message: rejection.message(),
        reason_code: rejection.code().to_owned(),
        ..CheckMotionsResponse::default()
    }
}

/// Motions of a request.
struct RequestedMotions {
    joint_names: Vec<String>,
    segments: Vec<MotionSegment>,
    /// Notes for the client.
    notes: Vec<String>,
}

impl RequestContext<'_> {
    fn motions(&self, request: &CheckMotionsRequest) -> Result<RequestedMotions, RequestRejection> {
        let joint_names = self.moving_joints(request)?;
        let joints = joint_names.len();
        let CheckMotionsRequest { starts, goals, other_joints, other_positions, .. } = request;
        check_counts(starts.len(), goals.len(), joints)?;
        if other_positions.len() != other_joints.len() {
            let (given, names) = (other_positions.len(), other_joints.len());
            let message = format!("other_positions has {given} numbers, but other_joints has {names} names");
            return Err(bad_request(message));
        }
        let all = [joint_names.as_slice(), other_joints].concat();
        let named = self.named("joint_names and other_joints", &all)?;
        let (rest, note) = self.rest(&named)?;
        let rows = Rows { named: &named, rest: &rest, others: other_positions };
        let direction = direction(&request.terms())?.unwrap_or_default();
        let tube = self.tube(&joint_names, &request.joint_tolerances)?;
        let mut notes = BatchNotes::default();
        let mut segments = Vec::with_capacity(starts.len() / joints);
        for (i, (start, goal)) in starts.chunks_exact(joints).zip(goals.chunks_exact(joints)).enumerate() {
            let reject = |error: &dyn std::fmt::Display| bad_request(format!("motion {i}: {error}"));
            let mut ends = vec![rows.end(i, "start", start)?, rows.end(i, "goal", goal)?];
            if direction == ContinuousDirection::Shortest {
                let (short, held) = self.shortest(ends)?;
                ends = short;
                if let Some(held) = held.first() {
                    return Err(reject(&format!("continuous_joint_direction: {held}")));
                }
            }
            let mut segment = MotionSegment::straight(self.robot(), &ends[0], &ends[1]);
            if let Some(tube) = &tube {
                segment = segment
                    .with_tube(self.robot(), tube.clone())
                    .map_err(|error| bad_request(format!("joint_tolerances: {error}")))?;
            }
            let trajectory =
                Trajectory::of_segments(vec![segment.clone()]).map_err(|error| reject(&error))?;
            notes.add(i, trajectory.long_turn_note(self.robot()));
            segments.push(segment);
        }
        let ends: Vec<[Configuration; 2]> = segments.iter().map(MotionSegment::ends).collect();
        let limits = self.robot().limits_note("motion", &ends);
        Ok(RequestedMotions { joint_names, segments, notes: notes.finish(limits.into_iter().chain(note)) })
    }

    /// The joints of starts and goals: those that are named, or those of the group.
    fn moving_joints(&self, request: &CheckMotionsRequest) -> Result<Vec<String>, RequestRejection> {
        let CheckMotionsRequest { joint_names, group, .. } = request;
        if !group.is_empty() && !joint_names.is_empty() {
            return Err(bad_request("both joint_names and group are given: give one of them"));
        }
        if group.is_empty() {
            let is_empty = || bad_request("joint_names is empty: name the joints, or a group");
            return if joint_names.is_empty() { Err(is_empty()) } else { Ok(joint_names.clone()) };
        }
        let of_group = self.robot().joint_group(group);
        let of_group = of_group.map_err(|error| bad_request(format!("group: {error}")))?;
        if of_group.is_empty() {
            return Err(bad_request(format!("group: '{group}' has no joint that moves")));
        }
        Ok(of_group.joint_names().to_vec())
    }

    /// By position of the robot: the tolerance (rad, m); none without tolerances.
    fn tube(&self, joint_names: &[String], tolerances: &[f64]) -> Result<Option<Vec<f64>>, RequestRejection> {
        if tolerances.is_empty() {
            return Ok(None);
        }
        of_equal_length("joint_tolerances", tolerances, joint_names)?;
        let named = self.named("joint_names", joint_names)?;
        let tube = named.tolerances(tolerances);
        tube.map(Some).map_err(|error| bad_request(format!("joint_tolerances: {error}")))
    }
}

/// Rejects numbers that are not a start and a goal for each motion.
fn check_counts(starts: usize, goals: usize, joints: usize) -> Result<(), RequestRejection> {
    if starts == 0 || !starts.is_multiple_of(joints) {
        return Err(bad_request(format!(
            "starts has {starts} numbers, but must have one for each of the {joints} joints for each motion"
        )));
    }
    if goals != starts {
        return Err(bad_request(format!("goals has {goals} numbers, but starts has {starts}")));
    }
    if starts / joints > MOTIONS {
        return Err(bad_request(format!(
            "starts has {} motions, but at most {MOTIONS} are checked at a time: ask more often",
            starts / joints
        )));
    }
    Ok(())
}

/// Conversion of rows of numbers to configurations.
struct Rows<'a> {
    named: &'a NamedJoints<'a>,
    rest: &'a Configuration,
    /// Positions of the joints that do not move.
    others: &'a [f64],
}

impl Rows<'_> {
    fn end(&self, motion: usize, what: &str, row: &[f64]) -> Result<Configuration, RequestRejection> {
        let values = [row, self.others].concat();
        let end = self.named.configuration(self.rest, &values);
        end.map_err(|error| bad_request(format!("motion {motion}: {what}: {error}")))
    }
}

/// Notes about single motions: the first one, and the number of others.
#[derive(Default)]
struct BatchNotes {
    first: Option<String>,
    others: usize,
}

impl BatchNotes {
    fn add(&mut self, motion: usize, note: Option<String>) {
        match note {
            Some(note) if self.first.is_none() => self.first = Some(format!("motion {motion}: {note}")),
            Some(_) => self.others += 1,
            None => {}
        }
    }

    fn finish(self, more: impl Iterator<Item = String>) -> Vec<String> {
        let others = match self.others {
            0 => String::new(),
            others => format!(" (and {others} more motions)"),
        };
        self.first.map(|note| note + &others).into_iter().chain(more).collect()
    }
}

fn check(
    checker: &CollisionChecker,
    batch: RequestedMotions,
    options: &MotionOptions,
    terms: &MotionTerms,
    workspace: &mut Workspace,
) -> CheckMotionsResponse {
    let mut response = BatchResponse::new(checker);
    let of_clearance = clearance_options(options);
    for segment in &batch.segments {
        // no check starts after the deadline
        let is_over = || options.deadline.is_some_and(|deadline| Instant::now() >= deadline);
        response.add((!is_over()).then(|| checker.check_motion_with(segment, options, workspace)).as_ref());
        if terms.with_clearance {
            let found = (!is_over()).then(|| checker.clearance_along(segment, &of_clearance, workspace));
            response.add_clearance(found.as_ref());
        }
        if terms.event_distance > 0.0 {
            let distance = terms.event_distance;
            let report = (!is_over()).then(|| checker.event_distance(segment, distance, options, workspace));
            response.add_event(report.as_ref());
        }
    }
    response.finish(batch)
}

/// Builder of the response, motion by motion.
struct BatchResponse<'a> {
    checker: &'a CollisionChecker,
    bodies: BodyList,
    undecided: BatchNotes,
    response: CheckMotionsResponse,
}

impl<'a> BatchResponse<'a> {
    fn new(checker: &'a CollisionChecker) -> Self {
        let response = CheckMotionsResponse { verdict: CheckMotionsResponse::FREE, ..Default::default() };
        Self { checker, bodies: BodyList::new(), undecided: BatchNotes::default(), response }
    }

    /// Adds the result of the next motion; `None` if it was not checked before the deadline.
    fn add(&mut self, report: Option<&MotionReport>) {
        let deadline = ([0.0, 1.0], None, UndecidedReason::Deadline);
        let (verdict, (t, pair, reason)) = match report.map(|report| &report.verdict) {
            Some(MotionVerdict::Free) => {
                (CheckMotionsResponse::FREE, ([1.0; 2], None, CheckMotionsResponse::REASON_NONE))
            }
            Some(MotionVerdict::Contact { t, pair, .. }) => {
                (CheckMotionsResponse::CONTACT, (*t, Some(*pair), CheckMotionsResponse::REASON_NONE))
            }
            undecided => {
                let (t, pair, reason) = match undecided {
                    Some(MotionVerdict::Undecided { t, pair, reason, .. }) => (*t, *pair, *reason),
                    _ => deadline,
                };
                let motion = self.response.verdicts.len();
                let bodies = pair.map_or_else(String::new, |(a, b)| {
                    format!("{} and {}: ", self.checker.body_name(a), self.checker.body_name(b))
                });
                self.undecided.add(motion, Some(format!("{bodies}{reason}")));
                (CheckMotionsResponse::UNDECIDED, (t, pair, reason_constant(Some(reason))))
            }
        };
        let mut index = |body| self.bodies.index(self.checker, body);
        let (a, b) = pair.map_or((NOBODY, NOBODY), |(a, b)| (index(a), index(b)));
        let response = &mut self.response;
        response.verdicts.push(verdict);
        response.reasons.push(reason);
        response.t_free.push(t[0]);
        response.t_contact.push(t[1]);
        response.pair_a.push(a);
        response.pair_b.push(b);
        response.verdict = match (response.verdict, verdict) {
            (CheckMotionsResponse::CONTACT, _) => CheckMotionsResponse::CONTACT,
            (worst, CheckMotionsResponse::FREE) => worst,
            (_, verdict) => verdict,
        };
    }

    fn add_clearance(&mut self, found: Option<&MotionClearance>) {
        add_clearance(&mut self.response.clearances, found, self.checker, &mut self.bodies);
    }

    fn add_event(&mut self, report: Option<&MotionReport>) {
        add_event(&mut self.response.events, report, self.checker, &mut self.bodies);
    }

    fn finish(self, RequestedMotions { joint_names, notes, .. }: RequestedMotions) -> CheckMotionsResponse {
        let nothing = (self.checker.pairs().is_empty())
            .then(|| "there is no pair to check: every motion counts as free".to_owned());
        let mut notes = self.undecided.finish(notes.into_iter());
        notes.extend(nothing);
        let mut response = self.response;
        response.message = shortened(notes.join("; "));
        let reasons =
            [&response.reasons, &response.clearances.clearance_reasons, &response.events.event_reasons];
        if reasons.iter().any(|reasons| reasons.contains(&CheckMotionsResponse::REASON_DEADLINE)) {
            "deadline".clone_into(&mut response.reason_code);
        }
        CheckMotionsResponse {
            bodies: self.bodies.names,
            body_types: self.bodies.types,
            joint_names,
            ..response
        }
    }
}
