//! Contacts of the colliding pairs of a state.

use clearance_checker::{CollisionChecker, CollisionReport, PairContacts, Workspace};
use clearance_proximity::Effort;
use clearance_robot::Configuration;
use clearance_scene::BodyId;

/// Largest number of contacts of a state.
const MOST_CONTACTS: usize = 1000;

/// Contacts of one colliding pair.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactsOfPair {
    /// The two bodies.
    pub bodies: (BodyId, BodyId),
    /// The deepest contact, and others.
    pub contacts: PairContacts,
}

/// Contacts of a state, in the order of its colliding pairs.
pub(super) struct StateContacts {
    pub found: Vec<ContactsOfPair>,
    /// Whether the deadline passed before the contacts of all pairs were found.
    pub is_late: bool,
    /// What is missing because there are too many.
    pub warning: Option<String>,
}

impl StateContacts {
    /// No contacts, because none were requested, or because there was no time.
    pub fn none(is_late: bool) -> Self {
        Self { found: Vec::new(), is_late, warning: None }
    }

    /// At most `per_pair` contacts of each pair, at least one. The deadline is compared before each pair.
    pub fn of_report(
        checker: &CollisionChecker,
        q: &Configuration,
        report: &CollisionReport,
        per_pair: usize,
        effort: &Effort,
        workspace: &mut Workspace,
    ) -> Self {
        let mut contacts = Self::none(false);
        let (mut room, pairs) = (MOST_CONTACTS, report.colliding_pairs.len());
        for (evaluated, &bodies) in report.colliding_pairs.iter().enumerate() {
            if room == 0 {
                contacts.warning = Some(format!(
                    "contacts are listed for the first {evaluated} of {pairs} colliding pairs: {MOST_CONTACTS} in all"
                ));
                break;
            }
            if effort.is_over() {
                contacts.is_late = true;
                break;
            }
            if let Some(found) = checker.contacts(q, bodies, per_pair.min(room), workspace) {
                room = room.saturating_sub(found.count());
                contacts.found.push(ContactsOfPair { bodies, contacts: found });
            }
        }
        contacts
    }
}
