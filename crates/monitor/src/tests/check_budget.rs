//! Tests of the check budget: joint states at a rate that is too high for exact distances.

use clearance_geometry::math::{Point, Pose};
use clearance_geometry::{Shape, TriangleMesh};
use clearance_scene::{AttachedObject, Obstacle};

use super::*;

/// A square wave-shaped mesh: its distance from a second one above it is almost the same everywhere.
fn waves() -> Shape {
    const SIDE: u32 = 70;
    let place = |i: u32| f64::from(i) / f64::from(SIDE) - 0.5;
    let corners = (0..SIDE * SIDE).map(|i| {
        let (x, y) = (place(i % SIDE), place(i / SIDE));
        Point::new(x, y, 0.002 * (40.0 * x).sin() * (40.0 * y).cos())
    });
    let squares = (0..SIDE * (SIDE - 1)).filter(|i| i % SIDE < SIDE - 1);
    let halves = squares.flat_map(|i| [[i, i + 1, i + SIDE], [i + 1, i + SIDE + 1, i + SIDE]]);
    Shape::Mesh(Arc::new(TriangleMesh::new(corners.collect(), halves.collect()).unwrap()))
}

/// The folding robot with a wave-shaped mesh at its tip, which slides over a second one.
fn slider() -> Arc<Revision> {
    let robot = RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap();
    let mut world = World::default();
    let held = Obstacle::of_shape("held", Pose::translation(1.5, 0.0, 0.3), waves());
    world.attach(AttachedObject::grasped(&held, "ball", &Pose::identity(), vec![])).unwrap();
    world.add(Obstacle::of_shape("floor", Pose::translation(2.5, 0.0, 0.25), waves())).unwrap();
    let checker = CollisionChecker::new(Arc::new(robot), &world, Settings::default()).unwrap();
    Arc::new(Revision::new(checker, 1, 0))
}

fn monitor_of(exact_distance_share: f64) -> Monitor {
    let settings = MonitorSettings { exact_distance_share, ..MonitorSettings::default() };
    let mut monitor = Monitor::new(settings, stopwatch);
    monitor.set_checker(slider());
    monitor
}

fn is_exact(evaluation: &Evaluation) -> bool {
    evaluation.checked_state.as_ref().unwrap().is_exact
}

/// The evaluations of so many joint states from a time (s) on, at this interval (s).
fn evaluated_from(monitor: &mut Monitor, begin: f64, count: u32, interval: f64) -> Vec<Evaluation> {
    let states = (0..count).map(|i| {
        let (seconds, angle) = (begin + interval * f64::from(i), 1e-4 * f64::from(i));
        monitor.on_joint_state(state(seconds, [angle, 0.0]), at(seconds))
    });
    states.collect()
}

/// The evaluations of joint states at this interval (s).
fn evaluated_at(monitor: &mut Monitor, interval: f64) -> Vec<Evaluation> {
    evaluated_from(monitor, 0.0, 40, interval)
}

#[test]
fn distances_are_lower_bounds_only_while_there_is_no_time_for_exact_ones() {
    let [mut patient, mut slow, mut fast] = [0.0, 0.2, 0.2].map(monitor_of);
    let truth = evaluated_at(&mut patient, 0.001);
    assert!(truth.iter().all(is_exact));
    let unhurried = evaluated_at(&mut slow, 0.2);
    let hurried = evaluated_at(&mut fast, 0.001);
    assert!(unhurried.iter().all(is_exact));
    let (first, later) = hurried.split_at(16);
    assert!(first.iter().all(is_exact), "how fast joint states come is not known yet");
    let rough = later.iter().filter(|evaluation| !is_exact(evaluation)).count();
    assert!(rough > 20, "{rough} of 24");
    for ((truth, slow), fast) in truth.iter().zip(&unhurried).zip(&hurried) {
        assert_eq!((code(truth), code(fast)), ("FREE", "FREE"));
        assert_eq!(truth.distance(), slow.distance());
        let (told, truth) = (fast.distance(), truth.distance());
        assert!(told <= truth && told >= truth - (0.1 * truth).max(0.001) - 1e-9, "{told}, not {truth}");
    }
    // when the joint states pause, there is time for exact distances
    let paused = fast.on_heartbeat(at(0.2));
    assert!(is_exact(&paused));
    assert_eq!(paused.distance(), truth.last().unwrap().distance());
}

fn exact_ones(evaluations: &[Evaluation]) -> usize {
    evaluations.iter().filter(|evaluation| is_exact(evaluation)).count()
}

/// Joint states that have queued while the host paused the node come at once: with exact distances, more would queue.
#[test]
fn the_rate_before_a_pause_limits_the_checks_after_it() {
    let mut monitor = monitor_of(0.2);
    let before = exact_ones(&evaluated_from(&mut monitor, 0.0, 40, 0.001)[16..]);
    let pause = monitor.on_heartbeat(at(0.3));
    assert!(is_exact(&pause), "there is time");
    let after = evaluated_from(&mut monitor, 0.5, 40, 0.001);
    assert!(exact_ones(&after[..16]) <= before + 4, "{} {before}", exact_ones(&after[..16]));
    // slower joint states: the old rate is forgotten at the second pause
    let slow = evaluated_from(&mut monitor, 1.0, 40, 0.2);
    assert!(slow[1..].iter().all(is_exact));
}

#[test]
fn recordings_of_earlier_versions_have_no_limit_after_a_pause() {
    let mut monitor = monitor_of(0.2);
    monitor.forget_rate_in_pauses();
    evaluated_from(&mut monitor, 0.0, 40, 0.001);
    let after = evaluated_from(&mut monitor, 0.5, 40, 0.001);
    assert!(after[..16].iter().all(is_exact));
    assert!(exact_ones(&after) < 40);
}
