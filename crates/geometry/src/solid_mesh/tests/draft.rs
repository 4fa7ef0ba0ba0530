//! Test helper: meshes that can be put together and damaged, and their winding numbers.

use std::collections::HashMap;

use crate::TriangleMesh;
use crate::math::{Point, Pose, Vector};
use crate::testing::Random;

/// Vertices and faces that can be modified.
#[derive(Clone, Default)]
pub struct Draft {
    pub vertices: Vec<Point>,
    pub faces: Vec<[u32; 3]>,
}

impl Draft {
    pub fn cuboid(low: [f64; 3], high: [f64; 3]) -> Self {
        let at = |i: usize, k: usize| if i >> k & 1 == 0 { low[k] } else { high[k] };
        let vertices = (0..8).map(|i| Point::new(at(i, 0), at(i, 1), at(i, 2))).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        Self { vertices, faces }
    }

    pub fn cube(half: f64) -> Self {
        Self::cuboid([-half; 3], [half; 3])
    }

    /// A cuboid with each face subdivided: `levels` times into four.
    pub fn divided(mut self, levels: usize) -> Self {
        for _ in 0..levels {
            let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
            let mut faces = Vec::new();
            for [a, b, c] in std::mem::take(&mut self.faces) {
                let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(p, q)| {
                    *middles.entry((p.min(q), p.max(q))).or_insert_with(|| {
                        let middle = nalgebra::center(&self.vertices[p as usize], &self.vertices[q as usize]);
                        self.vertices.push(middle);
                        self.vertices.len() as u32 - 1
                    })
                });
                faces.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
            }
            self.faces = faces;
        }
        self
    }

    pub fn ball(radius: f64) -> Self {
        let mut ball = Self::cube(1.0).divided(2);
        for p in &mut ball.vertices {
            *p = Point::from(p.coords.normalize() * radius);
        }
        ball
    }

    pub fn moved(mut self, pose: &Pose) -> Self {
        self.vertices.iter_mut().for_each(|p| *p = pose * *p);
        self
    }

    pub fn shifted(self, by: [f64; 3]) -> Self {
        self.moved(&Pose::translation(by[0], by[1], by[2]))
    }

    pub fn inward(mut self) -> Self {
        self.faces.iter_mut().for_each(|f| f.swap(1, 2));
        self
    }

    pub fn and(mut self, other: &Self) -> Self {
        let first = self.vertices.len() as u32;
        self.vertices.extend(&other.vertices);
        self.faces.extend(other.faces.iter().map(|f| f.map(|v| v + first)));
        self
    }

    /// Each face with its own vertices, as in STL.
    pub fn unwelded(&self) -> Self {
        let vertices = self.faces.iter().flatten().map(|v| self.vertices[*v as usize]).collect();
        Self {
            vertices,
            faces: (0..self.faces.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        }
    }

    pub fn mesh(&self) -> TriangleMesh {
        TriangleMesh::new(self.vertices.clone(), self.faces.clone()).unwrap()
    }

    pub fn encloses(&self, p: [f64; 3]) -> bool {
        self.mesh().encloses(&Point::from(p))
    }

    pub fn remarks(&self) -> String {
        self.mesh().solid().remarks().to_string()
    }
}

/// Winding number of the faces around a point, by brute force.
pub fn winding(draft: &Draft, p: &Point) -> f64 {
    let half_angle = |f: &[u32; 3]| {
        let [a, b, c] = f.map(|v| (draft.vertices[v as usize] - p).normalize());
        a.dot(&b.cross(&c)).atan2(1.0 + a.dot(&b) + b.dot(&c) + c.dot(&a))
    };
    draft.faces.iter().map(half_angle).sum::<f64>() / std::f64::consts::TAU
}

/// Two pyramids on a common ring with many corners; all faces reach the tips.
pub fn bicone(corners: u32, size: f64) -> Draft {
    let ring = (0..corners).map(|i| {
        let angle = std::f64::consts::TAU * f64::from(i) / f64::from(corners);
        Point::new(size * angle.cos(), size * angle.sin(), 0.0)
    });
    let tips = [size, -size].map(|z| Point::new(0.0, 0.0, z));
    let faces = (0..corners).flat_map(|i| {
        let next = (i + 1) % corners;
        [[i, next, corners], [next, i, corners + 1]]
    });
    Draft { vertices: ring.chain(tips).collect(), faces: faces.collect() }
}

pub fn random_shell(random: &mut Random) -> Draft {
    let half = 0.2 + random.within(0.1).abs() * 4.0;
    let shell = match random.below(3) {
        0 => Draft::cube(half),
        1 => Draft::cube(half).divided(1),
        _ => Draft::ball(half),
    };
    // on a grid, shells share corners, edges and walls
    let by = match random.below(3) {
        0 => Vector::zeros(),
        1 => Vector::from_fn(|_, _| 0.4 * random.below(3) as f64 - 0.4),
        _ => return shell.moved(&random.pose(0.4)),
    };
    shell.shifted(by.into())
}
