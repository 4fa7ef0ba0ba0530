//! C interface of the workspace: scratch memory of one thread's queries, guarded against concurrent use.

use std::cell::UnsafeCell;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

use clearance::Workspace;
use clearance::robot::Configuration;
use clearance_bindings::JointSpace;

use crate::arguments::Arguments;
use crate::checker::clearance_checker;
use crate::rows;
use crate::state_queries::StateResults;
use crate::status::{Failure, Outcome, call, clearance_status};
use crate::structs::clearance_state;

/// Memory of queries, and of their results: one for each thread, and only one query at a time. A second query at the same time fails with
/// `CLEARANCE_STATUS_ARGUMENT`.
///
/// A workspace works with every checker, but is fastest with one. Arrays of a result are valid until the next query with the workspace.
#[derive(Debug)]
pub struct clearance_workspace {
    use_state: AtomicU8,
    memory: UnsafeCell<Memory>,
}

const IDLE: u8 = 0;
const IN_USE: u8 = 1;
/// A query ended with an internal error.
const BROKEN: u8 = 2;

// SAFETY: only the holder of the use state `IN_USE` accesses the memory, see `Use`.
unsafe impl Sync for clearance_workspace {}
// SAFETY: the pointers in results are read by C alone.
unsafe impl Send for clearance_workspace {}

/// Content of a workspace.
#[derive(Debug)]
pub struct Memory {
    space: Arc<JointSpace>,
    row: Vec<f64>,
    /// A configuration of the whole robot.
    pub q: Configuration,
    /// The library's memory.
    pub workspace: Workspace,
    /// Arrays of the last result.
    pub results: StateResults,
    /// States of the last result, row by row.
    pub states: Vec<f64>,
}

impl Memory {
    fn new(checker: &clearance_checker) -> Self {
        Self {
            space: Arc::clone(&checker.space),
            row: Vec::new(),
            q: checker.space.rest().clone(),
            workspace: checker.checker.workspace(),
            results: StateResults::default(),
            states: Vec::new(),
        }
    }

    /// Reads a state into `self.q`.
    pub fn read(&mut self, checker: &clearance_checker, row: &[f64], name: &dyn Fn() -> String) -> Outcome {
        if !Arc::ptr_eq(&self.space, &checker.space) {
            self.space = Arc::clone(&checker.space);
            self.q.clone_from(checker.space.rest());
        }
        rows::read_into(&checker.space, row, name, &mut self.row, &mut self.q)
    }
}

/// Exclusive use of a workspace for one query.
struct Use<'w>(&'w clearance_workspace);

impl<'w> Use<'w> {
    fn begin(workspace: &'w clearance_workspace) -> Outcome<Self> {
        let begun = workspace.use_state.compare_exchange(IDLE, IN_USE, Ordering::Acquire, Ordering::Relaxed);
        match begun {
            Ok(_) => Ok(Self(workspace)),
            Err(BROKEN) => Err(Failure::argument(
                "an earlier query with this workspace ended with an internal error: make a new one",
            )),
            Err(_) => Err(Failure::argument(
                "the workspace is in use by another query: each thread needs a workspace of its own",
            )),
        }
    }

    fn memory(&mut self) -> &mut Memory {
        // SAFETY: `begin` makes at most one `Use` of a workspace at a time, and the result borrows it exclusively.
        unsafe { &mut *self.0.memory.get() }
    }
}

impl Drop for Use<'_> {
    fn drop(&mut self) {
        let state = if std::thread::panicking() { BROKEN } else { IDLE };
        self.0.use_state.store(state, Ordering::Release);
    }
}

/// Runs a query of a checker.
pub fn query(
    checker: *const clearance_checker,
    workspace: *mut clearance_workspace,
    query: impl FnOnce(Arguments<'_>, &clearance_checker, &mut Memory) -> Outcome,
) -> clearance_status {
    call(|arguments| {
        let checker = arguments.object(checker, "checker")?;
        let workspace = arguments.object(workspace.cast_const(), "workspace")?;
        query(arguments, checker, Use::begin(workspace)?.memory())
    })
}

/// As [`query`], on one state, which is then in the memory's `q`.
pub fn query_state(
    checker: *const clearance_checker,
    workspace: *mut clearance_workspace,
    state: clearance_state,
    on_state: impl FnOnce(Arguments<'_>, &clearance_checker, &mut Memory) -> Outcome,
) -> clearance_status {
    query(checker, workspace, |arguments, checker, memory| {
        let row = arguments.array(state.positions, state.n, "state")?;
        memory.read(checker, row, &|| "state".to_owned())?;
        on_state(arguments, checker, memory)
    })
}

/// Makes a workspace for queries of a checker.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_workspace_new(
    checker: *const clearance_checker,
    workspace: *mut *mut clearance_workspace,
) -> clearance_status {
    call(|arguments| {
        let memory = UnsafeCell::new(Memory::new(arguments.object(checker, "checker")?));
        let made = clearance_workspace { use_state: AtomicU8::new(IDLE), memory };
        arguments.write_handle(workspace, made, "workspace")
    })
}

/// Frees a workspace; null is ignored.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_workspace_free(workspace: *mut clearance_workspace) {
    call(|arguments| arguments.release(workspace, "workspace"));
}
