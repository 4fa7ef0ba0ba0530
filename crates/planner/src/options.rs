//! Options of the planner: limits of a search, and the error type of rejected input.

use std::time::Instant;

use clearance_checker::Watch;

/// Limits of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanOptions {
    /// Seed of the random states.
    pub seed: u64,
    /// Largest length of an edge of the trees: the Euclidean norm of all changes (rad, m).
    pub range: f64,
    /// Decision threshold (m) of the edges, as [`clearance_checker::MotionOptions::tolerance`].
    pub tolerance: f64,
    /// Number of edges after which the search ends.
    pub most_edges: u64,
    /// Number of shortcuts that are tried on a path.
    pub shortcuts: u32,
    /// Time at which the search ends.
    pub deadline: Option<Instant>,
    /// Handle by which another thread may stop the search.
    pub watch: Option<Watch>,
}

impl Default for PlanOptions {
    fn default() -> Self {
        Self {
            seed: 1,
            range: 1.0,
            tolerance: 5e-4,
            most_edges: 200_000,
            shortcuts: 64,
            deadline: None,
            watch: None,
        }
    }
}

impl PlanOptions {
    pub(crate) fn validate(&self) -> Result<(), PlanError> {
        for (option, value) in [("range", self.range), ("tolerance", self.tolerance)] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(PlanError::NotPositive { option, value });
            }
        }
        Ok(())
    }
}

/// Input that is not a planning problem.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// A state is not within the joint limits.
    #[error("{end}: {joint} is at {value}, beyond its limits {lower} to {upper}")]
    BeyondLimits {
        /// `start` or `goal`.
        end: &'static str,
        /// Name of the joint.
        joint: String,
        /// Its position (rad, m).
        value: f64,
        /// Lower limit (rad, m).
        lower: f64,
        /// Upper limit (rad, m).
        upper: f64,
    },
    /// Start and goal differ in what does not move.
    #[error("start and goal differ in {joint}, which is not in the group '{group}'")]
    OtherJoint {
        /// Name of the joint.
        joint: String,
        /// Name of the group.
        group: String,
    },
    /// Start and goal differ in a joint that no actuator moves.
    #[error("start and goal differ in {joint}, a passive joint of the SRDF, which no path moves")]
    PassiveJoint {
        /// Name of the joint.
        joint: String,
    },
    /// The group has a joint with several positions.
    #[error(
        "group '{group}' has {joint} of a planar or floating joint, but a path has joints of one position only: take a group without \
         it"
    )]
    SeveralPositions {
        /// Name of the first position of the joint.
        joint: String,
        /// Name of the group.
        group: String,
    },
    /// Nothing can move.
    #[error("group '{0}' has no joint that moves")]
    EmptyGroup(String),
    /// An option is not a positive number.
    #[error("{option} must be a finite number above 0: {value}")]
    NotPositive {
        /// Name of the option.
        option: &'static str,
        /// Its value.
        value: f64,
    },
}
