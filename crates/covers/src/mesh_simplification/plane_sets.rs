//! The planes of the original faces that each vertex stands for.
//!
//! The largest distance from them orders the collapses (Ronfard and Rossignac 1996, *Full-range approximation of triangulated polyhedra*):
//! it follows the largest distance of two surfaces better than a mean over planes does.

use clearance_geometry::Triangle;
use clearance_geometry::math::{Extremes, Point, Vector};

use super::quadric::Quadric;
use super::surface_complex::SurfaceComplex;

/// Weight of the planes that keep a boundary in its place, relative to those of faces with the same area.
const BOUNDARY: f64 = 4.0;

#[derive(Clone, Copy, Debug)]
struct WeightedPlane {
    point: Point,
    /// Zero for a face without area.
    normal: Vector,
    /// Area (m²).
    weight: f64,
}

/// A list of planes, and for each vertex the numbers of its planes, sorted.
#[derive(Clone, Debug, Default)]
pub struct PlaneSets {
    planes: Vec<WeightedPlane>,
    of_vertex: Vec<Vec<u32>>,
}

impl PlaneSets {
    /// For each vertex: the planes of its faces, and those through its boundary edges, perpendicular to the face.
    pub fn new(complex: &SurfaceComplex) -> Self {
        let mut sets = Self { planes: vec![], of_vertex: (0..complex.vertices()).map(|_| vec![]).collect() };
        let at = |v: u32| complex.position(v);
        for face in complex.faces() {
            let [a, b, c] = face.map(at);
            let weight = 0.5 * (b - a).cross(&(c - a)).norm();
            sets.add(WeightedPlane { point: a, normal: Triangle { a, b, c }.normal(), weight }, &face);
        }
        for vertex in 0..complex.vertices() {
            for [end, apex] in complex.boundary_at(vertex) {
                let [p, q, r] = [vertex, end, apex].map(at);
                let (edge, side) = (q - p, r - p);
                let across = side - edge * (edge.dot(&side) / edge.norm_squared().greater(f64::MIN_POSITIVE));
                if let Some(normal) = across.try_normalize(0.0) {
                    let weight = BOUNDARY * edge.norm_squared();
                    sets.add(WeightedPlane { point: p, normal, weight }, &[vertex]);
                }
            }
        }
        sets
    }

    fn add(&mut self, plane: WeightedPlane, vertices: &[u32]) {
        let number = u32::try_from(self.planes.len()).unwrap_or(u32::MAX);
        self.planes.push(plane);
        for vertex in vertices {
            self.of_vertex[*vertex as usize].push(number);
        }
    }

    /// The quadric of a vertex's planes.
    pub fn quadric(&self, vertex: u32) -> Quadric {
        let mut quadric = Quadric::zero();
        for plane in self.of_vertex(vertex) {
            quadric.add_plane(&plane.point, &plane.normal, plane.weight);
        }
        quadric
    }

    /// Largest distance (m) of a point from a plane of a vertex.
    pub fn largest_distance(&self, vertex: u32, p: &Point) -> f64 {
        let distance = |plane: &WeightedPlane| plane.normal.dot(&(p - plane.point)).abs();
        self.of_vertex(vertex).map(distance).fold(0.0, Extremes::greater)
    }

    fn of_vertex(&self, vertex: u32) -> impl Iterator<Item = &WeightedPlane> {
        self.of_vertex[vertex as usize].iter().map(|plane| &self.planes[*plane as usize])
    }

    /// Gives one vertex the planes of another, too.
    pub fn join(&mut self, kept: u32, gone: u32) {
        let gone = std::mem::take(&mut self.of_vertex[gone as usize]);
        let kept = &mut self.of_vertex[kept as usize];
        kept.extend(gone);
        kept.sort_unstable();
        kept.dedup();
    }
}
