//! Tests of the check between two successive joint states: contacts on the way.

mod transform_positions;
mod true_motions;

use clearance_geometry::math::Pose;
use clearance_geometry::{Primitive, Shape};
use clearance_scene::{AttachedObject, Obstacle};
use std::sync::OnceLock;

use super::*;

/// A ball of radius 1 cm that turns about the root at a distance of 1 m, and a flag on the other side that mimics it.
/// With `turn` at zero, the ball is in the wall.
const SWEEPER: &str = r#"<robot name="sweeper">
  <link name="base"/>
  <link name="post"><collision><origin xyz="0 1 1"/><geometry><box size="0.001 0.2 0.2"/></geometry></collision></link>
  <link name="arm"/>
  <link name="ball"><collision><origin xyz="1 0 0"/><geometry><sphere radius="0.01"/></geometry></collision></link>
  <link name="flag"><collision><origin xyz="-1 0 2"/><geometry><sphere radius="0.01"/></geometry></collision></link>
  <joint name="post" type="fixed"><parent link="base"/><child link="post"/></joint>
  <joint name="turn" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/></joint>
  <joint name="lift" type="prismatic">
    <parent link="arm"/><child link="ball"/><axis xyz="0 0 1"/>
    <limit lower="-5" upper="5" effort="1" velocity="1"/>
  </joint>
  <joint name="follow" type="continuous">
    <parent link="base"/><child link="flag"/><axis xyz="0 0 1"/><mimic joint="turn" multiplier="-1"/>
  </joint>
</robot>"#;

const RADIUS: f64 = 0.01;
const WALL: [f64; 3] = [0.4, 0.001, 0.4];

fn wall(name: &str, [x, y, z]: [f64; 3]) -> Obstacle {
    let shape = Shape::Primitive(Primitive::cuboid(WALL).unwrap());
    Obstacle::of_shape(name.to_owned(), Pose::translation(x, y, z), shape)
}

/// The sweeper, one model for all worlds.
fn robot() -> Arc<RobotModel> {
    static ROBOT: OnceLock<Arc<RobotModel>> = OnceLock::new();
    let read = || Arc::new(RobotModel::from_urdf(SWEEPER, &MeshFiles::default()).unwrap());
    Arc::clone(ROBOT.get_or_init(read))
}

/// The sweeper among walls of 1 mm across its way.
fn sweeper_among(walls: &[[f64; 3]], world_number: u64) -> Arc<Revision> {
    let mut world = World::default();
    for (number, at) in walls.iter().enumerate() {
        world.add(wall(&format!("wall{number}"), *at)).unwrap();
    }
    let checker = CollisionChecker::new(robot(), &world, Settings::default()).unwrap();
    Arc::new(Revision::new(checker, 1, world_number))
}

fn settings() -> MonitorSettings {
    MonitorSettings { distance_limit: 5.0, ..MonitorSettings::default() }
}

fn sweeper(settings: MonitorSettings) -> Monitor {
    let mut monitor = Monitor::new(settings, stopwatch);
    monitor.set_checker(sweeper_among(&[[1.0, 0.0, 0.0]], 1));
    monitor
}

fn turned(seconds: f64, turn: f64, lift: f64) -> JointStateInput {
    input(seconds, &[("turn", turn), ("lift", lift)])
}

fn send(monitor: &mut Monitor, seconds: f64, turn: f64) -> Evaluation {
    monitor.on_joint_state(turned(seconds, turn, 0.0), at(seconds))
}

fn pair(evaluation: &Evaluation) -> Option<[String; 2]> {
    let (a, b) = evaluation.motion_since_previous.passage()?.pair?;
    let checker = &evaluation.revision.as_ref()?.checker;
    Some([a, b].map(|body| checker.body_name(body).to_owned()))
}

#[expect(clippy::unnecessary_wraps, reason = "compared with options")]
fn names(a: &str, b: &str) -> Option<[String; 2]> {
    Some([a.to_owned(), b.to_owned()])
}

fn is_proven(evaluation: &Evaluation) -> bool {
    evaluation.motion_since_previous.passed_through().is_some()
}

fn why(evaluation: &Evaluation) -> String {
    evaluation.motion_since_previous.reason().unwrap_or_default()
}

#[test]
fn a_fast_tool_that_passes_a_thin_wall_is_reported_at_every_rate() {
    for (rate, expected) in [(25.0, 1), (50.0, 1), (200.0, 1), (1000.0, 0)] {
        for check_between_states in [true, false] {
            let mut monitor = sweeper(MonitorSettings { check_between_states, ..settings() });
            let (mut passed, mut touched) = (0, 0);
            // 5 rad/s, for 0.6 rad on either side of the wall
            let steps = (0.6 * rate / 5.0_f64).ceil();
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some hundred")]
            for step in 0..2 * steps as u32 {
                let seconds = f64::from(step) / rate;
                // no state up to 200 Hz is within the 0.021 rad in which the ball touches the wall
                let evaluation = send(&mut monitor, seconds, 5.0 / rate * (f64::from(step) - steps + 0.5));
                let is_contact = evaluation.checked_state.as_ref().unwrap().report.world_collision;
                touched += u32::from(is_contact);
                passed += u32::from(is_proven(&evaluation));
                if is_proven(&evaluation) {
                    assert_eq!((code(&evaluation), evaluation.speed_scale), ("COLLIDING", 0.0));
                    assert_eq!(pair(&evaluation), names("ball", "wall0"));
                    assert!(evaluation.distance() > 0.0, "the distances are those of the state alone");
                    let passage = evaluation.motion_since_previous.passed_through().unwrap();
                    assert!(0.0 < passage.t[0] && passage.t[0] <= passage.t[1] && passage.t[1] < 1.0);
                    assert_eq!(passage.stamps[1].seconds_since(passage.stamps[0]), 1.0 / rate);
                    assert!(evaluation.foremost().unwrap().contains("between the previous state"));
                } else {
                    assert_eq!(evaluation.status == Status::Colliding, is_contact);
                }
            }
            let reported = if check_between_states { expected } else { 0 };
            assert_eq!((passed, touched > 0), (reported, rate > 500.0), "{rate} Hz {check_between_states}");
        }
    }
}

#[test]
fn only_the_message_of_the_motion_is_colliding() {
    let mut monitor = sweeper(settings());
    assert!(why(&send(&mut monitor, 0.0, -0.2)).contains("first state"));
    assert!(is_proven(&send(&mut monitor, 0.02, 0.2)));
    let again = monitor.on_heartbeat(at(0.03));
    assert_eq!((code(&again), why(&again)), ("FREE", "no new state was evaluated".to_owned()));
    // evaluated again in another world, without a motion
    monitor.set_checker(sweeper_among(&[[1.0, 0.0, 0.0]], 2));
    let again = monitor.on_heartbeat(at(0.04));
    assert_eq!((code(&again), why(&again)), ("FREE", "no new state was evaluated".to_owned()));
    let next = send(&mut monitor, 0.05, 0.21);
    assert_eq!((code(&next), &next.motion_since_previous), ("FREE", &MotionSincePrevious::ProvenFree));
}

#[test]
fn nothing_is_claimed_about_gaps() {
    let mut monitor = sweeper(settings());
    send(&mut monitor, 0.0, -0.2);
    let evaluation = send(&mut monitor, 0.6, 0.2);
    assert_eq!((code(&evaluation), is_proven(&evaluation)), ("FREE", false));
    assert!(why(&evaluation).contains("0.600 s older"), "{}", why(&evaluation));
    // by the steady clock alone, as when simulated time is slow
    let later = Now { steady: Duration::from_secs(9), ..at(0.62) };
    let evaluation = monitor.on_joint_state(turned(0.62, -0.2, 0.0), later);
    assert!(why(&evaluation).contains("s older"), "{}", why(&evaluation));
    // the clock is set back by 0.1 s
    let back = Now { steady: Duration::from_secs_f64(9.02), ..at(0.52) };
    let evaluation = monitor.on_joint_state(turned(0.52, 0.2, 0.0), back);
    assert_eq!((code(&evaluation), is_proven(&evaluation)), ("FREE", false));
    assert!(why(&evaluation).contains("clock was set back"), "{}", why(&evaluation));
    // another robot model
    let another = Arc::new(RobotModel::from_urdf(SWEEPER, &MeshFiles::default()).unwrap());
    let checker = CollisionChecker::new(another, &World::default(), Settings::default()).unwrap();
    monitor.set_checker(Arc::new(Revision::new(checker, 2, 1)));
    let back = Now { steady: Duration::from_secs_f64(9.04), ..at(0.54) };
    let evaluation = monitor.on_joint_state(turned(0.54, -0.2, 0.0), back);
    assert!(why(&evaluation).contains("first state"), "{}", why(&evaluation));
}

#[test]
fn continuous_joints_go_the_short_way_and_mimic_joints_follow() {
    let mut monitor = sweeper(settings());
    send(&mut monitor, 0.0, 3.1);
    // the short way does not lead through the wall at zero
    assert_eq!(send(&mut monitor, 0.02, -3.1).motion_since_previous, MotionSincePrevious::ProvenFree);
    // the ball passes a wall at half a turn, and the flag one in its own height
    for (at, body) in [([-1.0, 0.0, 0.0], "ball"), ([1.0, 0.0, 2.0], "flag")] {
        let mut monitor = self::sweeper(settings());
        monitor.set_checker(sweeper_among(&[at], 2));
        send(&mut monitor, 0.0, 3.0);
        let evaluation = send(&mut monitor, 0.02, -3.0);
        assert_eq!((is_proven(&evaluation), pair(&evaluation)), (true, names(body, "wall0")));
    }
}

#[test]
fn links_that_pass_through_each_other_are_reported() {
    let mut monitor = sweeper(settings());
    let quarter = std::f64::consts::FRAC_PI_2;
    for (step, turn, is_passed) in [(0, quarter - 0.1, false), (1, quarter + 0.1, true)] {
        let seconds = 0.02 * f64::from(step);
        let evaluation = monitor.on_joint_state(turned(seconds, turn, 1.0), at(seconds));
        assert_eq!(is_proven(&evaluation), is_passed);
        assert_eq!(pair(&evaluation), if is_passed { names("post", "ball") } else { None });
    }
}

/// The ball holds a rod that reaches a metre below it, where there is a wall; later it has put the rod down.
#[test]
fn an_attached_object_that_passes_a_wall_is_reported() {
    let carrying = |world_number: u64, holds: bool| {
        let mut world = World::default();
        world.add(wall("wall0", [1.0, 0.0, -1.0])).unwrap();
        if holds {
            let rod = Shape::Primitive(Primitive::cuboid([0.01, 0.01, 1.0]).unwrap());
            let rod = Obstacle::of_shape("rod", Pose::translation(1.0, 0.0, -0.5), rod);
            let touch_links = vec!["ball".to_owned()];
            world.attach(AttachedObject::grasped(&rod, "ball", &Pose::identity(), touch_links)).unwrap();
        }
        let checker = CollisionChecker::new(robot(), &world, Settings::default()).unwrap();
        Arc::new(Revision::new(checker, 1, world_number))
    };
    let mut monitor = sweeper(settings());
    monitor.set_checker(carrying(1, true));
    assert_eq!(code(&send(&mut monitor, 0.0, -0.4)), "FREE");
    let evaluation = send(&mut monitor, 0.02, 0.4);
    assert_eq!((code(&evaluation), pair(&evaluation)), ("COLLIDING", names("rod", "wall0")));
    assert!(is_proven(&evaluation));
    monitor.set_checker(carrying(2, false));
    assert_eq!(code(&send(&mut monitor, 0.04, -0.4)), "FREE");
}

#[test]
fn the_contacts_of_the_states_themselves_are_no_passages() {
    let mut monitor = sweeper(settings());
    for (seconds, turn, status) in
        [(0.0, -0.2, "FREE"), (0.02, 0.0, "COLLIDING"), (0.04, 0.001, "COLLIDING"), (0.06, 0.2, "FREE")]
    {
        let evaluation = send(&mut monitor, seconds, turn);
        assert_eq!((code(&evaluation), pair(&evaluation)), (status, None), "at {turn}");
        assert!(!is_proven(&evaluation) && evaluation.warnings.is_empty());
        assert!(seconds == 0.0 || why(&evaluation).contains("collides itself"), "{}", why(&evaluation));
    }
    // another wall between a touching state and a free one is reported, in either direction
    let walls = [[1.0, 0.0, 0.0], [0.5_f64.cos(), 0.5_f64.sin(), 0.0]];
    for (ends, status) in [([0.0, 0.8], "COLLIDING"), ([0.8, 0.0], "COLLIDING")] {
        let mut monitor = sweeper(settings());
        monitor.set_checker(sweeper_among(&walls, 2));
        send(&mut monitor, 0.0, ends[0]);
        let evaluation = send(&mut monitor, 0.02, ends[1]);
        assert_eq!((code(&evaluation), pair(&evaluation)), (status, names("ball", "wall1")));
        let t = evaluation.motion_since_previous.passage().unwrap().t;
        assert!(0.0 < t[0] && t[0] <= t[1] && t[1] < 1.0, "{t:?}");
    }
}

#[test]
fn the_current_world_counts() {
    let mut monitor = sweeper(settings());
    send(&mut monitor, 0.0, 0.4);
    // the wall in the way is new
    monitor.set_checker(sweeper_among(&[[0.5_f64.cos(), 0.5_f64.sin(), 0.0]], 2));
    assert_eq!(pair(&send(&mut monitor, 0.02, 0.6)), names("ball", "wall0"));
    // the wall in the way is gone
    monitor.set_checker(sweeper_among(&[[1.0, 0.0, 0.0]], 3));
    assert_eq!(send(&mut monitor, 0.04, 0.4).motion_since_previous, MotionSincePrevious::ProvenFree);
    // a wall where the robot was: it came later
    monitor.set_checker(sweeper_among(&[[0.4_f64.cos(), 0.4_f64.sin(), 0.0]], 4));
    let evaluation = send(&mut monitor, 0.06, 0.6);
    assert_eq!((code(&evaluation), is_proven(&evaluation)), ("FREE", false));
    assert!(why(&evaluation).contains("world has changed"), "{}", why(&evaluation));
}

/// A robot that rests near an obstacle keeps its status, whatever the tolerance.
#[test]
fn a_possible_contact_within_the_tolerance_is_a_warning() {
    let near = (RADIUS + 0.0005 + 1e-4_f64).asin() + 1e-6;
    for (joint_noise, is_open) in [(0.0, false), (1e-5, false), (1e-3, true)] {
        let mut monitor = sweeper(MonitorSettings { joint_noise, ..settings() });
        for step in 0..10 {
            let seconds = 0.02 * f64::from(step);
            let evaluation = send(&mut monitor, seconds, near + 1e-7 * f64::from(step % 2));
            let expects = is_open && step > 0;
            assert_eq!(code(&evaluation), "FREE");
            assert_eq!(pair(&evaluation), if expects { names("ball", "wall0") } else { None });
            let warns = evaluation.warnings.iter().any(|text| text.starts_with("gap_not_proven: "));
            assert_eq!(warns, expects, "{:?}", evaluation.warnings);
        }
    }
}

#[test]
fn each_publisher_has_its_own_stamp() {
    let mut monitor = sweeper(settings());
    let one = |seconds, name, position, source| JointStateInput {
        source: SourceId([source; 16]),
        ..input(seconds, &[(name, position)])
    };
    monitor.on_joint_state(one(0.0, "lift", 0.0, 1), at(0.0));
    let first = monitor.on_joint_state(one(0.01, "turn", -0.2, 2), at(0.01));
    assert!(why(&first).contains("first state"));
    let lifted = monitor.on_joint_state(one(0.02, "lift", 0.001, 1), at(0.02));
    assert_eq!(lifted.motion_since_previous, MotionSincePrevious::ProvenFree);
    let passed = monitor.on_joint_state(one(0.03, "turn", 0.2, 2), at(0.03));
    assert_eq!(pair(&passed), names("ball", "wall0"));
}

#[test]
fn a_motion_that_the_deadline_leaves_open_is_not_proven() {
    let mut monitor = sweeper(MonitorSettings { check_deadline: 1e-9, ..settings() });
    send(&mut monitor, 0.0, -0.2);
    let evaluation = send(&mut monitor, 0.02, 0.2);
    assert_eq!((code(&evaluation), is_proven(&evaluation)), ("deadline", false));
    assert!(why(&evaluation).contains("deadline"), "{}", why(&evaluation));
    // a replay does the same without a deadline
    let mut replayed = sweeper(settings());
    send(&mut replayed, 0.0, -0.2);
    replayed.leave_out(LeftOut::MotionSincePrevious);
    let evaluation = send(&mut replayed, 0.02, 0.2);
    assert_eq!((code(&evaluation), evaluation.left_out), ("FREE", LeftOut::MotionSincePrevious));
    assert_eq!(evaluation.motion_since_previous.passage().map(|gap| gap.t), Some([0.0, 1.0]));
    replayed.leave_out(LeftOut::PassageExtent);
    let evaluation = send(&mut replayed, 0.04, -0.2);
    assert_eq!((code(&evaluation), evaluation.left_out), ("COLLIDING", LeftOut::PassageExtent));
}

/// The deadline left the state in the wall open, so what touches in it is not known, in a replay as little as before.
#[test]
fn a_motion_from_a_state_that_the_deadline_left_open_is_not_proven() {
    let mut live = sweeper(MonitorSettings { check_deadline: 1e-9, ..settings() });
    assert_eq!(send(&mut live, 0.0, 0.0).left_out, LeftOut::Pairs);
    live.set_settings(settings());
    let live = send(&mut live, 0.02, 0.2);
    assert_eq!((code(&live), live.left_out), ("FREE", LeftOut::MotionSincePrevious));
    assert!(why(&live).contains("deadline"), "{}", why(&live));

    let mut replayed = sweeper(settings());
    replayed.leave_out(LeftOut::Pairs);
    send(&mut replayed, 0.0, 0.0);
    replayed.leave_out(live.left_out);
    assert_eq!(send(&mut replayed, 0.02, 0.2).motion_since_previous, live.motion_since_previous);
}

/// Joint states that come faster than they are evaluated: `passed_over` are received between two that are evaluated.
fn motion_past(passed_over: &[[f64; 2]], ends: [f64; 2], noise: f64) -> Evaluation {
    let mut monitor = sweeper(MonitorSettings { joint_noise: noise, ..settings() });
    send(&mut monitor, 0.0, ends[0]);
    for (number, [turn, lift]) in (1..).zip(passed_over) {
        let seconds = 5e-5 * f64::from(number);
        assert!(monitor.receive(turned(seconds, *turn, *lift), at(seconds)));
    }
    send(&mut monitor, 0.02, ends[1])
}

#[test]
fn joint_states_that_are_not_evaluated_are_part_of_the_motion() {
    let proven = |passed_over: &[[f64; 2]], ends, noise| {
        let evaluation = motion_past(passed_over, ends, noise);
        assert_eq!(code(&evaluation), "FREE");
        let is_proven = evaluation.motion_since_previous == MotionSincePrevious::ProvenFree;
        assert_eq!(is_proven, evaluation.history.since_heartbeat.all_free);
        assert!(
            is_proven || why(&evaluation).contains("lies beside the checked line"),
            "{}",
            why(&evaluation)
        );
        is_proven
    };
    let rest = [-0.5, -0.5];
    assert!(proven(&[], rest, 0.0));
    // into the wall and back, also after a whole turn
    assert!(!proven(&[[0.0, 0.0]], rest, 0.0));
    assert!(!proven(&[[-0.4, 0.0], [std::f64::consts::TAU, 0.0], [-0.4, 0.0]], rest, 0.0));
    // so near that the distances suffice
    assert!(proven(&[[-0.499, 0.0], [-0.501, 0.0]], rest, 0.0));
    // on the line, or within its tube: it passes close to the wall, where the distances do not suffice
    let near = [-0.5, -0.02];
    assert!(proven(&[[-0.3, 0.0], [-0.1, 0.0]], near, 0.0));
    assert!(!proven(&[[-0.3, 0.001]], near, 0.0));
    assert!(proven(&[[-0.3, 0.001]], near, 0.002));
    assert!(!proven(&[[-0.3, f64::NAN]], near, 0.002));
    let many: Vec<[f64; 2]> = (0..300).map(|_| [-0.5, 0.0]).collect();
    assert!(!proven(&many, rest, 0.0), "more than are kept");
}
