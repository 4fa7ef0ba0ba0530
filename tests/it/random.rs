//! Test helper: deterministic random numbers, shapes and poses.

use clearance::geometry::math::{Point, Pose, Rotation, UnitVector, Vector};
use clearance::geometry::{Cube, Plane, PointCloud, Primitive, Shape, Triangle, TriangleMesh, Voxels};

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
        match self.below(5) {
            0 => Primitive::cuboid([x, y, z]),
            1 => Primitive::sphere(x),
            2 => Primitive::cylinder(x, y),
            3 => Primitive::cone(x, y),
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

    /// A plane within so many metres of the origin.
    pub fn plane(&mut self, offset: f64) -> Shape {
        let normal = UnitVector::new_normalize(self.vector(1.0) + Vector::repeat(1e-9));
        Shape::Plane(Plane { normal, offset: self.within(-offset, offset) })
    }

    /// Up to so many points.
    pub fn points(&mut self, most: u32, size: f64, radius: f64) -> Shape {
        let centres = (0..=self.below(most)).map(|_| self.single_point(size)).collect();
        Shape::Points(PointCloud::new(centres, radius).unwrap().into())
    }

    #[allow(clippy::cast_possible_truncation)]
    fn cube(&mut self, size: f64, half_edge: f64, on_grid: bool) -> Cube {
        let half_edge = half_edge as f32 / f32::from(1_u8 << self.below(3));
        let centre = self.single_point(size);
        let snapped = |c: f32| ((c / (2.0 * half_edge)).floor() + 0.5) * (2.0 * half_edge);
        Cube { centre: if on_grid { centre.map(snapped) } else { centre }, half_edge }
    }

    /// Up to so many cubes of three sizes, on a grid or not.
    pub fn voxels(&mut self, most: u32, size: f64, half_edge: f64) -> Shape {
        let on_grid = self.below(2) == 0;
        let count = 1 + self.below(most);
        Shape::Voxels(
            Voxels::new((0..count).map(|_| self.cube(size, half_edge, on_grid)).collect()).unwrap().into(),
        )
    }

    #[allow(clippy::cast_possible_truncation)]
    fn single_point(&mut self, size: f64) -> [f32; 3] {
        <[f64; 3]>::from(self.vector(size)).map(|c| c as f32)
    }

    pub fn shape(&mut self) -> Shape {
        match self.below(3) {
            0 => Shape::Primitive(self.primitive()),
            1 => Shape::Mesh(self.blob(6, 0.3).into()),
            _ => Shape::Mesh(self.soup(40, 0.3, 0.1).into()),
        }
    }
}
