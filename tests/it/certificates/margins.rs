//! Tests of certificates with a margin: the verifier proves that no pair is ever nearer than it.

use clearance::Question;
use clearance::checker::MotionOptions;
use clearance::geometry::{Primitive, Shape};
use clearance::motion::{Certificate, Trajectory};
use clearance::scene::World;
use clearance::verifier::{ExpectedMotion, Rejection, Verifier};

use super::{Scene, obstacle, resign, wall};
use crate::random::Random;

/// A ball of radius 0.1 m on a slide along x; the wall begins at x = 0.475 m.
pub const SLIDE: &str = "<robot name='slide'><link name='base'/>
<joint name='d' type='prismatic'><parent link='base'/><child link='ball'/><axis xyz='1 0 0'/>
  <limit lower='-10' upper='10' effort='1' velocity='1'/></joint>
<link name='ball'><collision><geometry><sphere radius='0.1'/></geometry></collision></link></robot>";

/// Two bars of half a metre on revolute joints, and a ball at the end.
const ARM: &str = "<robot name='arm'><link name='base'/>
<joint name='a' type='continuous'><parent link='base'/><child link='upper'/><axis xyz='0 0 1'/></joint>
<link name='upper'><collision><origin xyz='0.25 0 0'/><geometry><box size='0.5 0.06 0.06'/></geometry></collision></link>
<joint name='b' type='continuous'><parent link='upper'/><child link='lower'/><origin xyz='0.5 0 0'/><axis xyz='0 0 1'/></joint>
<link name='lower'><collision><origin xyz='0.25 0 0'/><geometry><box size='0.5 0.04 0.04'/></geometry></collision>
<collision><origin xyz='0.5 0 0'/><geometry><sphere radius='0.05'/></geometry></collision></link></robot>";

const SAMPLES: u32 = 500;

fn certify(scene: &Scene, trajectory: &Trajectory, margin: f64) -> Option<Certificate> {
    let options = MotionOptions { margin, ..MotionOptions::default() };
    scene.checker.certify_trajectory(trajectory, &options, &mut scene.checker.workspace()).1
}

/// The ball comes within 0.125 m of the wall.
fn near_the_wall(margin: f64) -> (Scene, Option<Certificate>) {
    let scene = Scene::new(SLIDE, wall());
    let motion = Trajectory::of_segments(vec![scene.straight(&[0.0], &[0.25])]).unwrap();
    let certificate = certify(&scene, &motion, margin);
    (scene, certificate)
}

#[test]
fn a_margin_is_proven_up_to_the_least_distance() {
    let (scene, certificate) = near_the_wall(0.124);
    let certificate = certificate.unwrap();
    assert_eq!(certificate.margin, Some(0.124));
    scene.verify(&certificate).unwrap();
    assert_eq!(Certificate::from_json(&certificate.to_json()).unwrap(), certificate);
    assert!(near_the_wall(0.126).1.is_none());
    assert!(near_the_wall(f64::NAN).1.is_none() && near_the_wall(f64::INFINITY).1.is_none());
}

#[test]
fn an_altered_margin_is_rejected() {
    let (scene, certificate) = near_the_wall(0.05);
    let certificate = certificate.unwrap();
    let with = |margin: Option<f64>, signed: bool| {
        let mut altered = certificate.clone();
        altered.margin = margin;
        if signed {
            resign(&mut altered);
        }
        scene.verify(&altered)
    };
    assert!(matches!(with(Some(0.06), false), Err(Rejection::Digest)));
    assert!(matches!(with(None, false), Err(Rejection::Digest)));
    for margin in [0.1251, 0.2, 5.0, 1e300] {
        assert!(with(Some(margin), true).is_err(), "{margin}");
    }
    for margin in [f64::NAN, f64::INFINITY, -0.01] {
        assert!(matches!(with(Some(margin), true), Err(Rejection::BadMargin(_))), "{margin}");
    }
    // a smaller claim is proven, too
    with(Some(0.01), true).unwrap();
    with(None, true).unwrap();
}

#[test]
fn the_expected_margin_is_a_least_one() {
    let (scene, certificate) = near_the_wall(0.05);
    let (certificate, old) = (certificate.unwrap(), near_the_wall(0.0).1.unwrap());
    assert_eq!(old.margin, None);
    let Scene { robot, world, settings, .. } = &scene;
    let verifier = Verifier::new(robot, world, settings, None).unwrap();
    let accepts = |certificate: &Certificate, margin: f64| {
        let expected = ExpectedMotion { margin: Some(margin), ..ExpectedMotion::default() };
        match verifier.verify_expected(certificate, &expected) {
            Ok(_) => true,
            Err(Rejection::OtherMotion(differences)) => {
                assert!(differences.to_string().contains("margin"), "{differences}");
                false
            }
            Err(other) => panic!("{other}"),
        }
    };
    assert!(accepts(&certificate, 0.05) && accepts(&certificate, 0.0) && !accepts(&certificate, 0.0501));
    assert!(accepts(&old, 0.0) && !accepts(&old, 1e-9) && !accepts(&certificate, f64::NAN));
}

/// Against sampled distances: what is proven is never nearer, and a margin above the least distance is rejected.
#[test]
fn margins_hold_at_all_samples() {
    let mut world = World::default();
    let shape = Shape::Primitive(Primitive::cuboid([0.1, 0.1, 0.3]).unwrap());
    world.add(obstacle("block", shape, [0.8, 0.4, 0.0])).unwrap();
    let scene = Scene::new(ARM, world);
    let mut workspace = scene.checker.workspace();
    let mut random = Random::new(12);
    let mut proven = 0;
    for _ in 0..60 {
        let points: Vec<[f64; 2]> =
            (0..3).map(|_| [random.within(-2.0, 2.0), random.within(-2.5, 2.5)]).collect();
        let segments = points.windows(2).map(|ends| scene.straight(&ends[0], &ends[1])).collect();
        let motion = Trajectory::of_segments(segments).unwrap();
        let margin = random.within(0.0, 0.1);
        let Some(mut certificate) = certify(&scene, &motion, margin) else { continue };
        scene.verify(&certificate).unwrap();
        let mut least = f64::INFINITY;
        for segment in motion.segments() {
            for i in 0..=SAMPLES {
                let q = segment.at(f64::from(i) / f64::from(SAMPLES));
                let report =
                    scene.checker.check(&q, Question::Distance { limit: f64::INFINITY }, &mut workspace);
                least = least.min(report.nearest.unwrap().distance);
            }
        }
        assert!(least > margin, "{least} {margin}");
        certificate.margin = Some(least + 1e-6);
        resign(&mut certificate);
        assert!(scene.verify(&certificate).is_err(), "{least} {margin}");
        proven += 1;
    }
    assert!(proven > 15, "only {proven} motions are proven");
}
