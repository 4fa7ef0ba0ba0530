//! Connected closed part of a mesh, and a test whether it winds around a point.

use std::collections::{HashMap, HashSet};

use clearance_geometry::TriangleMesh;
use clearance_geometry::math::{Point, Vector};

use super::ray_crossings::RayCrossings;

/// Rays are cast from this number of points of a ball, until one meets no edge.
const RAYS: u32 = 32;

/// Faces that are connected by common corners, and whose edges are used equally often in both directions.
#[derive(Debug)]
pub(super) struct ClosedPart {
    /// Faces of the part.
    pub mesh: TriangleMesh,
    /// True if no other face of the mesh has an area, and every edge has two faces: a closed surface of its own.
    pub is_whole: bool,
    crossings: RayCrossings,
}

impl ClosedPart {
    /// The part of a mesh whose first face is this one; `None` if it has a free edge, or there is no such part.
    pub fn new(mesh: &TriangleMesh, face: usize) -> Option<Self> {
        let places = places(mesh);
        let corners = |t: &[u32; 3]| t.map(|v| places[v as usize]);
        let has_corners = |t: &&[u32; 3]| {
            let [a, b, c] = corners(t);
            a != b && b != c && c != a
        };
        let start = corners(mesh.triangles().get(face).filter(has_corners)?)[0];
        let is_first = |reached: &HashSet<usize>| {
            let before = mesh.triangles()[..face].iter().filter(has_corners);
            before.map(corners).all(|t| !reached.contains(&t[0]))
        };
        let faces: Vec<[u32; 3]> = mesh.triangles().iter().filter(has_corners).copied().collect();
        let is_reached = reached(&faces.iter().map(corners).collect::<Vec<_>>(), start);
        let part: Vec<[u32; 3]> =
            faces.iter().filter(|t| is_reached.contains(&corners(t)[0])).copied().collect();
        let edges = Edges::of(part.iter().map(corners));
        if !edges.are_balanced() || !is_first(&is_reached) {
            return None;
        }
        let points = |t: &[u32; 3]| t.map(|v| mesh.vertices()[v as usize]);
        let crossings = RayCrossings::new(part.iter().map(points).collect());
        let is_whole = part.len() == faces.len() && edges.have_two_faces();
        let mesh = TriangleMesh::new(mesh.vertices().to_vec(), part).ok()?;
        Some(Self { mesh, is_whole, crossings })
    }

    /// True if the part winds around a point whose distance from it is larger than `radius` (m).
    pub fn winds_around(&self, centre: &Point, radius: f64) -> bool {
        let numbers = (0..RAYS).map(|i| {
            let angle = 2.4 * f64::from(i);
            let away = 0.5 * radius * f64::from(i) / f64::from(RAYS);
            self.crossings.winding_number(&(centre + Vector::new(0.0, angle.cos(), angle.sin()) * away))
        });
        numbers.flatten().next().is_some_and(|number| number != 0)
    }
}

/// By vertex: the first vertex at the same position.
fn places(mesh: &TriangleMesh) -> Vec<usize> {
    let mut first: HashMap<[u64; 3], usize> = HashMap::new();
    (mesh.vertices().iter().enumerate())
        // -0.0 and 0.0 are one place
        .map(|(i, p)| *first.entry([p.x, p.y, p.z].map(|c| (c + 0.0).to_bits())).or_insert(i))
        .collect()
}

/// The corners that faces connect with one of them.
fn reached(faces: &[[usize; 3]], start: usize) -> HashSet<usize> {
    let mut around: HashMap<usize, Vec<usize>> = HashMap::new();
    for [a, b, c] in faces {
        around.entry(*a).or_default().extend([b, c]);
        around.entry(*b).or_default().extend([a, c]);
        around.entry(*c).or_default().extend([a, b]);
    }
    let mut reached = HashSet::new();
    let mut open = vec![start];
    while let Some(corner) = open.pop() {
        if reached.insert(corner) {
            open.extend(around.remove(&corner).unwrap_or_default());
        }
    }
    reached
}

/// By edge: in how many faces it is used in either direction.
struct Edges(HashMap<[usize; 2], [usize; 2]>);

impl Edges {
    fn of(faces: impl Iterator<Item = [usize; 3]>) -> Self {
        let mut uses: HashMap<[usize; 2], [usize; 2]> = HashMap::new();
        for [a, b, c] in faces {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                uses.entry([from.min(to), from.max(to)]).or_default()[usize::from(from < to)] += 1;
            }
        }
        Self(uses)
    }

    /// True if every edge is used equally often in both directions.
    fn are_balanced(&self) -> bool {
        self.0.values().all(|[forwards, backwards]| forwards == backwards)
    }

    /// True if every edge is used once in either direction.
    fn have_two_faces(&self) -> bool {
        self.0.values().all(|uses| *uses == [1, 1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two tetrahedra without common corners, the second with one face turned or left out.
    fn tetrahedra(second: &[[u32; 3]]) -> TriangleMesh {
        let corners = |at: f64| {
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
                .map(|[x, y, z]| Point::new(x + at, y, z))
        };
        let first = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let faces = first.iter().chain(second).copied().collect();
        TriangleMesh::new([corners(0.0), corners(5.0)].concat(), faces).unwrap()
    }

    #[test]
    fn only_a_part_without_a_free_edge_has_an_inside() {
        let whole = [[4, 6, 5], [4, 5, 7], [4, 7, 6], [5, 6, 7]];
        let both = tetrahedra(&whole);
        let inside = Point::new(0.2, 0.2, 0.2);
        assert!(ClosedPart::new(&both, 1).is_none(), "not the first face of its part");
        let part = ClosedPart::new(&both, 0).unwrap();
        assert!(part.winds_around(&inside, 1e-3) && !part.is_whole && part.mesh.triangles().len() == 4);
        assert!(!part.winds_around(&(inside + Vector::x() * 5.0), 1e-3));
        assert!(ClosedPart::new(&both, 4).unwrap().winds_around(&(inside + Vector::x() * 5.0), 1e-3));
        assert!(ClosedPart::new(&both, 8).is_none());
        let turned = [[4, 6, 5], [4, 7, 5], [4, 7, 6], [5, 6, 7]];
        for second in [&whole[..3], &turned[..]] {
            let mesh = tetrahedra(second);
            assert!(ClosedPart::new(&mesh, 4).is_none());
            assert!(ClosedPart::new(&mesh, 0).is_some());
        }
        assert!(ClosedPart::new(&tetrahedra(&[]), 0).unwrap().is_whole);
        // two tetrahedra with a common edge: four faces meet there
        let edge = [[0, 5, 1], [0, 6, 5], [0, 1, 6], [1, 5, 6]];
        let seam = ClosedPart::new(&tetrahedra(&edge), 0).unwrap();
        assert!(!seam.is_whole && seam.mesh.triangles().len() == 8);
    }

    #[test]
    fn a_ray_that_meets_an_edge_is_replaced() {
        let corner = |i: u8| Point::from([0, 1, 2].map(|axis| f64::from(i >> axis & 1) - 0.5));
        let vertices = (0..8).map(corner).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]];
        let faces = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        let part = ClosedPart::new(&TriangleMesh::new(vertices, faces).unwrap(), 0).unwrap();
        assert_eq!(part.crossings.winding_number(&Point::origin()), None);
        assert!(part.winds_around(&Point::origin(), 0.4));
        assert!(!part.winds_around(&Point::new(-0.7, 0.0, 0.0), 0.1));
    }
}
