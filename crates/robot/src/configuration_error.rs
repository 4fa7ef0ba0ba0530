//! Errors of joint positions: why values are not a valid configuration, such as a contradictory mimic joint.

use clearance_geometry::constants::LARGEST_COORDINATE;

/// Reason why numbers are not a valid configuration.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the message of each variant describes it and its fields")]
pub enum ConfigurationError {
    #[error("{given} positions given, but the robot has {expected}: {names}")]
    WrongLength { given: usize, expected: usize, names: String },
    #[error("joint '{joint}' has position {value}, which is not finite")]
    NotFinite { joint: String, value: f64 },
    #[error(
        "joint '{joint}' has position {value:e}, farther than the {LARGEST_COORDINATE:e} that can be computed with"
    )]
    TooFar { joint: String, value: f64 },
    #[error("floating joint '{joint}' has a quaternion of length {length}, but it must be 1 within 1e-3")]
    NotAQuaternion { joint: String, length: f64 },
    #[error("the robot has no joint '{joint}'{hint}")]
    UnknownJoint { joint: String, hint: String },
    #[error("{0}")]
    LongName(String),
    #[error("joint '{joint}' is given twice")]
    Duplicate { joint: String },
    #[error("joint '{joint}' is fixed and has no position")]
    Fixed { joint: String },
    #[error("{given} values are given for {expected} named joints")]
    WrongCount { given: usize, expected: usize },
    #[error("{0}")]
    Mimic(Box<MimicContradiction>),
    #[error("tracking tolerance of joint '{joint}' is {value}, but must be finite and not negative")]
    Tolerance { joint: String, value: f64 },
    #[error(
        "joint '{joint}' has tolerance {value}, but it never moves, since it mimics a fixed joint, or another with multiplier 0: give it 0"
    )]
    ToleranceOfStanding { joint: String, value: f64 },
    #[error(
        "one tolerance for every joint is not possible, because joint '{joint}' {why}: give tolerances by name (those that can have one: {others})"
    )]
    NoToleranceForAll { joint: String, why: &'static str, others: String },
}

/// Error: the value of a mimic joint disagrees with its leader.
#[derive(Clone, Debug, PartialEq)]
pub struct MimicContradiction {
    /// Name of the mimic joint.
    pub joint: String,
    /// `position`, `velocity` or `acceleration`.
    pub what: &'static str,
    /// Value given for the mimic joint.
    pub given: f64,
    /// Name of the joint that it mimics.
    pub leader: String,
    /// Value of the leader.
    pub of_leader: f64,
    /// The value that follows from the leader.
    pub expected: f64,
    /// The named mimic joint, with its value, that determines the leader's value; none if the leader's value is given directly.
    pub from: Option<(String, f64)>,
}

impl std::fmt::Display for MimicContradiction {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { joint, what, given, leader, of_leader, expected, from } = self;
        let from = from.as_ref().map(|(name, value)| format!(" (because '{name}' has {value})"));
        let from = from.unwrap_or_default();
        write!(
            f,
            "joint '{joint}' is given {what} {given}, but it mimics '{leader}', whose {what} {of_leader}{from} makes that {expected}: \
             leave '{joint}' out, or give values that agree"
        )
    }
}
