//! Certified continuous collision checking of motions: a result `Free` is a proof for every t in [0, 1].
//!
//! An interval of the motion is free for a pair if the pair's distance in the middle is larger than its possible decrease towards either
//! end; that bound is derived in `docs/derivations/motion-bound.md`. Unproven parts are split until they are proven, or a contact is
//! found, or the motion within a piece is less than the tolerance.
//!
//! | step | file |
//! |---|---|
//! | capsules of all pairs, eight intervals at once | `level_zero` |
//! | one pair at one moment: its distance, and the interval it proves free | `interval_midpoint` |
//! | order in which intervals are searched | `order` |
//! | proofs and results of the check | `prover` |
//! | certificates of free motions | `certify` |
//! | many motions; stretches one after the other | `edges`, `trajectory` |
//! | progress of a check, and its cancellation | `watch` |
//! | volumes around a motion | `swept_volume` |
//! | time before which nothing can touch | `look_ahead` |

mod certify;
mod edges;
mod interval_midpoint;
mod level_zero;
mod look_ahead;
mod order;
mod prover;
mod report;
mod swept_volume;
mod trajectory;
mod watch;

pub(super) use level_zero::Ways;
pub use look_ahead::LookAhead;
pub(super) use prover::MotionScratch;
pub use report::{MotionOptions, MotionOrder, MotionReport, MotionVerdict, UndecidedReason};
pub use swept_volume::SweptVolume;
pub use trajectory::TrajectoryReport;
pub use watch::Watch;
