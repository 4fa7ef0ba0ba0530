//! Test oracles for penetration depths: exact for unions of boxes, by dense search for small meshes.
//! They are slow, and share no code with the engine.

mod box_depth;
mod direction_search;

pub use box_depth::{AxisBox, depth_of_boxes};
pub use direction_search::{length_along, searched_depth};
