//! Defects of one mesh, counted, each with one location.

use std::collections::HashMap;
use std::time::Instant;

use clearance_geometry::math::{Point, Vector};
use clearance_geometry::{DisjointSets, Triangle, TriangleMesh, WeldedMesh};

use crate::link_geometry::joined;
use crate::self_intersections;
use crate::triangle_tree::centroid;

/// Height of a triangle, relative to its longest edge, at which it counts as without area.
const FLAT: f64 = 1e-12;

/// A mesh is nearly closed if at most one of this many edges is open.
const MOST_OPEN: usize = 50;

/// Volume of a mesh, relative to the box around it, below which its sign says nothing about its winding.
const LEAST_VOLUME: f64 = 1e-3;

/// A number of equal defects, and the location of the first one (m, mesh frame).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Defect {
    /// Number of defects.
    pub count: usize,
    /// Location of the first one.
    pub point: Point,
}

/// Defects of one mesh. Vertices at equal positions count as one vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshDefects {
    /// Number of triangles.
    pub triangles: usize,
    /// Edges with one face only.
    pub open_edges: Option<Defect>,
    /// Edges that two faces run through in the same direction.
    pub mixed_orientation: Option<Defect>,
    /// Components of connected faces that are wound inward, and are no cavity of a larger one. The mesh is closed, or nearly so.
    pub inverted: Option<Defect>,
    /// Faces that repeat another one, with the same winding.
    pub duplicate_faces: Option<Defect>,
    /// Faces that repeat another one, with the opposite winding.
    pub double_sided_faces: Option<Defect>,
    /// Pairs of faces of which an edge of one passes through the other. The signs of the test are exact.
    pub self_intersections: Option<Defect>,
    /// True if the search for self-intersections ended early: at a number of them, of tests, or at the deadline.
    pub may_have_more_self_intersections: bool,
    /// Triangles without area.
    pub degenerate_triangles: Option<Defect>,
    /// Number of parts that share no vertex.
    pub components: usize,
}

impl MeshDefects {
    /// Searches for defects in a mesh. The deadline ends the search for self-intersections; the time of the others is linear in the number
    /// of faces.
    pub fn find(mesh: &TriangleMesh, deadline: Option<Instant>) -> Self {
        let welded = WeldedMesh::new(mesh);
        let mut defects = Self { triangles: welded.faces.len(), ..Self::default() };
        let mut sound = Vec::with_capacity(welded.faces.len());
        for (face, corners) in welded.faces.iter().enumerate() {
            let triangle = welded.triangle(face);
            if is_flat(&triangle) {
                note(&mut defects.degenerate_triangles, triangle.a);
            }
            // a face with two equal corners has no edges that matter
            let [a, b, c] = corners;
            if a != b && b != c && c != a {
                sound.push(face);
            }
        }
        let kept = defects.find_repeated(&welded, &sound);
        defects.find_edges(&welded, &kept);
        defects.find_components(&welded, &kept);
        let crossings = self_intersections::find(&welded, &kept, deadline);
        defects.may_have_more_self_intersections = crossings.is_limited;
        defects.self_intersections = crossings.point.map(|point| Defect { count: crossings.count, point });
        defects
    }

    /// True if the mesh has no open edge.
    pub fn is_closed(&self) -> bool {
        self.open_edges.is_none()
    }

    /// Notes faces with the same corners as earlier ones; returns the others.
    fn find_repeated(&mut self, welded: &WeldedMesh, faces: &[usize]) -> Vec<usize> {
        let mut first: HashMap<[u32; 3], bool> = HashMap::new();
        let mut kept = Vec::with_capacity(faces.len());
        for &face in faces {
            let corners = welded.faces[face];
            let mut key = corners;
            key.sort_unstable();
            let [a, b, c] = corners;
            let is_even = (a < b) ^ (b < c) ^ (a < c);
            match first.get(&key) {
                None => {
                    first.insert(key, is_even);
                    kept.push(face);
                }
                Some(&same) => {
                    let list = if same == is_even {
                        &mut self.duplicate_faces
                    } else {
                        &mut self.double_sided_faces
                    };
                    note(list, centroid(&welded.triangle(face)));
                }
            }
        }
        kept
    }

    fn find_edges(&mut self, welded: &WeldedMesh, faces: &[usize]) {
        let mut edges: Vec<([u32; 2], bool)> = faces
            .iter()
            .flat_map(|&face| {
                let [a, b, c] = welded.faces[face];
                [[a, b], [b, c], [c, a]].map(|[s, t]| ([s.min(t), s.max(t)], s < t))
            })
            .collect();
        edges.sort_unstable();
        for same in edges.chunk_by(|s, t| s.0 == t.0) {
            let [a, b] = same[0].0.map(|v| welded.positions[v as usize]);
            match same {
                [_] => note(&mut self.open_edges, a + (b - a) * 0.5),
                [s, t] if s.1 == t.1 => note(&mut self.mixed_orientation, a + (b - a) * 0.5),
                _ => {}
            }
        }
    }

    /// Counts components. One is inverted if it encloses a negative volume, after its holes are closed by cones with their apex at the
    /// mean of the vertices, and its box is not in that of a larger one that encloses a positive volume: then, it may be a cavity.
    fn find_components(&mut self, welded: &WeldedMesh, faces: &[usize]) {
        let mut parts =
            DisjointSets::of_faces(welded.positions.len(), faces.iter().map(|face| &welded.faces[*face]));
        let mut components: HashMap<u32, Component> = HashMap::new();
        let origin = mean(&welded.positions);
        for &face in faces {
            let Triangle { a, b, c } = welded.triangle(face);
            let bounds = [a.inf(&b.inf(&c)), a.sup(&b.sup(&c))];
            let volume = (a - origin).dot(&(b - origin).cross(&(c - origin))) / 6.0;
            let component = components.entry(parts.smallest(welded.faces[face][0])).or_insert(Component {
                volume: 0.0,
                face,
                bounds,
            });
            component.volume += volume;
            component.bounds = joined(component.bounds, bounds);
        }
        self.components = components.len();
        if self.mixed_orientation.is_some() || !self.is_nearly_closed(faces.len()) {
            return;
        }
        let least = LEAST_VOLUME * box_volume(&welded.positions);
        let solids: Vec<&Component> =
            components.values().filter(|component| component.volume > 0.0).collect();
        let is_inverted = |component: &&Component| {
            -component.volume > least && !solids.iter().any(|solid| solid.may_have_cavity(component))
        };
        let inverted: Vec<&Component> = components.values().filter(is_inverted).collect();
        let largest = inverted.iter().min_by(|s, t| s.volume.total_cmp(&t.volume).then(s.face.cmp(&t.face)));
        self.inverted = largest
            .map(|largest| Defect { count: inverted.len(), point: centroid(&welded.triangle(largest.face)) });
    }
}

/// Faces that share vertices.
struct Component {
    /// Volume (m³) that it encloses; negative if it is wound inward.
    volume: f64,
    /// Its first face.
    face: usize,
    /// Corners of its box.
    bounds: [Point; 2],
}

impl Component {
    /// Whether another component, which is wound inward, may be a cavity of this one.
    fn may_have_cavity(&self, other: &Self) -> bool {
        let [low, high] = self.bounds;
        let is_within = (0..3).all(|i| low[i] <= other.bounds[0][i] && other.bounds[1][i] <= high[i]);
        self.volume > -other.volume && is_within
    }
}

impl MeshDefects {
    /// True if few of the edges of this many faces are open.
    fn is_nearly_closed(&self, faces: usize) -> bool {
        self.open_edges.is_none_or(|open| MOST_OPEN * open.count <= 3 * faces)
    }
}

fn mean(points: &[Point]) -> Point {
    let sum: Vector = points.iter().map(|p| p.coords).sum();
    // a mesh has far fewer than 2^52 vertices
    #[allow(clippy::cast_precision_loss)]
    let count = points.len().max(1) as f64;
    Point::from(sum / count)
}

/// Volume (m³) of the box around points.
fn box_volume(points: &[Point]) -> f64 {
    let box_of = points.iter().map(|p| [*p; 2]).reduce(joined);
    box_of.map_or(0.0, |[low, high]| (high - low).product())
}

fn note(defect: &mut Option<Defect>, point: Point) {
    defect.get_or_insert(Defect { count: 0, point }).count += 1;
}

fn is_flat(triangle: &Triangle) -> bool {
    let edges = triangle.edges().map(|[a, b]| (b - a).norm_squared());
    let longest = edges.iter().fold(0.0, |l: f64, e| if *e > l { *e } else { l });
    let twice_area = (triangle.b - triangle.a).cross(&(triangle.c - triangle.a)).norm();
    twice_area <= FLAT * longest
}
