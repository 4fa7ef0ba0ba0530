//! Geometry of a link as the set to which distances are measured: mesh surfaces and, if closed, their insides, and solid primitives.

use std::ops::Range;

use clearance_geometry::math::{Extremes, Point};
use clearance_geometry::{InsideTest, Shape, Triangle, TriangleMesh};

use crate::link_geometry::PlacedShape;
use crate::triangle_tree::{Nearest, TriangleTree, centroid};

/// A convex part of the target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Element {
    Triangle(u32),
    Primitive(u32),
}

/// Distance of a point from the target.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Measured {
    /// Distance (m) from the nearest surface; negative inside a solid.
    pub signed: f64,
    pub nearest: Element,
}

/// Number of nodes of the tree after which a test whether a triangle is inside ends.
const MOST_NODES: usize = 4_000;

/// A mesh whose inside has distance 0.
#[derive(Debug)]
struct Solid<'s> {
    test: InsideTest<'s>,
    /// Its triangles in the tree.
    triangles: Range<u32>,
    /// True if a face of this mesh may meet the triangle of the current test.
    is_met: bool,
}

/// Shapes of one link to which distances are measured.
#[derive(Debug)]
pub(crate) struct DistanceTarget<'s> {
    tree: TriangleTree,
    primitives: Vec<&'s PlacedShape>,
    solids: Vec<Solid<'s>>,
}

impl<'s> DistanceTarget<'s> {
    /// With `are_solid`, points inside closed meshes have distance 0.
    pub fn new(shapes: &'s [PlacedShape], are_solid: bool) -> Self {
        let is_primitive = |placed: &&PlacedShape| matches!(placed.shape, Shape::Primitive(_));
        let (mut triangles, mut solids) = (Vec::new(), Vec::new());
        for mesh in shapes.iter().filter_map(mesh_of) {
            let first = index(triangles.len());
            triangles.extend((0..mesh.triangles().len()).map(|i| mesh.triangle(i)));
            if are_solid && !mesh.solid().surfaces().is_empty() {
                let triangles = first..index(triangles.len());
                solids.push(Solid { test: InsideTest::new(mesh), triangles, is_met: false });
            }
        }
        Self {
            tree: TriangleTree::new(triangles),
            primitives: shapes.iter().filter(is_primitive).collect(),
            solids,
        }
    }

    /// True if all points of a triangle are proven to be inside one closed mesh. A triangle that meets no face of the mesh is inside if one
    /// of its points is.
    pub fn proves_inside(&mut self, triangle: &Triangle) -> bool {
        let Self { tree, solids, .. } = self;
        for solid in solids.iter_mut() {
            solid.is_met = false;
        }
        let mut left = solids.len();
        let is_complete = left > 0
            && tree.overlapping(triangle, MOST_NODES, |face| {
                // the ranges are in increasing order
                let position = solids.partition_point(|solid| solid.triangles.end <= face);
                if let Some(solid) = solids.get_mut(position)
                    && solid.triangles.contains(&face)
                    && !solid.is_met
                    && tree.triangles()[face as usize].contact_point(triangle).is_some()
                {
                    solid.is_met = true;
                    left -= 1;
                }
                left > 0
            });
        is_complete
            && (solids.iter_mut()).any(|solid| !solid.is_met && solid.test.encloses(&centroid(triangle)))
    }

    /// Distance of `p`. `known` are elements that are probably near. Points at most `threshold` (m) from a mesh surface count as outside
    /// of meshes: their distance is then too large, never too small.
    pub fn measure(&mut self, p: &Point, known: &[Element], threshold: f64) -> Option<Measured> {
        let mut start: Option<Nearest> = None;
        for element in known {
            if let Element::Triangle(triangle) = *element {
                let squared = self.distance(*element, p).powi(2);
                if start.is_none_or(|s| squared < s.squared) {
                    start = Some(Nearest { triangle, squared });
                }
            }
        }
        let mesh = self.tree.nearest(p, start);
        let mut best = mesh.map(|nearest| Measured {
            signed: self.distance(Element::Triangle(nearest.triangle), p),
            nearest: Element::Triangle(nearest.triangle),
        });
        if let Some(found) = &mut best
            && found.signed > threshold
            && self.solids.iter_mut().any(|solid| solid.test.encloses(p))
        {
            found.signed = -found.signed;
        }
        for (placed, index) in self.primitives.iter().zip(0..) {
            let signed = primitive_distance(placed, p);
            if best.is_none_or(|b| signed < b.signed) {
                best = Some(Measured { signed, nearest: Element::Primitive(index) });
            }
        }
        best
    }

    /// Distance (m) of `p` from a convex element.
    pub fn distance(&self, element: Element, p: &Point) -> f64 {
        match element {
            Element::Triangle(triangle) => {
                let triangle: &Triangle = &self.tree.triangles()[triangle as usize];
                (triangle.nearest_point(p) - p).norm()
            }
            Element::Primitive(index) => primitive_distance(self.primitives[index as usize], p).greater(0.0),
        }
    }
}

fn index(position: usize) -> u32 {
    u32::try_from(position).unwrap_or(u32::MAX)
}

fn mesh_of(placed: &PlacedShape) -> Option<&TriangleMesh> {
    match &placed.shape {
        Shape::Mesh(mesh) => Some(mesh),
        _ => None,
    }
}

/// Signed distance (m) of a point from the surface of a solid primitive, negative inside. Infinite for other shapes.
pub(crate) fn primitive_distance(placed: &PlacedShape, p: &Point) -> f64 {
    let Shape::Primitive(primitive) = &placed.shape else { return f64::INFINITY };
    primitive.signed_distance(&placed.pose.inverse_transform_point(p))
}
