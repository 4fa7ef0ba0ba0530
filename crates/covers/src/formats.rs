//! Writers of covers for other programs: URDF, STL, XRDF and cuRobo YAML. Metres, coordinates in the link frames.

mod collision_elements;
mod curobo_yaml;
mod mesh_urdf;
mod shape_urdf;
mod sphere_urdf;
mod stl;
mod text;
mod xrdf;

pub use curobo_yaml::curobo_yaml;
pub use mesh_urdf::mesh_urdf;
pub use shape_urdf::shape_urdf;
pub use sphere_urdf::sphere_urdf;
pub use stl::{is_simplified_stl, stl};
pub use xrdf::xrdf;
