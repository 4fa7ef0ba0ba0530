//! One pair of bodies at their poses, ready to be asked about.

use super::report::{Body, PairDistance};
use crate::bounding_volume::BoundingVolume;
use crate::constants::CONTACT_DISTANCE;
use crate::math::Pose;
use crate::query::{self, CollisionBody, Separation, Work};

pub(super) struct Pair<'c> {
    pub ids: (Body, Body),
    pub bodies: (&'c CollisionBody, &'c CollisionBody),
    /// Pose of each body in the root frame.
    pub poses: (Pose, Pose),
    /// Safety distance (m) that is taken off the distance of the bodies.
    pub padding: f64,
}

impl Pair<'_> {
    /// A number never larger than the padded distance, from the bounding spheres alone.
    pub fn lower_bound(&self, work: &mut Work) -> f64 {
        work.volume_tests += 1;
        let (a, b) = self.bodies;
        let lower = a.bounding_sphere().lower_bound(b.bounding_sphere(), &self.pose_ab());
        (lower - self.padding).max(0.0)
    }

    /// Whether the padded bodies touch; if not, they are proven apart.
    pub fn touches(&self, work: &mut Work) -> bool {
        self.lower_bound(work) <= CONTACT_DISTANCE && {
            let (a, b) = self.bodies;
            query::within_margin(a, b, &self.pose_ab(), self.padding, work).is_some()
        }
    }

    /// The padded distance, unless it is proven larger than `limit`.
    pub fn distance(&self, limit: f64, work: &mut Work) -> Option<PairDistance> {
        let (a, b) = self.bodies;
        let raw = query::distance(a, b, &self.pose_ab(), limit + self.padding, work)?;
        Some(self.padded(&raw))
    }

    fn pose_ab(&self) -> Pose {
        self.poses.0.inv_mul(&self.poses.1)
    }

    /// A separation in the frame of a, with the padding taken off and the points in the root frame.
    fn padded(&self, raw: &Separation) -> PairDistance {
        let (a, b) = self.ids;
        PairDistance {
            a,
            b,
            distance: (raw.distance - self.padding).max(0.0),
            witness_points: raw.witness_points.map(|p| self.poses.0 * p),
        }
    }
}
