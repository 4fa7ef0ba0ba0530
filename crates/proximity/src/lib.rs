//! Proximity queries on two posed bodies: collision, distance and penetration depth.
//!
//! | query | function | result |
//! |---|---|---|
//! | do they touch? | [`collide`] | a common point, or proof that they are apart |
//! | do they come within a margin? | [`within_margin`] | witness points, or proof that they do not |
//! | how far are they apart? | [`distance`] | least distance and witness points, up to a limit |
//! | the same with tolerances or a deadline | [`distance_bounds`], [`margin_bounds`] | lower and upper bounds |
//! | the same with all nearest points, and whether they are unique | [`distance_with_witnesses`] | witness pairs with normals |
//! | how deep are two bodies in each other? | [`penetration_depth`] | bounds on the translation that separates them |
//! | where do they touch? | [`contact_points`] | points with normal and local depth, spread over the contact |
//! | how far, or how deep, are two primitives? | [`signed_distance`] | distance, negative where they overlap |
//!
//! Bodies are made of triangles, convex primitives, planes, points with a radius and cubes, in any mixture.
//!
//! A body has hierarchies of oriented boxes. [`CollisionBody::with_volumes_of`] adds those of another kind, with which its pairs are then
//! searched; results are the same.
//!
//! Bodies touch when their distance is at most [`CONTACT_DISTANCE`](clearance_geometry::constants::CONTACT_DISTANCE). A mesh is a
//! surface; a body built by [`CollisionBody::with_solid_meshes`] also includes the inside of its closed meshes. `pose_ab` is the pose of
//! body b in the frame of body a; witness points are in the frame of a, first on a. For valid input (finite poses) queries never fail: no
//! error, no panic.

// minimum and maximum of floating-point numbers, see `math/extremes.rs` of clearance-geometry
#![deny(missing_docs)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod bounding_volume;
pub mod bvh;

mod body;
mod contacts;
mod elements;
mod front;
mod narrow_phase;
mod penetration_depth;
mod queries;
mod search;
mod witnesses;

pub use body::{BodyPair, BodyVolume, BoundingSphere, CollisionBody, Piece, PieceVolume, VolumeShape};
pub use contacts::{ContactPoint, ContactPoints, ContactQuery, DeepestContact, contact_points};
pub use elements::{Element, ElementPair};
pub use front::{Front, FrontLimits};
pub use narrow_phase::{Separation, element_contact, element_separation};
pub use penetration_depth::{
    PenetrationDepth, SolidBody, UnknownDepth, depth_witnesses, is_one_inside, penetration_depth,
    signed_distance,
};
pub use queries::{
    DistanceBounds, DistanceCandidate, collide, distance, distance_bounds, distance_bounds_below,
    distance_candidates, distance_with_witnesses, elements_found_within_margin, elements_within_margin,
    margin_bounds, pieces_within_margin, within_margin,
};
pub use search::{Effort, Scratch, TieTolerance, Work};
pub use witnesses::{WitnessOptions, WitnessPair, WitnessPairs};
