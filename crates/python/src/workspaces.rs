//! Memory of queries, by thread and checker: no lock, and warm from query to query.

use std::cell::RefCell;
use std::time::Duration;

use clearance::Workspace;
use clearance::robot::Configuration;

use crate::checker_core::CheckerCore;

/// Checkers whose memory a thread keeps; the least recently used is dropped.
const MOST_CHECKERS: usize = 8;

/// Memory of one thread's queries to one checker.
pub struct QueryMemory {
    checker: u64,
    /// The library's memory.
    pub workspace: Workspace,
    /// Configurations of a block of states.
    pub block: Vec<Configuration>,
    /// A row for the whole robot.
    pub row: Vec<f64>,
    /// Duration of the last measured check of a single state.
    pub last_check: Duration,
    /// Number of checks of single states.
    pub single_checks: u64,
}

thread_local! {
    /// The most recently used first.
    static MEMORIES: RefCell<Vec<QueryMemory>> = const { RefCell::new(Vec::new()) };
}

/// Calls `query` with this thread's memory for the checker; `query` must not call this again.
pub fn with_memory<T>(core: &CheckerCore, query: impl FnOnce(&mut QueryMemory) -> T) -> T {
    MEMORIES.with_borrow_mut(|memories| {
        if memories.first().is_none_or(|memory| memory.checker != core.id) {
            bring_to_front(core, memories);
        }
        query(&mut memories[0])
    })
}

fn bring_to_front(core: &CheckerCore, memories: &mut Vec<QueryMemory>) {
    if let Some(index) = memories.iter().position(|memory| memory.checker == core.id) {
        memories[..=index].rotate_right(1);
        return;
    }
    memories.truncate(MOST_CHECKERS - 1);
    let memory = QueryMemory {
        checker: core.id,
        workspace: core.checker.workspace(),
        block: vec![core.space.rest().clone()],
        row: Vec::new(),
        last_check: Duration::ZERO,
        single_checks: 0,
    };
    memories.insert(0, memory);
}
