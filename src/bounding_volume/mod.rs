//! One simple solid around points or around a primitive.
//!
//! | type | the literature's name |
//! |---|---|
//! | [`Obb`] | oriented bounding box |
//! | [`Rss`] | rectangle swept sphere (RSS) |
//! | [`Sphere`] | bounding sphere; as a swept sphere, a point swept sphere (PSS) |
//!
//! A new volume is one file here and one line in this table.

mod obb;
mod principal_axes;
mod rss;
mod sphere;

pub use obb::Obb;
pub use principal_axes::principal_axes;
pub use rss::Rss;
pub use sphere::Sphere;

use crate::geometry::Primitive;
use crate::math::{Point, Pose};

/// A solid that is cheap to test and holds what it was fitted to.
pub trait BoundingVolume: Clone {
    /// The field's short name.
    const NAME: &'static str;

    /// A volume that holds the convex hull of `points`, in their frame. Rounding never leaves a point outside.
    fn fit(points: &[Point]) -> Self;

    /// A volume that holds a primitive placed at `pose`.
    fn around(primitive: &Primitive, pose: &Pose) -> Self;

    /// A number never larger than the distance (m) between the two volumes; `pose_ab` is the pose of `other`'s frame
    /// in this one's. Zero when they overlap.
    fn lower_bound(&self, other: &Self, pose_ab: &Pose) -> f64;

    /// False only if the volumes are more than [`CONTACT_DISTANCE`](crate::constants::CONTACT_DISTANCE) apart.
    fn may_touch(&self, other: &Self, pose_ab: &Pose) -> bool;

    /// A measure by which the larger of two volumes is split first.
    fn size(&self) -> f64;
}
