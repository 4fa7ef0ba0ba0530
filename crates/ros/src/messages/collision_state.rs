//! Conversion of evaluations to `CollisionState` messages, and of their pairs and distances to the messages in them.

use clearance_checker::{CollisionChecker, CollisionReport, PairDistance, PairKind};
use clearance_monitor::{
    BodyKind, ContactHistory, ContactsOfPair, Evaluation, MotionSincePrevious, NamedPair, PASSED_THROUGH,
    Status,
};
use clearance_scene::BodyId;
use ros2_interfaces_jazzy_serde::std_msgs::msg::Header;

use crate::messages::clearance_msgs;
use crate::messages::clearance_msgs::{BodyPair, CollisionState, PassedThrough, SkippedPairs};
use crate::messages::contact::contact_messages;
use crate::messages::time_and_geometry::point_message;
use crate::messages::time_and_geometry::stamp_message;

/// Maximum number of pairs in one message: `RustDDS` loses messages of more than about 250 kB.
pub const PAIRS_TOLD: usize = 1000;

/// Maximum number of pairs listed as touching since the last heartbeat message, for the same reason.
const MOST_TOUCHED_PAIRS: usize = 100;

/// Type of the checked geometry, as reported in messages.
const FIDELITY: &str = "mesh";

/// Type of the checked geometry where distances are only lower bounds.
pub const ROUGH_FIDELITY: &str = "mesh, distances as lower bounds";

/// Header of all messages about one joint state.
#[must_use]
pub fn header(evaluation: &Evaluation) -> Header {
    let frame = evaluation.revision.as_ref().map(|revision| revision.frame().to_owned());
    Header { stamp: stamp_message(evaluation.stamp.unwrap_or_default()), frame_id: frame.unwrap_or_default() }
}

fn fidelity(evaluation: &Evaluation) -> &'static str {
    let is_exact = evaluation.checked_state.as_ref().is_none_or(|checked_state| checked_state.is_exact);
    if is_exact { FIDELITY } else { ROUGH_FIDELITY }
}

/// Message for `~/state`: the complete evaluation.
#[must_use]
pub fn collision_state(evaluation: &Evaluation) -> CollisionState {
    let mut message = CollisionState {
        header: header(evaluation),
        status: match evaluation.status {
            Status::Free => CollisionState::FREE,
            Status::Colliding => CollisionState::COLLIDING,
            Status::Unknown(_) => CollisionState::UNKNOWN,
        },
        age: evaluation.age.unwrap_or_default(),
        warnings: evaluation.warnings.to_vec(),
        fidelity: fidelity(evaluation).to_owned(),
        self_distance: evaluation.distance_of(PairKind::SelfPair),
        world_distance: evaluation.distance_of(PairKind::WorldPair),
        ..CollisionState::default()
    };
    if let Some(reason) = evaluation.status.reason() {
        message.reason = reason.to_string();
        reason.code().clone_into(&mut message.reason_code);
    }
    add_history(&mut message, &evaluation.history);
    let Some(revision) = &evaluation.revision else {
        return message;
    };
    message.model_revision = revision.model;
    message.world_revision = revision.world;
    add_skipped(&mut message, &revision.checker);
    if let Some(checked_state) = &evaluation.checked_state {
        let open = undecided(&checked_state.report);
        message.pairs_checked = count(revision.checker.pairs().len().saturating_sub(open));
        if open > 0 {
            message.warnings.push(format!(
                "check_deadline passed before {open} pairs were decided: others may touch, or be nearer, than those in the report"
            ));
        }
        message.compute_time = checked_state.compute_time.as_secs_f64();
        add_findings(&mut message, &revision.checker, &checked_state.report);
        add_contacts(&mut message, &revision.checker, &checked_state.contacts);
        if let Some(ahead) = &checked_state.look_ahead {
            message.time_to_contact_known = true;
            message.time_to_contact = ahead.free_for;
            message.time_to_contact_considers_obstacle_motion = checked_state.obstacles_may_move;
            let pair = ahead.first.map(|(a, b)| pair_message(&revision.checker, a, b));
            message.first_contact_pair = pair.unwrap_or_default();
        }
    }
    add_motion(&mut message, &revision.checker, evaluation);
    message
}

/// Adds the motion since the previous state, with its proven or possible contact.
fn add_motion(message: &mut CollisionState, checker: &CollisionChecker, evaluation: &Evaluation) {
    let motion = &evaluation.motion_since_previous;
    message.motion_since_previous = match motion {
        MotionSincePrevious::NotChecked(_) => CollisionState::NOT_CHECKED,
        MotionSincePrevious::ProvenFree => CollisionState::PROVEN_FREE,
        MotionSincePrevious::PassedThrough(_) => CollisionState::PASSED_THROUGH,
        MotionSincePrevious::NotProven { .. } => CollisionState::NOT_PROVEN,
    };
    message.motion_since_previous_reason = motion.reason().unwrap_or_default();
    let Some(passage) = motion.passage() else { return };
    let pair = passage.pair.map(|(a, b)| pair_message(checker, a, b)).unwrap_or_default();
    let proven = motion.passed_through().is_some();
    let [previous_stamp, stamp] = passage.stamps.map(stamp_message);
    message.passed_through.push(PassedThrough {
        pair,
        t_lower: passage.t[0],
        t_upper: passage.t[1],
        previous_stamp,
        stamp,
        proven,
    });
    if let Some(passage) = evaluation.contact_since_previous() {
        PASSED_THROUGH.clone_into(&mut message.reason_code);
        message.reason = evaluation.passage_text(passage).unwrap_or_default();
    }
}

/// Adds the contacts counted since the start, and what happened since the last heartbeat message.
fn add_history(message: &mut CollisionState, history: &ContactHistory) {
    message.contacts_begun = history.begun;
    message.contacts_ended = history.ended;
    let since = &history.since_heartbeat;
    let to = &mut message.since_heartbeat;
    to.heartbeat = history.heartbeat;
    to.messages = since.evaluations;
    to.all_free = since.all_free && message.status != CollisionState::UNKNOWN;
    if let Some(least) = &since.least {
        to.least_distance = least.distance;
        to.least_distance_pair = least.pair.as_deref().map(named_pair_message).unwrap_or_default();
        to.least_distance_stamp = stamp_message(least.stamp);
    }
    to.touched_pair_count = count(since.touched.len());
    to.touched_pairs = since.touched.iter().take(MOST_TOUCHED_PAIRS).map(named_pair_message).collect();
}

/// Number of pairs that were left undecided at the deadline.
fn undecided(report: &CollisionReport) -> usize {
    let mut open: Vec<_> = report.undecided.iter().map(|pair| (pair.a, pair.b)).collect();
    open.sort_unstable();
    open.dedup();
    open.len()
}

fn add_skipped(message: &mut CollisionState, checker: &CollisionChecker) {
    message.skipped = (checker.pairs().skipped())
        .filter(|(_, count)| *count > 0)
        .map(|(reason, pairs)| SkippedPairs { reason: reason.to_string(), count: count(pairs) })
        .collect();
    message.pairs_skipped = message.skipped.iter().map(|s| s.count).sum();
}

fn add_findings(message: &mut CollisionState, checker: &CollisionChecker, report: &CollisionReport) {
    message.colliding_pairs =
        (report.colliding_pairs.iter().take(PAIRS_TOLD)).map(|&(a, b)| pair_message(checker, a, b)).collect();
    message.pair_distances =
        (report.pair_distances.iter().take(PAIRS_TOLD)).map(|pair| distance_message(checker, pair)).collect();
    for (what, pairs) in [("colliding", report.colliding_pairs.len()), ("near", report.pair_distances.len())]
    {
        if pairs > PAIRS_TOLD {
            message.warnings.push(format!("only {PAIRS_TOLD} of {pairs} {what} pairs are listed"));
        }
    }
    if let Some(nearest) = &report.nearest {
        message.distance_known = true;
        message.nearest = distance_message(checker, nearest);
    }
    let nearest_of =
        |kind| report.known_nearest_of(kind).map(|pair| distance_message(checker, pair)).unwrap_or_default();
    message.self_nearest = nearest_of(PairKind::SelfPair);
    message.world_nearest = nearest_of(PairKind::WorldPair);
    if let Some(kind) = report.unfinished {
        message.warnings.push(format!("check_deadline passed before {} was known", distance_field(kind)));
    }
}

/// Adds the contacts of the colliding pairs, fewer where many pairs are listed.
fn add_contacts(message: &mut CollisionState, checker: &CollisionChecker, contacts: &[ContactsOfPair]) {
    let touched = message.since_heartbeat.touched_pairs.len();
    let listed = message.colliding_pairs.len() + message.pair_distances.len() + touched;
    let room = PAIRS_TOLD.min((2 * PAIRS_TOLD).saturating_sub(listed));
    let found: usize = contacts.iter().map(|of_pair| of_pair.contacts.count()).sum();
    for of_pair in contacts {
        let (a, b) = of_pair.bodies;
        message.contacts.extend(contact_messages(&pair_message(checker, a, b), of_pair));
    }
    message.contacts.truncate(room);
    if found > room {
        message.warnings.push(format!("only {room} of {found} contacts are listed"));
    }
}

/// The field with the least distance of the pairs of one kind.
fn distance_field(kind: PairKind) -> &'static str {
    match kind {
        PairKind::SelfPair => "self_distance",
        PairKind::WorldPair => "world_distance",
    }
}

/// Kind of a body, as a constant of the message.
#[must_use]
pub fn body_type(body: impl Into<BodyKind>) -> u8 {
    match body.into() {
        BodyKind::Link => BodyPair::LINK,
        BodyKind::Attached => BodyPair::ATTACHED,
        BodyKind::Obstacle => BodyPair::OBSTACLE,
    }
}

fn named_pair_message([a, b]: &NamedPair) -> BodyPair {
    BodyPair {
        body_a: a.name.clone(),
        type_a: body_type(a.kind),
        body_b: b.name.clone(),
        type_b: body_type(b.kind),
    }
}

#[must_use]
pub fn pair_message(checker: &CollisionChecker, a: BodyId, b: BodyId) -> BodyPair {
    BodyPair {
        body_a: checker.body_name(a).to_owned(),
        type_a: body_type(a),
        body_b: checker.body_name(b).to_owned(),
        type_b: body_type(b),
    }
}

#[must_use]
pub fn distance_message(checker: &CollisionChecker, pair: &PairDistance) -> clearance_msgs::PairDistance {
    clearance_msgs::PairDistance {
        pair: pair_message(checker, pair.a, pair.b),
        distance: pair.distance,
        witness_points: pair.witness_points.each_ref().map(point_message),
    }
}

fn count(number: usize) -> u32 {
    u32::try_from(number).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clearance_monitor::{Expiry, LeftOut};

    #[test]
    fn an_evaluation_without_a_robot_is_unknown() {
        let evaluation = Evaluation {
            status: Status::Unknown(clearance_monitor::Reason::NoModel { fault: None }),
            stamp: None,
            age: None,
            checked_state: None,
            robot_state: None,
            speed_scale: 0.0,
            separation: None,
            left_out: LeftOut::Nothing,
            is_swapping: false,
            stale_world: None,
            motion_since_previous: clearance_monitor::MotionSincePrevious::default(),
            history: clearance_monitor::ContactHistory::default(),
            revision: None,
            warnings: [].into(),
            expiry: Expiry::default(),
        };
        let message = collision_state(&evaluation);
        assert_eq!(message.status, CollisionState::UNKNOWN);
        assert_eq!(message.reason_code, "no_model");
        assert_eq!(message.model_revision, 0);
        assert!(!message.distance_known);
        assert!(evaluation.distance().is_nan());
        assert!(message.self_distance.is_nan() && message.world_distance.is_nan());
    }

    /// The two-link robot folded onto its base, with this many contacts.
    #[test]
    fn contacts_are_in_the_order_of_the_colliding_pairs() {
        use clearance_monitor::{JointStateInput, Monitor, MonitorSettings, Now, Revision, Time};
        use clearance_robot::{MeshFiles, RobotModel};
        use std::sync::Arc;
        use std::time::Duration;

        let urdf = include_str!("../../../../urdf/two_link/two_link.urdf");
        let robot = Arc::new(RobotModel::from_urdf(urdf, &MeshFiles::default()).unwrap());
        let world = clearance_scene::World::default();
        let checker = CollisionChecker::new(robot, &world, clearance_scene::Settings::default()).unwrap();
        let revision = Arc::new(Revision::new(checker, 1, 1));
        for contacts_per_pair in [0, 3] {
            let settings = MonitorSettings { contacts_per_pair, ..MonitorSettings::default() };
            let mut monitor = Monitor::new(settings, || Duration::ZERO);
            monitor.set_checker(Arc::clone(&revision));
            let input = JointStateInput {
                names: vec!["joint1".to_owned(), "joint2".to_owned()],
                positions: vec![0.0, std::f64::consts::PI],
                ..JointStateInput::default()
            };
            let now = Now { ros: Some(Time::from_nanoseconds(5)), steady: Duration::ZERO };
            let message = collision_state(&monitor.on_joint_state(input, now));
            assert_eq!(message.status, CollisionState::COLLIDING);
            if contacts_per_pair == 0 {
                assert_eq!(message.contacts, []);
                continue;
            }
            assert!((1..=3).contains(&message.contacts.len()), "{:?}", message.contacts);
            assert!(message.contacts.iter().all(|contact| contact.pair == message.colliding_pairs[0]));
            let deepest = &message.contacts[0];
            assert!(deepest.depth_known && deepest.reason.is_empty());
            assert!(deepest.depth_lower <= deepest.depth_upper && (deepest.depth_upper - 0.3).abs() < 1e-6);
        }
    }
}
