//! Warns about pairs of links that touch in every joint state since the robot model was loaded.

use clearance_checker::{CollisionChecker, ConstantContacts};

use super::{CheckedState, Time};

/// Name of the compared states in the warning.
const STATES: &str = "every joint state so far";

/// Advice in the log.
const ADVICE: &str = "`clearance acm` decides which links can collide and writes an SRDF; --ignore A,B leaves a pair out for a trial";

/// Intersection of the colliding pairs of all joint states, until a state without any of them is received.
#[derive(Clone, Debug, Default)]
pub(super) struct ContactWatch {
    contacts: ConstantContacts,
    /// Stamp of the last joint state that was compared.
    stamp: Option<Time>,
    remark: Option<String>,
    is_taken: bool,
}

impl ContactWatch {
    /// Compares a joint state with this stamp. A state whose check was cut off by the deadline is skipped.
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

    /// Returns the warning once.
    pub fn take_remark(&mut self) -> Option<String> {
        let news = self.remark.clone().filter(|_| !self.is_taken);
        self.is_taken |= news.is_some();
        news.map(|remark| format!("{remark}. {ADVICE}"))
    }
}
