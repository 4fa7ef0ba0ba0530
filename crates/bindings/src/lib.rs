//! Conversions that the bindings for Python and C share, because they do not depend on the language.
//!
//! | content | file |
//! |---|---|
//! | joints of a checker's states: all of the robot, or those of a group | `joint_space` |
//! | names of joints, objects and arguments | `names` |
//! | pairs that are allowed to collide, or checked all the same | `pair_selection` |
//! | threads of batches | `thread_pools` |

#![deny(missing_docs)]

mod joint_space;
mod names;
mod pair_selection;
mod thread_pools;

pub use joint_space::{JointSpace, JointSpaceError};
pub use names::{find_joint, why_no_obstacle, with_package_paths};
pub use pair_selection::{NameError, PairSelection};
pub use thread_pools::{default_threads, pool};
