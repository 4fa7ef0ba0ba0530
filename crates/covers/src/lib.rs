//! Covers of the links of a robot by spheres, capsules and boxes, and simplified meshes, with proven errors.
//!
//! | question | function |
//! |---|---|
//! | which spheres contain the robot, and how far do they reach out? | [`sphere_cover`] |
//! | which spheres lie inside of the robot, and how deep is the rest? | [`inner_sphere_cover`] |
//! | how good is a model of spheres? | [`measure_spheres`] |
//! | which capsules or boxes contain the robot? | [`shape_cover`] |
//! | which meshes have fewer triangles, and how far do they differ? | [`mesh_cover`] |
//! | files for cuRobo, Isaac and VAMP | [`curobo_yaml`], [`xrdf`], [`sphere_urdf`], [`shape_urdf`] |
//! | URDF and STL files of simplified meshes | [`mesh_urdf`], [`stl`] |
//!
//! The search is approximate: signed distances on a grid, set cover, refinement. The result is proven: `containment` proves that the spheres
//! contain the solid, `excess` bounds how far they reach out.
//!
//! | content | file |
//! |---|---|
//! | the geometry of a link as a solid, distances from it | `link_solid`, `triangle_tree`, `primitive_mesh` |
//! | search of few balls, and its end by time | `distance_grid`, `offset_balls`, `samples`, `cover_search`, `refinement`; `search_limit` |
//! | capsules and boxes around parts of a solid | `cover_shape`, `link_parts`, `shape_fit` |
//! | simplification of meshes, with the distance of both surfaces | `mesh_simplification` |
//! | proofs | `containment`, `excess`, `uncovered_area`, `branch_and_bound` |
//! | covers of one solid | `outer_cover`, `inner_cover` |
//! | covers of a robot | `sphere_cover`, `shape_cover`, `mesh_cover`, `measured_cover`, `formats` |

#![deny(missing_docs)]
// minimum and maximum of floating-point numbers, see `math/extremes.rs` of clearance-geometry
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod ball;
mod branch_and_bound;
mod containment;
mod cover_search;
mod cover_shape;
mod distance_grid;
mod excess;
mod formats;
mod inner_cover;
mod link_parts;
mod link_solid;
mod measured_cover;
mod mesh_cover;
mod mesh_simplification;
mod offset_balls;
mod options;
mod outer_cover;
mod primitive_mesh;
mod refinement;
mod samples;
mod search_limit;
mod shape_cover;
mod shape_fit;
mod sphere_cover;
#[cfg(test)]
mod tests;
mod triangle_tree;
mod uncovered_area;

pub use cover_shape::{CoverShape, ShapeSize};
pub use formats::{curobo_yaml, is_simplified_stl, mesh_urdf, shape_urdf, sphere_urdf, stl, xrdf};
pub use measured_cover::{MeasuredCover, MeasuredLink, measure_spheres};
pub use mesh_cover::{LinkMeshes, MeshCover, SimplifiedMesh, mesh_cover};
pub use options::{CoverError, CoverSize};
pub use search_limit::SearchLimit;
pub use shape_cover::{LinkShapes, ShapeCover, shape_cover};
pub use shape_fit::ShapeKind;
pub use sphere_cover::{CoverSphere, LinkCover, SphereCover, inner_sphere_cover, sphere_cover};
pub use uncovered_area::UncoveredArea;
