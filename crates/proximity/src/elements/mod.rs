//! Convex elements of bodies: triangles, primitives, points and cubes.

mod core_shape;
mod element;
mod element_id;

pub use element::Element;
pub use element_id::ElementPair;

pub(crate) use core_shape::{CoreShape, Faces, RoundedShape};
pub(crate) use element_id::ElementId;
