//! Checks of robot models: defects of meshes, and certified distances between collision and visual geometry.
//!
//! | content | file |
//! |---|---|
//! | all checks of a robot | `robot_lint` |
//! | findings, severities | `finding` |
//! | defects of one mesh | `mesh_defects`, `self_intersections` |
//! | findings about the meshes of a link | `mesh_findings` |
//! | measurements of a link | `link_report` |
//! | units and scales | `size_checks` |
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
mod html_report;
mod link_geometry;
mod link_report;
mod measured_surface;
mod mesh_defects;
mod mesh_findings;
mod picture;
mod png;
mod robot_lint;
mod self_intersections;
mod size_checks;
mod triangle_tree;

pub use finding::{Check, Finding, GeometryKind, Severity};
pub use hausdorff::{HausdorffBounds, HausdorffOptions, hausdorff};
pub use html_report::html_report;
pub use link_geometry::PlacedShape;
pub use link_report::{LargestDistance, LinkReport};
pub use mesh_defects::{Defect, MeshDefects};
pub use robot_lint::{LintOptions, LintReport, lint};
