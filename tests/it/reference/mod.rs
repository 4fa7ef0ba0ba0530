//! Test oracle: the reference engine, slow and simple collision and distance queries.
//!
//! Plain f64, one volume and one pair of triangles at a time: per body a binary OBB tree for booleans (Gottschalk, Lin &
//! Manocha 1996) and a binary RSS tree for distances (Larsen, Gottschalk, Lin & Manocha 1999). It shares with the engine the
//! tests of two elements, which have their own tests, and no traversal, no volume and no rounding to f32.

mod body;
mod bounding_volume;
mod collide;
mod distance;
mod obb;
mod rss;
mod tree;

pub use body::ReferenceBody;
pub use collide::collide;
pub use distance::distance;
