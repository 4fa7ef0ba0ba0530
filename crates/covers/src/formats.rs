//! Files of sphere covers for other programs. Lengths in metres, coordinates in the link frames.

mod curobo_yaml;
mod sphere_urdf;
mod text;
mod xrdf;

pub use curobo_yaml::curobo_yaml;
pub use sphere_urdf::sphere_urdf;
pub use xrdf::xrdf;
