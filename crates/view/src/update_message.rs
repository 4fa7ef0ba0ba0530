//! Converts an evaluation to the JSON update that the page displays: status, distances, contacts and poses.

use clearance_checker::{CollisionChecker, CollisionReport, PairContacts, PairDistance, PairKind};
use clearance_geometry::math::{Point, Vector};
use clearance_monitor::{CheckedState, ContactsOfPair, Evaluation, MonitorSettings, Reason, Revision};
use clearance_robot::LinkPoses;
use clearance_scene::BodyId;
use serde::Serialize;
use std::time::{Duration, Instant};

use crate::geometry_documents::{pose_numbers, short};
use crate::latest_evaluation::TimedEvaluation;
use crate::state_control::StateControl;

/// Largest number of near pairs, and of colliding pairs, in one update.
const PAIRS_SHOWN: usize = 200;

/// An update. Lengths in metres, times in seconds.
#[derive(Serialize)]
struct Update<'a> {
    status: &'static str,
    reason: Option<String>,
    reason_code: Option<&'static str>,
    warnings: &'a [String],
    /// Number of the robot model that this refers to; 0 without a robot.
    model: u64,
    world: u64,
    /// Age of the joint state.
    age: Option<f64>,
    /// By link, as in the robot's document; absent when the robot's configuration is unknown.
    poses: Option<Vec<[f32; 7]>>,
    /// Positions (rad, m) of the sliders; absent where a node moves the robot.
    #[serde(skip_serializing_if = "Option::is_none")]
    sliders: Option<Vec<f64>>,
    #[serde(flatten)]
    findings: Option<Findings<'a>>,
}

#[derive(Serialize)]
struct Findings<'a> {
    compute_time: f64,
    pairs_checked: usize,
    /// Proven time without contact, after the joint state's stamp.
    free_for: Option<f64>,
    nearest: Option<Pair<'a>>,
    /// The nearest pair of two bodies of the robot.
    self_nearest: Nearest<'a>,
    /// The nearest pair of a body of the robot and an obstacle.
    world_nearest: Nearest<'a>,
    near: Vec<Pair<'a>>,
    near_count: usize,
    colliding: Vec<[Name<'a>; 2]>,
    colliding_count: usize,
    /// Contacts, where they are computed, in the order of `colliding`; the deepest of a pair first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    contacts: Vec<ContactShown>,
}

/// One contact of a colliding pair.
#[derive(Serialize)]
struct ContactShown {
    /// Index of the pair in `colliding`.
    pair: usize,
    position: [f32; 3],
    /// Unit vector towards the second body; absent if it is not known.
    normal: Option<[f32; 3]>,
    /// Depth; absent if it is not known.
    depth: Option<f64>,
}

/// The nearest pair of one kind.
#[derive(Serialize)]
struct Nearest<'a> {
    /// Whether it is known; false if the deadline passed before.
    known: bool,
    /// Absent if none is within the distance limit.
    pair: Option<Pair<'a>>,
}

#[derive(Serialize)]
struct Pair<'a> {
    bodies: [Name<'a>; 2],
    distance: f64,
    witness_points: [[f32; 3]; 2],
}

/// Kind and name of a body, which together are unique.
type Name<'a> = (&'static str, &'a str);

/// How long the last evaluation stays valid without a new one.
fn validity_time(heartbeat: Duration) -> Duration {
    2 * heartbeat + Duration::from_secs(1)
}

/// Current status as JSON; without an evaluation, UNKNOWN.
pub fn update(
    timed_evaluation: Option<&TimedEvaluation>,
    now: Instant,
    control: Option<&StateControl>,
) -> String {
    let Some(TimedEvaluation { evaluation, at, settings }) = timed_evaluation else {
        return json(&nothing_known("the node has not said anything yet".to_owned(), "silent"));
    };
    let since_evaluation = now.saturating_duration_since(*at);
    if since_evaluation > validity_time(settings.heartbeat_period()) {
        let reason = format!("the node has been silent for {:.1} s", since_evaluation.as_secs_f64());
        return json(&nothing_known(reason, "silent"));
    }
    let age = evaluation.age.map(|age| age + since_evaluation.as_secs_f64());
    if let Some(stale) = age.and_then(|age| stale_reason(evaluation, age, settings)) {
        return json(&nothing_known(stale.to_string(), stale.code()));
    }
    let Evaluation { status, robot_state, checked_state, revision, warnings, .. } = evaluation;
    let reason = status.reason();
    let (model, world) = revision.as_ref().map_or((0, 0), |r| (r.model, r.world));
    let both = |checked_state: &'_ Option<_>| checked_state.clone().zip(revision.as_ref());
    let poses = both(robot_state).map(|(robot_state, revision)| poses(revision, &robot_state.poses));
    let findings = checked_state.as_deref().zip(revision.as_deref());
    json(&Update {
        status: status.word(),
        reason: reason.map(ToString::to_string),
        reason_code: reason.map(Reason::code),
        warnings,
        model,
        world,
        age,
        poses,
        sliders: control
            .zip(checked_state.as_ref())
            .map(|(control, checked)| control.slider_positions(&checked.configuration)),
        findings: findings.map(|(checked_state, revision)| found(checked_state, &revision.checker)),
    })
}

/// The reason if the evaluation has become stale since it was made.
fn stale_reason(evaluation: &Evaluation, age: f64, settings: &MonitorSettings) -> Option<Reason> {
    let stale_after = settings.stale_after;
    let is_stale = evaluation.checked_state.is_some() && age > stale_after;
    is_stale.then(|| Reason::Stale { joints: Vec::new(), age, stale_after, also: None })
}

fn nothing_known(reason: String, code: &'static str) -> Update<'static> {
    Update {
        status: "UNKNOWN",
        reason: Some(reason),
        reason_code: Some(code),
        warnings: &[],
        model: 0,
        world: 0,
        age: None,
        poses: None,
        sliders: None,
        findings: None,
    }
}

fn json(update: &Update) -> String {
    // serialising plain structs of numbers and names cannot fail
    serde_json::to_string(update).unwrap_or_default()
}

fn poses(revision: &Revision, poses: &LinkPoses) -> Vec<[f32; 7]> {
    revision.checker.robot().link_ids().map(|link| pose_numbers(poses.pose(link))).collect()
}

fn found<'a>(checked_state: &'a CheckedState, checker: &'a CollisionChecker) -> Findings<'a> {
    let report = &checked_state.report;
    let CollisionReport { nearest, pair_distances, colliding_pairs, .. } = report;
    let mut near: Vec<&PairDistance> = pair_distances.iter().collect();
    near.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    let name = |body| (kind(body), checker.body_name(body));
    let pair = |pair: &PairDistance| Pair {
        bodies: [name(pair.a), name(pair.b)],
        distance: pair.distance,
        witness_points: pair.witness_points.map(|point: Point| point.coords.map(short).into()),
    };
    let nearest_of = |kind| Nearest {
        known: !report.distance_of(kind).is_nan(),
        pair: report.known_nearest_of(kind).map(pair),
    };
    Findings {
        compute_time: checked_state.compute_time.as_secs_f64(),
        pairs_checked: checker.pairs().len(),
        free_for: checked_state.look_ahead.map(|ahead| ahead.free_for),
        nearest: nearest.as_ref().map(pair),
        self_nearest: nearest_of(PairKind::SelfPair),
        world_nearest: nearest_of(PairKind::WorldPair),
        near: near.into_iter().take(PAIRS_SHOWN).map(pair).collect(),
        near_count: pair_distances.len(),
        colliding: colliding_pairs.iter().take(PAIRS_SHOWN).map(|&(a, b)| [name(a), name(b)]).collect(),
        colliding_count: colliding_pairs.len(),
        contacts: contacts(checked_state),
    }
}

/// The contacts of the pairs that are shown.
fn contacts(checked_state: &CheckedState) -> Vec<ContactShown> {
    let colliding = &checked_state.report.colliding_pairs;
    let shown = |pair, point: &Point, normal: Option<&Vector>, depth| ContactShown {
        pair,
        position: point.coords.map(short).into(),
        normal: normal.map(|normal| normal.map(short).into()),
        depth,
    };
    let mut contacts = Vec::new();
    let mut pairs = colliding.iter().take(PAIRS_SHOWN).enumerate();
    for ContactsOfPair { bodies, contacts: PairContacts { deepest, others } } in &checked_state.contacts {
        // both are in the order of the colliding pairs
        let Some((pair, _)) = pairs.by_ref().find(|(_, other)| *other == bodies) else { break };
        contacts.push(shown(pair, &deepest.point, deepest.normal.as_ref(), deepest.depth));
        contacts
            .extend(others.iter().map(|other| shown(pair, &other.point, Some(&other.normal), other.depth)));
    }
    contacts
}

fn kind(body: BodyId) -> &'static str {
    match body {
        BodyId::Link(_) => "link",
        BodyId::Attached(_) => "attached",
        BodyId::Obstacle(_) => "obstacle",
    }
}
