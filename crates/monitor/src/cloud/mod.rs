//! Processing of point clouds: transform, crop, self-filter and voxel filter.

mod cloud_filter;
mod self_filter;

pub use cloud_filter::{CloudFilter, FilteredCloud};
pub use self_filter::SelfFilter;
