//! Bounding volumes of parts of a surface, tested eight at a time.
//!
//! | type | name in the literature |
//! |---|---|
//! | [`Obb`] | oriented bounding box |
//! | [`Aabb`] | axis-aligned bounding box |
//! | [`Rss`] | rectangle swept sphere (RSS) |
//! | [`Capsule`] | line swept sphere (LSS) |
//! | [`Sphere`] | bounding sphere; as a swept sphere, a point swept sphere (PSS) |
//! | [`Kdop18`] | discrete oriented polytope of nine directions (18-DOP) |
//! | [`Kios`] | intersection of five balls (5-IOS) |
//!
//! To add a volume, add one file, its `mod` and `pub use` lines, and one row of this table. To let users select it, add a variant of
//! `VolumeKind` of clearance-geometry and its line in `bvh/volume_trees.rs`. The property tests of all volumes are in `tests/it/bodies.rs`.
//!
//! The *frames* of volumes have a common origin, their tree's anchor, and differ by a rotation. Volumes are fitted in f64, rounded
//! outward to f32, and tested in f32 with eight of them in the lanes of a vector; [`Relative::slack`] is the possible rounding error of a
//! test.

mod aabb;
mod capsule;
mod kdop18;
mod kios;
mod obb;
mod outline;
mod principal_axes;
mod rectangle_distance;
mod relative;
mod rounding;
mod rss;
mod sphere;
mod volume_trait;

pub use aabb::Aabb;
pub use capsule::Capsule;
pub use kdop18::Kdop18;
pub use kios::Kios;
pub use obb::Obb;
pub use outline::Outline;
pub use principal_axes::principal_axes;
pub use relative::{AnchoredReach, Axes, Relative};
pub use rss::Rss;
pub use sphere::Sphere;
pub use volume_trait::BoundingVolume;
