//! Patches: sets of faces connected by edges of exactly two faces, with consistent winding.

use super::weld::WeldedFaces;

/// Maximal sets of faces connected by edges of two faces, and their relations at all other edges.
pub(super) struct Patches {
    /// By patch: its faces, and for each whether it is reversed relative to the mesh so that the winding in the patch is consistent.
    pub faces: Vec<Vec<(u32, bool)>>,
    /// For each edge with other than two faces: how often, and in which direction, patches run along it. In a closed surface these
    /// numbers cancel.
    pub seams: Vec<Vec<(u32, i64)>>,
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
    /// By face: its patch, and whether it is reversed.
    places: Vec<(u32, bool)>,
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
        Self { neighbours, places: vec![(NONE, false); count], patches }
    }

    fn run(mut self) -> Self {
        for start in 0..self.places.len() {
            if self.places[start].0 == NONE {
                self.fill(u32::try_from(start).expect("faces are named by 32 bits"));
            }
        }
        self
    }

    fn fill(&mut self, start: u32) {
        let patch = u32::try_from(self.patches.faces.len()).expect("there are no more patches than faces");
        let mut faces = vec![(start, false)];
        let mut is_one_sided = false;
        self.places[start as usize] = (patch, false);
        let mut next = 0;
        while let Some(&(face, turned)) = faces.get(next) {
            next += 1;
            for neighbour in self.neighbours[face as usize].iter().filter(|n| n.face != NONE) {
                let place = &mut self.places[neighbour.face as usize];
                let wanted = turned ^ neighbour.turns;
                if place.0 == NONE {
                    *place = (patch, wanted);
                    faces.push((neighbour.face, wanted));
                } else {
                    is_one_sided |= place.1 != wanted;
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
                [(patch, _)] => self.patches.is_open[*patch as usize] = true,
                _ => self.patches.seams.push(seam),
            }
        }
        self.patches.seams.sort_unstable();
        self.patches.seams.dedup();
        self.patches.seams.sort_by_key(Vec::len);
    }

    /// Net number of times that patches run along an edge in one direction.
    fn seam(&self, at_edge: &[HalfEdge]) -> Vec<(u32, i64)> {
        let along = at_edge.iter().map(|half| {
            let (patch, turned) = self.places[half.face as usize];
            (patch, if half.is_forward == turned { -1 } else { 1 })
        });
        let mut along: Vec<(u32, i64)> = along.collect();
        along.sort_unstable();
        let sums = along
            .chunk_by(|a, b| a.0 == b.0)
            .map(|of_one| (of_one[0].0, of_one.iter().map(|(_, n)| n).sum()));
        let mut seam: Vec<(u32, i64)> = sums.filter(|(_, sum)| *sum != 0).collect();
        // the same condition for both directions of the edge
        if seam.first().is_some_and(|(_, sum)| *sum < 0) {
            for (_, sum) in &mut seam {
                *sum = -*sum;
            }
        }
        seam
    }
}
