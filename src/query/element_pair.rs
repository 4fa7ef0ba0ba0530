//! The least distance of two convex elements: closed form where there is one, GJK otherwise.

use super::core::{Core, RoundedCore};
use super::element::Element;
use super::narrow_phase;
use super::refine::refine;
use crate::constants::CONTACT_DISTANCE;
use crate::geometry::{PointPair, Triangle, nearest_on_segments};
use crate::math::{Point, Pose};

/// Projections before a slower method is asked: most pairs are decided by the first or the second.
const FEW_PROJECTIONS: usize = 4;

/// Rounding granted to a gap between supporting planes, relative to the coordinates that enter.
const PROJECTION_ROUNDING: f64 = 1e-14;

/// Most projections in the search for a common point.
const MOST_PROJECTIONS: usize = 200;

/// How far two things are apart (m), and where they are nearest. Touching things have distance 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Separation {
    pub distance: f64,
    /// In the frame of the first body, first on it.
    pub witness_points: PointPair,
}

impl Separation {
    pub(super) fn touching_at(point: Point) -> Self {
        Self { distance: 0.0, witness_points: [point, point] }
    }

    pub(super) fn of(witness_points: PointPair) -> Self {
        let distance = nalgebra::distance(&witness_points[0], &witness_points[1]);
        Self { distance: if distance <= CONTACT_DISTANCE { 0.0 } else { distance }, witness_points }
    }
}

/// A common point of two elements, if they touch.
#[must_use]
pub fn element_contact(a: &Element, b: &Element, pose_ab: &Pose) -> Option<Point> {
    if let (Element::Triangle(a), Element::Triangle(b)) = (a, b) {
        return a.contact_point(&b.transformed(pose_ab));
    }
    let (core_a, mut core_b) = (RoundedCore::from(a), RoundedCore::from(b));
    core_b.pose = pose_ab * core_b.pose;
    if proven_apart(&core_a, &core_b) {
        return None;
    }
    let separation = rounded_separation(&core_a, &core_b);
    (separation.distance == 0.0).then_some(separation.witness_points[0])
}

/// Whether a plane normal to the line between two nearly nearest points has one solid on each side: found by projecting on
/// one and the other in turn, a few times.
fn proven_apart(a: &RoundedCore, b: &RoundedCore) -> bool {
    let pose_ab = a.pose.inv_mul(&b.pose);
    let on_b = |p: &Point| pose_ab * b.core.nearest_point(&pose_ab.inverse_transform_point(p));
    let mut q = Point::from(pose_ab.translation.vector);
    for _ in 0..FEW_PROJECTIONS {
        let p = a.core.nearest_point(&q);
        q = on_b(&p);
        let Some(n) = (q - p).try_normalize(CONTACT_DISTANCE) else { return false };
        let on_a = a.core.support(&n);
        let on_b = pose_ab * b.core.support(&-(pose_ab.rotation.inverse() * n));
        let rounding = PROJECTION_ROUNDING * (on_a.coords.abs().sum() + on_b.coords.abs().sum());
        if n.dot(&(on_b - on_a)) > a.radius + b.radius + CONTACT_DISTANCE + rounding {
            return true;
        }
    }
    false
}

/// Distance and nearest points of two elements.
#[must_use]
pub fn element_separation(a: &Element, b: &Element, pose_ab: &Pose) -> Separation {
    if let (Element::Triangle(a), Element::Triangle(b)) = (a, b) {
        return Separation::of(a.nearest_points(&b.transformed(pose_ab)));
    }
    let (core_a, mut core_b) = (RoundedCore::from(a), RoundedCore::from(b));
    core_b.pose = pose_ab * core_b.pose;
    rounded_separation(&core_a, &core_b)
}

/// The cores' distance less both radii, and the nearest points moved out to the surfaces.
fn rounded_separation(a: &RoundedCore, b: &RoundedCore) -> Separation {
    let pose_ab = a.pose.inv_mul(&b.pose);
    let [p, q] = core_nearest_points(&a.core, &b.core, &pose_ab);
    let apart = nalgebra::distance(&p, &q);
    let [p, q] = [p, q].map(|p| a.pose * p);
    if apart <= a.radius + b.radius + CONTACT_DISTANCE {
        let share = if apart > 0.0 { (a.radius / apart).min(1.0) } else { 0.0 };
        return Separation::touching_at(p + (q - p) * share);
    }
    let out = (q - p) / apart;
    Separation {
        distance: apart - a.radius - b.radius,
        witness_points: [p + out * a.radius, q - out * b.radius],
    }
}

/// Nearest points of two cores in the frame of a; a common point twice when they overlap.
pub(super) fn core_nearest_points(a: &Core, b: &Core, pose_ab: &Pose) -> PointPair {
    let origin_b = || Point::from(pose_ab.translation.vector);
    match (a, b) {
        (_, Core::Point) => [a.nearest_point(&origin_b()), origin_b()],
        (Core::Point, _) => {
            let p = Point::origin();
            [p, pose_ab * b.nearest_point(&pose_ab.inverse_transform_point(&p))]
        }
        (Core::Segment(h), Core::Segment(k)) => {
            nearest_on_segments(&Core::segment(*h), &segment_at(*k, pose_ab))
        }
        (Core::Triangle(t), Core::Segment(h)) => t.nearest_to_segment(&segment_at(*h, pose_ab)),
        (Core::Segment(h), Core::Triangle(t)) => {
            let [on_b, on_a] = triangle_at(t, pose_ab).nearest_to_segment(&Core::segment(*h));
            [on_a, on_b]
        }
        (Core::Triangle(t), Core::Triangle(u)) => t.nearest_points(&triangle_at(u, pose_ab)),
        _ => iterated_nearest_points(a, b, pose_ab),
    }
}

/// Nearest points of cores without a formula. Projections find a common point of most that overlap.
fn iterated_nearest_points(a: &Core, b: &Core, pose_ab: &Pose) -> PointPair {
    let on_b = |p: &Point| pose_ab * b.nearest_point(&pose_ab.inverse_transform_point(p));
    let start = Point::from(pose_ab.translation.vector);
    let [p, q] = projections(a, on_b, &start, FEW_PROJECTIONS);
    if nalgebra::distance(&p, &q) <= CONTACT_DISTANCE {
        return [q, q];
    }
    match narrow_phase::nearest_points(a, b, pose_ab) {
        Some(pair) => proven_points(refine(a, b, pose_ab, pair)),
        None => overlap_or_proof(a, b, pose_ab),
    }
}

/// Points no farther apart than is proven: where the proof falls short, the shortfall counts as nearness.
fn proven_points(([p, q], proven): (PointPair, f64)) -> PointPair {
    let apart = nalgebra::distance(&p, &q);
    if apart - proven <= CONTACT_DISTANCE || apart == 0.0 {
        return [p, q];
    }
    [p, p + (q - p) * (proven.max(0.0) / apart)]
}

fn segment_at(half_length: f64, pose: &Pose) -> [Point; 2] {
    Core::segment(half_length).map(|p| pose * p)
}

fn triangle_at(t: &Triangle, pose: &Pose) -> Triangle {
    t.transformed(pose)
}

/// A common point twice, for cores that GJK takes for overlapping. It may err for small or barely separate ones: then the
/// proof that they are apart counts.
fn overlap_or_proof(a: &Core, b: &Core, pose_ab: &Pose) -> PointPair {
    let on_b = |p: &Point| pose_ab * b.nearest_point(&pose_ab.inverse_transform_point(p));
    let in_both = |p: &Point| {
        let off = |q: Point| nalgebra::distance(p, &q);
        off(a.nearest_point(p)).max(off(on_b(p))) <= CONTACT_DISTANCE
    };
    let [p, q] = projections(a, on_b, &Point::from(pose_ab.translation.vector), MOST_PROJECTIONS);
    if nalgebra::distance(&p, &q) <= CONTACT_DISTANCE {
        return [q, q];
    }
    let deepest = narrow_phase::penetration(a, b, pose_ab);
    if let Some(p) = deepest.and_then(|(_, pair)| pair.into_iter().find(in_both)) {
        return [p, p];
    }
    proven_points(refine(a, b, pose_ab, [p, q]))
}

/// Projects on one and the other of two convex solids in turn: that leads into their common part, if they have one
/// (Bregman 1965).
fn projections(a: &Core, on_b: impl Fn(&Point) -> Point, start: &Point, most: usize) -> PointPair {
    let mut p = a.nearest_point(start);
    let mut q = on_b(&p);
    for _ in 0..most {
        if nalgebra::distance(&p, &q) <= CONTACT_DISTANCE {
            break;
        }
        p = a.nearest_point(&q);
        q = on_b(&p);
    }
    [p, q]
}
