//! Processes state requests: converts names and numbers to configurations, and reports to messages. No I/O.

use clearance_checker::{
    CollisionChecker, CollisionReport, PairDistance, PairKind, Question, UndecidedPair, Workspace,
};
use clearance_monitor::Evaluation;
use clearance_proximity::Effort;
use clearance_robot::Configuration;
use clearance_robot::quoted_list;
use clearance_scene::BodyId;
use std::collections::HashSet;
use std::time::{Duration, Instant};

use crate::messages::clearance_msgs::PairDistance as PairDistanceMessage;
use crate::messages::clearance_srvs::{
    CheckStatesRequest, CheckStatesResponse, GetDistancesRequest, GetDistancesResponse,
};
use crate::messages::collision_state::distance_message;
use crate::services::body_list::{BodyList, NOBODY};
use crate::services::gradient_rows::{add_gradients, bytes_of_gradient};
use crate::services::request_context::{RequestContext, revisions};
use crate::services::request_fields::{deadline, not_negative};
use crate::services::request_rejection::{RequestRejection, bad_request, shortened};

/// Maximum number of states per request: with distances they take about a second, while other requests wait.
const STATES: usize = 10_000;

/// Maximum size of the pairs in a response (bytes): about 6000 pairs.
const LONGEST_PAIRS: usize = 1_000_000;

/// Default timeout of a batch. A client that needs longer must set a timeout, because other requests wait in the queue.
const LONGEST_BATCH: Duration = Duration::from_secs(60);

/// Default timeout of distances.
const LONGEST_DISTANCES: Duration = Duration::from_secs(10);

/// Number of pairs above which the memory is freed after the request.
pub const MANY_PAIRS: usize = 100_000;

/// Size of a pair without the names of its bodies (bytes).
const BYTES_OF_PAIR: usize = 96;

/// Responds to a request for many states. The workspace is memory that is reused to make later checks faster.
#[must_use]
pub fn evaluate_states(
    request: &CheckStatesRequest,
    evaluation: Option<&Evaluation>,
    workspace: &mut Option<Workspace>,
) -> CheckStatesResponse {
    let started = Instant::now();
    let found = RequestContext::of(evaluation).and_then(|context| {
        let effort = Effort {
            deadline: deadline(request.timeout, Some(LONGEST_BATCH), started)?,
            ..Effort::default()
        };
        let limit = limit("distance_limit", request.distance_limit)?;
        let question =
            if request.with_distance { Question::SelfAndWorldDistance { limit } } else { Question::Free };
        let (states, note) = context.states(request)?;
        let limits = context.robot().limits_note("state", states.iter().map(|q| [q]));
        let mut batch = BatchResponse::new(context.checker, request.with_distance);
        let workspace = workspace.get_or_insert_with(|| context.checker.workspace());
        for state in &states {
            // no check starts after the deadline
            let report =
                (!effort.is_over()).then(|| context.checker.check_with(state, question, &effort, workspace));
            batch.add(report.as_ref());
        }
        Ok(batch.response([limits, note]))
    });
    let mut response = found.unwrap_or_else(|rejection| rejected_states(&rejection));
    (response.model_revision, response.world_revision) = revisions(evaluation);
    response.compute_time = started.elapsed().as_secs_f64();
    response
}

/// Responds to a request for the distances in one state.
#[must_use]
pub fn evaluate_distances(
    request: &GetDistancesRequest,
    evaluation: Option<&Evaluation>,
    workspace: &mut Option<Workspace>,
) -> GetDistancesResponse {
    let started = Instant::now();
    let found = RequestContext::of(evaluation).and_then(|context| {
        let deadline = deadline(request.timeout, Some(LONGEST_DISTANCES), started)?;
        let effort = Effort { deadline, ..Effort::default() };
        let limit = limit("max_distance", request.max_distance)?;
        let requested_bodies = context.requested_bodies(&request.bodies)?;
        let (state, note) = context.state(&request.joint_names, &request.positions)?;
        let memory = workspace.get_or_insert_with(|| context.checker.workspace());
        let question = Question::PairDistances { limit };
        let report = context.checker.check_with(&state, question, &effort, memory);
        if report.pair_distances.len() + report.undecided.len() > MANY_PAIRS {
            *workspace = None;
        }
        let limits = context.robot().limits_note("state", [[&state]]);
        let list = ListedPairs {
            requested_bodies: &requested_bodies,
            most: request.max_pairs,
            bytes_each: BYTES_OF_PAIR
                + if request.with_gradients { bytes_of_gradient(context.robot()) } else { 0 },
        };
        let (mut response, listed) = distances(context.checker, report, &list, [limits, note]);
        if request.with_gradients {
            let memory = workspace.get_or_insert_with(|| context.checker.workspace());
            let found = context.checker.clearance_of_pairs(&state, &listed, deadline, memory);
            add_gradients(&mut response, context.robot(), &listed, &found);
        }
        Ok(response)
    });
    let mut response = found.unwrap_or_else(|rejection| rejected_distances(&rejection));
    (response.model_revision, response.world_revision) = revisions(evaluation);
    response.compute_time = started.elapsed().as_secs_f64();
    response
}

/// Response to a batch that was not checked.
#[must_use]
pub fn rejected_states(rejection: &RequestRejection) -> CheckStatesResponse {
    CheckStatesResponse {
        verdict: CheckStatesResponse::ERROR,
        message: rejection.message(),
        reason_code: rejection.code().to_owned(),
        ..CheckStatesResponse::default()
    }
}

/// Response for a state that was not checked.
#[must_use]
pub fn rejected_distances(rejection: &RequestRejection) -> GetDistancesResponse {
    GetDistancesResponse {
        message: rejection.message(),
        reason_code: rejection.code().to_owned(),
        self_distance: f64::NAN,
        world_distance: f64::NAN,
        ..GetDistancesResponse::default()
    }
}

/// Maximum distance (m) to search; 0 stands for no limit.
fn limit(name: &str, distance: f64) -> Result<f64, RequestRejection> {
    not_negative(name, "m", distance)?;
    Ok(if distance > 0.0 { distance } else { f64::INFINITY })
}

impl RequestContext<'_> {
    /// The states of a batch, and a note for the client.
    fn states(
        &self,
        request: &CheckStatesRequest,
    ) -> Result<(Vec<Configuration>, Option<String>), RequestRejection> {
        let CheckStatesRequest { joint_names, positions, .. } = request;
        if joint_names.is_empty() {
            return Err(bad_request("joint_names is empty"));
        }
        let (numbers, joints) = (positions.len(), joint_names.len());
        if numbers == 0 || numbers % joints != 0 {
            return Err(bad_request(format!(
                "positions has {numbers} numbers, but must have one for each of the {joints} joint_names for each state"
            )));
        }
        if numbers / joints > STATES {
            return Err(bad_request(format!(
                "positions has {} states, but at most {STATES} are checked at a time: ask more often",
                numbers / joints
            )));
        }
        let named = self.named("joint_names", joint_names)?;
        let (rest, note) = self.rest(&named)?;
        let state = |(i, row)| {
            let state = named.configuration(&rest, row);
            state.map_err(|error| bad_request(format!("state {i}: {error}")))
        };
        let states = positions.chunks_exact(joints).enumerate().map(state);
        Ok((states.collect::<Result<_, _>>()?, note))
    }

    /// The names of the bodies whose pairs are requested.
    fn requested_bodies<'n>(&self, names: &'n [String]) -> Result<HashSet<&'n str>, RequestRejection> {
        let (robot, world) = (self.robot(), self.checker.world());
        let known = |name: &str| {
            robot.link_by_name(name).is_some()
                || world.id(name).is_some()
                || world.attached_by_name(name).is_some()
        };
        if let Some(unknown) = names.iter().find(|name| !known(name)) {
            let name = quoted_list(std::slice::from_ref(unknown));
            return Err(bad_request(format!("bodies: there is no link, obstacle or attached object {name}")));
        }
        Ok(names.iter().map(String::as_str).collect())
    }
}

/// Builder of the response to a batch, state by state.
struct BatchResponse<'a> {
    checker: &'a CollisionChecker,
    with_distance: bool,
    bodies: BodyList,
    unknown: usize,
    /// By state: the nearest self pair and the nearest world pair.
    nearest_of_kinds: Vec<[Option<(BodyId, BodyId)>; 2]>,
    response: CheckStatesResponse,
}

impl<'a> BatchResponse<'a> {
    fn new(checker: &'a CollisionChecker, with_distance: bool) -> Self {
        let response = CheckStatesResponse { verdict: CheckStatesResponse::FREE, ..Default::default() };
        Self {
            checker,
            with_distance,
            bodies: BodyList::new(),
            unknown: 0,
            nearest_of_kinds: Vec::new(),
            response,
        }
    }

    /// Adds the result of the next state; `None` if it was not checked.
    fn add(&mut self, report: Option<&CollisionReport>) {
        let touching = report.and_then(|report| report.colliding_pairs.first().copied());
        let nearest = report.and_then(|report| report.nearest).filter(|_| self.with_distance);
        // for distances, an undecided pair may be the nearest one
        let known = |report: &CollisionReport| {
            report.is_free() && (report.undecided.is_empty() || !self.with_distance)
        };
        let (verdict, distance, pair) = match (touching, report) {
            (Some(pair), _) => (CheckStatesResponse::COLLIDING, 0.0, Some(pair)),
            (None, Some(report)) if known(report) => (
                CheckStatesResponse::FREE,
                nearest.map_or(f64::INFINITY, |nearest| nearest.distance),
                nearest.map(|nearest| (nearest.a, nearest.b)),
            ),
            _ => (CheckStatesResponse::UNKNOWN, f64::NAN, None),
        };
        self.unknown += usize::from(verdict == CheckStatesResponse::UNKNOWN);
        let (a, b) = pair.map_or((NOBODY, NOBODY), |(a, b)| (self.index(a), self.index(b)));
        let response = &mut self.response;
        response.verdicts.push(verdict);
        response.pair_a.push(a);
        response.pair_b.push(b);
        if self.with_distance {
            response.distances.push(distance);
            let distance_of = |kind| report.map_or(f64::NAN, |report| report.distance_of(kind));
            response.self_distances.push(distance_of(PairKind::SelfPair));
            response.world_distances.push(distance_of(PairKind::WorldPair));
            let nearest_of = |kind| report.and_then(|report| nearest_pair(report, kind));
            self.nearest_of_kinds.push(PairKind::ALL.map(nearest_of));
        }
        response.verdict = match (response.verdict, verdict) {
            (CheckStatesResponse::COLLIDING, _) => CheckStatesResponse::COLLIDING,
            (worst, CheckStatesResponse::FREE) => worst,
            (_, verdict) => verdict,
        };
    }

    /// Index of a body in the response's list of bodies.
    fn index(&mut self, body: BodyId) -> i32 {
        self.bodies.index(self.checker, body)
    }

    /// Adds the nearest pairs of both kinds. Their names follow those of the colliding and the nearest pairs, which have
    /// priority where the names do not fit.
    fn add_nearest_of_kinds(&mut self) {
        for pairs in std::mem::take(&mut self.nearest_of_kinds) {
            let [of_self, of_world] =
                pairs.map(|pair| pair.map_or([NOBODY; 2], |(a, b)| [self.index(a), self.index(b)]));
            let response = &mut self.response;
            response.self_pair_a.push(of_self[0]);
            response.self_pair_b.push(of_self[1]);
            response.world_pair_a.push(of_world[0]);
            response.world_pair_b.push(of_world[1]);
        }
    }

    fn response(mut self, notes: [Option<String>; 2]) -> CheckStatesResponse {
        self.add_nearest_of_kinds();
        let of = self.response.verdicts.len();
        let open = (self.unknown > 0).then(|| {
            format!("the timeout left {} of {of} states open: ask about fewer at a time", self.unknown)
        });
        self.response.message = message(self.checker, [open].into_iter().chain(notes));
        if self.unknown > 0 {
            "deadline".clone_into(&mut self.response.reason_code);
        }
        (self.response.bodies, self.response.body_types) = (self.bodies.names, self.bodies.types);
        self.response
    }
}

/// The first colliding pair of one kind, or else the nearest one.
fn nearest_pair(report: &CollisionReport, kind: PairKind) -> Option<(BodyId, BodyId)> {
    let touching = report.colliding_pairs.iter().find(|(_, b)| PairKind::of_second(*b) == kind);
    touching.copied().or_else(|| report.known_nearest_of(kind).map(|nearest| (nearest.a, nearest.b)))
}

/// The pairs of a response.
struct ListedPairs<'a> {
    requested_bodies: &'a HashSet<&'a str>,
    /// Largest number of pairs; 0: as many as fit.
    most: u32,
    /// Size of a pair without the names of its bodies (bytes).
    bytes_each: usize,
}

/// Response with the distances in one state, and the bodies of its pairs.
fn distances(
    checker: &CollisionChecker,
    report: CollisionReport,
    list: &ListedPairs,
    notes: [Option<String>; 2],
) -> (GetDistancesResponse, Vec<(BodyId, BodyId)>) {
    let requested_bodies = list.requested_bodies;
    let open = report.undecided.len();
    let verdict = if report.self_collision || report.world_collision {
        CheckStatesResponse::COLLIDING
    } else if open == 0 {
        CheckStatesResponse::FREE
    } else {
        CheckStatesResponse::UNKNOWN
    };
    let is_wanted = |body| requested_bodies.contains(checker.body_name(body));
    let is_requested = |a, b| requested_bodies.is_empty() || is_wanted(a) || is_wanted(b);
    let requested_open = report.undecided.iter().filter(|pair| is_requested(pair.a, pair.b));
    let open_kinds: Vec<PairKind> = requested_open.map(UndecidedPair::kind).collect();
    let mut pairs = report.pair_distances;
    // pairs that the timeout cut off have only an upper bound of the distance: closer points may exist
    pairs.retain(|pair| pair.lower >= pair.distance);
    pairs.retain(|pair| is_requested(pair.a, pair.b));
    // pairs at the same distance stay in the order of the pair list
    pairs.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    let requested = if list.most == 0 { pairs.len() } else { pairs.len().min(list.most as usize) };
    let listed = pair_messages(checker, &pairs[..requested], list.bytes_each);
    let bodies = pairs[..listed.len()].iter().map(|pair| (pair.a, pair.b)).collect();
    let cut = (listed.len() < requested)
        .then(|| format!("only {} of {} pairs are listed", listed.len(), pairs.len()));
    let left_out = (open > 0).then(|| format!("the timeout left {open} pairs open"));
    let [of_self, of_world] = PairKind::ALL.map(|kind| {
        let nearest = pairs.iter().find(|pair| pair.kind() == kind);
        let is_open = open_kinds.contains(&kind);
        nearest_message(checker, nearest, is_open)
    });
    let response = GetDistancesResponse {
        verdict,
        message: message(checker, [left_out, cut].into_iter().chain(notes)),
        reason_code: if open > 0 { "deadline".to_owned() } else { String::new() },
        pairs_found: u32::try_from(pairs.len()).unwrap_or(u32::MAX),
        pairs: listed,
        self_distance: of_self.0,
        self_nearest: of_self.1,
        world_distance: of_world.0,
        world_nearest: of_world.1,
        ..GetDistancesResponse::default()
    };
    (response, bodies)
}

/// The least distance (m) of one kind of pairs, with its pair: infinite if there is none, NaN if it is not known because
/// a pair is open.
fn nearest_message(
    checker: &CollisionChecker,
    nearest: Option<&PairDistance>,
    is_open: bool,
) -> (f64, PairDistanceMessage) {
    match nearest {
        Some(nearest) if !is_open || nearest.distance == 0.0 => {
            (nearest.distance, distance_message(checker, nearest))
        }
        _ => (if is_open { f64::NAN } else { f64::INFINITY }, PairDistanceMessage::default()),
    }
}

/// The first pairs, as many as fit into a response.
fn pair_messages(
    checker: &CollisionChecker,
    pairs: &[PairDistance],
    bytes_each: usize,
) -> Vec<PairDistanceMessage> {
    let mut bytes = 0;
    let messages = pairs.iter().map(|pair| distance_message(checker, pair));
    let fits = |message: &PairDistanceMessage| {
        bytes += bytes_each + message.pair.body_a.len() + message.pair.body_b.len();
        bytes <= LONGEST_PAIRS
    };
    messages.take_while(fits).collect()
}

/// Notes for the client as text.
pub fn message(checker: &CollisionChecker, notes: impl IntoIterator<Item = Option<String>>) -> String {
    let nothing = (checker.pairs().is_empty())
        .then(|| "there is no pair to check: every state counts as free".to_owned());
    let notes: Vec<String> = notes.into_iter().chain([nothing]).flatten().collect();
    shortened(notes.join("; "))
}

#[cfg(test)]
mod tests;
