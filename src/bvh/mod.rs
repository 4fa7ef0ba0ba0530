//! A binary tree of bounding volumes over the convex elements of a body.

mod element;
mod tree;

pub use element::Element;
pub use tree::{Content, LEAF_TRIANGLES, Node, Tree};
