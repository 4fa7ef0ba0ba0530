//! The triangles of a body, in f64, and the tree over them.

use clearance_geometry::math::{MatrixPose, Point};
use clearance_geometry::{Triangle, VolumeKind};

use super::surface_samples::SurfaceSamples;
use crate::bounding_volume::Obb;
use crate::bvh::{Tree, TriangleLeaf};
use crate::elements::{CoreShape, RoundedShape};

/// Triangles in the order of their tree's leaves, with shared corners.
#[derive(Clone, Debug)]
pub(crate) struct Surface {
    tree: Tree<Obb, TriangleLeaf>,
    samples: SurfaceSamples,
    vertices: Vec<Point>,
    faces: Vec<[u32; 3]>,
}

impl Surface {
    /// `None` without faces.
    pub fn new(vertices: Vec<Point>, faces: &[[u32; 3]]) -> Option<Self> {
        if faces.is_empty() {
            return None;
        }
        let corners: Vec<[Point; 3]> = faces.iter().map(|f| f.map(|v| vertices[v as usize])).collect();
        let (tree, order) = Tree::build(&corners);
        let samples = SurfaceSamples::new(tree.anchor(), &vertices, faces);
        let faces = order.iter().map(|&i| faces[i as usize]).collect();
        Some(Self { tree, samples, vertices, faces })
    }

    /// Tree over the triangles.
    #[inline]
    pub fn tree(&self) -> &Tree<Obb, TriangleLeaf> {
        &self.tree
    }

    /// Vertices spread over the surface.
    #[inline]
    pub fn samples(&self) -> &SurfaceSamples {
        &self.samples
    }

    /// Triangle `index` in the order of the leaves.
    #[inline]
    pub fn triangle(&self, index: u32) -> Triangle {
        let [a, b, c] = self.faces[index as usize];
        Triangle { a: self.vertex(a), b: self.vertex(b), c: self.vertex(c) }
    }

    /// Vertex numbers of triangle `index` in the order of the leaves.
    #[inline]
    pub fn corners(&self, index: u32) -> [u32; 3] {
        self.faces[index as usize]
    }

    /// As [`Self::triangle`], as a rounded shape.
    #[inline]
    pub fn shape(&self, index: u32) -> RoundedShape {
        RoundedShape {
            core: CoreShape::Triangle(self.triangle(index)),
            pose: MatrixPose::identity(),
            radius: 0.0,
        }
    }

    #[inline]
    pub fn vertex(&self, number: u32) -> Point {
        self.vertices[number as usize]
    }

    #[inline]
    pub fn triangle_count(&self) -> usize {
        self.faces.len()
    }

    /// Memory in bytes.
    #[inline]
    pub fn bytes(&self) -> usize {
        let own =
            self.vertices.capacity() * size_of::<Point>() + self.faces.capacity() * size_of::<[u32; 3]>();
        own + self.tree.bytes() + self.samples.bytes()
    }
}

impl Surface {
    /// Adds volumes of another kind to the tree.
    pub fn set_volumes(&mut self, kind: VolumeKind, kinds: &[VolumeKind]) {
        let Self { tree, vertices, faces, .. } = self;
        tree.set_volumes(kind, kinds, |leaf, points| {
            let (first, count) = (leaf.content.first as usize, leaf.content.count as usize);
            points.extend(faces[first..first + count].iter().flatten().map(|v| vertices[*v as usize]));
        });
    }
}
