//! Module of the collision geometry of a rigid body: `collision_body` has the body, the others its elements and hierarchies.

mod body_pair;
mod body_volume;
mod bounding_sphere;
mod collision_body;
mod cube_set;
mod interior;
mod piece;
mod solid_leaf;
mod surface;
mod surface_samples;

pub use body_pair::BodyPair;
pub use body_volume::{BodyVolume, VolumeShape};
pub use bounding_sphere::BoundingSphere;
pub use collision_body::CollisionBody;
pub use piece::{Piece, PieceVolume};

pub(crate) use cube_set::CubeSet;
pub(crate) use interior::{Interior, MeshTest};
pub(crate) use solid_leaf::{Hull, SolidLeaf};
pub(crate) use surface::Surface;
