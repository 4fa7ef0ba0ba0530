//! A small motion planner: RRT-Connect (Kuffner and LaValle 2000) whose edges are proven free, and shortcuts that are proven free.
//!
//! It shows what the engine does for planners. It is no planning framework: one robot state to another, joint limits, straight edges.
//!
//! | content | file |
//! |---|---|
//! | limits of a search, and what is rejected | `options` |
//! | results | `plan` |
//! | the joints that move, their ranges, samples | `space` |
//! | nodes and nearest nodes | `tree` |
//! | the search | `rrt_connect` |
//! | shorter paths | `shortcuts` |

#![deny(missing_docs)]

mod options;
mod plan;
mod rrt_connect;
mod shortcuts;
mod space;
mod tree;

pub use options::{PlanError, PlanOptions};
pub use plan::{NoPlan, Path, Plan};

use clearance_checker::{CollisionChecker, Workspace};
use clearance_robot::{Configuration, JointGroup};

use rrt_connect::Search;
use space::Space;

/// Searches a path of straight edges (in joint space) from one state to another, on which only the joints of a group move and stay within
/// their limits. Passive joints of the SRDF do not move, even if they are in the group. Every edge of a path that is found is proven free
/// ([`CollisionChecker::is_motion_free`]).
///
/// Nothing is proven if no path is found. Without a deadline, the same input gives the same result.
///
/// # Errors
/// If the start or the goal is beyond a limit, if they differ in a passive joint or in a joint outside of the group, if the group has planar
/// or floating joints, or if an option is not a positive number.
pub fn plan(
    checker: &CollisionChecker,
    group: &JointGroup,
    start: &Configuration,
    goal: &Configuration,
    options: &PlanOptions,
    workspace: &mut Workspace,
) -> Result<Plan, PlanError> {
    options.validate()?;
    let space = Space::new(checker.robot(), group, start, goal)?;
    Ok(Search::new(checker, &space, options, workspace).run())
}
