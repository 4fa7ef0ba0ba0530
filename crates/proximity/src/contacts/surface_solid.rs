//! Contacts of a surface and solid primitives: each triangle that a solid touches is a face that the solid may lie on.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, MatrixPose, Point, Vector};
use clearance_geometry::{PointPair, Triangle};

use super::candidate::{Candidate, Local, next_patch};
use super::chord::{Chord, Line};
use super::contact_patches::Patches;
use super::element_meeting::{Common, CornerNames, Meeting, MeetingPoint};
use super::manifold::{AcrossNormal, ConvexContact, ConvexShape, Manifold, PlacedSolid};
use super::polygon;
use super::surface_chords::chord_at;
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

/// Number of directions in which the part of a triangle inside a solid is measured.
const DIRECTIONS: u32 = 8;

/// Part of the distance from the middle of a triangle's inside by which its points are drawn back: rounding must not put them outside.
const INWARD: f64 = 1e-9;

/// How far from a point of the outline its depth is measured, relative to the face.
const BESIDE: f64 = 1e-7;

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

/// A triangle that a solid touches or is near.
struct Face {
    meeting: Meeting,
    solid: u32,
    /// Whether its points are corners of the solid or of the triangle: others are dropped where a patch has such.
    has_corners: bool,
    /// A point of the triangle inside the solid, between its points.
    middle: Point,
}

impl Face {
    /// A point next to a point of the outline, inside: along the outline, a line could miss the body.
    fn beside(&self, point: &Point) -> Point {
        point + (self.middle - point) * BESIDE
    }
}

impl SurfaceAndSolids<'_> {
    /// `fallback` is the normal of patches without a direction of their own.
    pub fn candidates(&self, fallback: Option<&Vector>, scratch: &mut Scratch, into: &mut Vec<Candidate>) {
        let faces = self.faces(fallback, scratch);
        let meetings: Vec<&Meeting> = faces.iter().map(|face| &face.meeting).collect();
        let patches = Patches::new(&meetings, fallback);
        let used = UsedFaces::new(&faces, &patches);
        let first = next_patch(into);
        for (face, patch) in faces.iter().zip(patches.of_meeting.iter().copied()) {
            let normal = patches.normals[patch as usize];
            if !used.uses(face, patch, &normal) {
                continue;
            }
            let (surface_is_a, solid) = (self.surface_is_a, face.solid);
            let local = |point: &MeetingPoint| match point.normal {
                Some(_) => Local::Known(point.depth),
                None if !face.meeting.has_outside => Local::Known(None),
                None => Local::OnFace { surface_is_a, solid, beside: face.beside(&point.position) },
            };
            into.extend(face.meeting.points.iter().map(|point| Candidate {
                position: point.position,
                normal: point.normal.unwrap_or(normal),
                patch: first + patch,
                local: local(point),
            }));
        }
    }

    /// The overlap (m, margin included) of the surface and a solid on the line along a normal through a point.
    pub fn depth(&self, solid: u32, point: &Point, normal: &Vector, scratch: &mut Scratch) -> Option<f64> {
        let line = Line { origin: *point, direction: *normal };
        let shape = ConvexSolid::Primitive(self.solid(solid));
        let of_solid = PlacedSolid { solid: &shape, pose: &MatrixPose::identity() }.chord(&line)?;
        let of_surface = chord_at(&self.surface, &line, CONTACT_DISTANCE, scratch)?;
        let [a, b] = if self.surface_is_a { [of_surface, of_solid] } else { [of_solid, of_surface] };
        Some((a.to - b.from).greater(0.0) + self.margin)
    }

    /// The triangles that solids touch.
    fn faces(&self, fallback: Option<&Vector>, scratch: &mut Scratch) -> Vec<Face> {
        let surface = self.surface.surface;
        let pose = self.pose_solids.relative(self.surface.pose);
        let relative = &self.solids.relative(surface.tree(), &pose);
        let trees = TreePair { a: self.solids, b: surface.tree(), relative };
        let (mut faces, mut names) = (Vec::new(), CornerNames::default());
        for_touching(trees, self.margin, 0.0, scratch, &mut |solid, triangle| {
            let found = self.face([solid, triangle], fallback, &mut names);
            let meets = found.is_some();
            faces.extend(found);
            meets
        });
        faces
    }

    /// A solid in the frame of the first body.
    fn solid(&self, index: u32) -> RoundedShape {
        let shape = &self.solids.leaves()[index as usize].content.shape;
        RoundedShape { pose: self.pose_solids.compose(&shape.pose), ..*shape }
    }

    fn face(
        &self,
        [solid, index]: [u32; 2],
        fallback: Option<&Vector>,
        names: &mut CornerNames,
    ) -> Option<Face> {
        let (shape, triangle) = (self.solid(solid), self.surface.triangle(index));
        let flat =
            RoundedShape { core: CoreShape::Triangle(triangle), pose: MatrixPose::identity(), radius: 0.0 };
        let limit = self.margin.greater(CONTACT_DISTANCE);
        let found = separation_within(&flat, &shape, &MatrixPose::identity(), limit)?;
        if found.distance > limit {
            return None;
        }
        let (normal, has_outside) = self.surface.normal(index, &triangle);
        // towards the second body
        let towards = if self.surface_is_a { normal } else { -normal };
        let is_turned = !has_outside && fallback.is_some_and(|fallback| fallback.dot(&towards) < 0.0);
        let towards = if is_turned { -towards } else { towards };
        let of_triangle = names.of(triangle.corners());
        let corners = if self.surface_is_a { [of_triangle, [solid; 3]] } else { [[solid; 3], of_triangle] };
        let meeting =
            |points, common| Meeting { corners, points, normals: [towards, -towards], has_outside, common };
        if found.distance > 0.0 {
            let points = vec![self.between(found.witness_points)];
            let middle = points[0].position;
            return Some(Face { meeting: meeting(points, Common::Point), solid, has_corners: true, middle });
        }
        let section = Section::new(&triangle, &shape, &found.witness_points[0]);
        let corners = self.manifold(&shape, &triangle, towards).corners;
        let has_corners = !corners.is_empty();
        let on_face = |position: Point| MeetingPoint { position, normal: None, depth: None };
        let points = if has_corners {
            corners.iter().map(|corner| on_face(corner.position)).collect()
        } else {
            section.points.iter().copied().map(on_face).collect()
        };
        let middle = section.middle;
        Some(Face { meeting: meeting(points, Common::Area(section.area)), solid, has_corners, middle })
    }

    fn between(&self, [on_surface, on_solid]: PointPair) -> MeetingPoint {
        let pair = if self.surface_is_a { [on_surface, on_solid] } else { [on_solid, on_surface] };
        MeetingPoint::between(pair, self.margin)
    }

    /// The part of a triangle inside a solid, as far as the solid lies on the triangle.
    fn manifold(&self, shape: &RoundedShape, triangle: &Triangle, normal: Vector) -> Manifold {
        let solid = ConvexSolid::Primitive(*shape);
        let placed = PlacedSolid { solid: &solid, pose: &MatrixPose::identity() };
        if self.surface_is_a {
            ConvexContact { a: triangle, b: &placed, normal, margin: 0.0 }.manifold()
        } else {
            ConvexContact { a: &placed, b: triangle, normal, margin: 0.0 }.manifold()
        }
    }
}

/// The faces that contacts may be on.
struct UsedFaces {
    /// By patch: the least cosine between its normal and that of a face.
    least_cosines: Vec<f64>,
    /// By patch: whether faces without corners are left out.
    only_corners: Vec<bool>,
    crosses: Vec<bool>,
}

impl UsedFaces {
    fn new(faces: &[Face], patches: &Patches) -> Self {
        let count = patches.normals.len();
        let mut used = Self {
            least_cosines: vec![0.0; count],
            only_corners: vec![false; count],
            crosses: patches.crosses.clone(),
        };
        let all = || faces.iter().zip(patches.of_meeting.iter().map(|patch| *patch as usize));
        for (face, patch) in all() {
            let cosine = face.meeting.normals[0].dot(&patches.normals[patch]);
            used.least_cosines[patch] = used.least_cosines[patch].greater(FACING * cosine);
        }
        for (face, patch) in all() {
            let cosine = face.meeting.normals[0].dot(&patches.normals[patch]);
            used.only_corners[patch] |= face.has_corners && cosine >= used.least_cosines[patch];
        }
        used
    }

    fn uses(&self, face: &Face, patch: u32, normal: &Vector) -> bool {
        let patch = patch as usize;
        let is_beside = self.crosses[patch] && matches!(face.meeting.common, Common::Point);
        !is_beside
            && face.meeting.normals[0].dot(normal) >= self.least_cosines[patch]
            && (face.has_corners || !self.only_corners[patch])
    }
}

/// The part of a triangle inside a solid.
struct Section {
    /// Points of its outline.
    points: Vec<Point>,
    /// Area (m²) of their convex hull.
    area: f64,
    /// A point inside the hull.
    middle: Point,
}

impl Section {
    /// `common` is a point of both.
    fn new(triangle: &Triangle, shape: &RoundedShape, common: &Point) -> Self {
        if triangle.normal() == Vector::zeros() {
            return Self { points: vec![*common], area: 0.0, middle: *common };
        }
        let plane = AcrossNormal::new(triangle.a, &triangle.normal());
        let solid = ConvexSolid::Primitive(*shape);
        let of_edges = triangle.edges().into_iter().filter_map(|edge| ends_in(&solid, edge)).flatten();
        let mut points: Vec<Point> = of_edges.collect();
        if points.len() < 3 {
            let rays = (0..DIRECTIONS).map(|i| f64::from(i) / f64::from(DIRECTIONS) * std::f64::consts::TAU);
            let rays = rays.map(|turn| plane.direction(turn));
            points.extend(rays.filter_map(|direction| {
                let line = Line { origin: *common, direction };
                let reach = chord_of_triangle(triangle, &line)?.to.lesser(solid.chord(&line)?.to);
                Some(line.at(reach.greater(0.0)))
            }));
        }
        let flat: Vec<polygon::Flat> = points.iter().map(|p| plane.flat(p)).collect();
        let hull = polygon::convex_hull(flat);
        if hull.is_empty() {
            return Self { points: vec![*common], area: 0.0, middle: *common };
        }
        let middle = polygon::middle(&hull);
        let drawn_back = hull.iter().map(|p| plane.point(&(p + (middle - p) * INWARD)));
        Self { points: drawn_back.collect(), area: polygon::area(&hull), middle: plane.point(&middle) }
    }
}

/// The ends of the part of a segment inside a solid.
fn ends_in(solid: &ConvexSolid, [p, q]: [Point; 2]) -> Option<[Point; 2]> {
    let length = nalgebra::distance(&p, &q);
    let direction = (q - p).try_normalize(0.0)?;
    let line = Line { origin: p, direction };
    let Chord { from, to } = solid.chord(&line)?;
    let (from, to) = (from.greater(0.0), to.lesser(length));
    (from <= to).then(|| [line.at(from), line.at(to)])
}

/// The part of a line in the plane of a triangle that is in the triangle.
fn chord_of_triangle(triangle: &Triangle, line: &Line) -> Option<Chord> {
    let normal = triangle.normal();
    triangle.edges().iter().try_fold(Chord::WHOLE, |chord, [a, b]| {
        let out = (b - a).cross(&normal).try_normalize(0.0)?;
        let slack = CONTACT_DISTANCE;
        chord.common(Chord::below(out.dot(&(line.origin - a)), out.dot(&line.direction), slack)?)
    })
}
