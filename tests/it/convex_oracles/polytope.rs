//! Test helper: convex polytope as vertices, edges and faces; cuts and placements of it.

use clearance::geometry::TriangleMesh;
use clearance::geometry::math::{Point, Pose, Vector};

use super::convex_hull;

/// Distance (m) beyond a face, relative to the coordinates, up to which a point counts as inside.
const INSIDE_TOLERANCE: f64 = 1e-12;

/// A solid polytope, or a flat polygon (two faces back to back), a segment (no face) or a point (no edge).
#[derive(Clone, Debug)]
pub struct Polytope {
    pub vertices: Vec<Point>,
    pub edges: Vec<Edge>,
    pub faces: Vec<Face>,
    /// Edges that end at each vertex.
    pub edges_of: Vec<Vec<usize>>,
}

/// An edge between two vertices.
#[derive(Clone, Debug)]
pub struct Edge {
    pub ends: [usize; 2],
    /// The two faces at the edge; empty for a segment.
    pub faces: Vec<usize>,
}

/// A flat face.
#[derive(Clone, Debug)]
pub struct Face {
    /// Vertices counter-clockwise, seen from outside.
    pub corners: Vec<usize>,
    pub edges: Vec<usize>,
    /// Outward unit normal.
    pub normal: Vector,
}

impl Polytope {
    pub fn point(at: Point) -> Self {
        Self::from_loops(vec![at], &[])
    }

    pub fn segment(ends: [Point; 2]) -> Self {
        let mut made = Self::from_loops(ends.to_vec(), &[]);
        made.edges.push(Edge { ends: [0, 1], faces: vec![] });
        made.edges_of = vec![vec![0]; 2];
        made
    }

    pub fn triangle(corners: [Point; 3]) -> Self {
        Self::from_loops(corners.to_vec(), &[vec![0, 1, 2], vec![0, 2, 1]])
    }

    pub fn cuboid(half_extents: [f64; 3]) -> Self {
        let sign = |i: usize, axis: usize| if i >> axis & 1 == 0 { -1.0 } else { 1.0 };
        let corner = |i: usize| Point::from(std::array::from_fn(|k| sign(i, k) * half_extents[k]));
        Self::hull(&(0..8).map(corner).collect::<Vec<_>>()).expect("a box has a volume")
    }

    /// The convex hull of points; `None` if all are in a plane.
    pub fn hull(points: &[Point]) -> Option<Self> {
        let loops = convex_hull::faces(points)?;
        let mut used: Vec<usize> = loops.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        let number = |vertex: &usize| used.binary_search(vertex).expect("every corner is used");
        let loops: Vec<Vec<usize>> = loops.iter().map(|face| face.iter().map(number).collect()).collect();
        Some(Self::from_loops(used.iter().map(|i| points[*i]).collect(), &loops))
    }

    /// A polytope from the corners of its faces.
    fn from_loops(vertices: Vec<Point>, loops: &[Vec<usize>]) -> Self {
        let edges_of = vec![vec![]; vertices.len()];
        let mut made = Self { vertices, edges: vec![], faces: vec![], edges_of };
        for corners in loops {
            let next = corners.iter().cycle().skip(1);
            let face = made.faces.len();
            let edges =
                corners.iter().zip(next).map(|(from, to)| made.edge_of_face(*from, *to, face)).collect();
            let normal = made.normal_of(corners);
            made.faces.push(Face { corners: corners.clone(), edges, normal });
        }
        assert!(made.edges.iter().all(|edge| edge.faces.len() == 2), "every edge has two faces");
        made
    }

    /// The number of the edge between two vertices, of which `face` is one of the faces.
    fn edge_of_face(&mut self, from: usize, to: usize, face: usize) -> usize {
        let known = self.edges.iter().position(|edge| edge.ends == [to, from] || edge.ends == [from, to]);
        let number = known.unwrap_or_else(|| {
            let number = self.edges.len();
            self.edges.push(Edge { ends: [from, to], faces: vec![] });
            self.edges_of[from].push(number);
            self.edges_of[to].push(number);
            number
        });
        self.edges[number].faces.push(face);
        number
    }

    /// Unit normal of a polygon, from its area vector.
    fn normal_of(&self, corners: &[usize]) -> Vector {
        let origin = self.vertices[corners[0]];
        let spoke = |i: usize| self.vertices[corners[i]] - origin;
        (2..corners.len()).map(|i| spoke(i - 1).cross(&spoke(i))).sum::<Vector>().normalize()
    }

    /// The polytope at a pose.
    #[must_use]
    pub fn placed(&self, pose: &Pose) -> Self {
        let mut placed = self.clone();
        placed.vertices.iter_mut().for_each(|vertex| *vertex = pose * *vertex);
        for i in 0..placed.faces.len() {
            placed.faces[i].normal = placed.normal_of(&self.faces[i].corners);
        }
        placed
    }

    /// The parts on both sides of a plane through `point`; `None` where there is no volume.
    pub fn cut(&self, point: &Point, normal: &Vector) -> [Option<Self>; 2] {
        let height = |vertex: usize| normal.dot(&(self.vertices[vertex] - point));
        let crossing = |edge: &Edge| {
            let [from, to] = edge.ends;
            let (below, above) = (height(from), height(to));
            let share = below / (below - above);
            let place = || self.vertices[from] + (self.vertices[to] - self.vertices[from]) * share;
            (below * above < 0.0).then(place)
        };
        let section: Vec<Point> = self.edges.iter().filter_map(crossing).collect();
        [1.0, -1.0].map(|side| {
            let on_side = (0..self.vertices.len()).filter(|i| side * height(*i) >= 0.0);
            let kept: Vec<Point> = on_side.map(|i| self.vertices[i]).chain(section.iter().copied()).collect();
            Self::hull(&kept)
        })
    }

    /// Height (m) of a point over the plane of a face.
    pub fn height_over(&self, face: usize, point: &Point) -> f64 {
        let Face { corners, normal, .. } = &self.faces[face];
        normal.dot(&(point - self.vertices[corners[0]]))
    }

    /// Unit vector in the plane of a face, at right angles to one of its edges and away from the face.
    pub fn away_from_face(&self, edge: usize, face: usize) -> Vector {
        let Face { corners, normal, .. } = &self.faces[face];
        let [from, to] = self.edges[edge].ends;
        let place = corners.iter().position(|corner| *corner == from).expect("an edge of the face");
        let along = self.vertices[to] - self.vertices[from];
        let is_forward = corners[(place + 1) % corners.len()] == to;
        let outward = along.cross(normal).normalize();
        if is_forward { outward } else { -outward }
    }

    /// Whether a point is in the polytope, up to rounding.
    pub fn holds(&self, point: &Point) -> bool {
        let tolerance = INSIDE_TOLERANCE * self.reach().max(point.coords.amax());
        let is_behind = |face: usize| self.height_over(face, point) <= tolerance;
        let is_beside = |edge: usize, face: usize| {
            let from = self.vertices[self.edges[edge].ends[0]];
            self.away_from_face(edge, face).dot(&(point - from)) <= tolerance
        };
        match self.faces.len() {
            0 => {
                let (from, to) = (self.vertices[0], *self.vertices.last().expect("no polytope is empty"));
                let along = to - from;
                let share = along.dot(&(point - from)) / along.norm_squared().max(f64::MIN_POSITIVE);
                nalgebra::distance(point, &(from + along * share.clamp(0.0, 1.0))) <= tolerance
            }
            2 => (0..2).all(is_behind) && self.faces[0].edges.iter().all(|edge| is_beside(*edge, 0)),
            count => (0..count).all(is_behind),
        }
    }

    /// Largest coordinate (m).
    pub fn reach(&self) -> f64 {
        self.vertices.iter().map(|vertex| vertex.coords.amax()).fold(0.0, f64::max)
    }

    /// The surface as triangles.
    pub fn mesh(&self) -> TriangleMesh {
        let number = |i: usize| u32::try_from(i).expect("few vertices");
        let fan = |corners: &Vec<usize>| -> Vec<[u32; 3]> {
            let triangle = |i: usize| [corners[0], corners[i - 1], corners[i]].map(number);
            (2..corners.len()).map(triangle).collect()
        };
        let triangles = self.faces.iter().flat_map(|face| fan(&face.corners)).collect();
        TriangleMesh::new(self.vertices.clone(), triangles).expect("finite coordinates")
    }
}

#[test]
fn a_box_has_the_features_of_a_box() {
    let made = Polytope::cuboid([1.0, 2.0, 3.0]);
    assert_eq!((made.vertices.len(), made.edges.len(), made.faces.len()), (8, 12, 6));
    assert!((made.mesh().signed_volume() - 48.0).abs() < 1e-12);
    assert!(made.holds(&Point::new(1.0, -2.0, 3.0)) && !made.holds(&Point::new(1.0, -2.0, 3.000_001)));
}

#[test]
fn halves_of_a_box_have_half_its_volume() {
    let cut = Polytope::cuboid([1.0, 2.0, 3.0]).cut(&Point::origin(), &Vector::new(0.3, -0.5, 0.7));
    let [above, below] = cut.map(|part| part.unwrap().mesh().signed_volume());
    assert!((above - 24.0).abs() < 1e-12 && (below - 24.0).abs() < 1e-12, "{above} {below}");
}

#[test]
fn a_flat_triangle_holds_its_points_and_no_others() {
    let corners = [Point::origin(), Point::new(1.0, 0.0, 0.0), Point::new(0.0, 1.0, 0.0)];
    let made = Polytope::triangle(corners);
    assert!(made.holds(&Point::new(0.5, 0.5, 0.0)));
    assert!(!made.holds(&Point::new(0.51, 0.5, 0.0)) && !made.holds(&Point::new(0.2, 0.2, 0.01)));
}
