//! Connected parts of a mesh.

use std::collections::{HashMap, HashSet};

use crate::math::Point;

/// One vertex of each connected part, corners at equal positions joined; in the order of the faces.
pub(super) fn part_points(vertices: &[Point], triangles: &[[u32; 3]]) -> Vec<Point> {
    let mut parent: Vec<usize> = (0..vertices.len()).collect();
    let mut first_at: HashMap<[u64; 3], usize> = HashMap::new();
    for (v, p) in vertices.iter().enumerate() {
        let same = *first_at.entry([p.x, p.y, p.z].map(|c| (c + 0.0).to_bits())).or_insert(v);
        join(&mut parent, same, v);
    }
    for t in triangles {
        let [a, b, c] = t.map(|v| v as usize);
        join(&mut parent, a, b);
        join(&mut parent, b, c);
    }
    let mut seen = HashSet::new();
    let corners = triangles.iter().flatten().map(|&v| v as usize);
    corners.filter(|&v| seen.insert(find(&mut parent, v))).map(|v| vertices[v]).collect()
}

fn find(parent: &mut [usize], mut v: usize) -> usize {
    while parent[v] != v {
        parent[v] = parent[parent[v]];
        v = parent[v];
    }
    v
}

fn join(parent: &mut [usize], a: usize, b: usize) {
    let (a, b) = (find(parent, a), find(parent, b));
    parent[a.max(b)] = a.min(b);
}
