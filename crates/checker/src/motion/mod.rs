//! Is the way from here to there free? Certified motion: an answer `Free` is a proof for every t in [0, 1].
//!
//! An interval of the motion is free for a pair if the pair's distance in the middle is more than what it can lose on the way to
//! either end; that bound is derived in `docs/derivations/motion-bound.md`. What is not proven is cut into pieces
//! until it is, or a contact is found, or the motion within a piece is less than the tolerance.
//!
//! | step | file |
//! |---|---|
//! | capsules of all pairs, eight intervals at once | `level_zero` |
//! | one pair at one moment: how far apart, how far for | `moment` |
//! | which intervals to look at, in which order | `order` |
//! | what a look proves, what is found | `prover` |
//! | what is proven, as a document | `certify` |
//! | many motions; stretches one after the other | `edges`, `trajectory` |
//! | how far a check has come, and its end before time | `watch` |
//! | volumes around a motion | `swept_volume` |
//! | until when nothing can touch | `look_ahead` |

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
