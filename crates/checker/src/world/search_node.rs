//! Nodes of the search for what is nearest to the robot parts: pairs, and pieces of obstacles.

/// A node of the search: something that may be near a robot part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum SearchNode {
    /// A pair with an obstacle or with another robot part.
    Pair(usize),
    /// A piece of an obstacle for which only the box was tested.
    BoxedPiece { part: usize, piece: u32 },
    /// A piece whose bounding volume was tested, too.
    Piece { part: usize, piece: u32 },
    /// The pieces in a node of the tree.
    TreeNode { part: usize, node: u32 },
}
