//! Witness pairs of overlapping solids: all directions in which they separate by the shortest translation, and for each the points that
//! come apart last.
//!
//! The depth is the least height of the Minkowski difference over all directions. Where several directions have it, or where support sets
//! of both solids lie in one plane along one another, the depth has no derivative.

use clearance_geometry::math::{Extremes, MatrixPose, Point, UnitVector, Vector};
use clearance_geometry::{Plane, PointPair};

use super::PenetrationDepth;
use super::convex_solid::{ConvexSolid, SupportMap};
use super::expanding_polytope::ConvexPair;
use super::solid_body::{Part, SolidBody, Union, spread_directions};
use crate::elements::CoreShape;
use crate::witnesses::{FacingSets, SupportSet, WitnessOptions, WitnessPair, WitnessPairs};

/// Number of directions that represent all directions across an axis.
const AROUND: u8 = 32;

/// Number of directions that represent all.
const SPREAD: usize = 64;

/// Lists the witness pairs of a depth that [`penetration_depth`](super::penetration_depth) found with `margin` (m), in the frame of a. The
/// first is that of the depth.
///
/// Returns true if the list tells whether there are others: for two convex solids, and for a plane and a convex solid. For other bodies
/// only the first pair is listed.
#[must_use]
pub fn depth_witnesses(
    bodies: [&SolidBody; 2],
    pose_ab: &MatrixPose,
    (depth, margin): (&PenetrationDepth, f64),
    options: &WitnessOptions,
    found: &mut WitnessPairs,
) -> bool {
    found.clear();
    if !depth.upper.is_finite() {
        return false;
    }
    let distance = (depth.upper - margin).greater(0.0);
    let first = WitnessPair { points: depth.witness_points, normal: depth.direction };
    let [a, b] = bodies.map(SolidBody::only_part);
    match (a, b) {
        (Some(Part::Convex(a)), Some(Part::Convex(b))) => {
            found.begin(options, distance, distance);
            found.offer(first);
            if !(OverlappingSolids { a, b, pose_ab }).collect(&first, distance, found) {
                return false;
            }
        }
        (Some(Part::Plane(plane)), Some(Part::Convex(solid))) => {
            found.begin(options, distance, distance);
            found.offer(first);
            PlaneInSolid { plane, solid, pose: pose_ab, plane_is_a: true }.collect(distance, found);
        }
        (Some(Part::Convex(solid)), Some(Part::Plane(plane))) => {
            found.begin(options, distance, distance);
            found.offer(first);
            let plane = &plane.placed(pose_ab);
            let pose = &MatrixPose::identity();
            PlaneInSolid { plane, solid, pose, plane_is_a: false }.collect(distance, found);
        }
        _ => {
            found.begin(options, distance, distance);
            found.offer(first);
            return false;
        }
    }
    found.finish();
    true
}

/// Two convex solids that overlap, the second posed in the frame of the first.
struct OverlappingSolids<'s> {
    a: &'s ConvexSolid,
    b: &'s ConvexSolid,
    pose_ab: &'s MatrixPose,
}

impl OverlappingSolids<'_> {
    /// Adds all pairs to the first; false where they are not known.
    fn collect(&self, first: &WitnessPair, depth: f64, found: &mut WitnessPairs) -> bool {
        let radii = self.a.radius() + self.b.radius();
        let [p, q] = first.points;
        let core_points = [p - first.normal * self.a.radius(), q + first.normal * self.b.radius()];
        self.collect_along(&first.normal, core_points, found);
        if depth < radii {
            // cores that are apart have one normal
            return true;
        }
        let Self { a, b, pose_ab } = *self;
        let directions = ConvexPair { a, b, pose_ab, rounded: false }.directions_within(found.tolerance());
        for direction in &directions {
            if !found.wants_more() {
                return true;
            }
            self.offer(direction.core_points, &direction.normal, found);
            self.collect_along(&direction.normal, direction.core_points, found);
        }
        !directions.is_empty() || self.collect_flat(&first.normal, core_points, found)
    }

    fn offer(&self, [p, q]: PointPair, normal: &Vector, found: &mut WitnessPairs) {
        let points = [p + normal * self.a.radius(), q - normal * self.b.radius()];
        found.offer(WitnessPair { points, normal: *normal });
    }

    /// All pairs for one normal, of which the points of one are known.
    fn collect_along(&self, normal: &Vector, [p, q]: PointPair, found: &mut WitnessPairs) {
        let tolerance = found.tolerance();
        let [mut set_a, mut set_b] = std::mem::take(&mut found.sets);
        self.a.support_set(&MatrixPose::identity(), normal, tolerance, &mut set_a);
        self.b.support_set(self.pose_ab, &-normal, tolerance, &mut set_b);
        if set_a.points().len() > 1 && set_b.points().len() > 1 {
            let gap = normal * (q - p).dot(normal);
            let facing = FacingSets::new([&mut set_a, &mut set_b], gap, found.resolution());
            facing.each_extreme_pair(|pair| {
                self.offer(pair, normal, found);
                found.wants_more()
            });
        }
        found.sets = [set_a, set_b];
    }

    /// Cores without common volume: points, segments and crossing segments, which separate in any direction across both. False for
    /// others, whose directions are not known.
    fn collect_flat(&self, normal: &Vector, core_points: PointPair, found: &mut WitnessPairs) -> bool {
        let lines = Line::of_core(self.a, &MatrixPose::identity()).zip(Line::of_core(self.b, self.pose_ab));
        let normals: Vec<Vector> = match lines {
            None => return false,
            Some((Line::Point, Line::Point)) => {
                spread_directions(SPREAD).into_iter().map(UnitVector::into_inner).collect()
            }
            Some((Line::Along(one), Line::Along(other))) if one.cross(&other).norm() > 1e-9 => vec![-normal],
            Some((Line::Along(axis), _) | (Line::Point, Line::Along(axis))) => around(&axis).collect(),
        };
        for normal in normals {
            self.offer(core_points, &normal, found);
        }
        true
    }
}

/// A core that is a point or a segment.
enum Line {
    Point,
    /// Unit vector along the segment.
    Along(Vector),
}

impl Line {
    /// In the frame that the solid is posed in; `None` for other cores.
    fn of_core(solid: &ConvexSolid, pose: &MatrixPose) -> Option<Self> {
        let ConvexSolid::Primitive(rounded) = solid else { return None };
        match rounded.core {
            CoreShape::Point => Some(Self::Point),
            CoreShape::Segment(_) => Some(Self::Along(pose.rotation * rounded.pose.rotation.column(2))),
            _ => None,
        }
    }
}

/// Unit vectors normal to an axis.
fn around(axis: &Vector) -> impl Iterator<Item = Vector> {
    let mut other = Vector::zeros();
    other[axis.iamin()] = 1.0;
    let u = axis.cross(&other).normalize();
    let v = axis.cross(&u);
    (0..AROUND).map(move |i| {
        let (sin, cos) = (f64::from(i) / f64::from(AROUND) * std::f64::consts::TAU).sin_cos();
        u * cos + v * sin
    })
}

/// A plane, and a convex solid posed in its frame.
struct PlaneInSolid<'s> {
    plane: &'s Plane,
    solid: &'s ConvexSolid,
    pose: &'s MatrixPose,
    plane_is_a: bool,
}

impl PlaneInSolid<'_> {
    /// The solid may leave to both sides; all its farthest points on the other side come apart last.
    fn collect(&self, depth: f64, found: &mut WitnessPairs) {
        let tolerance = found.tolerance();
        let normal = self.plane.normal.into_inner();
        let mut set = SupportSet::default();
        for away in [normal, -normal] {
            let local = -self.pose.rotation.tr_mul(&away);
            let lowest = self.pose * (self.solid.support(&local) + local * self.solid.radius());
            let height = away.dot(&normal) * -self.plane.height(&lowest);
            if height > depth + tolerance {
                continue;
            }
            self.solid.support_set(self.pose, &-away, tolerance, &mut set);
            for p in set.points() {
                self.offer(p - away * self.solid.radius(), &away, found);
            }
        }
    }

    fn offer(&self, on_solid: Point, away: &Vector, found: &mut WitnessPairs) {
        let on_plane = on_solid - self.plane.normal.into_inner() * self.plane.height(&on_solid);
        let (points, normal) =
            if self.plane_is_a { ([on_plane, on_solid], *away) } else { ([on_solid, on_plane], -away) };
        found.offer(WitnessPair { points, normal });
    }
}

impl Union {
    fn only_part(&self) -> Option<&Part> {
        match &self.parts[..] {
            [part] => Some(part),
            _ => None,
        }
    }
}

impl SolidBody {
    /// Its only part, if it has no others and no points or voxels.
    fn only_part(&self) -> Option<&Part> {
        if self.sets.is_empty() { self.union.as_ref()?.only_part() } else { None }
    }
}
