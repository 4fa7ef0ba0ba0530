//! C interface of `clearance`: arguments from C are converted, a function of the library is called, its result is converted.
//!
//! `include/clearance.h` is made from this code, and has its documentation. `include/clearance.hpp` is the C++ interface above it.
//!
//! | content | file |
//! |---|---|
//! | pointers from C, the only place that follows them | `arguments` |
//! | status, last error and version; no panic leaves a function | `status` |
//! | structs of arguments and results, texts | `structs`, `texts` |
//! | robots, worlds and their shapes | `robot`, `world`, `shapes` |
//! | checkers and their options; rows of positions | `checker`, `checker_options`; `rows` |
//! | memory of a thread's queries | `workspace` |
//! | queries on states, motions, paths, ways out of a collision | `state_queries`, `motion_queries`, `planning`, `recovery` |
//! | least distances along motions | `motion_distances` |
//! | options and verdicts of motion checks | `motion_options` |
//! | certificates and their verification | `certificate` |
//! | threads of batches | `thread_pools` |

#![allow(unsafe_code, reason = "C passes pointers; `arguments` alone follows them, with reasons")]
#![allow(non_camel_case_types, reason = "types have the names of the header")]
#![allow(
    clippy::not_unsafe_ptr_arg_deref,
    reason = "Rust code uses the library itself; the header states what pointers must be"
)]

pub mod arguments;
pub mod certificate;
pub mod checker;
pub mod checker_options;
pub mod motion_distances;
pub mod motion_options;
pub mod motion_queries;
pub mod planning;
pub mod recovery;
pub mod robot;
mod rows;
pub mod shapes;
pub mod state_queries;
pub mod status;
pub mod structs;
mod texts;
mod thread_pools;
pub mod workspace;
pub mod world;

/// Fails to compile for objects that threads can not share: the header promises that they may.
const fn is_shareable<T: Send + Sync>() {}
const _: () = is_shareable::<robot::clearance_robot>();
const _: () = is_shareable::<world::clearance_world>();
const _: () = is_shareable::<checker::clearance_checker>();
const _: () = is_shareable::<certificate::clearance_certificate>();
const _: () = is_shareable::<workspace::clearance_workspace>();
