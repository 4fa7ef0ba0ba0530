//! Slow paths that penetration depths are checked against. They share no code with the engine: exact depths of unions of boxes, and a
//! dense search over directions for small meshes.

mod box_depth;
mod direction_search;

pub use box_depth::{AxisBox, depth_of_boxes};
pub use direction_search::{length_along, searched_depth};
