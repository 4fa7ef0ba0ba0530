//! Penetration depth of convex cores by EPA, from the parry crate; this is the only file that uses parry.
//!
//! parry works on support functions; those of this crate are exact ([`CoreShape::support`]). Only the f64 build is used: in f32, parry's
//! absolute thresholds report meshes 5 mm apart as colliding.

use clearance_geometry::PointPair;
use clearance_geometry::math::{Point, Pose, Vector};
use parry3d_f64::math::{Pose as ParryPose, Vector as ParryVector};
use parry3d_f64::query::details::contact_support_map_support_map;
use parry3d_f64::shape::SupportMap;

use crate::elements::CoreShape;

impl SupportMap for CoreShape {
    fn local_support_point(&self, direction: ParryVector) -> ParryVector {
        to_parry(self.support(&from_parry(direction)).coords)
    }
}

/// Depth (m) of two overlapping cores and the points on each that are deepest in the other (van den Bergen 2001,
/// expanding polytope), in the frame of a; `None` when the iteration finds no contact.
#[inline]
pub(crate) fn penetration(a: &CoreShape, b: &CoreShape, pose_ab: &Pose) -> Option<(f64, PointPair)> {
    let contact = contact_support_map_support_map(&ParryPose::from(*pose_ab), a, b, 0.0)?;
    let on_a = Point::from(from_parry(contact.point1));
    let on_b = pose_ab * Point::from(from_parry(contact.point2));
    Some((-contact.dist, [on_a, on_b]))
}

fn to_parry(v: Vector) -> ParryVector {
    ParryVector::new(v.x, v.y, v.z)
}

fn from_parry(v: ParryVector) -> Vector {
    Vector::new(v.x, v.y, v.z)
}
