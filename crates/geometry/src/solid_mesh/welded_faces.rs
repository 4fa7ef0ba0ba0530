//! Welded faces of a mesh: vertices at equal positions are joined, and each face is kept once.

use crate::math::Point;

/// The distinct faces of a mesh, over welded vertices.
pub(super) struct WeldedFaces {
    /// Welded corners, with the winding of the first occurrence; no two are equal.
    pub corners: Vec<[u32; 3]>,
    /// True if a face occurs in both windings.
    pub is_double_sided: Vec<bool>,
    /// Number of faces that are left out because others have the same corners.
    pub repeated: usize,
}

impl WeldedFaces {
    /// Faces with two corners at one position have no relevant edges, and are left out.
    pub fn new(vertices: &[Point], triangles: &[[u32; 3]]) -> Self {
        let names = welded(vertices);
        let mut keyed: Vec<([u32; 3], u32)> = (triangles.iter().zip(0..))
            .map(|(t, number)| (sorted(t.map(|v| names[v as usize])), number))
            .filter(|([a, b, c], _)| a != b && b != c)
            .collect();
        keyed.sort_unstable();
        let own = |number: u32| triangles[number as usize].map(|v| names[v as usize]);
        let mut kept: Vec<(u32, bool)> = keyed
            .chunk_by(|a, b| a.0 == b.0)
            .map(|same| {
                let first = is_even(own(same[0].1));
                (same[0].1, same.iter().any(|(_, number)| is_even(own(*number)) != first))
            })
            .collect();
        // neighbours in the file are neighbours in memory
        kept.sort_unstable();
        Self {
            corners: kept.iter().map(|(number, _)| own(*number)).collect(),
            is_double_sided: kept.iter().map(|(_, double)| *double).collect(),
            repeated: keyed.len() - kept.len(),
        }
    }
}

/// For each vertex, the first vertex at the same position.
fn welded(vertices: &[Point]) -> Vec<u32> {
    // -0.0 and 0.0 are one position
    let mut keyed: Vec<([u64; 3], u32)> = (vertices.iter().zip(0..))
        .map(|(p, own)| ([p.x, p.y, p.z].map(|c| (c + 0.0).to_bits()), own))
        .collect();
    keyed.sort_unstable();
    let mut names = vec![0; vertices.len()];
    for same in keyed.chunk_by(|a, b| a.0 == b.0) {
        for (_, own) in same {
            names[*own as usize] = same[0].1;
        }
    }
    names
}

fn sorted(mut corners: [u32; 3]) -> [u32; 3] {
    corners.sort_unstable();
    corners
}

/// True if an even number of swaps sorts three different corners: if it is equal for two faces, so is their winding.
fn is_even([a, b, c]: [u32; 3]) -> bool {
    (a < b) ^ (b < c) ^ (a < c)
}
