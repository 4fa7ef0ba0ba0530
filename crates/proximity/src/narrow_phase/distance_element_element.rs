//! Distance and contact of two convex elements: closed formulas where there are some, GJK otherwise.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, MatrixPose, Point, Pose, Vector};
use clearance_geometry::{PointPair, Triangle, nearest_on_segments, nearest_pair};

use super::gjk::{self, ACCURACY, CorePair, Nearest};
use super::separation::Separation;
use crate::elements::{CoreShape, Element, Faces, RoundedShape};

/// A common point of two elements, if they touch.
#[must_use]
#[inline]
pub fn element_contact(a: &Element, b: &Element, pose_ab: &Pose) -> Option<Point> {
    if let (Element::Triangle(a), Element::Triangle(b)) = (a, b) {
        return a.contact_point(&b.transformed(pose_ab));
    }
    let found = separation_within(&a.into(), &b.into(), &pose_ab.into(), CONTACT_DISTANCE)?;
    (found.distance == 0.0).then_some(found.witness_points[0])
}

/// Distance and nearest points of two elements.
#[must_use]
#[allow(clippy::missing_panics_doc)] // nothing is beyond infinity
#[inline]
pub fn element_separation(a: &Element, b: &Element, pose_ab: &Pose) -> Separation {
    if let (Element::Triangle(a), Element::Triangle(b)) = (a, b) {
        return Separation::of(a.nearest_points(&b.transformed(pose_ab)));
    }
    separation_within(&a.into(), &b.into(), &pose_ab.into(), f64::INFINITY)
        .expect("nothing is beyond infinity")
}

/// Distance and nearest points of two elements, unless they are proven farther apart than `limit` (m): the cores' distance minus both
/// radii, and the nearest points moved out to the surfaces. The result does not depend on the limit.
#[inline]
pub(crate) fn separation_within(
    a: &RoundedShape,
    b: &RoundedShape,
    pose_ab: &MatrixPose,
    limit: f64,
) -> Option<Separation> {
    let pose_ab = a.pose.relative(&pose_ab.compose(&b.pose));
    let radii = a.radius + b.radius;
    let points = core_nearest_points(&a.core, &b.core, &pose_ab, limit + radii)?;
    Some(separation_at(a, b, points))
}

/// As [`separation_within`], where it only matters whether they touch or are proven farther apart than `limit` (m): approximately nearest
/// points often suffice. The returned points may then be any points with that distance.
#[inline]
pub(crate) fn touching_within(
    a: &RoundedShape,
    b: &RoundedShape,
    pose_ab: &MatrixPose,
    limit: f64,
) -> Option<Separation> {
    let pose = a.pose.relative(&pose_ab.compose(&b.pose));
    if let Some(points) = closed_form(&a.core, &b.core, &pose) {
        return Some(separation_at(a, b, points));
    }
    let pair = CorePair { a: &a.core, b: &b.core, pose_ab: &pose };
    let radii = a.radius + b.radius;
    let [p, q] = pair.nearly_nearest(&origin_of(&pose));
    if nalgebra::distance(&p, &q) <= radii + CONTACT_DISTANCE {
        return Some(separation_at(a, b, [p, q]));
    }
    if gjk::are_beyond(&pair, [p, q], limit + radii) {
        return None;
    }
    separation_within(a, b, pose_ab, limit)
}

/// The separation of two elements whose cores are nearest at points in the frame of a's.
fn separation_at(a: &RoundedShape, b: &RoundedShape, [p, q]: PointPair) -> Separation {
    let (apart, radii) = (nalgebra::distance(&p, &q), a.radius + b.radius);
    let [p, q] = [p, q].map(|p| &a.pose * p);
    if apart <= radii + CONTACT_DISTANCE {
        let share = if apart > 0.0 { (a.radius / apart).lesser(1.0) } else { 0.0 };
        return Separation::touching_at(p + (q - p) * share);
    }
    let out = (q - p) / apart;
    Separation { distance: apart - radii, witness_points: [p + out * a.radius, q - out * b.radius] }
}

/// The gap (m) between two elements along a unit direction (frame of a), minus the possible rounding error.
#[inline]
pub(crate) fn gap_along(a: &RoundedShape, b: &RoundedShape, pose_ab: &MatrixPose, n: &Vector) -> f64 {
    let pose_b = pose_ab.compose(&b.pose);
    let on_a = &a.pose * a.core.support(&a.pose.rotation.tr_mul(n));
    let on_b = &pose_b * b.core.support(&-pose_b.rotation.tr_mul(n));
    let rounding = 1e-13 * (on_a.coords.abs().sum() + on_b.coords.abs().sum() + a.radius + b.radius);
    n.dot(&(on_b - on_a)) - a.radius - b.radius - rounding
}

/// Nearest points of two cores in the frame of a, a common point twice when they overlap; `None` once they are proven farther
/// apart than `limit` (m).
#[inline]
pub(crate) fn core_nearest_points(
    a: &CoreShape,
    b: &CoreShape,
    pose_ab: &MatrixPose,
    limit: f64,
) -> Option<PointPair> {
    let pair = CorePair { a, b, pose_ab };
    if pair.has_slow_formula() && gjk::are_beyond(&pair, pair.nearly_nearest(&origin_of(pose_ab)), limit) {
        return None;
    }
    closed_form(a, b, pose_ab).or_else(|| {
        let found = match (a, b) {
            (CoreShape::Cylinder { .. }, _) | (_, CoreShape::Cylinder { .. }) => {
                with_cylinders(&pair, limit)?
            }
            _ => gjk::nearest_points(&pair, pair.nearly_nearest(&origin_of(pose_ab)), limit)?,
        };
        Some(settled(&pair, &found))
    })
}

fn closed_form(a: &CoreShape, b: &CoreShape, pose_ab: &MatrixPose) -> Option<PointPair> {
    let pair = CorePair { a, b, pose_ab };
    Some(match (a, b) {
        (_, CoreShape::Point) => [a.nearest_point(&origin_of(pose_ab)), origin_of(pose_ab)],
        (CoreShape::Point, _) => [Point::origin(), pair.nearest_on_b(&Point::origin())],
        (CoreShape::Segment(h), CoreShape::Segment(k)) => {
            nearest_on_segments(&CoreShape::segment(*h), &segment_at(*k, pose_ab))
        }
        (CoreShape::Triangle(t), CoreShape::Segment(h)) => t.nearest_to_segment(&segment_at(*h, pose_ab)),
        (CoreShape::Segment(h), CoreShape::Triangle(t)) => {
            let [on_b, on_a] = triangle_at(t, pose_ab).nearest_to_segment(&CoreShape::segment(*h));
            [on_a, on_b]
        }
        (CoreShape::Triangle(t), CoreShape::Triangle(u)) => t.nearest_points(&triangle_at(u, pose_ab)),
        _ => return None,
    })
}

/// A cylinder lies in the capsule around its axis. Where the nearest point is on the cylinder's side, both have the same distance. Only a
/// nearest point on an end or its rim needs iteration.
fn with_cylinders(pair: &CorePair, limit: f64) -> Option<Nearest> {
    let ((axis_a, radius_a), (axis_b, radius_b)) = (pair.a.capsule(), pair.b.capsule());
    let radii = radius_a + radius_b;
    let axes = CorePair { a: &axis_a, b: &axis_b, pose_ab: pair.pose_ab };
    let of_axes = match (&axis_a, &axis_b) {
        (CoreShape::Segment(_), CoreShape::Segment(_)) => {
            closed_form(&axis_a, &axis_b, pair.pose_ab).map(Nearest::exactly)
        }
        _ => gjk::nearest_points(&axes, axes.nearly_nearest(&origin_of(pair.pose_ab)), limit + radii),
    }?;
    let proven = of_axes.proven - radii;
    if proven > limit + ACCURACY {
        return None;
    }
    let [_, q] = of_axes.points;
    let start = pair.nearly_nearest(&q);
    if nalgebra::distance(&start[0], &start[1]) - proven <= ACCURACY {
        return Some(Nearest { points: start, proven });
    }
    gjk::nearest_points(pair, start, limit)
}

/// The result of the search, if its proof is sufficient. Within about 1e-6 m of contact the direction between nearest points is inexact,
/// and the proof may be insufficient. Then all faces of flat cores are compared; for others, the missing amount is subtracted from the
/// distance.
fn settled(pair: &CorePair, found: &Nearest) -> PointPair {
    let Nearest { points: [p, q], proven } = *found;
    let apart = nalgebra::distance(&p, &q);
    if apart - proven <= CONTACT_DISTANCE || apart == 0.0 {
        return [p, q];
    }
    // a point inside has no distance, whatever the distance of the faces
    if pair.a.depth(&q).is_some() {
        return [q, q];
    }
    if pair.b.depth(&pair.in_b(&p)).is_some() {
        return [p, p];
    }
    let of_faces = |(a, b): (Faces, Faces)| {
        let pairs = a.iter().flat_map(|t| b.iter().map(|u| t.nearest_points(&triangle_at(u, pair.pose_ab))));
        nearest_pair(pairs)
    };
    (pair.a.faces().zip(pair.b.faces()))
        .map_or_else(|| drawn_together([p, q], proven.greater(0.0) / apart), of_faces)
}

/// Two points moved towards each other by equal amounts, until their distance is the given fraction of the original one.
fn drawn_together([p, q]: PointPair, share: f64) -> PointPair {
    let aside = (q - p) * (0.5 - 0.5 * share);
    [p + aside, q - aside]
}

fn origin_of(pose_ab: &MatrixPose) -> Point {
    Point::from(pose_ab.translation)
}

fn segment_at(half_length: f64, pose: &MatrixPose) -> [Point; 2] {
    CoreShape::segment(half_length).map(|p| pose * p)
}

fn triangle_at(t: &Triangle, pose: &MatrixPose) -> Triangle {
    let [a, b, c] = t.corners().map(|p| pose * p);
    Triangle { a, b, c }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clearance_geometry::Primitive;
    use clearance_geometry::testing::Random;

    fn solid(random: &mut Random) -> RoundedShape {
        let mut size = || 0.02 + random.within(0.5).abs();
        let (x, y, z) = (size(), size(), size());
        let primitive = match random.below(5) {
            0 => Primitive::Sphere { radius: x },
            1 => Primitive::Capsule { radius: x, half_length: y },
            2 => Primitive::Cylinder { radius: x, half_length: y },
            3 => Primitive::Cone { radius: x, half_length: y },
            _ => Primitive::Box { half_extents: [x, y, z] },
        };
        (&Element::Primitive { primitive, pose: random.pose(0.3) }).into()
    }

    #[test]
    fn a_first_approximation_agrees_with_the_search_and_gives_a_common_point() {
        let mut random = Random::new(77);
        let mut touching = 0;
        for _ in 0..20_000 {
            let (a, b) = (solid(&mut random), solid(&mut random));
            let pose_ab = MatrixPose::from(&random.pose(1.0));
            let found = touching_within(&a, &b, &pose_ab, CONTACT_DISTANCE).filter(|f| f.distance == 0.0);
            let truth = separation_within(&a, &b, &pose_ab, CONTACT_DISTANCE).filter(|f| f.distance == 0.0);
            assert_eq!(found.is_some(), truth.is_some(), "{a:?} {b:?} {pose_ab:?}");
            if let Some(Separation { witness_points: [p, q], .. }) = found {
                let point = RoundedShape::point(&p);
                let off = |solid: &RoundedShape, pose: &MatrixPose| {
                    separation_within(solid, &point, pose, f64::INFINITY).unwrap().distance
                };
                assert_eq!(p, q);
                assert!(
                    off(&a, &MatrixPose::identity()) <= 2.0 * CONTACT_DISTANCE,
                    "{a:?} {b:?} {pose_ab:?}"
                );
                assert!(off(&b, &pose_ab.inverse()) <= 2.0 * CONTACT_DISTANCE, "{a:?} {b:?} {pose_ab:?}");
                touching += 1;
            }
        }
        assert!((2_000..15_000).contains(&touching), "{touching}");
    }
}
