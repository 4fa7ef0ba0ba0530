//! Contacts of two surfaces: points on the curves in which their triangles cross, or where triangles are near each other.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, MatrixPose, Point, Vector};
use clearance_geometry::{PointPair, Triangle};

use super::candidate::{Candidate, Local, next_patch};
use super::chord::Line;
use super::contact_patches::Patches;
use super::element_meeting::{Common, CornerNames, Meeting, MeetingPoint, extent};
use super::surface_chords::chord_at;
use super::touching_elements::for_touching;
use crate::body::Surface;
use crate::bvh::TreePair;
use crate::penetration_depth::Winding;
use crate::search::Scratch;

/// Error of computed common points (m), relative to the coordinates.
const ROUNDING: f64 = 1e-12;

/// Distance of a line from the curve in which the surfaces cross, relative to the size of the contact.
const ASIDE: f64 = 1e-7;

/// Most lines between the middle of a patch and its curve on which the depth is measured.
const INNER_LINES: usize = 8;

/// A surface whose body is posed in the frame of the first body.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlacedSurface<'s> {
    pub surface: &'s Surface,
    pub winding: &'s Winding,
    pub pose: &'s MatrixPose,
}

/// Two surfaces within the margin (m) of each other, and where their triangles meet.
pub(super) struct SurfacePair<'s> {
    a: PlacedSurface<'s>,
    b: PlacedSurface<'s>,
    margin: f64,
    meetings: Vec<Meeting>,
    patches: Patches,
    /// Largest distance (m) of the points from each other.
    extent: f64,
}

impl PlacedSurface<'_> {
    /// Triangle `index` in the frame of the first body.
    pub fn triangle(&self, index: u32) -> Triangle {
        let Triangle { a, b, c } = self.surface.triangle(index);
        Triangle { a: self.pose * a, b: self.pose * b, c: self.pose * c }
    }

    /// The normal of a triangle, outward if it bounds a solid, and whether it does.
    pub fn normal(&self, index: u32, triangle: &Triangle) -> (Vector, bool) {
        let sign = self.winding.sign(self.surface.corners(index));
        (triangle.normal() * sign.unwrap_or(1.0), sign.is_some())
    }
}

impl<'s> SurfacePair<'s> {
    /// `fallback` is the normal of patches without a direction of their own.
    pub fn new(
        a: PlacedSurface<'s>,
        b: PlacedSurface<'s>,
        margin: f64,
        fallback: Option<&Vector>,
        scratch: &mut Scratch,
    ) -> Self {
        let pose_ab = a.pose.relative(b.pose);
        let relative = &a.surface.tree().relative(b.surface.tree(), &pose_ab);
        let trees = TreePair { a: a.surface.tree(), b: b.surface.tree(), relative };
        let (mut meetings, mut names) = (Vec::new(), CornerNames::default());
        for_touching(trees, margin, 0.0, scratch, &mut |i, j| {
            let found = meeting(&a, &b, [i, j], margin, &mut names);
            let meets = found.is_some();
            meetings.extend(found);
            meets
        });
        let patches = Patches::new(&meetings.iter().collect::<Vec<_>>(), fallback);
        let extent = extent(&meetings);
        Self { a, b, margin, meetings, patches, extent }
    }

    /// The points of the contact; for each patch with a curve, also its inside.
    pub fn candidates(&self, into: &mut Vec<Candidate>) {
        let first = next_patch(into);
        for (patch, meeting) in self.patches.relevant(&self.meetings) {
            let of_point = |point: &MeetingPoint| Candidate {
                position: point.position,
                normal: point.normal.unwrap_or(self.patches.normals[patch as usize]),
                patch: first + patch,
                local: match (point.depth, meeting.common) {
                    (Some(depth), _) => Local::Known(Some(depth)),
                    (None, Common::Segment(_)) => Local::OnCurve(patch),
                    (None, _) => Local::Known(Some(self.margin)),
                },
            };
            into.extend(meeting.points.iter().map(of_point));
        }
        for (patch, position) in self.middles() {
            let normal = self.patches.normals[patch as usize];
            into.push(Candidate { position, normal, patch: first + patch, local: Local::InsideCurve(patch) });
        }
    }

    /// The middles of the curves of patches with an outside.
    fn middles(&self) -> impl Iterator<Item = (u32, Point)> {
        let mut sums = vec![(Vector::zeros(), 0.0); self.patches.normals.len()];
        for (patch, meeting) in self.patches.relevant(&self.meetings) {
            if let Common::Segment([p, q]) = meeting.common {
                let length = (q - p).norm();
                let (sum, weight) = &mut sums[patch as usize];
                *sum += (p.coords + q.coords) * (0.5 * length);
                *weight += length;
            }
        }
        let known = self.patches.has_outside.iter();
        (0..)
            .zip(sums)
            .zip(known)
            .filter(|((_, (_, weight)), has_outside)| **has_outside && *weight > 0.0)
            .map(|((patch, (sum, weight)), _)| (patch, Point::from(sum / weight)))
    }

    /// How deep (m) the bodies overlap along the normal of a patch, beside a point of its curve; `None` if this is not known.
    pub fn depth_on_curve(&self, patch: u32, position: &Point, scratch: &mut Scratch) -> Option<f64> {
        if !self.patches.has_outside[patch as usize] {
            return None;
        }
        let normal = self.patches.normals[patch as usize];
        let near = 10.0 * ASIDE * self.extent;
        let meetings = self.meetings_of(patch).filter(|meeting| {
            meeting.points.iter().any(|point| nalgebra::distance(&point.position, position) <= near)
        });
        let inward: Vector = meetings.map(|meeting| -(meeting.normals[0] + meeting.normals[1])).sum();
        let aside = (inward - normal * inward.dot(&normal)).try_normalize(1e-6).unwrap_or_else(Vector::zeros);
        let reach = ASIDE * self.extent;
        let line = Line { origin: position + aside * reach, direction: normal };
        let overlap = self.overlap(&line, 2.0 * reach, scratch)?;
        Some(overlap.depth.greater(0.0) + self.margin)
    }

    /// The deepest point inside the curve of a patch, of some, and how deep it is (m).
    pub fn deepest_inside(&self, patch: u32, middle: &Point, scratch: &mut Scratch) -> Option<(Point, f64)> {
        let normal = self.patches.normals[patch as usize];
        let points: Vec<Point> =
            self.meetings_of(patch).flat_map(|meeting| &meeting.points).map(|point| point.position).collect();
        let step = points.len().div_ceil(INNER_LINES).max(1);
        let halfway = points.iter().step_by(step).map(|p| nalgebra::center(p, middle));
        let mut deepest: Option<(Point, f64)> = None;
        for origin in std::iter::once(*middle).chain(halfway) {
            let line = Line { origin, direction: normal };
            let Some(overlap) = self.overlap(&line, 0.0, scratch) else { continue };
            let depth = overlap.depth + self.margin;
            if deepest.is_none_or(|(_, best)| depth > best) {
                deepest = Some((line.at(overlap.middle), depth));
            }
        }
        deepest
    }

    fn meetings_of(&self, patch: u32) -> impl Iterator<Item = &Meeting> {
        self.patches.relevant(&self.meetings).filter(move |(of, _)| *of == patch).map(|(_, meeting)| meeting)
    }

    /// The overlap of the bodies on a line around its origin, which may be up to `slack` (m) outside of either.
    fn overlap(&self, line: &Line, slack: f64, scratch: &mut Scratch) -> Option<Overlap> {
        let reach = slack + CONTACT_DISTANCE;
        let of_a = chord_at(&self.a, line, reach, scratch)?;
        let of_b = chord_at(&self.b, line, reach, scratch)?;
        let common = [of_a.from.greater(of_b.from), of_a.to.lesser(of_b.to)];
        let overlap = Overlap { depth: of_a.to - of_b.from, middle: 0.5 * (common[0] + common[1]) };
        (common[1] - common[0] >= -2.0 * slack).then_some(overlap)
    }
}

/// Overlap of two bodies on a line (m).
#[derive(Clone, Copy, Debug)]
struct Overlap {
    depth: f64,
    /// Parameter of the middle of what is in both bodies.
    middle: f64,
}

/// Where two triangles meet, if they come within the margin (m).
fn meeting(
    a: &PlacedSurface,
    b: &PlacedSurface,
    [i, j]: [u32; 2],
    margin: f64,
    names: &mut CornerNames,
) -> Option<Meeting> {
    let (ours, theirs) = (a.triangle(i), b.triangle(j));
    let crossing = curve(&ours, &theirs);
    let points: Vec<MeetingPoint> = match crossing {
        Some(ends) => ends.map(|position| MeetingPoint { position, normal: None, depth: None }).into(),
        None => near_points(&ours, &theirs, margin.greater(CONTACT_DISTANCE))
            .map(|pair| MeetingPoint::between(pair, margin))
            .collect(),
    };
    if points.is_empty() {
        return None;
    }
    let ((of_a, a_is_known), (of_b, b_is_known)) = (a.normal(i, &ours), b.normal(j, &theirs));
    let common = crossing.map_or(Common::Point, |[p, q]| {
        let is_along = (q - p).dot(&of_a.cross(&of_b)) >= 0.0;
        Common::Segment(if is_along { [p, q] } else { [q, p] })
    });
    Some(Meeting {
        corners: [names.of(ours.corners()), names.of(theirs.corners())],
        points,
        normals: [of_a, of_b],
        has_outside: a_is_known && b_is_known,
        common,
    })
}

impl MeetingPoint {
    /// A point between the nearest points of elements that are apart; in the middle of a common point, if they touch.
    pub fn between([p, q]: PointPair, margin: f64) -> Self {
        let gap = nalgebra::distance(&p, &q);
        Self {
            position: nalgebra::center(&p, &q),
            normal: (q - p).try_normalize(CONTACT_DISTANCE),
            depth: Some((margin - gap).greater(0.0)),
        }
    }
}

/// The ends of the segment in which two triangles cross.
fn curve(ours: &Triangle, theirs: &Triangle) -> Option<[Point; 2]> {
    let is_common = |p: &Point| {
        let off = |t: &Triangle| nalgebra::distance(p, &t.nearest_point(p));
        off(ours).greater(off(theirs)) <= CONTACT_DISTANCE + ROUNDING * p.coords.amax()
    };
    let mut points = ours.crossing_points(theirs).filter(is_common);
    let first = points.next()?;
    let farthest = points.max_by(|p, q| {
        nalgebra::distance_squared(p, &first).total_cmp(&nalgebra::distance_squared(q, &first))
    })?;
    (farthest != first).then_some([first, farthest])
}

/// Corners of either triangle and the nearest points of the other, and the nearest points of both, as far as they are within reach (m).
fn near_points(ours: &Triangle, theirs: &Triangle, reach: f64) -> impl Iterator<Item = PointPair> {
    let of_ours = ours.corners().map(|p| [p, theirs.nearest_point(&p)]);
    let of_theirs = theirs.corners().map(|q| [ours.nearest_point(&q), q]);
    let all = of_ours.into_iter().chain(of_theirs).chain([ours.nearest_points(theirs)]);
    all.filter(move |[p, q]| nalgebra::distance(p, q) <= reach)
}
