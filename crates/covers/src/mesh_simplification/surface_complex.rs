//! Triangles over shared vertices, of which edges are collapsed without a change of topology.
//!
//! Closed surfaces stay closed, and surfaces whose edges have at most two faces stay so: an edge collapses only under the link condition
//! (Dey, Edelsbrunner, Guha and Nekhayev 1999, *Topology preserving edge contraction*). A vertex at an edge of three or more faces keeps
//! its place.

use std::collections::{HashMap, HashSet};

use clearance_geometry::TriangleMesh;
use clearance_geometry::WeldedMesh;
use clearance_geometry::math::Point;

/// Topology of the faces around a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Around {
    /// A closed fan.
    Disk,
    /// A fan between two boundary edges.
    HalfDisk,
    /// Anything else: the vertex keeps its place.
    Other,
}

/// Number of faces at a vertex above which its edges stay, since each of their tests reads all of these faces. Collapses around it reduce
/// the number.
const MOST_FACES: usize = 1000;

/// Where the vertex of a collapsed edge may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    Anywhere,
    /// At this end of the edge.
    At(u32),
}

/// The faces of several meshes, which have no common vertices.
#[derive(Clone, Debug, Default)]
pub struct SurfaceComplex {
    positions: Vec<Point>,
    faces: Vec<[u32; 3]>,
    is_removed: Vec<bool>,
    faces_of: Vec<Vec<u32>>,
    around: Vec<Around>,
    count: usize,
}

impl SurfaceComplex {
    /// Vertices at equal positions are joined; faces without three positions are left out, and repeated faces, too. Where surfaces touch at
    /// one vertex only, each gets its own.
    pub fn new<'m>(meshes: impl Iterator<Item = &'m TriangleMesh>) -> (Self, Vec<usize>) {
        let mut complex = Self::default();
        let mut ends = vec![];
        for mesh in meshes {
            complex.add(&WeldedMesh::new(mesh));
            ends.push(complex.faces.len());
        }
        complex.count = complex.faces.len();
        complex.is_removed = vec![false; complex.count];
        complex.find_faces_of_vertices();
        for vertex in 0..index(complex.positions.len()) {
            complex.split_fans(vertex);
        }
        complex.around = (0..index(complex.positions.len())).map(|v| complex.kind(v)).collect();
        (complex, ends)
    }

    fn add(&mut self, mesh: &WeldedMesh) {
        let first = index(self.positions.len());
        self.positions.extend_from_slice(&mesh.positions);
        let mut known = HashSet::new();
        for face in &mesh.faces {
            let mut key = *face;
            key.sort_unstable();
            if key[0] != key[1] && key[1] != key[2] && known.insert(key) {
                self.faces.push(face.map(|v| first + v));
            }
        }
    }

    fn find_faces_of_vertices(&mut self) {
        self.faces_of = vec![vec![]; self.positions.len()];
        for (face, number) in self.faces.iter().zip(0..) {
            for v in face {
                self.faces_of[*v as usize].push(number);
            }
        }
    }

    /// The neighbours of a vertex, each as often as it shares a face, sorted, with the face's position in the list of the vertex.
    fn spokes(&self, vertex: u32) -> Vec<(u32, usize)> {
        let faces = self.faces_of[vertex as usize].iter().enumerate();
        let others = |(i, f): (usize, &u32)| self.faces[*f as usize].map(|v| (v, i));
        let mut spokes: Vec<_> = faces.flat_map(others).filter(|(v, _)| *v != vertex).collect();
        spokes.sort_unstable();
        spokes
    }

    /// Gives each fan of faces that are connected by edges at a vertex a vertex of its own.
    fn split_fans(&mut self, vertex: u32) {
        let spokes = self.spokes(vertex);
        let faces = self.faces_of[vertex as usize].clone();
        let mut sets = clearance_geometry::DisjointSets::new(faces.len());
        for pair in spokes.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
            sets.join(index(pair[0].1), index(pair[1].1));
        }
        let mut vertices: HashMap<u32, u32> = HashMap::from([(0, vertex)]);
        self.faces_of[vertex as usize].clear();
        for (face, i) in faces.iter().zip(0..) {
            let own = *vertices.entry(sets.smallest(i)).or_insert_with(|| {
                self.positions.push(self.positions[vertex as usize]);
                self.faces_of.push(vec![]);
                index(self.positions.len() - 1)
            });
            replace(&mut self.faces[*face as usize], vertex, own);
            self.faces_of[own as usize].push(*face);
        }
    }

    fn kind(&self, vertex: u32) -> Around {
        let spokes = self.spokes(vertex);
        let mut boundary = 0;
        for edge in spokes.chunk_by(|a, b| a.0 == b.0) {
            match edge.len() {
                1 => boundary += 1,
                2 => {}
                _ => return Around::Other,
            }
        }
        match boundary {
            0 => Around::Disk,
            2 => Around::HalfDisk,
            _ => Around::Other,
        }
    }

    /// Number of faces.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Position (m) of a vertex.
    pub fn position(&self, vertex: u32) -> Point {
        self.positions[vertex as usize]
    }

    /// Number of vertices, with those that are no longer used.
    pub fn vertices(&self) -> u32 {
        index(self.positions.len())
    }

    /// The corners of the faces at a vertex.
    pub fn faces_at(&self, vertex: u32) -> impl Iterator<Item = [u32; 3]> {
        self.faces_of[vertex as usize].iter().map(|f| self.faces[*f as usize])
    }

    /// The corners of all faces.
    pub fn faces(&self) -> impl Iterator<Item = [u32; 3]> {
        self.faces_in(0..self.faces.len())
    }

    /// The corners of the faces whose numbers are in a range.
    pub fn faces_in(&self, range: std::ops::Range<usize>) -> impl Iterator<Item = [u32; 3]> {
        range.filter(|f| !self.is_removed[*f]).map(|f| self.faces[f])
    }

    /// The neighbours of a vertex, sorted.
    pub fn neighbours(&self, vertex: u32) -> Vec<u32> {
        let mut neighbours: Vec<u32> = self.faces_at(vertex).flatten().filter(|v| *v != vertex).collect();
        neighbours.sort_unstable();
        neighbours.dedup();
        neighbours
    }

    /// The boundary edges at a vertex: the other end of each, and the third corner of its face.
    pub fn boundary_at(&self, vertex: u32) -> Vec<[u32; 2]> {
        let spokes = self.spokes(vertex);
        let single = spokes.chunk_by(|a, b| a.0 == b.0).filter(|edge| edge.len() == 1);
        let apex = |(end, i): (u32, usize)| {
            let face = self.faces[self.faces_of[vertex as usize][i] as usize];
            let third = face.into_iter().find(|v| *v != vertex && *v != end);
            third.map(|third| [end, third])
        };
        single.filter_map(|edge| apex(edge[0])).collect()
    }

    /// Where the vertex may be into which an edge collapses without a change of topology; `None` if the edge must stay.
    pub fn place(&self, u: u32, v: u32) -> Option<Place> {
        if [u, v].iter().any(|end| self.faces_of[*end as usize].len() > MOST_FACES) {
            return None;
        }
        let apexes: Vec<u32> = (self.faces_at(u).filter(|face| face.contains(&v)))
            .filter_map(|face| face.into_iter().find(|w| *w != u && *w != v))
            .collect();
        let is_boundary = apexes.len() == 1;
        let place = match (self.around[u as usize], self.around[v as usize]) {
            (Around::Disk, Around::Disk) => Place::Anywhere,
            (Around::HalfDisk, Around::HalfDisk) if is_boundary => Place::Anywhere,
            (_, Around::Disk) => Place::At(u),
            (Around::Disk, _) => Place::At(v),
            (Around::Other, Around::HalfDisk) if is_boundary => Place::At(u),
            (Around::HalfDisk, Around::Other) if is_boundary => Place::At(v),
            _ => return None,
        };
        (matches!(apexes.len(), 1 | 2) && self.is_link_condition_met(u, v, &apexes)).then_some(place)
    }

    fn is_link_condition_met(&self, u: u32, v: u32, apexes: &[u32]) -> bool {
        let (of_u, of_v) = (self.neighbours(u), self.neighbours(v));
        let common = of_u.iter().filter(|w| of_v.binary_search(w).is_ok()).count();
        if common != apexes.len() {
            return false;
        }
        match apexes {
            // a face alone, or at one vertex of its boundary: both other edges are boundary edges
            [a] => !(self.edge_faces(u, *a) == 1 && self.edge_faces(v, *a) == 1),
            // a tetrahedron
            [a, b] => {
                let closes = |end: u32| self.faces_at(end).any(|face| face.contains(a) && face.contains(b));
                !(closes(u) && closes(v))
            }
            _ => false,
        }
    }

    fn edge_faces(&self, u: u32, v: u32) -> usize {
        self.faces_at(u).filter(|face| face.contains(&v)).count()
    }

    /// Collapses an edge into its end `kept`, at a position (m).
    pub fn collapse(&mut self, kept: u32, gone: u32, position: Point) {
        self.positions[kept as usize] = position;
        for number in std::mem::take(&mut self.faces_of[gone as usize]) {
            let face = self.faces[number as usize];
            if face.contains(&kept) {
                self.is_removed[number as usize] = true;
                self.count -= 1;
                for corner in face.into_iter().filter(|corner| *corner != gone) {
                    self.faces_of[corner as usize].retain(|f| *f != number);
                }
            } else {
                replace(&mut self.faces[number as usize], gone, kept);
                self.faces_of[kept as usize].push(number);
            }
        }
    }
}

fn replace(face: &mut [u32; 3], from: u32, to: u32) {
    for corner in face.iter_mut().filter(|corner| **corner == from) {
        *corner = to;
    }
}

fn index(number: usize) -> u32 {
    u32::try_from(number).unwrap_or(u32::MAX)
}
