//! What a solid is, in its own frame.

mod mesh;
mod primitive;
mod shape;
mod triangle;

pub use mesh::{MeshError, TriangleMesh};
pub use primitive::{Primitive, PrimitiveError};
pub use shape::Shape;
pub use triangle::{
    PointPair, Triangle, nearest_on_segment, nearest_on_segments, nearest_pair, separated_across,
};
