//! Splits a large body into pieces with bounding volumes, so that a broad phase can find the pieces that are near.

use std::collections::BinaryHeap;

use clearance_geometry::constants::VOLUME_SLACK;
use clearance_geometry::math::{MatrixPose, Point, RotationMatrix, Vector};

use super::body::CollisionBody;
use super::core::{Core, RoundedCore};
use crate::bounding_volume::Obb;
use crate::bvh::{NodeRef, Tree};

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
    Grains { set: u32, node: NodeRef },
}

/// Bounding volume of a piece, in the frame of the body.
#[derive(Clone, Copy, Debug)]
pub enum PieceVolume {
    /// Capsule: all points within a distance (m) of a segment.
    Capsule { ends: [Point; 2], radius: f64 },
    /// Oriented box; the axes are columns.
    Box { centre: Point, axes: RotationMatrix, half_extents: Vector },
}

/// Minimum number of leaves of a piece.
const LEAVES: usize = 4;

impl CollisionBody {
    /// Splits the body into not many more than `most` pieces. Empty if it cannot be split: planes are infinite, and solid meshes have an
    /// inside.
    #[must_use]
    #[inline]
    pub fn pieces(&self, most: usize) -> Vec<(Piece, PieceVolume)> {
        if self.has_planes() || self.interior.is_some() {
            return Vec::new();
        }
        let mut pieces = Vec::new();
        if let Some(solids) = &self.solids {
            let cores = solids.leaves().iter().map(|leaf| &leaf.content.core);
            pieces.extend(cores.map(|core| (Piece::Solids, around(core))));
        }
        if let Some(surface) = &self.surface {
            let tree = &surface.tree;
            let cut = cut(tree, most.min(tree.leaves().len() / LEAVES));
            let pose = MatrixPose::identity();
            pieces.extend(cut.map(|node| (Piece::Surface(node), box_of(tree, node, &pose, 0.0))));
        }
        for grains in &self.grains {
            let (tree, set) = (&grains.tree, grains.set);
            let cut = cut(tree, most.min(tree.leaves().len() / LEAVES));
            let volume = |node| box_of(tree, node, &grains.pose_bg, grains.radius);
            pieces.extend(cut.map(|node| (Piece::Grains { set, node }, volume(node))));
        }
        pieces
    }
}

/// A volume around a solid.
fn around(RoundedCore { core, pose, radius }: &RoundedCore) -> PieceVolume {
    let centre = Point::from(pose.translation);
    let half_extents = match *core {
        Core::Point => return PieceVolume::Capsule { ends: [centre, centre], radius: *radius },
        Core::Segment(half_length) => {
            let ends = Core::segment(half_length).map(|end| pose * end);
            return PieceVolume::Capsule { ends, radius: *radius };
        }
        Core::Cuboid(half) => half,
        Core::Cylinder { radius, half_length } | Core::Cone { radius, half_length } => {
            Vector::new(radius, radius, half_length)
        }
        Core::Triangle(_) => unreachable!("a triangle is no solid"),
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
