//! Tests of elements: exact in f64 for two elements, conservative in f32 for eight pairs at once.

mod cube_lanes;
mod distance_element_element;
mod gjk;
mod separation;
mod single_precision;
mod solid_lanes;
mod triangle_lanes;

pub use distance_element_element::{element_contact, element_separation};
pub use separation::Separation;

pub(crate) use cube_lanes::{OneTriangle, lower_bounds_from_cube, nearest_lane};
pub(crate) use distance_element_element::{
    core_nearest_points, gap_along, separation_within, touching_within,
};
pub(crate) use single_precision::{f32_above, shortened, shortened_to_f32, triangle_slack, widened};
pub(crate) use solid_lanes::{lower_bounds_of_cubes, lower_bounds_of_triangles};
pub(crate) use triangle_lanes::{DistanceLanes, LaneTriangles, MovedTriangles, TrianglePairs};
