//! Contacts of a surface and solid primitives: each triangle that a solid touches is a face that the solid may lie on.

use clearance_geometry::Triangle;
use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, MatrixPose, Vector};

use super::candidate::{Candidate, Local};
use super::chord::Line;
use super::manifold::{ConvexContact, ConvexShape, Manifold, PlacedSolid};
use super::meeting::{Common, CornerNames, Meeting, MeetingPoint, Patches};
use super::surface_pair::PlacedSurface;
use super::touching_elements::for_touching;
use crate::body::SolidLeaf;
use crate::bounding_volume::Obb;
use crate::bvh::{Tree, TreePair};
use crate::elements::{CoreShape, RoundedShape};
use crate::narrow_phase::separation_within;
use crate::penetration_depth::ConvexSolid;
use crate::search::Scratch;

/// Cosine between the normals of a triangle and of its patch, relative to the largest of the patch, below which the solid is beside the
/// triangle, not on it.
const FACING: f64 = 0.5;

/// A surface of one body and the solids of the other.
pub(super) struct SurfaceAndSolids<'s> {
    pub surface: PlacedSurface<'s>,
    pub solids: &'s Tree<Obb, SolidLeaf>,
    pub pose_solids: &'s MatrixPose,
    /// True if the surface belongs to the first body.
    pub surface_is_a: bool,
    /// Distance (m) up to which they count as touching.
    pub margin: f64,
}

impl SurfaceAndSolids<'_> {
    /// `fallback` is the normal of patches without a direction of their own.
    pub fn candidates(&self, fallback: Option<&Vector>, scratch: &mut Scratch, into: &mut Vec<Candidate>) {
        let (meetings, solids) = self.meetings(fallback, scratch);
        let patches = Patches::new(&meetings, fallback);
        let first = into.iter().map(|candidate| candidate.patch + 1).max().unwrap_or(0);
        let facing = facing(&meetings, &patches);
        for ((patch, meeting), solid) in patches.of_meeting.iter().copied().zip(&meetings).zip(solids) {
            if patches.crosses[patch as usize] && matches!(meeting.common, Common::Point) {
                continue;
            }
            let normal = patches.normals[patch as usize];
            if meeting.normals[0].dot(&normal) < FACING * facing[patch as usize] {
                continue;
            }
            let solid = self.solid(solid);
            into.extend(meeting.points.iter().map(|point| {
                let known = point.depth.filter(|_| point.normal.is_some());
                let measured = || self.depth(&solid, point, &normal).filter(|_| meeting.has_outside);
                Candidate {
                    position: point.position,
                    normal: point.normal.unwrap_or(normal),
                    patch: first + patch,
                    local: Local::Known(known.or_else(measured)),
                }
            }));
        }
    }

    /// Where the solids touch triangles, and the index of the solid of each meeting.
    fn meetings(&self, fallback: Option<&Vector>, scratch: &mut Scratch) -> (Vec<Meeting>, Vec<u32>) {
        let surface = self.surface.surface;
        let pose = self.pose_solids.relative(self.surface.pose);
        let relative = &self.solids.relative(surface.tree(), &pose);
        let trees = TreePair { a: self.solids, b: surface.tree(), relative };
        let (mut meetings, mut solids, mut names) = (Vec::new(), Vec::new(), CornerNames::default());
        for_touching(trees, self.margin, 0.0, scratch, |solid, triangle| {
            let found = self.meeting([solid, triangle], fallback, &mut names);
            let meets = found.is_some();
            solids.extend(meets.then_some(solid));
            meetings.extend(found);
            meets
        });
        (meetings, solids)
    }

    /// A solid in the frame of the first body.
    fn solid(&self, index: u32) -> RoundedShape {
        let shape = &self.solids.leaves()[index as usize].content.shape;
        RoundedShape { pose: self.pose_solids.compose(&shape.pose), ..*shape }
    }

    fn meeting(
        &self,
        [solid, index]: [u32; 2],
        fallback: Option<&Vector>,
        names: &mut CornerNames,
    ) -> Option<Meeting> {
        let (shape, triangle) = (self.solid(solid), self.surface.triangle(index));
        let face =
            RoundedShape { core: CoreShape::Triangle(triangle), pose: MatrixPose::identity(), radius: 0.0 };
        let (first, second) = if self.surface_is_a { (&face, &shape) } else { (&shape, &face) };
        let limit = self.margin.greater(CONTACT_DISTANCE);
        let found = separation_within(first, second, &MatrixPose::identity(), limit)?;
        if found.distance > limit {
            return None;
        }
        let (normal, has_outside) = self.surface.normal(index, &triangle);
        // towards the second body
        let towards = if self.surface_is_a { normal } else { -normal };
        let is_turned = !has_outside && fallback.is_some_and(|fallback| fallback.dot(&towards) < 0.0);
        let towards = if is_turned { -towards } else { towards };
        let common = if found.distance > 0.0 {
            Manifold::default()
        } else {
            self.manifold(&shape, &triangle, towards)
        };
        let points: Vec<MeetingPoint> = if common.corners.is_empty() {
            let between = MeetingPoint::between(found.witness_points, self.margin);
            vec![MeetingPoint { depth: between.depth.filter(|_| found.distance > 0.0), ..between }]
        } else {
            let corners = common.corners.iter();
            corners
                .map(|corner| MeetingPoint { position: corner.position, normal: None, depth: None })
                .collect()
        };
        let of_triangle = names.of(triangle.corners());
        let corners = if self.surface_is_a { [of_triangle, [solid; 3]] } else { [[solid; 3], of_triangle] };
        let common = if common.corners.is_empty() { Common::Point } else { Common::Area(common.area) };
        Some(Meeting { corners, points, normals: [towards, -towards], has_outside, common })
    }

    /// The part of a triangle inside a solid, as far as the solid lies on the triangle.
    fn manifold(&self, shape: &RoundedShape, triangle: &Triangle, normal: Vector) -> Manifold {
        let solid = ConvexSolid::Primitive(*shape);
        let placed = PlacedSolid { solid: &solid, pose: &MatrixPose::identity() };
        let mut manifold = if self.surface_is_a {
            ConvexContact { a: triangle, b: &placed, normal, margin: 0.0 }.manifold()
        } else {
            ConvexContact { a: &placed, b: triangle, normal, margin: 0.0 }.manifold()
        };
        // the line through a corner meets the triangle there, or just beside it
        for corner in &mut manifold.corners {
            corner.position = triangle.nearest_point(&corner.position);
        }
        manifold
    }

    /// How far (m, margin included) a solid reaches behind a point of the surface.
    fn depth(&self, shape: &RoundedShape, point: &MeetingPoint, normal: &Vector) -> Option<f64> {
        let line = Line { origin: point.position, direction: *normal };
        let chord = PlacedSolid { solid: &ConvexSolid::Primitive(*shape), pose: &MatrixPose::identity() }
            .chord(&line);
        let depth = chord.map_or(0.0, |chord| if self.surface_is_a { -chord.from } else { chord.to });
        Some(depth.greater(0.0) + self.margin)
    }
}

/// For each patch, the largest cosine between its normal and that of a triangle in it.
fn facing(meetings: &[Meeting], patches: &Patches) -> Vec<f64> {
    let mut largest = vec![0.0_f64; patches.normals.len()];
    for (meeting, patch) in meetings.iter().zip(&patches.of_meeting) {
        let of_patch = &mut largest[*patch as usize];
        *of_patch = of_patch.greater(meeting.normals[0].dot(&patches.normals[*patch as usize]));
    }
    largest
}
