//! Results of the planner: a path with its trajectory and certificate, or the reason why there is none.

use clearance_checker::{CollisionChecker, MotionOptions, Workspace};
use clearance_motion::{Certificate, MotionSegment, Trajectory};
use clearance_robot::Configuration;

/// Result of a search.
#[derive(Clone, Debug, PartialEq)]
pub enum Plan {
    /// A path whose edges are proven free.
    Found(Path),
    /// No path was found; nothing is proven about whether there is one.
    NotFound(NoPlan),
}

/// States between which straight edges are proven free.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// From the start to the goal, at least two.
    pub states: Vec<Configuration>,
    /// Number of edges that were checked.
    pub edges: u64,
    /// Number of nodes of both trees.
    pub nodes: usize,
}

/// Why no path was found.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoPlan {
    /// The start collides, or could not be decided.
    #[error("the start is not free")]
    StartNotFree,
    /// The goal collides, or could not be decided.
    #[error("the goal is not free")]
    GoalNotFree,
    /// The largest number of edges was reached.
    #[error("none found within {edges} edges")]
    MostEdges {
        /// Number of edges that were checked.
        edges: u64,
    },
    /// Another thread stopped the search.
    #[error("stopped after {edges} edges")]
    Canceled {
        /// Number of edges that were checked.
        edges: u64,
    },
    /// The time was over.
    #[error("none found in time, within {edges} edges")]
    Deadline {
        /// Number of edges that were checked.
        edges: u64,
    },
}

impl NoPlan {
    /// Name of the reason in output.
    #[must_use]
    pub fn reason(&self) -> &'static str {
        match self {
            Self::StartNotFree => "start_not_free",
            Self::GoalNotFree => "goal_not_free",
            Self::MostEdges { .. } => "most_edges",
            Self::Deadline { .. } => "deadline",
            Self::Canceled { .. } => "canceled",
        }
    }
}

impl Path {
    /// Length: the sum of the Euclidean norms of the changes along all edges (rad, m).
    #[must_use]
    pub fn length(&self) -> f64 {
        let squared = |a: &Configuration, b: &Configuration| {
            a.positions().iter().zip(b.positions()).map(|(a, b)| (a - b) * (a - b)).sum::<f64>()
        };
        self.states.windows(2).map(|ends| squared(&ends[0], &ends[1]).sqrt()).sum()
    }

    /// The edges as a trajectory without times.
    ///
    /// # Panics
    /// Never: consecutive edges share their states.
    #[must_use]
    pub fn trajectory(&self, checker: &CollisionChecker) -> Trajectory {
        let edge = |ends: &[Configuration]| MotionSegment::straight(checker.robot(), &ends[0], &ends[1]);
        Trajectory::of_segments(self.states.windows(2).map(edge).collect()).expect("edges join")
    }

    /// A certificate that every edge is free, for `clearance verify`; `None` only if a deadline or the budget of `options` ends the proof.
    #[must_use]
    pub fn certificate(
        &self,
        checker: &CollisionChecker,
        options: &MotionOptions,
        workspace: &mut Workspace,
    ) -> Option<Certificate> {
        checker.certify_trajectory(&self.trajectory(checker), options, workspace).1
    }
}
