//! Ancestor of a frame in the `tf` tree.

use clearance_geometry::math::Pose;

use super::Time;
use super::transform::StoredTransform;

/// An ancestor of a frame.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ancestor<'t> {
    pub name: &'t str,
    /// Its transform to its own parent; `None` for the topmost frame.
    pub transform: Option<&'t StoredTransform>,
    /// Pose, in this ancestor, of the frame that the search started from.
    pub pose_af: Pose,
    /// The oldest transform on the path, if one of them is not static: its frame and stamp.
    pub oldest: Option<(&'t str, Time)>,
    /// The frame on the path whose stamp was latest when it was received, and by how much (s) it was later than the
    /// clock; `None` if none was.
    pub largest_lead: Option<(&'t str, f64)>,
}

impl<'t> Ancestor<'t> {
    /// The parent of this ancestor, as the next ancestor; `transform_of` gives a frame's transform to its parent.
    pub fn parent(&self, transform_of: impl FnOnce(&str) -> Option<&'t StoredTransform>) -> Option<Self> {
        let StoredTransform { transform, lead, .. } = self.transform?;
        let stamped = transform.stamp.map(|stamp| (self.name, stamp));
        let oldest = match (self.oldest, stamped) {
            (Some(a), Some(b)) => Some(if b.1 < a.1 { b } else { a }),
            (a, b) => a.or(b),
        };
        let is_later = *lead > self.largest_lead.map_or(0.0, |(_, known)| known);
        let largest_lead = if is_later { Some((self.name, *lead)) } else { self.largest_lead };
        let name = transform.parent.as_str();
        let pose_af = transform.pose_pf * self.pose_af;
        Some(Self { name, transform: transform_of(name), pose_af, oldest, largest_lead })
    }
}
