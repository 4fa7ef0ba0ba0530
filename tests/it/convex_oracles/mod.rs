//! Test oracles for convex polytopes: separation by a plane, and distance by V-Clip.
//! They share no code with the engine, and none with each other.
//!
//! | file | what it decides |
//! |---|---|
//! | `separating_plane`, `linear_program` | whether a plane separates two point sets strictly (linear programming, Seidel 1991) |
//! | `feature_walk`, `voronoi_region` | distance and nearest points by walking from feature to feature (V-Clip, Mirtich 1998) |
//! | `polytope`, `convex_hull` | vertices, edges and faces that the walk uses |
//!
//! Either oracle checks its own result: a plane separates because all points are on their sides of it, nearest points are nearest
//! because parallel planes through them separate the polytopes, and a common point is in both polytopes.

mod convex_hull;
mod feature_walk;
mod linear_program;
mod polytope;
mod separating_plane;
mod voronoi_region;

pub use feature_walk::{Proximity, nearest_features};
pub use polytope::Polytope;
pub use separating_plane::widest_gap;
