//! Wide trees of bounding volumes: eight children to a node, eight primitives to a leaf.
//!
//! Every node has its own frame, a rotation about the tree's anchor, in which the volumes of its children are packed. One traversal
//! ([`descend`]) serves all volumes and all queries of two trees, another ([`descend_to_plane`]) serves queries of a tree and a plane.
//! Items that are added and removed often are in a tree of another type ([`DynamicTree`]).

mod axis_box;
mod build;
mod cut;
mod descend;
mod dynamic_tree;
mod grain_leaf;
mod grain_tree;
mod plane;
mod tree;
mod triangle_leaf;

pub use axis_box::{AxisBox, EightBoxes};
pub use descend::{Entry, Visitor, descend, descend_from};
pub use dynamic_tree::{Child, DynamicTree};
pub use grain_leaf::{Grain, GrainLeaf};
pub use plane::{PlaneVisitor, TreePlane, descend_to_plane};
pub use tree::{Content, Leaf, Node, NodeRef, Tree};
pub use triangle_leaf::TriangleLeaf;
