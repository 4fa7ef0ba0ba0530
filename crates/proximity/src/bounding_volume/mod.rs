//! Bounding volumes of parts of a surface, tested eight at a time.
//!
//! | type | name in the literature |
//! |---|---|
//! | [`Obb`] | oriented bounding box |
//! | [`Aabb`] | axis-aligned bounding box |
//! | [`Rss`] | rectangle swept sphere (RSS) |
//! | [`Capsule`] | line swept sphere (LSS) |
//! | [`Sphere`] | bounding sphere; as a swept sphere, a point swept sphere (PSS) |
//!
//! To add a volume, add one file, its `mod` and `pub use` lines, and one row of this table. The property tests of all
//! volumes are in `tests/it/bodies.rs`.
//!
//! The *frames* of volumes have a common origin, their tree's anchor, and differ by a rotation. Volumes are fitted in f64, rounded
//! outward to f32, and tested in f32 with eight of them in the lanes of a vector; [`Relative::slack`] is the possible rounding error of a
//! test.

mod aabb;
mod capsule;
mod obb;
mod principal_axes;
mod relative;
mod rounding;
mod rss;
mod sphere;
mod volume_trait;

pub use aabb::Aabb;
pub use capsule::Capsule;
pub use obb::Obb;
pub use principal_axes::principal_axes;
pub use relative::{AnchoredReach, Axes, Relative};
pub use rss::Rss;
pub use sphere::Sphere;
pub use volume_trait::BoundingVolume;
