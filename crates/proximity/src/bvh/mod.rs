//! Wide trees of bounding volumes: eight children to a node, eight elements to a leaf.
//!
//! Every node has its own frame, a rotation about the tree's anchor, in which the volumes of its children are packed. One traversal
//! (`traversal`) serves all volumes and all queries of two trees, another (`plane_traversal`) serves queries of a tree and a plane.
//! Volumes of other kinds around the same nodes, which users may select, are in `volume_trees`.
//! Items that are added and removed often are in a tree of another type ([`DynamicTree`]).

mod axis_box;
mod build;
mod cube_leaf;
mod cube_tree;
mod dynamic_tree;
mod plane_traversal;
mod surface_area_heuristic;
mod traversal;
mod tree;
mod triangle_leaf;
mod volume_trees;

pub use axis_box::{AxisBox, EightBoxes};
pub use dynamic_tree::{Child, DynamicTree, SelectedBoxes};
pub use tree::NodeRef;

pub(crate) use cube_leaf::CubeLeaf;
pub(crate) use plane_traversal::{PlaneVisitor, TreePlane, traverse_to_plane};
pub(crate) use traversal::{Entry, TreePair, Visitor, traverse};
pub(crate) use tree::{Content, Leaf, Tree};
pub(crate) use triangle_leaf::TriangleLeaf;
pub(crate) use volume_trees::VolumeTreePair;
