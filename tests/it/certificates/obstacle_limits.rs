//! Tests of certificates that hold for every motion of obstacles within their limits.

use std::sync::Arc;

use clearance::checker::{MotionOptions, MotionVerdict, UndecidedReason};
use clearance::motion::{ObstacleLimits, SpeedLimit, Trajectory, TrajectoryPoint};
use clearance::verifier::{ExpectedMotion, Verifier};

use super::margins::SLIDE;
use super::{Scene, wall};

/// The ball moves 0.05 m towards the wall and back, from 1 s to 3 s; its gap at rest is 0.375 m.
fn there_and_back(scene: &Scene) -> Trajectory {
    let point = |time_from_start: f64, position: f64| TrajectoryPoint {
        positions: vec![position],
        time_from_start,
        ..TrajectoryPoint::default()
    };
    let points = [point(1.0, 0.0), point(2.0, 0.05), point(3.0, 0.0)];
    let rest = scene.robot.default_configuration();
    Trajectory::from_points(&scene.robot, &["d".to_owned()], &points, &rest).unwrap()
}

fn limits(name: &str, speed: f64) -> Arc<ObstacleLimits> {
    let by_name = [(name.to_owned(), SpeedLimit { speed, acceleration: 0.0 })].into();
    Arc::new(ObstacleLimits { by_name, ..ObstacleLimits::default() })
}

#[test]
fn what_is_free_for_all_motions_of_the_wall_is_verified() {
    let scene = Scene::new(SLIDE, wall());
    let limited = |speed: f64, latency: f64| {
        there_and_back(&scene).with_obstacle_limits(&scene.world, &limits("wall", speed), latency).unwrap()
    };
    let certificate = scene.certify(&limited(0.1, 0.0)).unwrap();
    let verifier = Verifier::new(&scene.robot, &scene.world, &scene.settings, None).unwrap();
    verifier.verify(&certificate).unwrap();
    for (speed, is_covered) in [(0.1, true), (0.05, true), (0.101, false)] {
        let motion = Some(limited(speed, 0.0));
        let expected = ExpectedMotion { motion, ..ExpectedMotion::default() };
        assert_eq!(verifier.verify_expected(&certificate, &expected).is_ok(), is_covered, "{speed}");
    }
    // the wall gets as far as the ball before 3 s, or has moved before the trajectory begins
    for (speed, latency) in [(0.13, 0.0), (0.1, 0.8)] {
        let options = MotionOptions::default();
        let report = scene.checker.check_trajectory(
            &limited(speed, latency),
            &options,
            &mut scene.checker.workspace(),
        );
        let reason = UndecidedReason::Tube;
        assert!(
            matches!(report.verdict, MotionVerdict::Undecided { reason: found, .. } if found == reason),
            "{report:?}"
        );
        let [time, _] = report.time.unwrap();
        let soonest = (0.375 / speed - latency).min(3.0);
        assert!(time <= soonest && time > soonest - 0.2, "{time} {soonest}");
    }
}

#[test]
fn limits_that_do_not_fit_are_rejected() {
    let scene = Scene::new(SLIDE, wall());
    let timed = there_and_back(&scene);
    let error = timed.clone().with_obstacle_limits(&scene.world, &limits("wal", 0.1), 0.0).unwrap_err();
    assert!(error.to_string().contains("the world has no such obstacle"), "{error}");
    for (speed, latency) in [(-0.1, 0.0), (f64::NAN, 0.0), (0.1, -2.0), (0.1, f64::INFINITY)] {
        assert!(timed.clone().with_obstacle_limits(&scene.world, &limits("wall", speed), latency).is_err());
    }
    let untimed = Trajectory::of_segments(vec![scene.straight(&[0.0], &[0.1])]).unwrap();
    assert!(untimed.with_obstacle_limits(&scene.world, &limits("wall", 0.1), 0.0).is_err());
}

/// A second segment that knows obstacles anew, or not at all, is no continuation.
#[test]
fn limits_that_end_between_segments_are_a_mismatch() {
    let scene = Scene::new(SLIDE, wall());
    let limited =
        there_and_back(&scene).with_obstacle_limits(&scene.world, &limits("wall", 0.1), 0.0).unwrap();
    let first = limited.segments()[0].clone();
    let second = limited.segments()[1].nominal();
    assert!(Trajectory::of_segments(vec![first.clone(), second]).is_err());
    assert!(Trajectory::of_segments(vec![first.clone(), limited.segments()[1].clone()]).is_ok());
    let mut is_first = true;
    let forgetful = limited
        .map(|segment| {
            let segment = if is_first { segment } else { segment.nominal() };
            is_first = false;
            Ok::<_, std::convert::Infallible>(segment)
        })
        .unwrap();
    let report =
        scene.checker.check_trajectory(&forgetful, &MotionOptions::default(), &mut scene.checker.workspace());
    assert!(!report.is_free(), "{report:?}");
}
