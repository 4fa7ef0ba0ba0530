//! From what a sensor sees to what has to be avoided: points placed, cropped, freed of the robot itself, thinned out.

mod self_filter;
mod sieve;

pub use self_filter::SelfFilter;
pub use sieve::{Sieve, Sieved};
