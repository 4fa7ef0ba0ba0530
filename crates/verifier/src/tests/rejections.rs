//! Tests that true certificates are accepted, and altered ones are rejected.

use clearance_checker::CollisionChecker;
use clearance_geometry::math::{Point, Pose, Vector};
use clearance_geometry::testing::Random;
use clearance_geometry::{Primitive, Shape};
use clearance_motion::{
    Certificate, MotionSegment, MovingObstacle, ObstacleLimits, ObstacleUncertainty, Proof, SpeedLimit,
    Trajectory, UncertaintyText,
};
use clearance_robot::{MeshFiles, RobotModel};
use clearance_scene::{AllowedCollisionMatrix, AttachedObject};
use clearance_scene::{MeshModel, Settings};
use clearance_scene::{Obstacle, World};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::alterations::ALTERATIONS;
use super::prover::prove;
use super::scenes;
use crate::{ExpectedMotion, Rejection, Verifier, verify};

const TWO_LINK: &str = include_str!("../../../../urdf/two_link/two_link.urdf");

fn two_link() -> RobotModel {
    RobotModel::from_urdf(TWO_LINK, &MeshFiles::default()).unwrap()
}

fn ball(name: &str, centre: [f64; 3]) -> Obstacle {
    let pose_rs = Pose::from_parts(Vector::from(centre).into(), nalgebra::UnitQuaternion::identity());
    let shape = Shape::Primitive(Primitive::Sphere { radius: 0.1 });
    Obstacle::of_shape(name, pose_rs, shape)
}

/// Two balls outside the arm's reach, one of which comes and goes.
fn balls() -> World {
    let mut world = World::default();
    world.add(ball("still", [0.0, -2.5, 0.0])).unwrap();
    world.add(ball("comes", [3.0, 0.0, 0.5])).unwrap();
    world
}

fn straight(robot: &RobotModel, from: &[f64], to: &[f64]) -> MotionSegment {
    let [from, to] = [from, to].map(|q| robot.configuration(q).unwrap());
    MotionSegment::straight(robot, &from, &to)
}

/// The ball that comes, on its way from one place to another.
fn coming(from: [f64; 3], to: [f64; 3]) -> Vec<MovingObstacle> {
    let [from, to] =
        [from, to].map(|v| Pose::from_parts(Vector::from(v).into(), nalgebra::UnitQuaternion::identity()));
    vec![MovingObstacle::between("comes", Point::new(3.0, 0.0, 0.5), &from, &to)]
}

/// Out, along a curve, and back within a tube.
fn tour(robot: &RobotModel) -> Vec<MotionSegment> {
    let first = straight(robot, &[0.0, 0.5], &[1.0, -0.5]);
    let bent = vec![[1.0, -0.5, 0.25, 0.25, 0.5, -0.5], [-0.5, 0.25, 0.0, 0.5, -0.25, 0.0]];
    let second = MotionSegment::polynomial(robot, bent).unwrap();
    let third = straight(robot, &[1.0, 0.0], &[0.0, 0.5]).with_tube(robot, vec![0.02, 0.03]).unwrap();
    let moves = [
        coming([0.0; 3], [-0.3, 0.2, 0.0]),
        coming([-0.3, 0.2, 0.0], [0.1, 0.0, 0.0]),
        coming([0.1, 0.0, 0.0], [0.0; 3]),
    ];
    [first, second, third].into_iter().zip(moves).map(|(s, m)| s.with_movers(m).unwrap()).collect()
}

fn settings() -> Settings {
    Settings { padding: 0.01, ..Settings::default() }
}

#[test]
fn what_is_proven_is_accepted() {
    let (robot, world) = (two_link(), balls());
    let verifier = Verifier::new(&robot, &world, &settings(), None).unwrap();
    let certificate = prove(&verifier, &settings(), &tour(&robot)).unwrap();
    let found = verifier.verify(&certificate).unwrap();
    assert_eq!((found.segments, found.pairs), (3, 7));
    assert_eq!(found.proofs, certificate.segments.iter().map(|s| s.proofs.len()).sum::<usize>());
    let read = Certificate::from_json(&certificate.to_json()).unwrap();
    assert_eq!(verifier.verify(&read).unwrap(), found);
    // unless it says so, nobody expects that obstacles make way
    let moves = verifier.verify_expected(&certificate, &ExpectedMotion::default()).unwrap_err().to_string();
    assert!(moves.contains("obstacle 'comes' moves, expected to stand"), "{moves}");
}

#[test]
fn a_verification_that_is_stopped_accepts_nothing() {
    let (robot, world, stop) = (two_link(), balls(), AtomicBool::new(false));
    let verifier = Verifier::new(&robot, &world, &settings(), None).unwrap().stopped_by(&stop);
    let certificate = prove(&verifier, &settings(), &tour(&robot)).unwrap();
    assert!(verifier.verify(&certificate).is_ok());
    stop.store(true, Ordering::Relaxed);
    assert!(matches!(verifier.verify(&certificate), Err(Rejection::Stopped)));
}

#[test]
fn whatever_is_altered_is_rejected() {
    let (robot, world) = (two_link(), balls());
    let verifier = Verifier::new(&robot, &world, &settings(), None).unwrap();
    let certificate = prove(&verifier, &settings(), &tour(&robot)).unwrap();
    for (what, alter, fits) in ALTERATIONS {
        let mut altered = certificate.clone();
        alter(&mut altered);
        if *what != "format" {
            let rejection = verifier.verify(&altered).unwrap_err();
            assert!(matches!(rejection, Rejection::Digest), "{what}: {rejection}");
        }
        altered.digest = altered.content_hash();
        let rejection = verifier.verify(&altered).expect_err(what);
        assert!(fits(&rejection), "{what}: {rejection:?}");
    }
    let mut altered = certificate.clone();
    altered.digest.replace_range(..1, "x");
    assert!(matches!(verifier.verify(&altered), Err(Rejection::Digest)));
}

#[test]
fn it_holds_for_one_robot_one_world_and_one_set_of_rules() {
    let (robot, world) = (two_link(), balls());
    let verifier = Verifier::new(&robot, &world, &settings(), None).unwrap();
    let certificate = prove(&verifier, &settings(), &tour(&robot)).unwrap();
    let thinner = RobotModel::from_urdf(&TWO_LINK.replace("0.01", "0.009"), &MeshFiles::default()).unwrap();
    let rejected =
        |robot: &RobotModel, world: &World, settings: &Settings, matrix: Option<&AllowedCollisionMatrix>| {
            verify(robot, world, settings, matrix, &certificate).unwrap_err()
        };
    assert!(matches!(rejected(&thinner, &world, &settings(), None), Rejection::Model(_)));
    let mut elsewhere = World::default();
    elsewhere.add(ball("still", [0.0, -2.5, 0.0])).unwrap();
    elsewhere.add(ball("comes", [3.0, 0.0, 0.5 + 1e-12])).unwrap();
    assert!(matches!(rejected(&robot, &elsewhere, &settings(), None), Rejection::World(_)));
    for other in [
        Settings { padding: 0.02, ..settings() },
        Settings { link_padding: [("tip".to_owned(), 0.0)].into(), ..settings() },
        Settings { pad_self: true, ..settings() },
        Settings { check_self: false, ..settings() },
        Settings { check_world: false, ..settings() },
        Settings { mesh_model: MeshModel::Solid, ..settings() },
    ] {
        assert!(matches!(rejected(&robot, &world, &other, None), Rejection::Model(_)), "{other:?}");
    }
    // without a matrix adjacent links are left out, with one they are not
    let matrix = AllowedCollisionMatrix::default();
    assert!(matches!(rejected(&robot, &world, &settings(), Some(&matrix)), Rejection::Model(_)));
    let mut matrix = AllowedCollisionMatrix::default();
    for (a, b) in [("base", "upper"), ("upper", "tip"), ("still", "tip")] {
        matrix.set(a, b, true);
    }
    assert!(matches!(rejected(&robot, &world, &settings(), Some(&matrix)), Rejection::UnknownPair(..)));
    let bad = Settings { padding: f64::NAN, ..settings() };
    assert!(matches!(rejected(&robot, &world, &bad, None), Rejection::BadPadding { .. }));
    for bad in [
        Settings { link_padding: [("x".to_owned(), 0.0)].into(), ..settings() },
        Settings { link_scale: [("x".to_owned(), 2.0)].into(), ..settings() },
    ] {
        let rejection = rejected(&robot, &world, &bad, None);
        assert!(matches!(rejection, Rejection::UnknownLink(_)));
        assert_eq!(rejection.to_string(), "padding or scale is given for link 'x', which the robot has not");
    }
    let mut held = balls();
    let still = held.obstacle_by_name("still").unwrap();
    let object = AttachedObject::grasped(still, "hand", &Pose::identity(), vec![]);
    held.attach(object).unwrap();
    let rejection = rejected(&robot, &held, &settings(), None);
    assert!(matches!(rejection, Rejection::NoCarrier { .. }));
    let text = "object 'still' is attached to link 'hand', which the robot has not";
    assert_eq!(rejection.to_string(), text);
}

/// Changes a true certificate to one of another motion, as a forger would: all its fields are consistent, but it is not true.
fn forged(mut certificate: Certificate, segments: &[MotionSegment]) -> Certificate {
    for (proof, segment) in certificate.segments.iter_mut().zip(segments) {
        proof.motion = segment.text();
    }
    certificate.motion = certificate.motion_hash();
    certificate.digest = certificate.content_hash();
    certificate
}

/// Certificates of every kind of lie about a motion that hits something.
fn assert_cannot_pass(
    verifier: &Verifier,
    settings: &Settings,
    free: &[MotionSegment],
    hits: &[MotionSegment],
) {
    assert!(prove(verifier, settings, hits).is_err());
    let honest = prove(verifier, settings, free).unwrap();
    let mut forgery = forged(honest, hits);
    verifier.verify(&forgery).unwrap_err();
    let mut random = Random::new(76);
    for _ in 0..300 {
        let parts = 1 + u32::try_from(random.below(40)).unwrap();
        for segment in &mut forgery.segments {
            segment.proofs.clear();
            for pair in 0..verifier.model.required.pairs.len() {
                let padding = verifier.model.required.pairs[pair].padding;
                let end = |k: u32| f64::from(k) / f64::from(parts);
                let bound = [1e-9, 0.01, 0.5, 3.0][random.below(4)] * (1.0 + random.within(1.0));
                let lower = bound + padding + [1e-8, 1e-3, 1.0][random.below(3)];
                segment.proofs.extend((0..parts).map(|k| Proof(pair, end(k), end(k + 1), lower, bound)));
            }
        }
        forgery.digest = forgery.content_hash();
        verifier.verify(&forgery).unwrap_err();
    }
}

#[test]
fn a_motion_that_hits_cannot_pass() {
    let (robot, world) = (two_link(), balls());
    let verifier = Verifier::new(&robot, &world, &settings(), None).unwrap();
    let free = [straight(&robot, &[0.0, 0.0], &[0.0, 2.6])];
    // the tip folds back into the base
    let hits = [straight(&robot, &[0.0, 0.0], &[0.0, 2.84])];
    assert_cannot_pass(&verifier, &settings(), &free, &hits);
    // it stays clear of it, but it may be off
    let within = [straight(&robot, &[0.0, 0.0], &[0.0, 2.6]).with_tube(&robot, vec![0.0, 0.25]).unwrap()];
    assert_cannot_pass(&verifier, &settings(), &free, &within);
    // it stands, and the ball comes
    let still = [straight(&robot, &[0.0, 0.0], &[0.0, 0.0])];
    let hit = coming([0.0; 3], [-1.0, 0.0, -0.5]);
    let hit = [straight(&robot, &[0.0, 0.0], &[0.0, 0.0]).with_movers(hit).unwrap()];
    assert_cannot_pass(&verifier, &settings(), &still, &hit);
    // it stands, and the ball may come
    let may_hit = limited(&robot, 1.0, [[0.0, 3.0]]);
    assert_cannot_pass(&verifier, &settings(), &still, &may_hit);
}

/// The robot stands, and obstacles may move for these times (s).
fn limited<const N: usize>(robot: &RobotModel, speed: f64, times: [[f64; 2]; N]) -> Vec<MotionSegment> {
    let by_name = [("still".to_owned(), SpeedLimit { speed: 0.0, acceleration: 0.1 })].into();
    let limits = Arc::new(ObstacleLimits { default: SpeedLimit { speed, acceleration: 0.0 }, by_name });
    let uncertainty = |time| ObstacleUncertainty::new(Arc::clone(&limits), time).unwrap();
    times.map(|time| straight(robot, &[0.0, 0.0], &[0.0, 0.0]).with_uncertainty(uncertainty(time))).into()
}

/// Alterations of limits of obstacles, with a test of the rejection.
type LimitAlteration = (&'static str, fn(&mut UncertaintyText), fn(&Rejection) -> bool);

const LIMIT_ALTERATIONS: &[LimitAlteration] = &[
    ("faster", |u| u.limits.default.speed = 1.0, |r| matches!(r, Rejection::ObstacleLimits { segment: 1 })),
    ("longer", |u| u.time[1] = 3.0, |r| matches!(r, Rejection::Bound { segment: 1, .. })),
    ("known anew", |u| u.time = [0.0, 0.1], |r| matches!(r, Rejection::ObstacleLimits { segment: 1 })),
    ("negative", |u| u.limits.default.speed = -1.0, |r| matches!(r, Rejection::Motion { segment: 1, .. })),
    ("backwards", |u| u.time = [2.0, 1.0], |r| matches!(r, Rejection::Motion { segment: 1, .. })),
    ("no number", |u| u.time[1] = f64::NAN, |r| matches!(r, Rejection::Motion { segment: 1, .. })),
];

#[test]
fn limits_of_obstacles_are_part_of_the_claim() {
    let (robot, world) = (two_link(), balls());
    let verifier = Verifier::new(&robot, &world, &settings(), None).unwrap();
    let motion = limited(&robot, 0.1, [[0.0, 1.0], [1.0, 2.0]]);
    let certificate = prove(&verifier, &settings(), &motion).unwrap();
    verifier.verify(&Certificate::from_json(&certificate.to_json()).unwrap()).unwrap();
    for (what, alter, fits) in LIMIT_ALTERATIONS {
        let mut altered = certificate.clone();
        alter(altered.segments[1].motion.obstacle_uncertainty.as_mut().unwrap());
        altered.motion = altered.motion_hash();
        altered.digest = altered.content_hash();
        let rejection = verifier.verify(&altered).expect_err(what);
        assert!(fits(&rejection), "{what}: {rejection:?}");
    }
    let mut altered = forged(certificate.clone(), &limited(&robot, 0.1, [[0.0, 1.0]]));
    altered.segments[1].motion.obstacle_uncertainty = None;
    altered.motion = altered.motion_hash();
    altered.digest = altered.content_hash();
    assert!(matches!(verifier.verify(&altered), Err(Rejection::ObstacleLimits { segment: 1 })));
    let expected = |motion: Vec<MotionSegment>| {
        let motion = Some(Trajectory::of_segments(motion).unwrap());
        verifier.verify_expected(&certificate, &ExpectedMotion { motion, ..ExpectedMotion::default() })
    };
    expected(motion).unwrap();
    let error = expected(limited(&robot, 0.2, [[0.0, 1.0], [1.0, 2.0]])).unwrap_err().to_string();
    assert!(error.contains("segment 0: obstacles have moved for 0.0 to 1.0 s, by up to 0.1 m/s"), "{error}");
}

#[test]
fn what_lies_inside_a_closed_mesh_is_rejected_where_meshes_are_solid() {
    let robot = two_link();
    let mut world = World::default();
    let ends = [[9., 0., 0.], [-9., 0., 0.], [0., 9., 0.], [0., -9., 0.], [0., 0., 9.], [0., 0., -9.]];
    let shape = scenes::eight_faces(ends.map(Point::from));
    let pose_rs = Pose::identity();
    world.add(Obstacle::of_shape("hall", pose_rs, shape)).unwrap();
    let motion = [straight(&robot, &[0.0, 0.0], &[0.5, 0.5])];
    for mesh_model in [MeshModel::Surface, MeshModel::Solid] {
        let settings = Settings { mesh_model, ..settings() };
        let verifier = Verifier::new(&robot, &world, &settings, None).unwrap();
        let certificate = prove(&verifier, &settings, &motion).unwrap();
        let checker = CollisionChecker::new(Arc::new(robot.clone()), &world, settings.clone()).unwrap();
        let free = checker.is_free(&motion[0].at(0.5), &mut checker.workspace());
        assert_eq!(free, mesh_model == MeshModel::Surface);
        let found = verifier.verify(&certificate);
        assert!(
            matches!((&found, free), (Ok(_), true) | (Err(Rejection::Inside { .. }), false)),
            "{found:?}"
        );
    }
}

/// Random robots with joints of all kinds: what is proven is accepted, and never hits at any sampled instant.
#[test]
fn random_motions() {
    let mut random = Random::new(78);
    let mut accepted = 0;
    for _ in 0..60 {
        let robot = scenes::robot(&mut random, &scenes::ALL_KINDS);
        let world = scenes::world(&mut random, 3.0);
        let motion = scenes::motion(&mut random, &robot, 0.3);
        let settings = Settings { check_self: random.below(4) == 0, padding: 0.005, ..Settings::default() };
        let verifier = Verifier::new(&robot, &world, &settings, None).unwrap();
        let segments = [motion];
        let Ok(certificate) = prove(&verifier, &settings, &segments) else { continue };
        // its obstacles have moved already when it begins: accepted only if that is expected
        let motion = Some(Trajectory::of_segments(segments.to_vec()).unwrap());
        verifier
            .verify_expected(&certificate, &ExpectedMotion { motion, ..ExpectedMotion::default() })
            .unwrap();
        let displaced =
            segments[0].obstacles().iter().any(|mover| mover.displacement(0.0) != Pose::identity());
        let strictly = verifier.verify(&certificate);
        assert!(matches!(
            (&strictly, displaced),
            (Ok(_), false) | (Err(Rejection::ObstacleStart { .. }), true)
        ));
        accepted += 1;
        if segments[0].obstacles().is_empty() {
            let checker = CollisionChecker::new(Arc::new(robot.clone()), &world, settings.clone()).unwrap();
            let mut workspace = checker.workspace();
            assert!((0..=50).all(|k| checker.is_free(&segments[0].at(f64::from(k) / 50.0), &mut workspace)));
        }
    }
    println!("{accepted} of 60 were free");
    assert!(accepted > 20, "{accepted}");
}

/// Proofs of links and objects at their original size do not apply to larger ones.
#[test]
fn larger_bodies_are_verified_as_large_as_they_are() {
    let (robot, world) = (two_link(), balls());
    let unscaled = Verifier::new(&robot, &world, &settings(), None).unwrap();
    for (larger, holds) in [
        (Settings { link_scale: [("tip".to_owned(), 4.0)].into(), ..settings() }, false),
        (Settings { object_scale: [("still".to_owned(), 20.0)].into(), ..settings() }, false),
        (Settings { link_scale: [("tip".to_owned(), 0.5)].into(), ..settings() }, true),
    ] {
        // as if the proofs were about the larger ones
        let forged = prove(&unscaled, &larger, &tour(&robot)).unwrap();
        let verifier = Verifier::new(&robot, &world, &larger, None).unwrap();
        assert_eq!(verifier.verify(&forged).is_ok(), holds, "{larger:?}");
        let own = prove(&verifier, &larger, &tour(&robot));
        assert!(own.is_err() || verifier.verify(&own.unwrap()).is_ok());
    }
    let bad = Settings { link_scale: [("tip".to_owned(), -1.0)].into(), ..settings() };
    assert!(matches!(Verifier::new(&robot, &world, &bad, None), Err(Rejection::CannotScale { .. })));
}
