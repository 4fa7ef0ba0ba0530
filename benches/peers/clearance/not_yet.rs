//! What the library cannot do yet. THE ONLY PLACE to touch when it learns it: each function says what belongs in it, and
//! `None` leaves a dash in the report.

use clearance::{CollisionChecker, Configuration, Workspace};

use crate::answer::Answer;

/// TODO(batch): whether each state is free, on one thread: `CollisionChecker::check_states`.
pub fn batch(_checker: &CollisionChecker, _states: &[Configuration]) -> Option<Vec<bool>> {
    None
}

/// TODO(stream): the least distance within `limit` of successive states, each helped by the last: the stream interface.
/// The stream must begin cold in every call, so that a repeated pass gains nothing from the one before.
pub fn stream(
    _checker: &CollisionChecker,
    _workspace: &mut Workspace,
    _states: &[Configuration],
    _limit: f64,
) -> Option<Vec<Answer>> {
    None
}

/// TODO(level 0): thread CPU time (ns) a state of kinematics and the first, coarse filter alone.
pub fn level_0_nanoseconds(_checker: &CollisionChecker, _states: &[Configuration]) -> Option<f64> {
    None
}

/// TODO(memory): bytes of all hierarchies of the links, triangles included.
pub fn hierarchy_bytes(_checker: &CollisionChecker) -> Option<usize> {
    None
}

/// TODO(cost model): for each volume type, of `T = N_bv * C_bv + N_p * C_p` over the states of the last subject,
/// `NAME n_bv c_bv_ns n_p c_p_ns`, words separated by spaces, volume types by tabs.
pub fn cost_model() -> Option<String> {
    None
}
