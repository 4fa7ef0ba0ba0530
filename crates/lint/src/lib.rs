//! Checks of robot models: defects of meshes, and certified distances between collision and visual geometry.
//!
//! | content | file |
//! |---|---|
//! | all checks of a robot | `robot_lint` |
//! | findings, severities | `finding` |
//! | defects of one mesh | `mesh_defects`, `self_intersections` |
//! | units, missing geometry | `size_checks` |
//! | certified one-sided Hausdorff distances | `hausdorff` |
//! | surfaces whose points are measured | `measured_surface` |
//! | geometry to which distances are measured | `distance_target`, `triangle_tree` |
//! | pictures | `picture`, `png` |
//! | page with all of it | `html_report` |
//!
//! Units are metres. Points are in the frame of their link. The same input gives the same report.

#![deny(missing_docs)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod distance_target;
mod finding;
mod hausdorff;
mod link_geometry;
mod measured_surface;
mod mesh_defects;
mod self_intersections;
mod triangle_tree;
mod welded_mesh;

pub use finding::{Check, Finding, GeometryKind, Severity};
pub use hausdorff::{HausdorffBounds, HausdorffOptions, hausdorff};
pub use link_geometry::PlacedShape;
pub use mesh_defects::{Defect, MeshDefects};
