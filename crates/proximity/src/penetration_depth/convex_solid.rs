//! Convex solids with support maps: primitives, and closed meshes that are their own convex hull.

use std::collections::HashSet;

use clearance_geometry::math::{Extremes, MatrixPose, Point, Pose, Vector};
use clearance_geometry::{Primitive, TriangleMesh};

use crate::elements::Element;
use crate::elements::RoundedShape;
use crate::witnesses::SupportSet;

/// Largest number of vertices of a mesh that is tested for convexity; the test compares every vertex with every face.
const MOST_VERTICES: usize = 4096;

/// Distance of a vertex beyond the plane of a face up to which a mesh counts as convex, relative to the size of the mesh: the rounding of
/// coordinates in 32 bits.
const CONVEX_TOLERANCE: f64 = 1e-7;

/// Points of a convex set that are farthest along a direction.
pub(crate) trait SupportMap {
    /// The point of the core that is farthest along `direction`.
    fn support(&self, direction: &Vector) -> Point;

    /// Radius (m) of the sphere that is swept over the core.
    fn radius(&self) -> f64;

    /// Directions in which the solid often separates from another one by the shortest translation: normals of faces, axes of primitives.
    fn likely_normals(&self) -> Vec<Vector> {
        Vec::new()
    }
}

/// A convex solid in the frame of its body: a core swept by a sphere.
#[derive(Clone, Debug)]
pub(crate) enum ConvexSolid {
    Primitive(RoundedShape),
    Hull(Hull),
}

/// Convex polyhedron.
#[derive(Clone, Debug)]
pub(crate) struct Hull {
    vertices: Vec<Point>,
    faces: Vec<HalfSpace>,
    /// Largest distance (m) of a vertex beyond the plane of a face.
    excess: f64,
}

/// All points p with `normal · p <= offset` (m); the normal is a unit vector.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HalfSpace {
    pub normal: Vector,
    pub offset: f64,
}

impl SupportMap for ConvexSolid {
    fn support(&self, direction: &Vector) -> Point {
        match self {
            Self::Primitive(rounded) => {
                &rounded.pose * rounded.core.support(&rounded.pose.rotation.tr_mul(direction))
            }
            Self::Hull(hull) => farthest_along(&hull.vertices, direction),
        }
    }

    fn radius(&self) -> f64 {
        match self {
            Self::Primitive(rounded) => rounded.radius,
            Self::Hull(_) => 0.0,
        }
    }

    fn likely_normals(&self) -> Vec<Vector> {
        match self {
            Self::Primitive(rounded) => {
                let axes = (0..3).map(|i| rounded.pose.rotation.column(i).into_owned());
                axes.flat_map(|axis| [axis, -axis]).collect()
            }
            Self::Hull(hull) => hull.faces.iter().map(|face| face.normal).collect(),
        }
    }
}

impl ConvexSolid {
    pub fn primitive(primitive: Primitive, pose: Pose) -> Self {
        Self::Primitive(RoundedShape::from(&Element::Primitive { primitive, pose }))
    }

    /// The support set of the core along a direction, posed in another frame.
    pub fn support_set(&self, pose: &MatrixPose, n: &Vector, tolerance: f64, set: &mut SupportSet) {
        match self {
            Self::Primitive(rounded) => {
                set.set_to_core(&rounded.core, &pose.compose(&rounded.pose), n, tolerance);
            }
            Self::Hull(hull) => {
                set.set_to_hull(&hull.vertices, &pose.rotation.tr_mul(n), tolerance);
                set.transform(pose);
            }
        }
    }

    /// Length (m) by which the solid may be smaller than its support points show.
    pub fn excess(&self) -> f64 {
        match self {
            Self::Primitive(_) => 0.0,
            Self::Hull(hull) => hull.excess,
        }
    }

    /// Radius (m) of the largest ball around `p` inside the solid; `None` for a point outside.
    pub fn inner_radius(&self, p: &Point) -> Option<f64> {
        let radius = match self {
            Self::Primitive(rounded) => {
                let p = Point::from(rounded.pose.rotation.tr_mul(&(p.coords - rounded.pose.translation)));
                let of_core = (rounded.core.depth(&p)).map_or_else(
                    || -nalgebra::distance(&p, &rounded.core.nearest_point(&p)),
                    |(depth, _)| depth,
                );
                of_core + rounded.radius
            }
            Self::Hull(hull) => {
                let rooms = hull.faces.iter().map(|face| face.offset - face.normal.dot(&p.coords));
                rooms.fold(f64::INFINITY, f64::lesser)
            }
        };
        (radius >= 0.0).then_some(radius)
    }
}

impl Hull {
    pub fn vertices(&self) -> &[Point] {
        &self.vertices
    }

    /// The half-spaces of the faces: the solid is what all of them have in common.
    pub fn faces(&self) -> &[HalfSpace] {
        &self.faces
    }

    /// A closed mesh at a pose, if it is convex: no vertex is beyond the plane of any face.
    pub fn of_convex_mesh(mesh: &TriangleMesh, pose: &Pose) -> Option<Self> {
        let [surface] = mesh.solid().surfaces() else { return None };
        if mesh.solid().remarks().is_open() {
            return None;
        }
        let mut seen = HashSet::new();
        let corners = surface.triangles().iter().flatten().map(|&v| mesh.vertices()[v as usize]);
        let distinct = corners.filter(|p| seen.insert(p.coords.data.0[0].map(f64::to_bits)));
        let vertices: Vec<Point> = distinct.take(MOST_VERTICES + 1).map(|p| pose * p).collect();
        if vertices.len() > MOST_VERTICES {
            return None;
        }
        let size = pose.rotation * (mesh.bounds().1 - mesh.bounds().0);
        let planes = surface.triangles().iter().map(|t| t.map(|v| pose * mesh.vertices()[v as usize]));
        let faces: Vec<HalfSpace> = planes.filter_map(HalfSpace::below).collect();
        let beyond =
            |face: &HalfSpace| face.normal.dot(&farthest_along(&vertices, &face.normal).coords) - face.offset;
        let tolerance = CONVEX_TOLERANCE * size.norm();
        let mut excess = 0.0_f64;
        for face in &faces {
            excess = excess.greater(beyond(face));
            if excess > tolerance {
                return None;
            }
        }
        Some(Self { vertices, faces, excess })
    }
}

impl HalfSpace {
    /// The half-space below a triangle that is wound counter-clockwise seen from above; `None` without area.
    fn below([a, b, c]: [Point; 3]) -> Option<Self> {
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0)?;
        Some(Self { normal, offset: normal.dot(&a.coords) })
    }
}

/// The point farthest along a direction.
pub(super) fn farthest_along(points: &[Point], direction: &Vector) -> Point {
    let mut best = (f64::NEG_INFINITY, Point::origin());
    for p in points {
        let height = p.coords.dot(direction);
        if height > best.0 {
            best = (height, *p);
        }
    }
    best.1
}
