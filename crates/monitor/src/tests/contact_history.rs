//! Tests of the contact counts since the start, and of the summary in each heartbeat message.

use clearance_geometry::math::{Extremes, Pose};
use clearance_geometry::{Primitive, Shape};
use clearance_scene::{BodyId, Obstacle};
use proptest::prelude::*;
use std::collections::BTreeSet;

use super::*;

const NEAR: [f64; 2] = [0.0, 2.5];

/// Names of the pair of links that the folded robot brings into contact.
fn folded() -> Vec<[String; 2]> {
    vec![["ball".to_owned(), "base".to_owned()]]
}

fn touched(evaluation: &Evaluation) -> Vec<[String; 2]> {
    let touched = evaluation.history.since_heartbeat.touched.iter();
    touched.map(|pair| pair.each_ref().map(|body| body.name.clone())).collect()
}

fn counts(evaluation: &Evaluation) -> (u64, u64) {
    (evaluation.history.begun, evaluation.history.ended)
}

fn least(evaluation: &Evaluation) -> f64 {
    evaluation.history.since_heartbeat.least.as_ref().map_or(f64::NAN, |least| least.distance)
}

/// A contact of 20 ms at 1 kHz, seen by a subscriber that receives ten messages a second.
#[test]
fn a_short_contact_is_in_the_next_heartbeat_message() {
    let mut monitor = monitor();
    let mut heartbeats = Vec::new();
    for millisecond in 0..1000_u32 {
        let positions = if (330..350).contains(&millisecond) { COLLIDING } else { NEAR };
        let seconds = f64::from(millisecond) * 1e-3;
        let evaluation = monitor.on_joint_state(state(seconds, positions), at(seconds));
        if evaluation.history.is_heartbeat {
            heartbeats.push((millisecond, evaluation));
        }
    }
    let times: Vec<u32> = heartbeats.iter().map(|(millisecond, _)| *millisecond).collect();
    assert_eq!(times, (0..10).map(|i| i * 100).collect::<Vec<_>>());
    let gap = monitor_distance(NEAR);
    for (millisecond, evaluation) in &heartbeats {
        assert_eq!(code(evaluation), "FREE");
        let has_contact = *millisecond == 400;
        let since = &evaluation.history.since_heartbeat;
        assert_eq!(touched(evaluation), if has_contact { folded() } else { Vec::new() });
        assert_eq!(counts(evaluation), if *millisecond < 400 { (0, 0) } else { (1, 1) });
        assert_eq!(least(evaluation), if has_contact { 0.0 } else { gap });
        // nothing is known of the motion to the first state
        assert_eq!(since.all_free, *millisecond > 0 && !has_contact, "{millisecond}");
        assert_eq!(since.evaluations, if *millisecond == 0 { 1 } else { 100 });
        let stamp = since.least.as_ref().unwrap().stamp;
        assert!(!has_contact || stamp == time(START + 0.33));
    }
}

fn monitor_distance(positions: [f64; 2]) -> f64 {
    monitor().on_joint_state(state(0.0, positions), at(0.0)).distance()
}

#[test]
fn a_contact_between_two_states_counts_as_begun_and_ended() {
    let mut world = World::default();
    let wall = Shape::Primitive(Primitive::cuboid([0.4, 0.001, 0.4]).unwrap());
    world.add(Obstacle::of_shape("wall", Pose::translation(2.0, 0.0, 0.0), wall)).unwrap();
    let robot = RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap();
    let checker = CollisionChecker::new(Arc::new(robot), &world, Settings::default()).unwrap();
    let mut monitor = monitor();
    monitor.set_checker(Arc::new(Revision::new(checker, 2, 0)));
    let turns = [-0.5, 0.5, 0.5, 0.6];
    let evaluations: Vec<_> = turns
        .iter()
        .zip([0.0, 0.02, 0.04, 0.06])
        .map(|(turn, seconds)| monitor.on_joint_state(state(seconds, [*turn, 0.0]), at(seconds)))
        .collect();
    assert_eq!(evaluations.iter().map(counts).collect::<Vec<_>>(), [(0, 0), (1, 1), (1, 1), (1, 1)]);
    let through = vec![["ball".to_owned(), "wall".to_owned()]];
    for evaluation in &evaluations[1..] {
        assert_eq!(touched(evaluation), through, "until the next heartbeat");
        assert_eq!(least(evaluation), 0.0);
        assert!(!evaluation.history.since_heartbeat.all_free);
    }
}

#[test]
fn an_unknown_state_neither_begins_nor_ends_a_contact() {
    let mut monitor = monitor();
    assert_eq!(counts(&monitor.on_joint_state(state(0.0, COLLIDING), at(0.0))), (1, 0));
    assert_eq!(counts(&monitor.on_joint_state(state(0.1, [0.0, f64::NAN]), at(0.1))), (1, 0));
    monitor.set_enabled(false);
    let disabled = monitor.on_heartbeat(at(0.2));
    assert_eq!((counts(&disabled), disabled.history.since_heartbeat.all_free), ((1, 0), false));
    monitor.set_enabled(true);
    assert_eq!(counts(&monitor.on_joint_state(state(0.3, COLLIDING), at(0.3))), (1, 0));
    assert_eq!(counts(&monitor.on_joint_state(state(0.4, FREE), at(0.4))), (1, 1));
    // another robot model does not begin the count anew
    monitor.set_checker(revision(2));
    assert_eq!(counts(&monitor.on_joint_state(state(0.5, COLLIDING), at(0.5))), (2, 1));
}

#[test]
fn nothing_is_proven_free_without_the_check_between_states() {
    let mut monitor = monitor();
    monitor.set_settings(MonitorSettings { check_between_states: false, ..MonitorSettings::default() });
    monitor.on_joint_state(state(0.0, FREE), at(0.0));
    let repeated = monitor.on_heartbeat(at(0.1));
    assert_eq!((code(&repeated), repeated.history.is_heartbeat), ("FREE", true));
    assert!(!repeated.history.since_heartbeat.all_free);
    monitor.set_settings(MonitorSettings::default());
    monitor.on_heartbeat(at(0.2));
    assert!(monitor.on_heartbeat(at(0.3)).history.since_heartbeat.all_free);
}

#[test]
fn heartbeat_messages_are_numbered() {
    let mut monitor = monitor();
    let messages = (0..1000).map(|millisecond| {
        let seconds = f64::from(millisecond) * 1e-3;
        monitor.on_joint_state(state(seconds, FREE), at(seconds)).history
    });
    let numbers = messages.filter(|history| history.is_heartbeat).map(|history| history.heartbeat);
    assert_eq!(numbers.collect::<Vec<_>>(), (1..=10).collect::<Vec<_>>());
}

/// An event of a random run: seconds since the last one, and the positions of a joint state; `None`: no joint state.
type Event = (f64, Option<[f64; 2]>);

fn events() -> impl Strategy<Value = Vec<Event>> {
    let positions = prop_oneof![Just(FREE), Just(NEAR), Just(COLLIDING)];
    prop::collection::vec((0.001..0.05, prop::option::weighted(0.8, positions)), 1..200)
}

/// Expected content of heartbeat messages, counted from all evaluations.
#[derive(Default)]
struct Expected {
    colliding: BTreeSet<(BodyId, BodyId)>,
    begun: u64,
    ended: u64,
    since_heartbeat: Since,
}

#[derive(Default)]
struct Since {
    touched: BTreeSet<(BodyId, BodyId)>,
    distances: Vec<f64>,
    was_not_free: bool,
}

impl Expected {
    fn add(&mut self, evaluation: &Evaluation) {
        let report = &evaluation.checked_state.as_ref().unwrap().report;
        let colliding: BTreeSet<_> = report.colliding_pairs.iter().copied().collect();
        let passed = evaluation.motion_since_previous.passed_through().and_then(|passage| passage.pair);
        let through =
            passed.is_some_and(|pair| !self.colliding.contains(&pair) && !colliding.contains(&pair));
        self.begun += colliding.difference(&self.colliding).count() as u64 + u64::from(through);
        self.ended += self.colliding.difference(&colliding).count() as u64 + u64::from(through);
        let since = &mut self.since_heartbeat;
        since.touched.extend(colliding.iter().copied().chain(passed));
        let touches = !colliding.is_empty() || passed.is_some();
        since.distances.push(if touches { 0.0 } else { evaluation.distance() });
        since.was_not_free |= !evaluation.status.is_free();
        self.colliding = colliding;
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// Heartbeat messages add up to all evaluations, whatever the times of the joint states and the period.
    #[test]
    fn heartbeat_messages_lose_nothing(heartbeat_rate in 1.0..30.0, events in events()) {
        let mut monitor = monitor();
        monitor.set_settings(MonitorSettings { heartbeat_rate, distance_limit: 5.0, ..MonitorSettings::default() });
        let mut expected = Expected::default();
        let (mut now, mut last) = (0.0, 0.0);
        monitor.on_joint_state(state(0.0, FREE), at(0.0));
        for (interval, positions) in events {
            now += interval;
            let evaluation = match positions {
                Some(positions) => monitor.on_joint_state(state(now, positions), at(now)),
                None => monitor.on_heartbeat(at(now)),
            };
            expected.add(&evaluation);
            prop_assert_eq!(counts(&evaluation), (expected.begun, expected.ended));
            prop_assert!(now - last <= 1.0 / heartbeat_rate + 0.05, "a heartbeat is late");
            if !evaluation.history.is_heartbeat {
                continue;
            }
            let since = &evaluation.history.since_heartbeat;
            let Since { touched, distances, was_not_free } = std::mem::take(&mut expected.since_heartbeat);
            prop_assert_eq!(since.touched.len(), touched.len());
            prop_assert_eq!(since.evaluations as usize, distances.len());
            prop_assert_eq!(least(&evaluation), distances.into_iter().fold(f64::INFINITY, f64::lesser));
            prop_assert!(!was_not_free || !since.all_free);
            last = now;
        }
    }
}
