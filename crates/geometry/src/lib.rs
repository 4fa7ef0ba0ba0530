//! Geometry of shapes in their own frames: primitives, meshes, planes, point clouds and voxels.
//!
//! | content | file |
//! |---|---|
//! | any shape | `shape` |
//! | box, sphere, cylinder, cone, capsule; signed distances from them | `primitive`, `primitive_distance` |
//! | triangle mesh, also with joined vertices; its connected parts | `mesh`, `welded_mesh`, `connected_parts` |
//! | solid of a mesh; inside tests | `solid_mesh`, `inside_test` |
//! | plane, point cloud, voxels | `plane`, `point_cloud`, `voxels` |
//! | distances of triangles and segments | `triangle` |
//! | names of the kinds of bounding volumes | `volume_kind` |
//! | tolerances; vectors and poses; SIMD lanes | `constants`, `math`, `simd` |

// minimum and maximum of floating-point numbers, see `math/extremes.rs` of clearance-geometry
#![deny(missing_docs)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod constants;
pub mod math;
pub mod simd;
#[cfg(any(test, feature = "testing"))]
#[doc(hidden)]
#[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation)]
pub mod testing;

mod connected_parts;
mod inside_test;
mod mesh;
mod plane;
mod point_cloud;
mod primitive;
mod primitive_distance;
mod shape;
mod solid_mesh;
mod triangle;
mod volume_kind;
mod voxels;
mod welded_mesh;

pub use nalgebra;

pub use connected_parts::DisjointSets;
pub use inside_test::InsideTest;
pub use mesh::{MeshError, TriangleMesh};
pub use plane::{Plane, PlaneError};
pub use point_cloud::{PointCloud, PointCloudError};
pub use primitive::{Primitive, PrimitiveError};
pub use shape::{ScaleError, Shape};
pub use solid_mesh::{ClosedSurface, InsideGrid, InsideWork, SolidMesh, SolidRemarks};
pub use triangle::{
    PointPair, Triangle, nearest_on_segment, nearest_on_segments, nearest_pair, separated_across,
};
pub use volume_kind::{UnknownVolumeKind, VolumeKind};
pub use voxels::{Cube, Voxels, VoxelsError};
pub use welded_mesh::WeldedMesh;
