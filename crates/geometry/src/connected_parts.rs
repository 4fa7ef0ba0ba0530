//! Connected parts of a mesh: their vertices, by disjoint sets (union-find).

use std::collections::HashMap;

use crate::WeldedMesh;
use crate::math::Point;

/// Disjoint sets of the numbers from 0 on (union-find).
#[derive(Clone, Debug)]
pub struct DisjointSets {
    parent: Vec<u32>,
}

impl DisjointSets {
    /// One set for each of so many numbers.
    #[must_use]
    pub fn new(count: usize) -> Self {
        Self { parent: (0..).take(count).collect() }
    }

    /// One set for each connected part of faces over so many vertices.
    #[must_use]
    pub fn of_faces<'f>(vertices: usize, faces: impl IntoIterator<Item = &'f [u32; 3]>) -> Self {
        let mut sets = Self::new(vertices);
        for [a, b, c] in faces {
            sets.join(*a, *b);
            sets.join(*b, *c);
        }
        sets
    }

    /// The smallest number of the set of `number`.
    pub fn smallest(&mut self, mut number: u32) -> u32 {
        while self.parent[number as usize] != number {
            let above = self.parent[number as usize];
            self.parent[number as usize] = self.parent[above as usize];
            number = self.parent[number as usize];
        }
        number
    }

    /// Joins the sets of two numbers.
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.smallest(a), self.smallest(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }
}

/// The vertices of each connected part, each once, corners at equal positions joined; in the order of the faces.
pub(super) fn part_vertices(welded: &WeldedMesh) -> Vec<Vec<Point>> {
    let mut sets = DisjointSets::of_faces(welded.positions.len(), &welded.faces);
    let (mut parts, mut numbers) = (Vec::new(), HashMap::new());
    let mut is_new = vec![true; welded.positions.len()];
    for &vertex in welded.faces.iter().flatten() {
        if std::mem::take(&mut is_new[vertex as usize]) {
            let part = *numbers.entry(sets.smallest(vertex)).or_insert(parts.len());
            if part == parts.len() {
                parts.push(Vec::new());
            }
            parts[part].push(welded.positions[vertex as usize]);
        }
    }
    parts
}
