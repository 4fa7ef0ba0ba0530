//! Tests of recovery from collisions: nearby free states, and joint velocities that reduce the penetration.

use std::sync::Arc;
use std::time::{Duration, Instant};

use clearance::checker::{
    CollisionChecker, FreeState, MotionOptions, NoFreeState, Question, Recovery, RecoveryError,
    RecoveryOptions, Retreat,
};
use clearance::geometry::math::Pose;
use clearance::geometry::{Primitive, Shape};
use clearance::motion::MotionSegment;
use clearance::robot::{Configuration, MeshFiles, RobotModel};
use clearance::scene::{Obstacle, Settings, World};
use clearance::verifier::verify;
use serde_json::Value;

use crate::program::Folder;
use crate::random::Random;
use crate::streams::{checkers, random_state};

/// Largest distance (rad) of a colliding state from the free state that it is made of.
const NEAR: f64 = 0.3;

/// Random states that collide, with a free state within [`NEAR`].
pub fn colliding_states(checker: &CollisionChecker, random: &mut Random, count: usize) -> Vec<Configuration> {
    let mut workspace = checker.workspace();
    let mut found = Vec::new();
    while found.len() < count {
        let free = random_state(checker, random);
        if !checker.is_free(&free, &mut workspace) {
            continue;
        }
        let by: Vec<f64> = free.positions().iter().map(|_| random.within(-1.0, 1.0)).collect();
        let length = by.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
        let moved = free.positions().iter().zip(&by).map(|(q, by)| q + NEAR * by / length);
        let mut moved: Vec<f64> = moved.collect();
        for joint in checker.robot().joint_ids() {
            let limits = checker.robot().joint(joint).limits;
            if let (Some(limits), Some(first)) = (limits, checker.robot().first_position(joint)) {
                moved[first] = moved[first].clamp(limits.lower, limits.upper);
            }
        }
        let q = checker.robot().configuration(&moved).unwrap();
        if !checker.is_free(&q, &mut workspace) {
            found.push(q);
        }
    }
    found
}

fn norm(a: &Configuration, b: &Configuration) -> f64 {
    a.positions().iter().zip(b.positions()).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

fn between(checker: &CollisionChecker, a: &Configuration, b: &Configuration, t: f64) -> Configuration {
    let positions = a.positions().iter().zip(b.positions()).map(|(a, b)| a + t * (b - a));
    checker.robot().configuration(&positions.collect::<Vec<f64>>()).unwrap()
}

/// Checks the guarantees of a free state, by single states and by the verifier.
fn verify_free_state(
    checker: &CollisionChecker,
    q: &Configuration,
    options: &RecoveryOptions,
    found: &FreeState,
) {
    let mut workspace = checker.workspace();
    let FreeState { state, distance, exit, .. } = found;
    let report = checker.check(state, Question::Distance { limit: f64::INFINITY }, &mut workspace);
    assert!(report.is_free());
    assert!(report.nearest.is_none_or(|nearest| nearest.distance >= options.clearance - 1e-12));
    assert!((distance - norm(q, state)).abs() < 1e-12 && *distance <= options.largest_distance + 1e-12);
    assert!(checker.robot().outside_limits(state.positions()).next().is_none());
    let steps = (checker.travel(q.positions(), state.positions()) / FreeState::LONGEST_STEP).ceil().max(1.0);
    let before = (0..).map(|i| f64::from(i) / steps).take_while(|t| *t < exit - 1e-12);
    for t in before {
        assert!(!checker.is_free(&between(checker, q, state, t), &mut workspace));
    }
    let after = between(checker, q, state, *exit);
    for i in 0..=50 {
        assert!(checker.is_free(&between(checker, &after, state, f64::from(i) / 50.0), &mut workspace));
    }
    let segment = MotionSegment::straight(checker.robot(), &after, state);
    let (report, certificate) = checker.certify_motion(&segment, &MotionOptions::default(), &mut workspace);
    assert!(report.is_free(), "{report:?}");
    verify(checker.robot(), checker.world(), checker.settings(), None, &certificate.unwrap()).unwrap();
}

/// The demo arm in its world with padding, and the dual arm alone.
fn arms() -> [CollisionChecker; 2] {
    let [demo_arm, dual_arm] = checkers();
    let alone = CollisionChecker::new(Arc::clone(dual_arm.robot()), &World::default(), Settings::default());
    [demo_arm, alone.unwrap()]
}

/// The number of states matters, not the time.
#[test]
fn nearly_all_states_have_a_way_out() {
    let mut random = Random::new(3);
    for checker in arms() {
        let options = RecoveryOptions::default();
        let mut workspace = checker.workspace();
        let (mut found_count, mut farther, states) = (0, 0, colliding_states(&checker, &mut random, 100));
        for q in &states {
            let found = match checker.find_free_state(q, &options, &mut workspace).unwrap() {
                Recovery::Found(found) => found,
                Recovery::NoneFound(_) => continue,
                Recovery::AlreadyFree => panic!("{q:?} collides"),
            };
            verify_free_state(&checker, q, &options, &found);
            found_count += 1;
            farther += usize::from(found.distance > NEAR + 0.01);
        }
        println!("{}: {found_count} of {}, {farther} farther", checker.robot().name(), states.len());
        assert!(found_count >= 95 && farther <= 5, "{}: {found_count}, {farther}", checker.robot().name());
    }
}

#[test]
fn results_repeat_and_a_free_state_stays() {
    let [checker, _] = checkers();
    let options = RecoveryOptions::default();
    let states = colliding_states(&checker, &mut Random::new(5), 5);
    let mut workspace = checker.workspace();
    let all = |workspace: &mut _| -> Vec<Recovery> {
        states.iter().map(|q| checker.find_free_state(q, &options, workspace).unwrap()).collect()
    };
    let first = all(&mut workspace);
    assert_eq!(first, all(&mut workspace));
    assert_eq!(first, all(&mut checker.portable_workspace()));
    assert_eq!(first, all(&mut checker.streaming_workspace()));
    let Recovery::Found(found) = &first[0] else { panic!("{first:?}") };
    assert_eq!(
        checker.find_free_state(&found.state, &RecoveryOptions { clearance: 0.0, ..options }, &mut workspace),
        Ok(Recovery::AlreadyFree)
    );
}

/// A finger of two joints that turn about z, 1 m each, between two walls.
const FINGER: &str = "<robot name='finger'>
  <link name='base'/>
  <link name='first'><collision><origin xyz='0.5 0 0'/><geometry><box size='0.9 0.02 0.02'/></geometry></collision></link>
  <link name='second'><collision><origin xyz='0.5 0 0'/><geometry><box size='0.9 0.02 0.02'/></geometry></collision></link>
  <joint name='shoulder' type='revolute'><parent link='base'/><child link='first'/><axis xyz='0 0 1'/>
    <limit lower='-0.1' upper='0.4' effort='1' velocity='1'/></joint>
  <joint name='elbow' type='revolute'><parent link='first'/><child link='second'/><origin xyz='1 0 0'/><axis xyz='0 0 1'/>
    <limit lower='-1' upper='1' effort='1' velocity='1'/></joint>
</robot>";

/// The finger with a ball of radius 0.1 m at these places.
fn finger(balls: &[[f64; 2]]) -> CollisionChecker {
    let robot = RobotModel::from_urdf(FINGER, &MeshFiles::default()).unwrap();
    let mut world = World::default();
    for (i, [x, y]) in balls.iter().enumerate() {
        let ball = Shape::Primitive(Primitive::sphere(0.1).unwrap());
        world.add(Obstacle::of_shape(format!("ball{i}"), Pose::translation(*x, *y, 0.0), ball)).unwrap();
    }
    CollisionChecker::new(Arc::new(robot), &world, Settings::default()).unwrap()
}

fn state(checker: &CollisionChecker, positions: [f64; 2]) -> Configuration {
    checker.robot().configuration(&positions).unwrap()
}

fn recover(checker: &CollisionChecker, positions: [f64; 2], options: &RecoveryOptions) -> Recovery {
    checker.find_free_state(&state(checker, positions), options, &mut checker.workspace()).unwrap()
}

#[test]
fn locked_joints_limits_and_groups_hold() {
    // the ball touches the second link from below: up is nearer, with both joints
    let checker = finger(&[[1.5, -0.08]]);
    let joint = |name: &str| checker.robot().joint_by_name(name).unwrap();
    let options = RecoveryOptions::default();
    let Recovery::Found(both) = recover(&checker, [0.0, 0.0], &options) else { panic!() };
    let only = |locked: &str| {
        let options = RecoveryOptions { locked: vec![joint(locked)], ..options.clone() };
        match recover(&checker, [0.0, 0.0], &options) {
            Recovery::Found(found) => found,
            other => panic!("{other:?}"),
        }
    };
    let (by_elbow, by_shoulder) = (only("shoulder"), only("elbow"));
    assert_eq!(by_elbow.state.positions()[0], 0.0);
    assert_eq!(by_shoulder.state.positions()[1], 0.0);
    assert!(both.distance <= by_elbow.distance && both.distance <= by_shoulder.distance);
    // 0.03 m over an arm of 1.5 m and 0.5 m; the clearance is much smaller
    assert!((by_shoulder.distance - 0.03 / 1.5).abs() < 0.002, "{by_shoulder:?}");
    assert!((by_elbow.distance - 0.03 / 0.5).abs() < 0.006, "{by_elbow:?}");
    assert!((both.distance - 0.03 / 1.5_f64.hypot(0.5)).abs() < 0.002, "{both:?}");
    // at its upper limit the shoulder can only turn down, through the ball
    let listed = RecoveryOptions { joints: Some(vec![joint("shoulder")]), ..options };
    let ball = [1.5 * 0.4_f64.cos(), 1.5 * 0.4_f64.sin()];
    let above = finger(&[[ball[0] + 0.08 * 0.4_f64.sin(), ball[1] - 0.08 * 0.4_f64.cos()]]);
    let Recovery::Found(through) = recover(&above, [0.4, 0.0], &listed) else { panic!() };
    assert!(through.state.positions()[0] < 0.4 - 0.1, "{through:?}");
    let wide = RecoveryOptions { largest_distance: 0.05, ..listed };
    assert!(matches!(
        recover(&above, [0.4, 0.0], &wide),
        Recovery::NoneFound(NoFreeState { unmoved: None, .. })
    ));
}

/// Right at a contact there is no room for a proof: the free state is a little farther away.
#[test]
fn states_that_hardly_touch_have_a_way_out_without_clearance() {
    let checker = finger(&[[0.5, 0.05], [1.5, 0.05]]);
    let options = RecoveryOptions { clearance: 0.0, ..RecoveryOptions::default() };
    let mut workspace = checker.workspace();
    // the border of the positions of the shoulder that collide
    let (mut free, mut touches) = (0.4, 0.0);
    for _ in 0..60 {
        let middle = 0.5 * (free + touches);
        if checker.is_free(&state(&checker, [middle, 0.0]), &mut workspace) {
            free = middle;
        } else {
            touches = middle;
        }
    }
    for depth in [1e-12, 1e-9, 1e-7, 1e-5] {
        let found = recover(&checker, [touches - depth, 0.0], &options);
        let Recovery::Found(found) = found else { panic!("{depth}: {found:?}") };
        assert!(found.distance < depth + 2e-5, "{depth}: {found:?}");
    }
}

#[test]
fn what_cannot_be_done_has_a_name() {
    let checker = finger(&[[0.5, 0.05], [1.5, 0.05]]);
    let joint = |name: &str| checker.robot().joint_by_name(name).unwrap();
    let elbow_only = RecoveryOptions { joints: Some(vec![joint("elbow")]), ..RecoveryOptions::default() };
    let Recovery::NoneFound(none) = recover(&checker, [0.0, 0.0], &elbow_only) else { panic!() };
    assert_eq!(none.reason(), "not_movable");
    let (a, b) = none.unmoved.unwrap();
    assert_eq!([checker.body_name(a), checker.body_name(b)], ["first", "ball0"]);
    let too_far = RecoveryOptions { clearance: 10.0, ..RecoveryOptions::default() };
    let Recovery::NoneFound(none) = recover(&checker, [0.0, 0.0], &too_far) else { panic!() };
    assert!(none.reason() == "not_movable" && none.checks < 1000, "no ball can be 10 m away: {none:?}");
    let few = RecoveryOptions { most_checks: 10, clearance: 0.3, ..RecoveryOptions::default() };
    let Recovery::NoneFound(none) = recover(&checker, [0.0, 0.0], &few) else { panic!() };
    assert_eq!(none.reason(), "unfinished");
    let past = Instant::now().checked_sub(Duration::from_secs(1)).unwrap_or_else(Instant::now);
    let late = RecoveryOptions { deadline: Some(past), ..RecoveryOptions::default() };
    let Recovery::NoneFound(none) = recover(&checker, [0.0, 0.0], &late) else { panic!() };
    assert_eq!(none.reason(), "unfinished");

    let q = state(&checker, [0.0, 0.0]);
    let wrong = RecoveryOptions { largest_distance: f64::NAN, ..RecoveryOptions::default() };
    let error = checker.find_free_state(&q, &wrong, &mut checker.workspace()).unwrap_err();
    assert!(error.to_string().contains("largest_distance"), "{error}");
    assert!(matches!(
        RecoveryOptions::of_group(checker.robot(), "arm"),
        Err(RecoveryError::UnknownGroup { .. })
    ));
}

/// Depths of pairs of convex shapes are exact: the fastest of many velocities is compared.
#[test]
fn no_velocity_reduces_the_penetration_faster() {
    let mut random = Random::new(7);
    let checker = finger(&[[1.5, -0.05], [0.6, 0.09]]);
    let mut workspace = checker.workspace();
    let options = RecoveryOptions::default();
    let penetration = |q: &Configuration, workspace: &mut _| {
        let found = checker.clearance(q, 0.0, workspace);
        found.pairs.iter().map(|pair| -pair.distance).fold(0.0, f64::max)
    };
    let mut compared = 0;
    for _ in 0..200 {
        let q = state(&checker, [random.within(-0.09, 0.09), random.within(-0.1, 0.1)]);
        let Retreat::Direction(retreat) = checker.retreat_direction(&q, &options, &mut workspace).unwrap()
        else {
            assert!(checker.is_free(&q, &mut workspace));
            continue;
        };
        let depth = penetration(&q, &mut workspace);
        assert!((depth - retreat.depth).abs() < 1e-9);
        let length: f64 = retreat.velocities.iter().map(|v| v * v).sum();
        assert!((length - 1.0).abs() < 1e-12);
        let step = 1e-6;
        let fall = |velocities: &[f64], workspace: &mut _| {
            let moved = q.positions().iter().zip(velocities).map(|(q, v)| q + step * v);
            let moved = checker.robot().configuration(&moved.collect::<Vec<f64>>()).unwrap();
            (depth - penetration(&moved, workspace)) / step
        };
        let rate = fall(&retreat.velocities, &mut workspace);
        assert!((rate - retreat.rate).abs() < 1e-3, "{rate} {retreat:?}");
        for i in 0..90 {
            let angle = f64::from(i) * std::f64::consts::TAU / 90.0;
            assert!(fall(&[angle.cos(), angle.sin()], &mut workspace) <= rate + 1e-3);
        }
        compared += 1;
    }
    assert!(compared > 100, "{compared}");
}

#[test]
fn retreat_respects_limits_and_locked_joints() {
    let checker = finger(&[[1.5, -0.05]]);
    let joint = |name: &str| checker.robot().joint_by_name(name).unwrap();
    let mut workspace = checker.workspace();
    let q = state(&checker, [0.0, 0.0]);
    let options = RecoveryOptions { locked: vec![joint("shoulder")], ..RecoveryOptions::default() };
    let Retreat::Direction(elbow) = checker.retreat_direction(&q, &options, &mut workspace).unwrap() else {
        panic!()
    };
    assert_eq!(elbow.velocities, [0.0, 1.0]);
    assert!((elbow.rate - 0.5).abs() < 0.05 && elbow.pairs_without_depth == 0, "{elbow:?}");
    let both =
        RecoveryOptions { locked: vec![joint("shoulder"), joint("elbow")], ..RecoveryOptions::default() };
    assert!(matches!(checker.retreat_direction(&q, &both, &mut workspace), Ok(Retreat::Stuck(_))));
    let free = finger(&[]);
    let q = state(&free, [0.0, 0.0]);
    assert_eq!(free.retreat_direction(&q, &options, &mut free.workspace()), Ok(Retreat::Free));
}

#[test]
fn the_command_prints_states_and_reasons() {
    let world = "world:
  collision_objects:
    - id: ball
      primitives: [{type: sphere, dimensions: [0.1]}]
      primitive_poses: [{position: [1.5, -0.08, 0], orientation: [0, 0, 0, 1]}]
";
    let folder = Folder::of(FINGER, world);
    let run = |more: &[&str]| {
        let given = ["recover", "--urdf", "r.urdf", "--world", "w.yaml", "--state", "shoulder=0 elbow=0"];
        folder.run(&[&given, more].concat())
    };
    let found = run(&["--format", "json"]);
    assert_eq!(found.status.code(), Some(0), "{found:?}");
    let json: Value = serde_json::from_slice(&found.stdout).unwrap();
    let result = &json["results"][0];
    assert_eq!(result["result"], "found");
    assert!(result["distance"].as_f64().unwrap() < 0.03 && result["state"].as_array().unwrap().len() == 2);
    let text = String::from_utf8(run(&[]).stdout).unwrap();
    assert!(
        text.contains("state 0: free state at a distance of 0.0") && text.contains("  shoulder: 0.0000 to ")
    );
    let none = run(&["--locked", "shoulder,elbow"]);
    assert_eq!(none.status.code(), Some(1));
    assert!(
        String::from_utf8(none.stdout)
            .unwrap()
            .contains("no joint that may move moves ball and second apart")
    );
    for (wrong, word) in [
        (["--locked", "wrist"], "wrist"),
        (["--group", "arm"], "arm"),
        (["--clearance", "-1"], "--clearance"),
        (["--max-distance", "nan"], "--max-distance"),
        (["--deadline", "0"], "--deadline"),
    ] {
        let rejected = run(&wrong);
        assert_eq!(rejected.status.code(), Some(2));
        assert!(String::from_utf8(rejected.stderr).unwrap().contains(word));
    }
}
