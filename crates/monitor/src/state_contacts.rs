//! Search for the contact points of the colliding pairs of a state, with limits on number and time.

use clearance_checker::{CollisionChecker, CollisionReport, PairContacts, Workspace};
use clearance_proximity::Effort;
use clearance_robot::Configuration;
use clearance_scene::BodyId;

use super::LeftOut;

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

/// Search for the contacts of a state.
pub(super) struct ContactQuery<'q> {
    pub checker: &'q CollisionChecker,
    pub configuration: &'q Configuration,
    pub report: &'q CollisionReport,
    /// Largest number of contacts of each pair; 0: none are searched.
    pub per_pair: usize,
    /// Ends the search at its deadline, which is compared before each pair.
    pub effort: &'q Effort,
    /// The part of the evaluation that was left out so far.
    pub left_out: LeftOut,
}

/// Contacts of a state, in the order of its colliding pairs.
#[derive(Default)]
pub(super) struct StateContacts {
    pub found: Vec<ContactsOfPair>,
    /// Whether the deadline passed before the contacts of all pairs were found.
    pub is_late: bool,
    /// Warning about pairs without contacts.
    pub warning: Option<String>,
}

impl StateContacts {
    /// The part that the deadline left out.
    pub fn left_out(&self) -> LeftOut {
        if self.is_late { LeftOut::Contacts } else { LeftOut::Nothing }
    }
}

impl ContactQuery<'_> {
    /// At most `per_pair` contacts of each pair, and at least one, as far as a state may have so many.
    ///
    /// Where the replay of a recording leaves contacts out, all are searched: the recorded ones were the first of them.
    pub fn search(&self, workspace: &mut Workspace) -> StateContacts {
        let pairs = &self.report.colliding_pairs;
        let mut contacts =
            StateContacts { is_late: self.left_out == LeftOut::Contacts, ..StateContacts::default() };
        if self.per_pair > 0 && !pairs.is_empty() {
            contacts.is_late |= self.left_out > LeftOut::Contacts;
            if self.left_out <= LeftOut::Contacts {
                self.search_pairs(&mut contacts, workspace);
            }
        }
        if contacts.is_late {
            contacts.warning =
                Some("contacts of some colliding pairs are not known: check_deadline has passed".to_owned());
        }
        contacts
    }

    fn search_pairs(&self, contacts: &mut StateContacts, workspace: &mut Workspace) {
        let pairs = &self.report.colliding_pairs;
        let mut room = MOST_CONTACTS;
        for (searched, &bodies) in pairs.iter().enumerate() {
            if room == 0 {
                let of = pairs.len();
                contacts.warning = Some(format!(
                    "contacts are listed for the first {searched} of {of} colliding pairs: {MOST_CONTACTS} in all"
                ));
                return;
            }
            if self.effort.is_over() {
                contacts.is_late = true;
                return;
            }
            let most = self.per_pair.min(room);
            if let Some(found) = self.checker.contacts(self.configuration, bodies, most, workspace) {
                room = room.saturating_sub(found.count());
                contacts.found.push(ContactsOfPair { bodies, contacts: found });
            }
        }
    }
}
