//! Processing of point clouds: transform, crop, self-filter and voxel filter.

mod self_filter;
mod sieve;

pub use self_filter::SelfFilter;
pub use sieve::{Sieve, Sieved};
