//! Tests of the joins of a certificate's segments: they are exact, or the gap between them is proven free.

use clearance::checker::{MotionOptions, MotionVerdict};
use clearance::geometry::math::{Point, Pose};
use clearance::geometry::{Primitive, Shape};
use clearance::motion::{MotionSegment, MovingObstacle, Trajectory, TrajectoryPoint};
use clearance::scene::{AttachedObject, World};
use clearance::verifier::Rejection;

use super::{Scene, obstacle, sheet, wall};
use crate::random::Random;

/// A slide along x that follows `lead` by a factor; its link has a box or, if `held`, a sheet in its hand.
fn follower(multiplier: f64, held: bool) -> Scene {
    let solid =
        if held { "" } else { "<collision><geometry><box size='0.1 0.1 0.1'/></geometry></collision>" };
    let urdf = format!(
        "<robot name='follower'><link name='base'/>
        <joint name='lead' type='prismatic'><parent link='base'/><child link='leader'/><axis xyz='0 1 0'/>
          <limit lower='-10' upper='10' effort='1' velocity='1'/></joint><link name='leader'/>
        <joint name='follow' type='prismatic'><parent link='base'/><child link='tool'/><axis xyz='1 0 0'/>
          <mimic joint='lead' multiplier='{multiplier}'/><limit lower='-10' upper='10' effort='1' velocity='1'/></joint>
        <link name='tool'>{solid}</link></robot>"
    );
    if !held {
        return Scene::new(&urdf, wall());
    }
    let mut world = World::default();
    world.add(obstacle("sheet", sheet(), [0.5, 0.0, 0.0])).unwrap();
    let own = obstacle("held", sheet(), [0.0; 3]);
    world.attach(AttachedObject::grasped(&own, "tool", &Pose::identity(), vec![])).unwrap();
    Scene::new(&urdf, world)
}

/// Both segments are free, but what lies between them is not: neither the checker nor the verifier takes them for one motion.
fn assert_gap_is_found(scene: &Scene, segments: Vec<MotionSegment>, what: &str) {
    let forged = scene.spliced(&segments);
    let rejection = scene.verify(&forged).expect_err(what);
    assert!(matches!(rejection, Rejection::OpenJoin { segment: 1, .. }), "{what}: {rejection:?}");
    let trajectory = Trajectory::of_segments(segments).unwrap();
    let report = scene.checker.check_trajectory(
        &trajectory,
        &MotionOptions::default(),
        &mut scene.checker.workspace(),
    );
    let MotionVerdict::Undecided { t, pair, .. } = report.verdict else { panic!("{what}: {report:?}") };
    assert!(t == [0.0, 0.0] && report.segment == 1 && pair.is_some(), "{what}: {report:?}");
    assert!(scene.certify(&trajectory).is_none(), "{what}");
}

#[test]
fn nothing_passes_through_a_gap() {
    for (multiplier, held) in [(50.0, true), (1e4, true), (1e9, false), (-1e9, false)] {
        let scene = follower(multiplier, held);
        let at = |x: f64| x / multiplier;
        let gap = 4.9e-10 * multiplier.signum();
        let first = scene.straight(&[at(-1.0)], &[at(0.5) - gap]);
        let second = scene.straight(&[at(0.5) + gap], &[at(2.0)]);
        assert_gap_is_found(&scene, vec![first, second], &format!("straight, {multiplier}"));
        let bent = |a: f64, b: f64| {
            MotionSegment::polynomial(&scene.robot, vec![[a, 0.0, b - a, 0.0, 0.0, 0.0]]).unwrap()
        };
        let curved = vec![bent(at(-1.0), at(0.5) - gap), bent(at(0.5) + gap, at(2.0))];
        assert_gap_is_found(&scene, curved, &format!("polynomials, {multiplier}"));
    }
}

#[test]
fn floating_bodies_do_not_turn_through_a_gap() {
    // ten metres from the joint a turn by 1e-9 is 1e-8 m
    let urdf =
        "<robot name='floats'><link name='base'/><joint name='free' type='floating'><parent link='base'/>
        <child link='tool'/></joint><link name='tool'/></robot>";
    let mut world = World::default();
    let own = obstacle("held", sheet(), [0.0, 0.0, 0.0]);
    let far = Pose::translation(0.0, 1000.0, 0.0).inverse();
    world.attach(AttachedObject::grasped(&own, "tool", &far, vec![])).unwrap();
    world.add(obstacle("sheet", sheet(), [0.0, 1000.0, 0.0])).unwrap();
    let scene = Scene::new(urdf, world);
    let turned = |angle: f64| [0.0, 0.0, 0.0, 0.0, 0.0, (0.5 * angle).sin(), (0.5 * angle).cos()];
    let first = scene.straight(&turned(-1e-3), &turned(-4.5e-10));
    let second = scene.straight(&turned(4.5e-10), &turned(1e-3));
    assert_gap_is_found(&scene, vec![first, second], "a turn");
    // a quaternion and its negative are one orientation
    let end = turned(-5e-4);
    let joined = [scene.straight(&turned(-1e-3), &end), scene.straight(&end.map(|q| -q), &turned(-4e-4))];
    scene.verify(&scene.spliced(&joined)).unwrap();
}

#[test]
fn obstacles_do_not_jump_through_a_gap() {
    let urdf = "<robot name='stands'><link name='base'><collision><geometry><sphere radius='0.001'/></geometry></collision></link>
        <link name='other'/><joint name='j' type='revolute'><parent link='base'/><child link='other'/><axis xyz='0 0 1'/>
          <limit lower='-1' upper='1' effort='1' velocity='1'/></joint></robot>";
    let mut world = World::default();
    world.add(obstacle("sheet", sheet(), [-1e6, 0.0, 0.0])).unwrap();
    let scene = Scene::new(urdf, world);
    let shifted = |x: f64| Pose::translation(x, 0.0, 0.0);
    let moving = |from: f64, to: f64| {
        let mover = MovingObstacle::between("sheet", Point::origin(), &shifted(from), &shifted(to));
        scene.straight(&[0.0], &[0.0]).with_obstacles(&scene.world, vec![mover]).unwrap()
    };
    let middle = 1e6;
    let (before, after) = (middle - 0.0012, middle + 0.0012);
    // larger than rounding explains
    let torn = [moving(0.0, before), moving(after, 1.1e6)];
    let rejection = scene.verify(&scene.spliced(&torn)).unwrap_err();
    assert!(matches!(rejection, Rejection::ObstacleJump { segment: 1, .. }), "{rejection:?}");
    // within it, a sheet may pass a grain
    let grain = "<robot name='grain'><link name='base'><collision><geometry><sphere radius='1e-5'/></geometry></collision></link>
        <link name='other'/><joint name='j' type='revolute'><parent link='base'/><child link='other'/><axis xyz='0 0 1'/>
          <limit lower='-1' upper='1' effort='1' velocity='1'/></joint></robot>";
    let scene = Scene::new(grain, scene.world);
    let moving = |from: f64, to: f64| {
        let mover = MovingObstacle::between("sheet", Point::origin(), &shifted(from), &shifted(to));
        scene.straight(&[0.0], &[0.0]).with_obstacles(&scene.world, vec![mover]).unwrap()
    };
    let segments = vec![moving(0.0, middle - 4e-4), moving(middle + 4e-4, 1.1e6)];
    assert_gap_is_found(&scene, segments, "an obstacle");
}

/// Rounding at the ends of polynomials makes gaps, and these are free.
#[test]
fn trajectories_of_polynomials_are_certified() {
    let urdf = include_str!("../../../urdf/two_link/two_link.urdf");
    let mut world = World::default();
    let ball = Shape::Primitive(Primitive::sphere(0.1).unwrap());
    world.add(obstacle("ball", ball, [1.5, 1.5, 0.0])).unwrap();
    let scene = Scene::new(urdf, world);
    let joints = ["joint1", "joint2"].map(str::to_owned);
    let mut random = Random::new(12);
    let mut free = 0;
    for case in 0..60 {
        let mut time = 0.0;
        let points: Vec<TrajectoryPoint> = (0..6)
            .map(|_| {
                time += random.within(0.1, 2.0);
                let pair = |random: &mut Random, size: f64| {
                    vec![random.within(-size, size), random.within(-size, size)]
                };
                TrajectoryPoint {
                    positions: pair(&mut random, 0.6),
                    velocities: pair(&mut random, 0.3),
                    accelerations: if case % 2 == 0 { pair(&mut random, 0.2) } else { vec![] },
                    time_from_start: time,
                }
            })
            .collect();
        let rest = scene.robot.default_configuration();
        let trajectory = Trajectory::from_points(&scene.robot, &joints, &points, &rest).unwrap();
        if let Some(certificate) = scene.certify(&trajectory) {
            free += 1;
            assert_eq!(scene.verify(&certificate).unwrap().segments, 5);
        }
    }
    assert!(free > 20, "{free}");
}

/// Of two points that a trajectory goes straight through, every digit is kept.
#[test]
fn straight_ways_join_without_rounding() {
    let scene = follower(1e9, false);
    let mut random = Random::new(13);
    let ends: Vec<[f64; 1]> = (0..200).map(|_| [random.within(-1e-9, 0.3e-9)]).collect();
    let segments: Vec<_> = ends.windows(2).map(|two| scene.straight(&two[0], &two[1])).collect();
    let trajectory = Trajectory::of_segments(segments).unwrap();
    let certificate = scene.certify(&trajectory).unwrap();
    for two in certificate.segments.windows(2) {
        assert_eq!(two[0].motion.to, two[1].motion.from);
    }
    scene.verify(&certificate).unwrap();
}
