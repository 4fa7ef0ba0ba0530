//! What verifying costs; it only prints: `cargo test --release speed -- --ignored --nocapture`.

use std::f64::consts::PI;
use std::sync::Arc;
use std::time::Instant;

use super::prover::prove;
use crate::checker::Settings;
use crate::geometry::{Shape, TriangleMesh};
use crate::math::{Point, Pose, Vector};
use crate::motion::{MotionSegment, Proof};
use crate::robot::{MeshFiles, RobotModel};
use crate::testing::Random;
use crate::verifier::Verifier;
use crate::world::{Obstacle, ObstacleShape, World};

const ARM: &str = include_str!("../../../urdf/demo_arm/demo_arm.urdf");

/// A ball of 2 · 2 · `n`² triangles.
fn ball(n: u32, radius: f64) -> Shape {
    let corner = |i: u32, j: u32| {
        let (polar, around) = (f64::from(i) / f64::from(n) * PI, f64::from(j) / f64::from(n) * PI);
        Point::new(polar.sin() * around.cos(), polar.sin() * around.sin(), polar.cos()) * radius
    };
    let wide = 2 * n + 1;
    let vertices = (0..=n).flat_map(|i| (0..wide).map(move |j| corner(i, j))).collect();
    let at = |i: u32, j: u32| i * wide + j;
    let faces = (0..n).flat_map(|i| {
        (0..2 * n).flat_map(move |j| {
            [[at(i, j), at(i + 1, j), at(i, j + 1)], [at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]]
        })
    });
    Shape::Mesh(Arc::new(TriangleMesh::new(vertices, faces.collect()).unwrap()))
}

#[test]
#[ignore = "a measurement"]
fn speed() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("urdf/demo_arm");
    let robot = RobotModel::from_urdf(ARM, &MeshFiles::under(folder)).unwrap();
    let mut world = World::default();
    let mut random = Random::new(79);
    for i in 0..10 {
        let away = random.direction().into_inner() * 1.2 + Vector::new(0.0, 0.0, 0.5);
        let placed =
            ObstacleShape { pose_rs: Pose::from_parts(away.into(), random.rotation()), shape: ball(50, 0.1) };
        world.add(Obstacle { name: format!("ball {i}"), shapes: vec![placed] }).unwrap();
    }
    let settings = Settings::default();
    let begun = Instant::now();
    let verifier = Verifier::new(&robot, &world, &settings, None).unwrap();
    println!("built in {:.1?}, {} pairs", begun.elapsed(), verifier.subject.pairs.len());
    for _ in 0..12 {
        let q = |random: &mut Random| {
            robot.position_names().iter().map(|_| random.within(0.7)).collect::<Vec<_>>()
        };
        let [from, to] = [q(&mut random), q(&mut random)].map(|q| robot.configuration(&q).unwrap());
        let motion = [MotionSegment::straight(&robot, &from, &to)];
        let Ok(certificate) = prove(&verifier, &settings, &motion) else { continue };
        // as a prover with capsules would have it: rougher bounds, and distances that are no better than needed
        let mut rough = certificate.clone();
        for Proof(_, _, _, lower, bound) in rough.segments.iter_mut().flat_map(|s| &mut s.proofs) {
            *bound += 0.2 * (*lower - *bound);
            *lower -= 0.3 * (*lower - *bound);
        }
        rough.digest = rough.content_hash();
        for (what, certificate) in [("exact", certificate), ("rough", rough)] {
            let begun = Instant::now();
            let found = verifier.verify(&certificate).unwrap();
            let took = begun.elapsed();
            let begun = Instant::now();
            let hashed = [certificate.content_hash(), certificate.motion_hash()].len();
            let hashing = begun.elapsed();
            let each = took / u32::try_from(found.proofs).unwrap();
            println!(
                "{what}: {took:.0?}, of that {hashing:.0?} for {hashed} hashes: {each:.2?} a proof; {found:?}"
            );
        }
    }
}
