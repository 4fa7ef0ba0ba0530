//! Splits a large body into pieces with bounding volumes, so that a broad phase can find the pieces that are near.

use std::collections::BinaryHeap;

use clearance_geometry::constants::VOLUME_SLACK;
use clearance_geometry::math::{MatrixPose, Point, RotationMatrix, Vector};

use super::cube_set::CubeSet;
use super::solid_leaf::SolidLeaf;
use super::surface::Surface;
use crate::bounding_volume::Obb;
use crate::bvh::{NodeRef, Tree};
use crate::elements::{CoreShape, RoundedShape};

/// A part of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Piece {
    /// The whole body.
    Whole,
    /// All of its solids.
    Solids,
    /// A subtree of the tree over its triangles.
    Surface(NodeRef),
    /// A subtree of one of its clouds or sets of voxels.
    Cubes {
        /// Index of the cloud or set of voxels.
        set: u32,
        /// Root of the subtree.
        node: NodeRef,
    },
    /// The inside of its solid meshes, without their surfaces.
    Inside,
}

/// Bounding volume of a piece, in the frame of the body.
#[derive(Clone, Copy, Debug)]
pub enum PieceVolume {
    /// Capsule: all points within a distance (m) of a segment.
    Capsule {
        /// Ends of the segment.
        ends: [Point; 2],
        /// Distance (m) from the segment.
        radius: f64,
    },
    /// Oriented box.
    Box {
        /// Centre of the box.
        centre: Point,
        /// Axes of the box as columns.
        axes: RotationMatrix,
        /// Half extents (m) along the axes.
        half_extents: Vector,
    },
}

/// Minimum number of leaves of a piece.
const LEAVES: usize = 4;

/// The solids of a body; each has a volume of its own.
#[inline]
pub(super) fn solid_pieces(solids: &Tree<Obb, SolidLeaf>) -> impl Iterator<Item = (Piece, PieceVolume)> {
    solids.leaves().iter().map(|leaf| (Piece::Solids, around(&leaf.content.shape)))
}

/// Splits a surface into not many more than `most` pieces.
#[inline]
pub(super) fn surface_pieces(surface: &Surface, most: usize) -> impl Iterator<Item = (Piece, PieceVolume)> {
    let (tree, pose) = (surface.tree(), MatrixPose::identity());
    let cut = cut(tree, most.min(tree.leaves().len() / LEAVES));
    cut.map(move |node| (Piece::Surface(node), box_of(tree, node, &pose, 0.0)))
}

/// Splits a set of cubes into not many more than `most` pieces.
#[inline]
pub(super) fn cube_pieces(cubes: &CubeSet, most: usize) -> impl Iterator<Item = (Piece, PieceVolume)> {
    let tree = cubes.tree();
    let cut = cut(tree, most.min(tree.leaves().len() / LEAVES));
    cut.map(|node| {
        let piece = Piece::Cubes { set: cubes.index(), node };
        (piece, box_of(tree, node, cubes.pose_bs(), cubes.radius()))
    })
}

/// A volume around a solid.
fn around(RoundedShape { core, pose, radius }: &RoundedShape) -> PieceVolume {
    let centre = Point::from(pose.translation);
    let half_extents = match *core {
        CoreShape::Point => return PieceVolume::Capsule { ends: [centre, centre], radius: *radius },
        CoreShape::Segment(half_length) => {
            let ends = CoreShape::segment(half_length).map(|end| pose * end);
            return PieceVolume::Capsule { ends, radius: *radius };
        }
        CoreShape::Cuboid(half) => half,
        CoreShape::Cylinder { radius, half_length } | CoreShape::Cone { radius, half_length } => {
            Vector::new(radius, radius, half_length)
        }
        CoreShape::Triangle(_) => unreachable!("a triangle is no solid"),
    };
    PieceVolume::Box { centre, axes: pose.rotation, half_extents: half_extents.add_scalar(*radius) }
}

/// The box of a node, enlarged by `radius` (m), of a tree that is placed in its body.
fn box_of<L>(tree: &Tree<Obb, L>, node: NodeRef, pose_bt: &MatrixPose, radius: f64) -> PieceVolume {
    let (volume, axes) = tree.volume(node);
    let axes = RotationMatrix::from_fn(|i, k| f64::from(axes.0[k][i]));
    let centre = tree.anchor() + axes * Vector::from(volume.centre.map(f64::from));
    // axes are rounded, so they are neither exactly orthogonal nor exactly of length one
    let farther = radius + VOLUME_SLACK * tree.reach();
    let half_extents = Vector::from(volume.half_extents.map(f64::from)).add_scalar(farther);
    PieceVolume::Box { centre: pose_bt * centre, axes: pose_bt.rotation * axes, half_extents }
}

/// A node, with its size.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Sized {
    /// The bits of non-negative floats have the same order as the floats.
    size: u32,
    node: NodeRef,
}

/// Nodes that together contain a whole tree: the largest are opened until there are `most` or a few more.
fn cut<L>(tree: &Tree<Obb, L>, most: usize) -> impl Iterator<Item = NodeRef> + use<L> {
    let sized = |node| {
        let [x, y, z] = tree.volume(node).0.half_extents;
        Sized { size: (x * x + y * y + z * z).to_bits(), node }
    };
    let mut open = BinaryHeap::from([sized(tree.root())]);
    let mut closed = Vec::new();
    while open.len() + closed.len() < most {
        let Some(Sized { node, .. }) = open.pop() else { break };
        if node.is_leaf() {
            closed.push(node);
            continue;
        }
        let parent = tree.node(node);
        open.extend(parent.children[..parent.child_count as usize].iter().map(|child| sized(*child)));
    }
    open.into_iter().map(|sized| sized.node).chain(closed)
}
