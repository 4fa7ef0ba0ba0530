//! Contacts of two touching bodies, spread over the region of contact.

use clearance_geometry::math::{Point, Vector};
use clearance_proximity::{ContactPoint, ContactQuery, Scratch, SolidBody, contact_points};

use super::contact::{Contact, FoundContact};
use crate::pairs::PosedPair;

/// Contacts of two touching bodies, paddings included; in the root frame.
#[derive(Clone, Debug, PartialEq)]
pub struct PairContacts {
    /// The deepest contact: its depth is that of the whole bodies, with proven bounds.
    pub deepest: Contact,
    /// Others; the first ones are farthest apart, and each separate patch of the contact has one, as far as there may
    /// be so many.
    pub others: Vec<LocalContact>,
}

/// A place where two bodies touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalContact {
    /// A point of both bodies (m); where only their paddings overlap, half way between them.
    pub point: Point,
    /// Unit vector towards the second body: along it, the second body leaves the first one here by the shortest way.
    pub normal: Vector,
    /// Overlap (m) of the two shapes that meet here, on the line along the normal through the point. It is no bound on
    /// the translation that separates the bodies. `None` where an open mesh has no inside.
    pub depth: Option<f64>,
}

impl PairContacts {
    /// At most `most` contacts of a pair, and at least the deepest; `None` if the bodies are apart.
    pub(crate) fn of_pair<'s>(
        pair: &PosedPair,
        solids: impl Fn() -> [&'s SolidBody; 2],
        most: usize,
        scratch: &mut Scratch,
    ) -> Option<Self> {
        let FoundContact { contact, deepest } = FoundContact::of_pair(pair, &solids, scratch)?;
        let (bodies, margin) = (pair.posed_bodies(), pair.info.padding);
        let query = ContactQuery { bodies, solids: solids(), margin, deepest };
        let found = contact_points(&query, most.saturating_sub(1), scratch);
        let in_root = |found: &ContactPoint| LocalContact {
            point: &pair.pose_ra * found.position,
            normal: pair.pose_ra.rotation * found.normal,
            depth: found.depth,
        };
        Some(Self {
            deepest: Contact { point: &pair.pose_ra * found.deepest, ..contact },
            others: found.others.iter().map(in_root).collect(),
        })
    }

    /// Number of contacts.
    #[must_use]
    pub fn count(&self) -> usize {
        1 + self.others.len()
    }
}
