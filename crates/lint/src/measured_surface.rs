//! Surface of the geometry of a link, as patches over triangles: the set whose points the Hausdorff distance ranges over.

use std::f64::consts::TAU;

use clearance_geometry::math::{Extremes, Point, Pose};
use clearance_geometry::{Primitive, Shape, Triangle, WeldedMesh};

use crate::link_geometry::PlacedShape;

/// Number of flat strips around a cylinder or cone: they lie within 2e-5 of its radius.
const STRIPS: u32 = 512;

/// Deviation of a patch from a sphere, relative to its radius, below which it counts as flat.
const SPHERE_DEVIATION: f64 = 1e-4;

/// The surface that a patch over a triangle is part of.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Carrier {
    /// The patch is the triangle, up to [`MeasuredSurface::deviation`].
    Flat,
    /// The patch is the projection of the triangle, from the centre onto the sphere.
    Sphere { centre: Point, radius: f64 },
}

impl Carrier {
    /// Largest distance (m) of a point of the patch from its triangle.
    pub fn bulge(&self, triangle: &Triangle) -> f64 {
        match *self {
            Self::Flat => 0.0,
            Self::Sphere { centre, radius } => {
                let nearest = triangle.nearest_point(&centre);
                let bulge = radius - (nearest - centre).norm();
                // a part of the deviation
                if bulge <= SPHERE_DEVIATION * radius { 0.0 } else { bulge }
            }
        }
    }

    /// The point that divides the patch between two corners.
    pub fn midpoint(&self, a: &Point, b: &Point) -> Point {
        let middle = a + (b - a) * 0.5;
        match *self {
            Self::Flat => middle,
            Self::Sphere { centre, radius } => {
                (middle - centre).try_normalize(0.0).map_or(middle, |direction| centre + direction * radius)
            }
        }
    }
}

/// A part of the surface over a triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patch {
    /// Indices of the corners in [`MeasuredSurface::corners`].
    pub corners: [u32; 3],
    pub carrier: Carrier,
}

/// Patches that cover the surface of all shapes of a link, in the link frame.
#[derive(Debug, Default)]
pub(crate) struct MeasuredSurface {
    pub corners: Vec<Point>,
    pub patches: Vec<Patch>,
    /// Every point of the true surface has a patch within this distance (m), and the other way round.
    pub deviation: f64,
}

impl MeasuredSurface {
    pub fn new(shapes: &[PlacedShape]) -> Self {
        let mut surface = Self::default();
        for placed in shapes {
            match &placed.shape {
                Shape::Mesh(mesh) => surface.add_mesh(&WeldedMesh::new(mesh)),
                Shape::Primitive(primitive) => surface.add_primitive(primitive, &placed.pose),
                // a URDF has no other shapes
                Shape::Plane(_) | Shape::Points(_) | Shape::Voxels(_) => {}
            }
        }
        surface
    }

    fn add_mesh(&mut self, mesh: &WeldedMesh) {
        let first = self.next_corner();
        self.corners.extend_from_slice(&mesh.positions);
        let patch = |face: &[u32; 3]| Patch { corners: face.map(|v| first + v), carrier: Carrier::Flat };
        self.patches.extend(mesh.faces.iter().map(patch));
    }

    fn add_primitive(&mut self, primitive: &Primitive, pose: &Pose) {
        match *primitive {
            Primitive::Box { half_extents } => self.add_box(half_extents, pose),
            Primitive::Sphere { radius } => {
                self.add_half_sphere(0.0, 1.0, radius, pose);
                self.add_half_sphere(0.0, -1.0, radius, pose);
            }
            Primitive::Cylinder { radius, half_length } => {
                self.add_side([radius, radius], half_length, pose);
                self.add_disc(radius, -half_length, pose);
                self.add_disc(radius, half_length, pose);
            }
            Primitive::Cone { radius, half_length } => {
                self.add_side([radius, 0.0], half_length, pose);
                self.add_disc(radius, -half_length, pose);
            }
            Primitive::Capsule { radius, half_length } => {
                self.add_side([radius, radius], half_length, pose);
                self.add_half_sphere(-half_length, -1.0, radius, pose);
                self.add_half_sphere(half_length, 1.0, radius, pose);
            }
        }
    }

    fn add_box(&mut self, [x, y, z]: [f64; 3], pose: &Pose) {
        // by bits of the corner's number: x, y, z
        const FACES: [[u32; 4]; 6] =
            [[0, 2, 6, 4], [1, 3, 7, 5], [0, 1, 5, 4], [2, 3, 7, 6], [0, 1, 3, 2], [4, 5, 7, 6]];
        let sign = |i: u32, bit: u32| if i & bit == 0 { -1.0 } else { 1.0 };
        let first = self.next_corner();
        let corner = |i: u32| pose * Point::new(sign(i, 1) * x, sign(i, 2) * y, sign(i, 4) * z);
        self.corners.extend((0..8).map(corner));
        for [a, b, c, d] in FACES {
            self.add_patch([a, b, c].map(|v| first + v), Carrier::Flat);
            self.add_patch([a, c, d].map(|v| first + v), Carrier::Flat);
        }
    }

    /// Side of a cylinder or cone with these radii at `-half_length` and `half_length`.
    fn add_side(&mut self, radii: [f64; 2], half_length: f64, pose: &Pose) {
        let first = self.next_corner();
        for strip in 0..STRIPS {
            let (sin, cos) = angle(strip).sin_cos();
            for (radius, z) in [(radii[0], -half_length), (radii[1], half_length)] {
                self.corners.push(pose * Point::new(radius * cos, radius * sin, z));
            }
        }
        self.deviation = self.deviation.greater(sagitta(radii[0].greater(radii[1])));
        for strip in 0..STRIPS {
            let next = (strip + 1) % STRIPS;
            let [a, b, c, d] = [2 * strip, 2 * strip + 1, 2 * next + 1, 2 * next].map(|v| first + v);
            self.add_patch([a, b, c], Carrier::Flat);
            self.add_patch([a, c, d], Carrier::Flat);
        }
    }

    fn add_disc(&mut self, radius: f64, z: f64, pose: &Pose) {
        let first = self.next_corner();
        for strip in 0..STRIPS {
            let (sin, cos) = angle(strip).sin_cos();
            self.corners.push(pose * Point::new(radius * cos, radius * sin, z));
        }
        self.corners.push(pose * Point::new(0.0, 0.0, z));
        self.deviation = self.deviation.greater(sagitta(radius));
        for strip in 0..STRIPS {
            self.add_patch([first + strip, first + (strip + 1) % STRIPS, first + STRIPS], Carrier::Flat);
        }
    }

    /// Four octants of a sphere around `(0, 0, z)`, above or below its centre.
    fn add_half_sphere(&mut self, z: f64, side: f64, radius: f64, pose: &Pose) {
        let first = self.next_corner();
        for [x, y] in [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]] {
            self.corners.push(pose * Point::new(x * radius, y * radius, z));
        }
        self.corners.push(pose * Point::new(0.0, 0.0, z + side * radius));
        self.deviation = self.deviation.greater(SPHERE_DEVIATION * radius);
        let carrier = Carrier::Sphere { centre: pose * Point::new(0.0, 0.0, z), radius };
        for quarter in 0..4 {
            self.add_patch([first + quarter, first + (quarter + 1) % 4, first + 4], carrier);
        }
    }

    fn add_patch(&mut self, corners: [u32; 3], carrier: Carrier) {
        self.patches.push(Patch { corners, carrier });
    }

    fn next_corner(&self) -> u32 {
        u32::try_from(self.corners.len()).unwrap_or(u32::MAX)
    }
}

fn angle(strip: u32) -> f64 {
    f64::from(strip) * TAU / f64::from(STRIPS)
}

/// Distance (m) of an arc from the middle of its chord, and a little more for rounding.
fn sagitta(radius: f64) -> f64 {
    radius * (1.0 - (0.5 * TAU / f64::from(STRIPS)).cos()) * 1.001
}

impl MeasuredSurface {
    /// Triangles for a picture; spheres are drawn by many.
    pub fn drawn_triangles(&self) -> Vec<Triangle> {
        let mut drawn = Vec::with_capacity(self.patches.len());
        for patch in &self.patches {
            let [a, b, c] = patch.corners.map(|v| self.corners[v as usize]);
            let depth = if matches!(patch.carrier, Carrier::Flat) { 0 } else { SPHERE_SPLITS };
            divide(&Triangle { a, b, c }, &patch.carrier, depth, &mut drawn);
        }
        drawn
    }
}

/// Number of times that the octants of a drawn sphere are split.
const SPHERE_SPLITS: u32 = 4;

fn divide(triangle: &Triangle, carrier: &Carrier, depth: u32, drawn: &mut Vec<Triangle>) {
    if depth == 0 {
        drawn.push(*triangle);
        return;
    }
    let Triangle { a, b, c } = *triangle;
    let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|[p, q]| carrier.midpoint(&p, &q));
    for [a, b, c] in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
        divide(&Triangle { a, b, c }, carrier, depth - 1, drawn);
    }
}
