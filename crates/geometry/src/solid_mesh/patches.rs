//! Patches: sets of faces connected by edges of exactly two faces, with consistent winding.

use super::welded_faces::WeldedFaces;

/// A face of a patch.
#[derive(Clone, Copy)]
pub(super) struct OrientedFace {
    pub face: u32,
    /// True if it is reversed relative to the mesh, so that the winding in the patch is consistent.
    pub is_reversed: bool,
}

/// A patch and its multiplicity in a surface or along an edge; negative in the reverse direction.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct PatchMultiple {
    pub patch: u32,
    pub times: i64,
}

/// Place of a face: its patch, and whether it is reversed there.
#[derive(Clone, Copy)]
struct Place {
    patch: u32,
    is_reversed: bool,
}

/// Maximal sets of faces connected by edges of two faces, and their relations at all other edges.
pub(super) struct Patches {
    /// By patch: its faces.
    pub faces: Vec<Vec<OrientedFace>>,
    /// For each edge with other than two faces: how often, and in which direction, patches run along it. In a closed surface these
    /// numbers cancel.
    pub seams: Vec<Vec<PatchMultiple>>,
    /// By patch: true if it has a free edge, or only one side; then it is part of no closed surface.
    pub is_open: Vec<bool>,
}

/// An edge of a face, from the smaller corner to the larger or in reverse.
#[derive(Clone, Copy)]
struct HalfEdge {
    /// The smaller corner in the upper half, the larger in the lower.
    edge: u64,
    face: u32,
    is_forward: bool,
}

/// At an edge of two faces: the other face, and whether one of the two must be reversed.
#[derive(Clone, Copy)]
struct Neighbour {
    face: u32,
    turns: bool,
}

const NONE: u32 = u32::MAX;

impl Patches {
    pub fn new(welded: &WeldedFaces) -> Self {
        let halves = half_edges(&welded.corners);
        let mut found = Flood::new(welded.corners.len(), &halves).run();
        found.add_seams(&halves);
        found.patches
    }
}

fn half_edges(corners: &[[u32; 3]]) -> Vec<HalfEdge> {
    let mut halves = Vec::with_capacity(3 * corners.len());
    for (&[a, b, c], face) in corners.iter().zip(0..) {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let (low, high) = if from < to { (from, to) } else { (to, from) };
            halves.push(HalfEdge {
                edge: u64::from(low) << 32 | u64::from(high),
                face,
                is_forward: from < to,
            });
        }
    }
    halves.sort_unstable_by_key(|half| (half.edge, half.face));
    halves
}

/// Traversal of faces from neighbour to neighbour.
struct Flood {
    neighbours: Vec<[Neighbour; 3]>,
    /// By face.
    places: Vec<Place>,
    patches: Patches,
}

impl Flood {
    fn new(count: usize, halves: &[HalfEdge]) -> Self {
        let mut neighbours = vec![[Neighbour { face: NONE, turns: false }; 3]; count];
        let mut link = |from: u32, to: Neighbour| {
            let free = neighbours[from as usize].iter_mut().find(|n| n.face == NONE);
            *free.expect("a face has three edges") = to;
        };
        for at_edge in halves.chunk_by(|a, b| a.edge == b.edge) {
            if let [a, b] = at_edge {
                let turns = a.is_forward == b.is_forward;
                link(a.face, Neighbour { face: b.face, turns });
                link(b.face, Neighbour { face: a.face, turns });
            }
        }
        let patches = Patches { faces: Vec::new(), seams: Vec::new(), is_open: Vec::new() };
        Self { neighbours, places: vec![Place { patch: NONE, is_reversed: false }; count], patches }
    }

    fn run(mut self) -> Self {
        for start in 0..self.places.len() {
            if self.places[start].patch == NONE {
                self.fill(u32::try_from(start).expect("faces are named by 32 bits"));
            }
        }
        self
    }

    fn fill(&mut self, start: u32) {
        let patch = u32::try_from(self.patches.faces.len()).expect("there are no more patches than faces");
        let mut faces = vec![OrientedFace { face: start, is_reversed: false }];
        let mut is_one_sided = false;
        self.places[start as usize] = Place { patch, is_reversed: false };
        let mut next = 0;
        while let Some(&OrientedFace { face, is_reversed }) = faces.get(next) {
            next += 1;
            for neighbour in self.neighbours[face as usize].iter().filter(|n| n.face != NONE) {
                let place = &mut self.places[neighbour.face as usize];
                let wanted = is_reversed ^ neighbour.turns;
                if place.patch == NONE {
                    *place = Place { patch, is_reversed: wanted };
                    faces.push(OrientedFace { face: neighbour.face, is_reversed: wanted });
                } else {
                    is_one_sided |= place.is_reversed != wanted;
                }
            }
        }
        self.patches.faces.push(faces);
        self.patches.is_open.push(is_one_sided);
    }

    fn add_seams(&mut self, halves: &[HalfEdge]) {
        for at_edge in halves.chunk_by(|a, b| a.edge == b.edge).filter(|halves| halves.len() != 2) {
            let seam = self.seam(at_edge);
            match seam.as_slice() {
                [] => {}
                [PatchMultiple { patch, .. }] => self.patches.is_open[*patch as usize] = true,
                _ => self.patches.seams.push(seam),
            }
        }
        self.patches.seams.sort_unstable();
        self.patches.seams.dedup();
        self.patches.seams.sort_by_key(Vec::len);
    }

    /// Net number of times that patches run along an edge in one direction.
    fn seam(&self, at_edge: &[HalfEdge]) -> Vec<PatchMultiple> {
        let along = at_edge.iter().map(|half| {
            let Place { patch, is_reversed } = self.places[half.face as usize];
            PatchMultiple { patch, times: if half.is_forward == is_reversed { -1 } else { 1 } }
        });
        let mut along: Vec<PatchMultiple> = along.collect();
        along.sort_unstable();
        let sums = along
            .chunk_by(|a, b| a.patch == b.patch)
            .map(|of_one| PatchMultiple { times: of_one.iter().map(|one| one.times).sum(), ..of_one[0] });
        let mut seam: Vec<PatchMultiple> = sums.filter(|sum| sum.times != 0).collect();
        // the same condition for both directions of the edge
        if seam.first().is_some_and(|first| first.times < 0) {
            for sum in &mut seam {
                sum.times = -sum.times;
            }
        }
        seam
    }
}
