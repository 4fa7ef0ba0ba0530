//! Search for the nearest elements of two bodies: branch and bound over their trees.
//!
//! `body_search` searches all kinds of elements of two bodies. For each pair of kinds one file `nearest_…` tests the leaves of two trees
//! that the traversal reaches.

mod best_so_far;
mod body_search;
mod contained_point;
mod cube_search_state;
mod effort;
mod goal;
mod nearest_cubes_cubes;
mod nearest_plane_body;
mod nearest_solid_cubes;
mod nearest_solid_solid;
mod nearest_surface_cubes;
mod nearest_surface_solid;
mod nearest_surface_surface;
mod scratch;
mod searched_pieces;
mod ties;
mod tree_traversal;
mod triangle_candidates;
mod work;

pub use effort::Effort;
pub use scratch::Scratch;
pub use ties::TieTolerance;
pub use work::Work;

pub(crate) use best_so_far::BestSoFar;
pub(crate) use body_search::{SearchResult, search, search_pieces};
pub(crate) use contained_point::contained_point;
pub(crate) use goal::Goal;
pub(crate) use nearest_surface_surface::{SurfaceSurfaceVisitor, separation_of_triangles};
pub(crate) use scratch::ScratchParts;
pub(crate) use searched_pieces::SearchedPieces;
pub(crate) use ties::Tie;
pub(crate) use triangle_candidates::{TriangleCandidate, TriangleCandidates};
