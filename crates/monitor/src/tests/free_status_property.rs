//! Property test on random inputs: only complete, fresh joint states are FREE, and nothing panics.

use proptest::prelude::*;

use super::*;

/// An input of the monitor.
#[derive(Clone, Debug)]
enum Happening {
    JointState(JointStateInput),
    Heartbeat,
    Model,
}

fn position() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -4.0..4.0f64,
        1 => prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e308, -0.0]),
    ]
}

fn happening() -> impl Strategy<Value = Happening> {
    let name = prop::sample::select(vec!["shoulder", "elbow", "follower", "other", ""]);
    let whole = (position(), position())
        .prop_map(|(a, b)| (vec!["shoulder".to_owned(), "elbow".to_owned()], vec![a, b]));
    let any =
        (prop::collection::vec(name.prop_map(str::to_owned), 0..4), prop::collection::vec(position(), 0..4));
    let stamp = prop_oneof![
        6 => (-1.0..1.0f64).prop_map(|s| time(START + s)),
        1 => prop::sample::select(vec![i64::MIN, -1, 0, 1, i64::MAX]).prop_map(Time::from_nanoseconds),
    ];
    let source = prop::sample::select(vec![SourceId([1; 16]), SourceId([2; 16])]);
    let velocities = prop::collection::vec(prop_oneof![position(), Just(1e9)], 0..4);
    let joint_state = (prop_oneof![whole, any], velocities, stamp, source).prop_map(
        |((names, positions), velocities, stamp, source)| {
            Happening::JointState(JointStateInput { source, stamp, names, positions, velocities })
        },
    );
    prop_oneof![6 => joint_state, 3 => Just(Happening::Heartbeat), 1 => Just(Happening::Model)]
}

fn now() -> impl Strategy<Value = Now> {
    let ros = prop_oneof![
        8 => (-1.0..1.0f64).prop_map(|s| Some(time(START + s))),
        1 => Just(None),
        1 => prop::sample::select(vec![i64::MIN, i64::MAX]).prop_map(|n| Some(Time::from_nanoseconds(n))),
    ];
    (ros, 0..2000u64).prop_map(|(ros, ms)| Now { ros, steady: Duration::from_millis(ms) })
}

/// Whether FREE is allowed at `now`, after these messages with their times of reception: the last one with each joint
/// counts.
fn may_be_free(heard: &[(JointStateInput, Now)], now: Now) -> bool {
    let Some(ros) = now.ros else { return false };
    ["shoulder", "elbow"].into_iter().all(|name| {
        let names = |input: &JointStateInput| input.names.iter().filter(|n| *n == name).count();
        let Some((input, came)) = heard.iter().rev().find(|(input, _)| names(input) > 0) else {
            return false;
        };
        let place = input.names.iter().position(|n| n == name).unwrap();
        let fresh = match input.stamp {
            Time::ZERO => true,
            stamp => ros.seconds_since(stamp).abs() <= 0.5,
        };
        let since_reception = now.steady.saturating_sub(came.steady);
        input.names.len() == input.positions.len()
            && names(input) == 1
            && input.positions[place].is_finite()
            && fresh
            && since_reception <= Duration::from_millis(500)
    })
}

proptest! {
    #[test]
    fn nothing_panics_and_free_is_never_reported_without_a_whole_fresh_joint_state(
        happenings in prop::collection::vec((happening(), now()), 0..30)
    ) {
        let mut monitor = look_ahead();
        let mut heard = Vec::new();
        for (happening, now) in happenings {
            let evaluation = match happening {
                Happening::JointState(input) => {
                    // a joint state without positions is skipped
                    if input.names.is_empty() || !input.positions.is_empty() {
                        heard.push((input.clone(), now));
                    }
                    monitor.on_joint_state(input, now)
                }
                Happening::Heartbeat => monitor.on_heartbeat(now),
                Happening::Model => {
                    monitor.set_checker(revision(2));
                    monitor.on_heartbeat(now)
                }
            };
            let _ = monitor.time_to_heartbeat(now);
            prop_assert!((0.0..=0.5).contains(&evaluation.time_to_contact()));
            prop_assert!(evaluation.speed_scale == 0.0 || evaluation.status.is_free());
            let allowed = may_be_free(&heard, now);
            prop_assert!(!evaluation.status.is_free() || allowed, "{:?}", evaluation.status);
            prop_assert_eq!(
                evaluation.checked_state.is_some(),
                !matches!(evaluation.status, Status::Unknown(_))
            );
        }
    }
}
