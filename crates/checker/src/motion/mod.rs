//! Certified continuous collision checking of motions: a result `Free` is a proof for every t in [0, 1].
//!
//! An interval of the motion is free for a pair if the pair's distance in the middle is larger than its possible
//! decrease towards either end; that bound is derived in `docs/derivations/motion-bound.md`. Unproven parts are split
//! until they are proven, or a contact is found, or the motion within a piece is less than the tolerance.
//!
//! | content | file |
//! |---|---|
//! | one motion, and pairs placed along it | `checked_motion` |
//! | one pair in the middle of an interval: its distance, and a bound on its motion | `interval_midpoint` |
//! | capsules of all pairs, eight intervals at once | `level_zero` |
//! | states that are tested before the pairs, where that is worth its cost | `probe_credits` |
//! | scratch memory | `motion_scratch` |
//! | proofs, contacts and open intervals of the check | `prover` |
//! | intervals of a motion at level 0 | `level_zero_intervals` |
//! | order in which intervals are searched for a contact | `interval_search` |
//! | order in which they are searched for a proof that all are free | `free_search` |
//! | check of one motion | `motion_check` |
//! | options and result of the check | `motion_report` |
//! | check of a trajectory, segment by segment | `trajectory_check` |
//! | least distance along a motion or trajectory | `clearance_along_segments` |
//! | branch and bound of the least distance | `clearance_search` |
//! | bounds on the least distance, so far | `least_bounds` |
//! | options and result of the least distance | `motion_clearance` |
//! | certificates of free motions | `certification` |
//! | progress of a check, and its cancellation | `watch` |
//! | volumes around a motion | `swept_volume` |
//! | time before which nothing can touch | `look_ahead` |

mod certification;
mod checked_motion;
mod clearance_along_segments;
mod clearance_search;
mod free_search;
mod interval_midpoint;
mod interval_search;
mod least_bounds;
mod level_zero;
mod level_zero_intervals;
mod look_ahead;
mod motion_check;
mod motion_clearance;
mod motion_report;
mod motion_scratch;
mod probe_credits;
mod prover;
mod swept_volume;
mod trajectory_check;
mod watch;

pub use certification::{CertificateConstants, CertificateSubject, prove_motion, prove_trajectory};
pub use checked_motion::CheckedMotion;
pub use clearance_along_segments::ClearanceAlong;
pub use look_ahead::{LookAhead, LookAheadState, look_ahead};
pub use motion_check::MotionCheck;
pub use motion_clearance::{LeastClearance, MotionClearance, MotionClearanceOptions, NearestMoment};
pub use motion_report::{MotionOptions, MotionOrder, MotionReport, MotionVerdict, UndecidedReason};
pub use motion_scratch::{MotionScratch, MotionWorkspace};
pub use swept_volume::{SweptVolume, swept_volumes};
pub use trajectory_check::{TrajectoryReport, check_trajectory};
pub use watch::Watch;
