//! Pairs of links that touch in every joint state since the robot is known.

use clearance_checker::{CollisionChecker, ConstantContacts};

use super::{CheckedState, Time};

/// Name of the states in the warning.
const STATES: &str = "every joint state so far";

/// Compares the colliding pairs of joint states, until one state without them comes.
#[derive(Clone, Debug, Default)]
pub(super) struct ContactWatch {
    contacts: ConstantContacts,
    /// Of the last joint state that was compared.
    stamp: Option<Time>,
    remark: Option<String>,
    is_taken: bool,
}

impl ContactWatch {
    /// Takes note of a joint state of this stamp; one that a deadline left undecided says nothing.
    pub fn note(&mut self, checked_state: &CheckedState, stamp: Option<Time>, checker: &CollisionChecker) {
        let report = &checked_state.report;
        if !self.contacts.is_open() || !report.undecided.is_empty() || self.stamp == stamp {
            return;
        }
        self.stamp = stamp;
        self.contacts.add(&checked_state.configuration, &report.colliding_pairs);
        self.remark = self.contacts.remark(STATES, checker);
    }

    pub fn remark(&self) -> Option<&str> {
        self.remark.as_deref()
    }

    /// The remark, if it was never taken.
    pub fn take_news(&mut self) -> Option<String> {
        let news = self.remark.clone().filter(|_| !self.is_taken);
        self.is_taken |= news.is_some();
        news
    }
}
