//! Restricts a search to some pieces of the second body.

use crate::body::Piece;
use crate::bvh::NodeRef;

/// The part of the second body that is searched.
#[derive(Clone, Copy, Debug)]
pub(crate) enum SearchedPieces<'p> {
    All,
    Some(&'p [Piece]),
}

impl<'p> SearchedPieces<'p> {
    /// All of the body if one of the pieces is the whole body.
    #[inline]
    pub fn new(pieces: &'p [Piece]) -> Self {
        if pieces.contains(&Piece::Whole) { Self::All } else { Self::Some(pieces) }
    }

    #[inline]
    pub fn has_solids(self) -> bool {
        match self {
            Self::All => true,
            Self::Some(pieces) => pieces.contains(&Piece::Solids),
        }
    }

    /// True if the inside of closed meshes is searched.
    #[inline]
    pub fn has_inside(self) -> bool {
        match self {
            Self::All => true,
            Self::Some(pieces) => pieces.contains(&Piece::Inside),
        }
    }

    /// True if anything but the inside is searched.
    #[inline]
    pub fn has_elements(self) -> bool {
        match self {
            Self::All => true,
            Self::Some(pieces) => pieces.iter().any(|piece| *piece != Piece::Inside),
        }
    }

    /// Start nodes in the tree over triangles.
    #[inline]
    pub fn of_surface(self, root: NodeRef, starts: &mut Vec<NodeRef>) {
        self.starts(root, starts, |piece| match piece {
            Piece::Surface(node) => Some(node),
            _ => None,
        });
    }

    /// Start nodes in the tree over a set of cubes.
    #[inline]
    pub fn of_cubes(self, of: u32, root: NodeRef, starts: &mut Vec<NodeRef>) {
        self.starts(root, starts, |piece| match piece {
            Piece::Cubes { set, node } if set == of => Some(node),
            _ => None,
        });
    }

    fn starts(self, root: NodeRef, starts: &mut Vec<NodeRef>, node: impl Fn(Piece) -> Option<NodeRef>) {
        starts.clear();
        match self {
            Self::All => starts.push(root),
            Self::Some(pieces) => starts.extend(pieces.iter().filter_map(|piece| node(*piece))),
        }
    }
}
