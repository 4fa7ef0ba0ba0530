//! All witness pairs of two elements.

use clearance_geometry::math::Vector;
use clearance_geometry::{Plane, PointPair};

use super::facing_sets::FacingSets;
use super::refinement::PlacedCores;
use super::witness_pairs::{WitnessOptions, WitnessPair, WitnessPairs};
use crate::body::BodyPair;
use crate::elements::RoundedShape;
use crate::search::Tie;

/// Lists the witness pairs of two bodies that are apart, from their nearest elements, of which the first are the nearest.
pub(crate) fn collect_witnesses(
    bodies: BodyPair,
    ties: &[Tie],
    options: &WitnessOptions,
    found: &mut WitnessPairs,
) {
    let Some(nearest) = ties.first() else { return };
    let (distance, radii) = (nearest.separation.distance, radii_of(bodies, nearest));
    found.begin(options, distance, distance + radii);
    for tie in ties {
        collect_pairs(bodies, tie, found);
        if !found.wants_more() {
            break;
        }
    }
    found.finish();
}

/// Sum of the radii (m) of two elements.
fn radii_of(BodyPair { a, b, .. }: BodyPair, tie: &Tie) -> f64 {
    let radius =
        |body: &crate::CollisionBody, id| body.plane(id).map_or_else(|| body.element(id).radius, |_| 0.0);
    radius(a, tie.elements.a) + radius(b, tie.elements.b)
}

fn collect_pairs(BodyPair { a, b, pose_ab }: BodyPair, tie: &Tie, found: &mut WitnessPairs) {
    let (id_a, id_b) = (tie.elements.a, tie.elements.b);
    let in_a = |mut shape: RoundedShape| {
        shape.pose = pose_ab.compose(&shape.pose);
        shape
    };
    let points = tie.separation.witness_points;
    match (a.plane(id_a), b.plane(id_b)) {
        (None, None) => of_convex(&a.element(id_a), &in_a(b.element(id_b)), points, found),
        (Some(plane), None) => of_plane(plane, &in_a(b.element(id_b)), points, true, found),
        (None, Some(plane)) => of_plane(&plane.placed(pose_ab), &a.element(id_a), points, false, found),
        (Some(plane), Some(_)) => {
            let [p, q] = points;
            let normal = plane.normal.into_inner();
            found.offer(WitnessPair { points, normal: normal * (q - p).dot(&normal).signum() });
            // parallel planes: any points
            found.note_more();
        }
    }
}

/// The witness pairs of two convex elements in the frame of a, from approximate points.
fn of_convex(a: &RoundedShape, b: &RoundedShape, points: PointPair, found: &mut WitnessPairs) {
    let Some(out) = direction(points) else { return };
    let placed = PlacedCores { cores: [&a.core, &b.core], poses: [&a.pose, &b.pose] };
    let mut cores = [points[0] - out * a.radius, points[1] + out * b.radius];
    if placed.are_searched() {
        cores = placed.nearest_points(cores);
    }
    let Some(normal) = direction(cores) else { return };
    let on_surfaces =
        |[p, q]: PointPair| WitnessPair { points: [p + normal * a.radius, q - normal * b.radius], normal };
    found.offer(on_surfaces(cores));
    if !found.wants_more() {
        return;
    }
    let tolerance = found.tolerance();
    let [mut set_a, mut set_b] = std::mem::take(&mut found.sets);
    set_a.set_to_core(&a.core, &a.pose, &normal, tolerance);
    if set_a.points().len() > 1 {
        set_b.set_to_core(&b.core, &b.pose, &-normal, tolerance);
        if set_b.points().len() > 1 {
            let gap = cores[1] - cores[0];
            let facing = FacingSets::new([&mut set_a, &mut set_b], gap, found.resolution());
            facing.each_extreme_pair(|pair| {
                found.offer(on_surfaces(pair));
                found.wants_more()
            });
        }
    }
    found.sets = [set_a, set_b];
}

/// The witness pairs of a plane and a convex element in one frame.
fn of_plane(
    plane: &Plane,
    element: &RoundedShape,
    points: PointPair,
    plane_is_a: bool,
    found: &mut WitnessPairs,
) {
    let plane_normal = plane.normal.into_inner();
    let [on_plane, on_element] = if plane_is_a { points } else { [points[1], points[0]] };
    let out = plane_normal * (on_element - on_plane).dot(&plane_normal).signum();
    let normal = if plane_is_a { out } else { -out };
    found.offer(WitnessPair { points, normal });
    let tolerance = found.tolerance();
    let [mut set, other] = std::mem::take(&mut found.sets);
    set.set_to_core(&element.core, &element.pose, &-out, tolerance);
    for p in set.points() {
        if !found.wants_more() {
            break;
        }
        let on_element = p - out * element.radius;
        let on_plane = on_element - plane_normal * plane.height(&on_element);
        let points = if plane_is_a { [on_plane, on_element] } else { [on_element, on_plane] };
        found.offer(WitnessPair { points, normal });
    }
    found.sets = [set, other];
}

/// Unit vector from the first point to the second.
fn direction([p, q]: PointPair) -> Option<Vector> {
    (q - p).try_normalize(0.0)
}
