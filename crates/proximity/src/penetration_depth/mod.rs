//! Penetration depth: how far must one of two overlapping solids be moved until they are apart?
//!
//! | file | contents |
//! |---|---|
//! | `solid_body` | a rigid body as a union of solids |
//! | `convex_solid` | support points and inner balls of primitives and convex meshes |
//! | `signed_distance` | two primitives |
//! | `rounded_pair`, `expanding_polytope` | exact depth of two convex solids |
//! | `depth_witnesses` | all points and directions in which two convex solids are deepest |
//! | `plane` | exact depth of a plane in a bounded body |
//! | `separating_translation` | upper bounds for others: short translations that are proven to separate |
//! | `inner_balls` | lower bounds for others: balls inside both solids |
//! | `winding` | which side of a surface is outside |
//! | `exit` | shortest way of a point out of a body |
//! | `solid_set` | points and voxels: which one is deepest |

mod convex_solid;
mod depth_witnesses;
mod exit;
mod expanding_polytope;
mod inner_balls;
mod plane;
mod rounded_pair;
mod separating_translation;
mod signed_distance;
mod solid_body;
mod solid_set;
#[cfg(test)]
mod tests;
mod winding;

pub use depth_witnesses::depth_witnesses;
pub use signed_distance::signed_distance;
pub use solid_body::SolidBody;

#[cfg(test)]
pub(crate) use convex_solid::SupportMap;
pub(crate) use convex_solid::{ConvexSolid, HalfSpace, Hull};
pub(crate) use exit::Exit;
pub(crate) use solid_body::{Part, Union, distance_of_point};
pub(crate) use winding::Winding;

use clearance_geometry::PointPair;
use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, MatrixPose, Point, Vector};

use crate::search::Scratch;
use expanding_polytope::{ConvexDepth, ConvexPair};
use inner_balls::{Ball, SurfacePoint};
use separating_translation::{GAP, MovedSolids, SeparatingTranslation};
use solid_set::deepest_solids;

/// Relative lengths that are added to an exact depth until the distance after the translation is proven positive: that of curved solids in
/// contact is found less accurately than their depth.
const ALLOWANCES: [f64; 4] = [0.0, 1e-8, 1e-7, 1e-6];

/// Rounding error of the distance of two points, relative to the coordinates.
const ROUNDING: f64 = 1e-13;

/// Ratio of the bounds above which more work is done for the lower one.
const WIDE: f64 = 1.25;

/// Bounds on the translational penetration depth of two bodies: the length of the shortest translation after which they are apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PenetrationDepth {
    /// No translation shorter than this (m) separates the bodies.
    pub lower: f64,
    /// After a translation of the second body by this (m) along `direction`, the distance is proven larger than the margin. Infinite
    /// where no such translation was found: direction and witness points then have no meaning.
    pub upper: f64,
    /// Unit vector, in the frame of the first body.
    pub direction: Vector,
    /// The points of the first and the second body that come apart last in this translation, in the frame of the first.
    pub witness_points: PointPair,
    /// Reason why the true depth may be much larger than `lower`, or `upper` is not known.
    pub unknown: Option<UnknownDepth>,
}

/// Reason why a depth is not known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnknownDepth {
    /// A mesh is not closed: it has no inside.
    OpenMesh,
    /// Infinite bodies that no translation separates, as two planes.
    Inseparable,
    /// Only points or voxels of the one body touch points or voxels of the other: for these no depth is computed.
    BothAreSets,
}

impl UnknownDepth {
    /// Stable name for reports.
    #[must_use]
    pub fn code(self) -> &'static str {
        match self {
            Self::OpenMesh => "open_mesh",
            Self::Inseparable => "inseparable",
            Self::BothAreSets => "points_or_voxels",
        }
    }
}

impl PenetrationDepth {
    /// Result without a translation that separates.
    fn unknown(lower: f64, reason: UnknownDepth) -> Self {
        Self {
            lower,
            upper: f64::INFINITY,
            direction: Vector::x(),
            witness_points: [Point::origin(); 2],
            unknown: Some(reason),
        }
    }

    /// The deeper of two, by their lower bounds.
    fn deeper(self, other: Self) -> Self {
        if other.lower > self.lower { other } else { self }
    }

    /// As seen from the other body, which is posed in the frame of the first.
    fn swapped(self, pose_ab: &MatrixPose) -> Self {
        let [on_b, on_a] = self.witness_points.map(|p| pose_ab * p);
        Self { direction: -(pose_ab.rotation * self.direction), witness_points: [on_a, on_b], ..self }
    }
}

/// Depth of two bodies, b posed in the frame of a, whose distance is at most `margin` (m); `None` if they are farther apart.
///
/// It is the depth of the bodies enlarged by `margin` together: the length of the shortest translation after which their distance is
/// larger. Two convex solids (primitives, or meshes without dents) have an exact depth, up to rounding, and so has a plane in a bounded
/// body. A body of several shapes counts as their union. Each point of a cloud and each voxel is a body of its own; the result is for the
/// deepest one, of the 64 that may be deepest. Points and voxels of both bodies are compared only if nothing else touches, and without a depth.
#[must_use]
pub fn penetration_depth(
    a: &SolidBody,
    b: &SolidBody,
    pose_ab: impl Into<MatrixPose>,
    margin: f64,
    scratch: &mut Scratch,
) -> Option<PenetrationDepth> {
    deepest(a, b, &pose_ab.into(), margin, scratch)
}

/// Whether two bodies overlap where closed meshes are solids, although their surfaces are apart: one is inside a mesh of the other.
#[must_use]
pub fn is_one_inside(a: &SolidBody, b: &SolidBody, pose_ab: &MatrixPose, scratch: &mut Scratch) -> bool {
    (a.has_closed_meshes() || b.has_closed_meshes()) && deepest(a, b, pose_ab, 0.0, scratch).is_some()
}

fn deepest(
    a: &SolidBody,
    b: &SolidBody,
    pose_ab: &MatrixPose,
    margin: f64,
    scratch: &mut Scratch,
) -> Option<PenetrationDepth> {
    let pose_ba = &pose_ab.inverse();
    let unions = a.union.as_ref().zip(b.union.as_ref());
    let of_unions = unions.and_then(|(a, b)| depth_of_unions([a, b], pose_ab, margin, scratch));
    let mut all: Vec<PenetrationDepth> = of_unions.into_iter().collect();
    for set in &b.sets {
        all.extend(a.union.as_ref().and_then(|a| depth_of_set(a, set, pose_ab, margin, scratch)));
    }
    for set in &a.sets {
        let found = b.union.as_ref().and_then(|b| depth_of_set(b, set, pose_ba, margin, scratch));
        all.extend(found.map(|depth| depth.swapped(pose_ab)));
    }
    if all.is_empty() && sets_are_near([a, b], pose_ab, margin, scratch) {
        return Some(PenetrationDepth::unknown(0.0, UnknownDepth::BothAreSets));
    }
    all.into_iter().reduce(PenetrationDepth::deeper)
}

/// Whether points or voxels of the one body are within `margin` (m) of those of the other.
fn sets_are_near(bodies: [&SolidBody; 2], pose_ab: &MatrixPose, margin: f64, scratch: &mut Scratch) -> bool {
    let [a, b] = bodies.map(SolidBody::all_sets);
    a.zip(b).is_some_and(|(a, b)| crate::within_margin(a, b, pose_ab, margin, scratch).is_some())
}

fn depth_of_set(
    body: &Union,
    set: &solid_set::SolidSet,
    pose_bs: &MatrixPose,
    margin: f64,
    scratch: &mut Scratch,
) -> Option<PenetrationDepth> {
    let candidates = deepest_solids(set, body, pose_bs, margin, scratch).into_iter();
    let depths =
        candidates.filter_map(|index| depth_of_unions([body, &set.solid(index)?], pose_bs, margin, scratch));
    depths.reduce(PenetrationDepth::deeper)
}

fn depth_of_unions(
    [a, b]: [&Union; 2],
    pose_ab: &MatrixPose,
    margin: f64,
    scratch: &mut Scratch,
) -> Option<PenetrationDepth> {
    let found = crate::distance(&a.whole, &b.whole, pose_ab, margin.greater(CONTACT_DISTANCE), scratch)?;
    let apart = (found.distance > 0.0).then_some(found.distance);
    let exact = match (&a.parts[..], &b.parts[..]) {
        ([Part::Convex(a)], [Part::Convex(b)]) => depth_of_convex(a, b, pose_ab).map(|mut depth| {
            depth.lower -= a.excess() + b.excess();
            depth
        }),
        ([Part::Plane(plane)], _) => plane::depth_in_plane(plane, b, pose_ab, margin),
        (_, [Part::Plane(plane)]) => {
            plane::depth_in_plane(plane, a, &pose_ab.inverse(), margin).map(|depth| depth.swapped(pose_ab))
        }
        _ => None,
    };
    let exact = exact.map(|depth| PenetrationDepth {
        lower: (depth.lower + margin).greater(0.0),
        upper: (depth.upper + margin).greater(0.0),
        direction: depth.direction,
        witness_points: depth.witness_points,
        unknown: (a.is_open || b.is_open).then_some(UnknownDepth::OpenMesh),
    });
    let exact = exact.and_then(|depth| {
        let mut solids = MovedSolids { a, b, pose_ab, margin, scratch };
        let lengths = ALLOWANCES.iter().map(|allowance| depth.upper * (1.0 + allowance) + GAP);
        let proven = lengths.into_iter().find(|length| solids.is_separated(&(depth.direction * *length)));
        proven.map(|upper| PenetrationDepth { upper, ..depth })
    });
    Some(exact.unwrap_or_else(|| search_depth([a, b], pose_ab, margin, apart, scratch)))
}

/// Depth of two convex solids; `None` if they are apart by more than their radii.
pub(crate) fn depth_of_convex(a: &ConvexSolid, b: &ConvexSolid, pose_ab: &MatrixPose) -> Option<ConvexDepth> {
    if let (ConvexSolid::Primitive(first), ConvexSolid::Primitive(second)) = (a, b)
        && let Some(depth) = rounded_pair::depth_of_rounded(first, second, pose_ab)
    {
        return Some(depth);
    }
    let pair = |rounded| ConvexPair { a, b, pose_ab, rounded };
    pair(false).depth().or_else(|| pair(true).depth())
}

/// Bounds on the depth of two unions, of which it is known how far they are `apart` (m), if they do not touch.
fn search_depth(
    bodies: [&Union; 2],
    pose_ab: &MatrixPose,
    margin: f64,
    apart: Option<f64>,
    scratch: &mut Scratch,
) -> PenetrationDepth {
    let [a, b] = bodies;
    let mut balls = BallPair::default();
    // the distance of bodies changes at most as much as one is moved
    let mut lower = apart.map_or_else(|| of_exact_parts(bodies, pose_ab), |distance| -distance);
    if apart.is_none() {
        let of_b: Vec<Ball> = b.balls(scratch).iter().map(|ball| ball.transformed(pose_ab)).collect();
        balls.offer(inner_balls::deepest_pair(a.balls(scratch), &of_b));
        lower = lower.greater(balls.depth());
    }
    let found = MovedSolids { a, b, pose_ab, margin, scratch }.shortest(lower + margin);
    let Some(found) = found else {
        return PenetrationDepth::unknown((lower + margin).greater(0.0), UnknownDepth::Inseparable);
    };
    let upper = found.translation.norm();
    let rounding = ROUNDING * (a.size() + b.size() + pose_ab.translation.amax() + upper);
    if apart.is_none() {
        balls.offer(tangent_balls(bodies, pose_ab, &found, scratch));
        lower = lower.greater(balls.depth());
        let is_wide = |lower: f64| lower + margin < upper / WIDE;
        if is_wide(lower) {
            let [p, q] = [found.after.witness_points[0], found.after.witness_points[1] - found.translation];
            let middle = nalgebra::center(&p, &q);
            balls.offer(inner_balls::common_balls(&middle, upper, bodies, pose_ab, scratch));
            lower = lower.greater(balls.depth());
        }
        if let Some((_, pair)) = balls.0.filter(|_| is_wide(lower)) {
            let step = 0.25 * pair[0].radius.greater(pair[1].radius);
            lower = lower.greater(inner_balls::improved(pair, bodies, pose_ab, step, scratch));
        }
    }
    PenetrationDepth {
        lower: (lower + margin - a.excess() - b.excess() - rounding).greater(0.0).lesser(upper),
        upper,
        direction: found.translation / upper,
        witness_points: [found.after.witness_points[0], found.after.witness_points[1] - found.translation],
        unknown: (a.is_open || b.is_open).then_some(UnknownDepth::OpenMesh),
    }
}

/// The pair of balls with the largest lower bound so far.
#[derive(Default)]
struct BallPair(Option<(f64, [Ball; 2])>);

impl BallPair {
    fn offer(&mut self, other: Option<(f64, [Ball; 2])>) {
        if other.is_some_and(|(depth, _)| self.0.is_none_or(|(best, _)| depth > best)) {
            self.0 = other;
        }
    }

    fn depth(&self) -> f64 {
        self.0.map_or(0.0, |(depth, _)| depth)
    }
}

/// The largest lower bound (m) of pairs of convex parts, and of planes in the other body.
fn of_exact_parts([a, b]: [&Union; 2], pose_ab: &MatrixPose) -> f64 {
    let mut lower = 0.0_f64;
    for first in &a.parts {
        for second in &b.parts {
            if let (Part::Convex(first), Part::Convex(second)) = (first, second) {
                lower =
                    lower.greater(depth_of_convex(first, second, pose_ab).map_or(0.0, |depth| depth.lower));
            }
        }
    }
    let pose_ba = &pose_ab.inverse();
    for (planes, other, pose) in [(a, b, pose_ab), (b, a, pose_ba)] {
        for part in &planes.parts {
            let Part::Plane(plane) = part else { continue };
            let depth = plane::depth_in_plane(plane, other, pose, 0.0);
            lower = lower.greater(depth.map_or(0.0, |depth| depth.lower));
        }
    }
    lower
}

/// Balls that touch the surfaces where the bodies come apart last: their bound is exact where both surfaces, or one of them, have room
/// for such balls.
fn tangent_balls(
    [a, b]: [&Union; 2],
    pose_ab: &MatrixPose,
    found: &SeparatingTranslation,
    scratch: &mut Scratch,
) -> Option<(f64, [Ball; 2])> {
    let pose_ba = pose_ab.inverse();
    let [p, q] = [found.after.witness_points[0], found.after.witness_points[1] - found.translation];
    let out = (found.after.witness_points[1] - p).try_normalize(0.0);
    let out = out.unwrap_or_else(|| found.translation.normalize());
    let depth = found.translation.norm();
    let on_a = SurfacePoint { point: p, inward: -out };
    let on_b = SurfacePoint { point: &pose_ba * q, inward: pose_ba.rotation * out };
    let mut balls_of_a = vec![Ball { centre: p, radius: 0.0 }];
    let mut balls_of_b = vec![Ball { centre: q, radius: 0.0 }];
    for share in [1.0, 0.5, 0.25] {
        balls_of_a.extend(Ball::tangent(&on_a, share * depth, a, scratch));
        let of_b = Ball::tangent(&on_b, share * depth, b, scratch);
        balls_of_b.extend(of_b.map(|ball| ball.transformed(pose_ab)));
    }
    let middle = nalgebra::center(&p, &q);
    balls_of_a.extend(Ball::around(middle, a, scratch));
    let of_b = Ball::around(&pose_ba * middle, b, scratch);
    balls_of_b.extend(of_b.map(|ball| ball.transformed(pose_ab)));
    let pairs = balls_of_a.iter().flat_map(|a| balls_of_b.iter().map(|b| (a.depth(b), [*a, *b])));
    pairs.max_by(|a, b| a.0.total_cmp(&b.0))
}
