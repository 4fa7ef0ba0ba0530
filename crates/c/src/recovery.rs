//! C interface of the search for a free state near a colliding one.

use std::ffi::c_char;
use std::ptr;

use clearance::checker::{FreeState, NoFreeState, Recovery, RecoveryOptions};
use clearance::robot::JointId;
use clearance_bindings::find_joint;

use crate::arguments::Arguments;
use crate::checker::clearance_checker;
use crate::motion_options::deadline;
use crate::status::{Failure, Outcome, clearance_status};
use crate::structs::{clearance_pair, clearance_state, texts};
use crate::workspace::{Memory, clearance_workspace, query_state};

/// Limits of a search for a free state. Start with `clearance_recovery_options_default`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct clearance_recovery_options {
    /// Largest Euclidean norm of all changes (rad, m). Default 0.5.
    pub max_distance: f64,
    /// Distance (m) that the free state keeps from every collision. Default 0.0001.
    pub clearance: f64,
    /// Number of checked states after which the search ends. Default 30 000.
    pub max_checks: u64,
    /// Time (s) after which the search ends. Default infinity.
    pub timeout: f64,
    /// Names of joints that stay where they are.
    pub locked: *const *const c_char,
    /// Number of these joints.
    pub locked_count: usize,
}

impl Default for clearance_recovery_options {
    fn default() -> Self {
        Self {
            max_distance: RecoveryOptions::LARGEST_DISTANCE,
            clearance: RecoveryOptions::CLEARANCE,
            max_checks: RecoveryOptions::MOST_CHECKS,
            timeout: f64::INFINITY,
            locked: ptr::null(),
            locked_count: 0,
        }
    }
}

/// The default limits.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_recovery_options_default() -> clearance_recovery_options {
    clearance_recovery_options::default()
}

/// Result of a search for a free state. The state is valid until the next query with the workspace.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct clearance_free_state {
    /// True if there is a free state.
    pub is_found: bool,
    /// `found`, `already_free`, `not_movable`, `unfinished` or `beyond_limits`.
    pub reason: *const c_char,
    /// n positions of the free state (rad, m), or null.
    pub positions: *const f64,
    /// Number of positions of a state.
    pub n: usize,
    /// Euclidean norm of all changes (rad, m); NaN without a free state.
    pub distance: f64,
    /// The straight motion to the free state is proven free from this t in [0, 1] on; NaN without a free state.
    pub exit: f64,
    /// A pair that no movable joint moves apart by the clearance, if the reason is `not_movable`; names are valid as long as the checker.
    pub pair: clearance_pair,
    /// Number of states that were checked.
    pub checks: u64,
}

/// Searches for a free state near `state`. Only the joints of the checker's states move, without the locked ones. Floating joints and
/// passive joints of the SRDF never move, planar joints only with a group that has them. Null `options` are the defaults. Nothing proves
/// that no free state is nearer.
///
/// Rejected: unknown joints, and lengths that are negative or not finite.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_checker_find_free_state(
    checker: *const clearance_checker,
    workspace: *mut clearance_workspace,
    state: clearance_state,
    options: *const clearance_recovery_options,
    free_state: *mut clearance_free_state,
) -> clearance_status {
    query_state(checker, workspace, state, |arguments, checker, memory| {
        let options = recovery_options(arguments, checker, options)?;
        let Memory { q, workspace, .. } = memory;
        let found = checker.checker.find_free_state(q, &options, workspace).map_err(Failure::rejected)?;
        arguments.write(free_state, result(checker, memory, found), "free_state")
    })
}

fn recovery_options(
    arguments: Arguments<'_>,
    checker: &clearance_checker,
    options: *const clearance_recovery_options,
) -> Outcome<RecoveryOptions> {
    let given = arguments.object_or_none(options, "options")?.copied().unwrap_or_default();
    let joint = |name: &String| {
        find_joint(checker.model(), name).map_err(|why| Failure::rejected(format!("locked: {why}")))
    };
    let locked = texts(arguments, given.locked, given.locked_count, "locked")?;
    Ok(RecoveryOptions {
        joints: checker.space.is_group().then(|| checker.space.joints()),
        locked: locked.iter().map(joint).collect::<Outcome<Vec<JointId>>>()?,
        largest_distance: given.max_distance,
        clearance: given.clearance,
        most_checks: given.max_checks,
        deadline: deadline(given.timeout)?,
    })
}

fn result(checker: &clearance_checker, memory: &mut Memory, found: Recovery) -> clearance_free_state {
    let none = clearance_free_state {
        is_found: false,
        reason: c"".as_ptr(),
        positions: ptr::null(),
        n: checker.space.names().len(),
        distance: f64::NAN,
        exit: f64::NAN,
        pair: clearance_pair::NONE,
        checks: 1,
    };
    let (reason, (state, distance, exit, checks)) = match found {
        Recovery::AlreadyFree => (c"already_free", (memory.q.clone(), 0.0, 0.0, 1)),
        Recovery::Found(FreeState { state, distance, exit, checks }) => {
            (c"found", (state, distance, exit, checks))
        }
        Recovery::NoneFound(NoFreeState { unmoved, is_unfinished, checks }) => {
            let reason = match unmoved {
                Some(_) => c"not_movable",
                None if is_unfinished => c"unfinished",
                None => c"beyond_limits",
            };
            let pair = unmoved.map_or(clearance_pair::NONE, |pair| checker.pair(pair));
            return clearance_free_state { reason: reason.as_ptr(), pair, checks, ..none };
        }
    };
    memory.states = checker.space.select(state.positions());
    let (reason, positions) = (reason.as_ptr(), memory.states.as_ptr());
    clearance_free_state { is_found: true, reason, positions, distance, exit, checks, ..none }
}
