//! Contacts of a plane: corners and outermost points of the other body behind it.

use std::collections::HashMap;

use clearance_geometry::Plane;
use clearance_geometry::math::{Extremes, MatrixPose, Point, Vector};

use super::candidate::{Candidate, Local, next_patch};
use super::manifold::{ConvexShape, PlacedSolid};
use crate::body::{CollisionBody, Surface};
use crate::bvh::Tree;
use crate::elements::{CoreShape, RoundedShape};
use crate::penetration_depth::ConvexSolid;

/// A plane of one body, and the other body.
pub(super) struct PlaneContact<'s> {
    /// In the frame of the first body.
    pub plane: Plane,
    pub plane_is_a: bool,
    pub other: &'s CollisionBody,
    pub pose_other: &'s MatrixPose,
    pub margin: f64,
}

/// A point of the other body, and the part of its surface that it belongs to.
#[derive(Clone, Copy)]
struct Low {
    position: Point,
    /// Height (m) over the plane.
    height: f64,
    patch: u32,
}

impl PlaneContact<'_> {
    /// Points behind the plane, which is the half-space on the side to which the other body reaches less; cubes are left out.
    pub fn candidates(&self, fallback: Option<&Vector>, into: &mut Vec<Candidate>) {
        let normal = self.plane.normal.into_inner();
        let towards = if self.plane_is_a { 1.0 } else { -1.0 };
        let along = fallback.map_or(0.0, |fallback| fallback.dot(&normal)) * towards;
        let side = if along.abs() > 0.99 { along.signum() } else { self.nearer_side() };
        let out = normal * side;
        let first = next_patch(into);
        let low = self.low_points(&out, side);
        into.extend(low.iter().map(|point| Candidate {
            position: point.position,
            normal: out * towards,
            patch: first + point.patch,
            local: Local::Known(Some(self.margin - point.height)),
        }));
    }

    /// 1 if the other body has to move less along the normal than against it.
    fn nearer_side(&self) -> f64 {
        let normal = self.plane.normal.into_inner();
        let deepest = |side: f64| {
            let points = self.low_points(&(normal * side), side);
            points.iter().map(|point| -point.height).fold(0.0, f64::greater)
        };
        if deepest(1.0) <= deepest(-1.0) { 1.0 } else { -1.0 }
    }

    /// Points of the other body that are behind the plane or within the margin; `out` is the normal on this side.
    fn low_points(&self, out: &Vector, side: f64) -> Vec<Low> {
        let mut low = Vec::new();
        let height = |p: &Point| side * self.plane.height(p);
        for leaf in self.other.solids().into_iter().flat_map(Tree::leaves) {
            let patch = low.last().map_or(0, |last: &Low| last.patch + 1);
            let points = lowest_of_solid(&leaf.content.shape, self.pose_other, out).into_iter();
            let points = points.map(|position| Low { position, height: height(&position), patch });
            low.extend(points.filter(|point| point.height <= self.margin));
        }
        if let Some(surface) = self.other.surface() {
            self.add_vertices(surface, height, &mut low);
        }
        low
    }

    /// Vertices that are connected behind the plane belong to one patch.
    fn add_vertices(&self, surface: &Surface, height: impl Fn(&Point) -> f64, low: &mut Vec<Low>) {
        let first = low.last().map_or(0, |last| last.patch + 1);
        let mut number_at: HashMap<[u64; 3], usize> = HashMap::new();
        let (mut points, mut parent): (Vec<Low>, Vec<usize>) = Default::default();
        for index in 0..u32::try_from(surface.triangle_count()).expect("triangle count fits 31 bits") {
            let mut before = None;
            for p in surface.triangle(index).corners() {
                let position = self.pose_other * p;
                let height = height(&position);
                if height > self.margin {
                    continue;
                }
                let number =
                    *number_at.entry([p.x, p.y, p.z].map(|c| (c + 0.0).to_bits())).or_insert_with(|| {
                        points.push(Low { position, height, patch: 0 });
                        parent.push(points.len() - 1);
                        points.len() - 1
                    });
                let (a, b) = (root(&mut parent, before.unwrap_or(number)), root(&mut parent, number));
                parent[a.max(b)] = a.min(b);
                before = Some(number);
            }
        }
        let mut names: HashMap<usize, u32> = HashMap::new();
        for (number, point) in points.into_iter().enumerate() {
            let next = first + u32::try_from(names.len()).expect("vertex count fits 32 bits");
            let patch = *names.entry(root(&mut parent, number)).or_insert(next);
            low.push(Low { patch, ..point });
        }
        low.sort_by_key(|point| point.patch);
    }
}

fn root(parent: &mut [usize], mut of: usize) -> usize {
    while parent[of] != of {
        parent[of] = parent[parent[of]];
        of = parent[of];
    }
    of
}

/// Points of a solid that may be the lowest ones: all corners, points of the rims, or the outermost points of round ends.
fn lowest_of_solid(shape: &RoundedShape, pose: &MatrixPose, out: &Vector) -> Vec<Point> {
    let solid = ConvexSolid::Primitive(*shape);
    let placed = PlacedSolid { solid: &solid, pose };
    let axis = |i: usize| pose.rotation * shape.pose.rotation.column(i);
    let ends = |i: usize| [axis(i), -axis(i)].into_iter().flat_map(|n| placed.support_face(&n)).collect();
    match shape.core {
        CoreShape::Cuboid(_) | CoreShape::Cylinder { .. } | CoreShape::Cone { .. } => {
            let mut points: Vec<Point> = ends(2);
            points.extend(placed.support_face(&-out));
            points
        }
        CoreShape::Segment(half_length) => {
            CoreShape::segment(half_length).map(|end| pose * (&shape.pose * end) - out * shape.radius).into()
        }
        CoreShape::Point | CoreShape::Triangle(_) => placed.support_face(&-out),
    }
}
