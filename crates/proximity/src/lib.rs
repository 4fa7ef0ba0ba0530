//! Proximity queries on two posed bodies: collision, distance and penetration depth.
//!
//! | query | function | result |
//! |---|---|---|
//! | do they touch? | [`collide`] | a common point, or proof that they are apart |
//! | do they come within a margin? | [`within_margin`] | witness points, or proof that they do not |
//! | how far are they apart? | [`distance`] | least distance and witness points, up to a limit |
//! | the same with tolerances or a deadline | [`distance_bounds`], [`margin_bounds`] | lower and upper bounds |
//! | how deep are two solids in each other? | [`signed_distance`], [`deepest_overlap`] | least translation that separates, negative |
//!
//! Bodies are made of triangles, convex primitives, planes, points with a radius and cubes, in any mixture.
//!
//! Bodies touch when their distance is at most [`CONTACT_DISTANCE`](clearance_geometry::constants::CONTACT_DISTANCE). A mesh is a
//! surface; a body built by [`CollisionBody::with_solid_meshes`] also includes the inside of its closed meshes. `pose_ab` is the pose of
//! body b in the frame of body a; witness points are in the frame of a, first on a. For valid input (finite poses) queries never fail: no
//! error, no panic.

// minimum and maximum of floating-point numbers, see `math/extremes.rs` of clearance-geometry
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod bounding_volume;
pub mod bvh;

mod body;
mod bounding_sphere;
mod collide;
mod containment;
mod core;
mod distance;
mod element;
mod element_pair;
mod front;
mod gjk;
mod grain_grains;
mod grain_lanes;
mod grains;
mod incumbent;
mod narrow_phase;
mod penetration;
mod piece;
mod planes;
mod postponed;
mod samples;
mod scratch;
mod search;
mod solid;
mod solid_grains;
mod solid_lanes;
mod solid_solid;
mod surface;
mod surface_grains;
mod surface_solid;
mod surface_surface;
mod triangle_lanes;
mod volumes;
mod within_margin;
mod work;

pub use body::CollisionBody;
pub use bounding_sphere::BoundingSphere;
pub use collide::collide;
pub use distance::distance_bounds_below;
pub use distance::{DistanceBounds, Effort, distance, distance_bounds};
pub use element::Element;
pub use element_pair::{Separation, element_contact, element_separation};
pub use front::Front;
pub use penetration::{deepest_overlap, signed_distance};
pub use piece::{Piece, PieceVolume};
pub use postponed::{ElementPair, Postponed, nearest_in_doubt};
pub use scratch::Scratch;
pub use volumes::BodyVolume;
pub use within_margin::{margin_bounds, pieces_within_margin, within_margin};
pub use work::Work;
