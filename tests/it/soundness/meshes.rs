//! Tests of meshes against meshes, with one to two thousand triangles, and of points inside solid meshes.

use clearance::geometry::math::{Point, Pose, Vector};
use clearance::geometry::{Shape, TriangleMesh};
use clearance::proximity::{CollisionBody, Scratch, collide, distance};

use super::laws::{Case, Scrutiny, judge};
use super::ledger::{Family, Ledger, survey};
use super::share;
use super::solid_oracle::solid_distance;
use super::subject::Subject;
use super::triangles::OF_TRIANGLES;
use crate::random::Random;

fn ask(
    name: &'static str,
    seed: u64,
    counts: (usize, usize),
    make: impl Fn(&mut Random) -> TriangleMesh + Sync,
) {
    let family = Family { name, accuracy: OF_TRIANGLES };
    let count = share(counts.0, counts.1);
    let ledger = survey(count, seed, |random, ledger| {
        let (a, b) = (Subject::mesh(make(random)), Subject::mesh(make(random)));
        judge_poses(&a, &b, &family, random, ledger);
    });
    ledger.finish(&family, count);
}

/// A random pose, and from there straight towards each other until they are a small gap or overlap from touching.
fn judge_poses(a: &Subject, b: &Subject, family: &Family, random: &mut Random, ledger: &mut Ledger) {
    let ((centre_a, ball_a), (centre_b, ball_b)) = (a.solid.ball(), b.solid.ball());
    let rotation = random.rotation();
    let apart = random.vector(1.0).normalize() * (random.within(0.1, 1.2) * (ball_a + ball_b));
    let pose_ab = Pose::from_parts((centre_a + apart - rotation * centre_b).into(), rotation);
    let case = Case { a, b, pose_ab };
    let scrutiny = Scrutiny::mostly_laws(random);
    judge(&case, family.accuracy, scrutiny, random, ledger);
    let mut near = case;
    let gap = solid_distance(&a.solid, &b.solid, &pose_ab, f64::INFINITY).unwrap_or(0.0);
    let shift = gap - ball_a.min(1.0) * 10f64.powf(random.within(-12.0, -2.0));
    near.pose_ab.translation.vector -= apart.normalize() * shift;
    judge(&near, family.accuracy, Scrutiny::mostly_answers(random), random, ledger);
}

/// Few triangles most often, now and then thousands.
fn some(random: &mut Random, most: f64) -> u32 {
    let count = most.powf(random.within(0.0, 1.0)).round();
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let count = count as u32;
    count.max(1)
}

fn transformed(mesh: &TriangleMesh, f: impl Fn(&Point) -> Point) -> TriangleMesh {
    let vertices = mesh.vertices().iter().map(f).collect();
    TriangleMesh::new(vertices, mesh.triangles().to_vec()).expect("finite corners")
}

#[test]
fn soups() {
    ask("triangle soups", 500, (60, 5_000), |random| {
        let edge = random.within(0.02, 0.5);
        let count = some(random, 2000.0);
        random.soup(count, 0.5, edge)
    });
}

#[test]
fn blobs() {
    ask("closed blobs", 501, (60, 5_000), |random| {
        let rings = 2 + some(random, 20.0);
        let size = random.within(0.2, 1.0);
        random.blob(rings, size)
    });
}

/// Flattened and stretched until triangles are slivers of any aspect.
#[test]
fn needles_and_plates() {
    ask("needles and plates", 502, (60, 5_000), |random| {
        let rings = 2 + some(random, 12.0);
        let blob = random.blob(rings, 1.0);
        let mut factor = || 10f64.powf(random.within(-6.0, 0.0));
        let stretch = Vector::new(factor(), factor(), 1.0);
        let turn = random.rotation();
        transformed(&blob, |p| turn * Point::from(p.coords.component_mul(&stretch)))
    });
}

/// Vertices and triangles twice, triangles without area, and neighbours that do not share their corners.
#[test]
fn duplicates_and_degenerates() {
    ask("duplicates and degenerates", 503, (60, 5_000), |random| {
        let rings = 2 + some(random, 8.0);
        let blob = random.blob(rings, 0.5);
        let mut vertices = blob.vertices().to_vec();
        let mut triangles = blob.triangles().to_vec();
        let offset = u32::try_from(vertices.len()).expect("few");
        vertices.extend_from_within(..);
        for i in 0..triangles.len() {
            let [a, b, c] = triangles[i];
            match random.below(6) {
                0 => triangles.push([a, b, c]),
                1 => triangles.push([a + offset, b + offset, c + offset]),
                2 => triangles.push([a, a, b]),
                3 => triangles.push([c; 3]),
                4 => triangles[i] = [a, b + offset, c],
                _ => (),
            }
        }
        TriangleMesh::new(vertices, triangles).expect("a mesh")
    });
}

/// A fan of slivers around one corner, as the ends of cylinders in CAD meshes are.
#[test]
fn fans() {
    ask("fans of slivers", 504, (60, 5_000), |random| {
        let count = 3 + some(random, 500.0);
        let height = 10f64.powf(random.within(-6.0, 0.0));
        let rim = (0..count).map(|i| {
            let turn = std::f64::consts::TAU * f64::from(i) / f64::from(count);
            Point::new(turn.cos(), turn.sin(), 0.0)
        });
        let vertices: Vec<Point> = std::iter::once(Point::new(0.0, 0.0, height)).chain(rim).collect();
        let triangles = (0..count).map(|i| [0, 1 + i, 1 + (i + 1) % count]);
        TriangleMesh::new(vertices, triangles.collect()).expect("a mesh")
    });
}

#[test]
fn huge_and_tiny() {
    ask("meshes, 1 um to 1 km", 505, (60, 5_000), |random| {
        let scale = 10f64.powf(random.within(-6.0, 3.0));
        let rings = 2 + some(random, 8.0);
        random.blob(rings, scale)
    });
}

#[test]
fn far_from_the_origin() {
    ask("meshes far from their origin", 506, (60, 5_000), |random| {
        let rings = 2 + some(random, 8.0);
        let blob = random.blob(rings, 0.5);
        let far = random.vector(1.0) * 10f64.powf(random.within(1.0, 6.0));
        transformed(&blob, |p| p + far)
    });
}

/// A mesh against itself where it is, and a step of its own edges away: everything is coplanar with something.
#[test]
fn a_mesh_against_itself() {
    let family = Family { name: "a mesh against itself", accuracy: OF_TRIANGLES };
    let count = share(60, 5_000);
    let ledger = survey(count, 507, |random, ledger| {
        let rings = 2 + some(random, 12.0);
        let a = Subject::mesh(random.blob(rings, 0.5));
        let mut along = random.vector(1.0);
        along[random.below(3) as usize] = 0.0;
        let shift = along * [0.0, 1e-10, 1e-6, 0.1, 2.0][random.below(5) as usize];
        let case = Case {
            a: &a,
            b: &a,
            pose_ab: Pose::from_parts(shift.into(), clearance::geometry::math::Rotation::identity()),
        };
        judge(&case, family.accuracy, Scrutiny::mostly_laws(random), random, ledger);
    });
    ledger.finish(&family, count);
}

/// Where closed meshes are solid, what lies inside touches; what lies outside is as far as from the surface.
#[test]
fn solid_meshes_hold_what_is_inside_them() {
    let mut random = Random::new(508);
    let solid = |mesh: TriangleMesh| {
        let shape = Shape::Mesh(mesh.into());
        CollisionBody::with_solid_meshes([(&Pose::identity(), &shape)]).expect("a mesh")
    };
    for _ in 0..share(100, 5_000) {
        let rings = 6 + some(&mut random, 10.0);
        let (outer, inner) = (random.blob(rings, 1.0), random.blob(3, 0.05));
        let surfaces = [&outer, &inner].map(|mesh| Subject::mesh(mesh.clone()));
        let (a, b) = (solid(outer), solid(inner));
        let inside = Pose::from_parts(random.vector(0.2).into(), random.rotation());
        let outside = Pose::from_parts((random.vector(1.0).normalize() * 1.5).into(), random.rotation());
        for (pose, holds) in [(inside, true), (outside, false)] {
            let apart = solid_distance(&surfaces[0].solid, &surfaces[1].solid, &pose, f64::INFINITY);
            let wanted = if holds { 0.0 } else { apart.expect("a distance") };
            for (a, b, pose) in [(&a, &b, pose), (&b, &a, pose.inverse())] {
                let told = distance(a, b, &pose, f64::INFINITY, &mut Scratch::default()).expect("a distance");
                assert!((told.distance - wanted).abs() <= 1e-13, "{} instead of {wanted}", told.distance);
                assert_eq!(collide(a, b, &pose, &mut Scratch::default()).is_some(), holds);
            }
        }
    }
}
