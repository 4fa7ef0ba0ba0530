//! Deterministic random shapes and poses.

use clearance::geometry::{Primitive, Shape, Triangle, TriangleMesh};
use clearance::math::{Point, Pose, Rotation, Vector};

/// A small generator of reproducible numbers (SplitMix64, Steele, Lea & Flood 2014).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub fn next_u64(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Uniform in [lo, hi).
    pub fn within(&mut self, lo: f64, hi: f64) -> f64 {
        #[allow(clippy::cast_precision_loss)]
        let unit = (self.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        lo + (hi - lo) * unit
    }

    pub fn below(&mut self, n: u32) -> u32 {
        u32::try_from(self.next_u64() % u64::from(n)).unwrap()
    }

    pub fn vector(&mut self, size: f64) -> Vector {
        Vector::from_fn(|_, _| self.within(-size, size))
    }

    pub fn point(&mut self, size: f64) -> Point {
        Point::from(self.vector(size))
    }

    pub fn rotation(&mut self) -> Rotation {
        let q = nalgebra::Vector4::from_fn(|_, _| self.within(-1.0, 1.0));
        Rotation::from_quaternion(nalgebra::Quaternion::from(q + nalgebra::Vector4::repeat(1e-9)))
    }

    pub fn pose(&mut self, reach: f64) -> Pose {
        Pose::from_parts(self.vector(reach).into(), self.rotation())
    }

    pub fn triangle(&mut self, size: f64) -> Triangle {
        let [a, b, c] = [self.point(size), self.point(size), self.point(size)];
        Triangle { a, b, c }
    }

    pub fn primitive(&mut self) -> Primitive {
        let (x, y, z) = (self.within(0.05, 0.5), self.within(0.05, 0.5), self.within(0.05, 0.5));
        match self.below(4) {
            0 => Primitive::cuboid([x, y, z]),
            1 => Primitive::sphere(x),
            2 => Primitive::cylinder(x, y),
            _ => Primitive::capsule(x, y),
        }
        .unwrap()
    }

    /// A bumpy closed mesh of `2 * rings * rings` triangles or so, about `size` large.
    pub fn blob(&mut self, rings: u32, size: f64) -> TriangleMesh {
        let mut vertices = vec![];
        let segments = 2 * rings;
        for i in 0..=rings {
            for j in 0..segments {
                let polar = std::f64::consts::PI * f64::from(i) / f64::from(rings);
                let around = std::f64::consts::TAU * f64::from(j) / f64::from(segments);
                let pole = i == 0 || i == rings;
                let radius = if pole { size } else { size * self.within(0.7, 1.0) };
                let across = if pole { 0.0 } else { radius * polar.sin() };
                vertices.push(Point::new(across * around.cos(), across * around.sin(), radius * polar.cos()));
            }
        }
        let mut triangles = vec![];
        for i in 0..rings {
            for j in 0..segments {
                let at = |i: u32, j: u32| i * segments + j % segments;
                triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
                triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        TriangleMesh::new(vertices, triangles).unwrap()
    }

    /// A set of loose triangles.
    pub fn soup(&mut self, count: u32, size: f64, edge: f64) -> TriangleMesh {
        let mut vertices = vec![];
        for _ in 0..count {
            let centre = self.point(size);
            vertices.extend((0..3).map(|_| centre + self.vector(edge)));
        }
        let triangles = (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
        TriangleMesh::new(vertices, triangles.collect()).unwrap()
    }

    pub fn shape(&mut self) -> Shape {
        match self.below(3) {
            0 => Shape::Primitive(self.primitive()),
            1 => Shape::Mesh(self.blob(6, 0.3).into()),
            _ => Shape::Mesh(self.soup(40, 0.3, 0.1).into()),
        }
    }
}
