//! Tests of distances and signed distances of primitives, also against meshes, compared with oracles.

use clearance::geometry::math::{Point, Pose, Vector};
use clearance::geometry::{Primitive, Shape};
use clearance::proximity::signed_distance;

use super::laws::{Case, Scrutiny, judge};
use super::ledger::{Accuracy, Family, Ledger, survey};
use super::random_pairs::{CLOSED, Kind, OF_BOXES, OF_CLOSED_FORMS, OF_CYLINDERS, ask};
use super::share;
use super::solid_oracle::solid_distance;
use super::subject::Subject;
use super::triangles::OF_TRIANGLES;
use crate::random::Random;

#[test]
fn round_solids() {
    let round = [Kind::Sphere, Kind::Capsule];
    ask("spheres and capsules", OF_CLOSED_FORMS, [&round, &round], (600, 300_000), 400);
}

#[test]
fn boxes_and_round_solids() {
    ask("boxes, spheres, capsules", OF_BOXES, [&CLOSED, &[Kind::Box]], (300, 100_000), 401);
}

#[test]
fn cylinders_and_spheres() {
    ask("cylinders and spheres", OF_CLOSED_FORMS, [&[Kind::Cylinder], &[Kind::Sphere]], (600, 100_000), 402);
}

#[test]
fn cylinders_and_others() {
    ask("cylinders, boxes, capsules", OF_CYLINDERS, [&CLOSED, &[Kind::Cylinder]], (60, 20_000), 403);
}

#[test]
fn cylinders_and_cylinders() {
    ask("cylinders", OF_CYLINDERS, [&[Kind::Cylinder], &[Kind::Cylinder]], (30, 6_000), 404);
}

#[test]
fn round_solids_and_meshes() {
    let round = [Kind::Sphere, Kind::Capsule];
    let meshes = [Kind::Triangle, Kind::Soup];
    ask("spheres, capsules against meshes", OF_TRIANGLES, [&round, &meshes], (600, 200_000), 405);
}

#[test]
fn boxes_and_meshes() {
    let meshes = [Kind::Triangle, Kind::Soup];
    ask("boxes against meshes", OF_BOXES, [&meshes, &[Kind::Box]], (200, 60_000), 406);
}

#[test]
fn cylinders_and_meshes() {
    let meshes = [Kind::Triangle, Kind::Soup];
    ask("cylinders against meshes", OF_CYLINDERS, [&meshes, &[Kind::Cylinder]], (60, 20_000), 407);
}

#[test]
fn cones_and_spheres() {
    ask("cones and spheres", OF_CLOSED_FORMS, [&[Kind::Cone], &[Kind::Sphere]], (600, 100_000), 409);
}

#[test]
fn cones_and_others() {
    ask("cones, boxes, capsules", OF_CYLINDERS, [&CLOSED, &[Kind::Cone]], (60, 20_000), 410);
}

#[test]
fn cones_and_round_solids() {
    let turned = [Kind::Cone, Kind::Cylinder];
    ask("cones and cylinders", OF_CYLINDERS, [&[Kind::Cone], &turned], (30, 6_000), 411);
}

#[test]
fn cones_and_meshes() {
    let meshes = [Kind::Triangle, Kind::Soup];
    ask("cones against meshes", OF_CYLINDERS, [&meshes, &[Kind::Cone]], (60, 20_000), 412);
}

/// How far a primitive reaches from its origin along a unit vector.
fn support(primitive: &Primitive, n: &Vector) -> f64 {
    match *primitive {
        Primitive::Box { half_extents } => Vector::from(half_extents).dot(&n.abs()),
        Primitive::Sphere { radius } => radius,
        Primitive::Cylinder { radius, half_length } => n.xy().norm() * radius + n.z.abs() * half_length,
        Primitive::Cone { radius, half_length } => {
            (n.xy().norm() * radius - n.z * half_length).max(n.z * half_length)
        }
        Primitive::Capsule { radius, half_length } => n.z.abs() * half_length + radius,
    }
}

/// Apart, the signed distance is the distance; overlapping, no direction separates sooner than by the depth that is told,
/// and moving so far along the direction told does separate.
#[test]
fn signed_distances() {
    let family = Family {
        name: "signed distances",
        accuracy: Accuracy { absolute: 1e-9, of_reach: 2e-6, shortfall: 0.0 },
    };
    let count = share(400, 50_000);
    let ledger = survey(count, 408, |random, ledger| {
        let (x, y) = (random.primitive(), random.primitive());
        let pose_ab = random.pose(0.5);
        let wrong = signed_disagreements(&x, &y, &pose_ab, &family, random, ledger);
        ledger.poses += 1;
        ledger.element_pairs += 1;
        ledger.note(&format!("{x:?} {y:?} {pose_ab:?}"), &wrong);
    });
    ledger.finish(&family, count);
}

fn signed_disagreements(
    x: &Primitive,
    y: &Primitive,
    pose_ab: &Pose,
    family: &Family,
    random: &mut Random,
    ledger: &mut Ledger,
) -> Vec<String> {
    let [a, b] = [x, y].map(|p| Subject::of(Shape::Primitive(*p)));
    let apart =
        |pose: &Pose| solid_distance(&a.solid, &b.solid, pose, f64::INFINITY).unwrap_or(f64::INFINITY);
    let (truth, told) = (apart(pose_ab), signed_distance(x, y, pose_ab));
    let reach = a.solid.reach + b.solid.reach + pose_ab.translation.vector.amax();
    let band = family.accuracy.band(reach).above;
    if truth > 2e-9 {
        ledger.error(told.distance, truth, reach, family.accuracy);
        return if (told.distance - truth).abs() <= band {
            vec![]
        } else {
            vec![format!("{told:?} instead of {truth:e}")]
        };
    }
    ledger.touching += 1;
    let mut wrong = vec![];
    let depth = -told.distance;
    let overlap = |n: &Vector| {
        support(x, n) + support(y, &-(pose_ab.rotation.inverse() * n)) - n.dot(&pose_ab.translation.vector)
    };
    let sooner = (0..300).map(|_| overlap(&random.vector(1.0).normalize())).fold(f64::INFINITY, f64::min);
    if sooner < depth - band {
        wrong.push(format!("told {depth:e} deep, but {sooner:e} separates"));
    }
    let [p, q] = told.witness_points;
    if let Some(out) = (p - q).try_normalize(1e-6) {
        let moved = Pose::from(nalgebra::Translation3::from(out * (depth + 2.0 * band))) * pose_ab;
        if apart(&moved) == 0.0 {
            wrong.push(format!("moved out by {depth:e} it still overlaps"));
        }
    }
    wrong
}

/// A box around a body, a body inside a box, and both centred: overlap without any surfaces meeting.
#[test]
fn solids_hold_what_is_inside_them() {
    let family = Family { name: "inside solids", accuracy: OF_CYLINDERS };
    let count = share(300, 30_000);
    let ledger = survey(count, 409, |random, ledger| {
        let outer = [Kind::Box, Kind::Sphere, Kind::Cylinder, Kind::Capsule][random.below(4) as usize];
        let inner = [Kind::Box, Kind::Sphere, Kind::Capsule, Kind::Triangle][random.below(4) as usize];
        let (a, b) = (Subject::of(outer.shape(1.0, random)), Subject::of(inner.shape(0.01, random)));
        let pose_ab = Pose::from_parts(Point::origin().coords.into(), random.rotation());
        let case = Case { a: &a, b: &b, pose_ab };
        judge(&case, family.accuracy, Scrutiny::Laws, random, ledger);
    });
    assert!(2 * ledger.touching > count, "most lie inside");
    ledger.finish(&family, count);
}
