//! Error type: numbers that are not a valid motion.

use clearance_geometry::constants::LARGEST_COORDINATE;
use clearance_robot::ConfigurationError;

use super::LimitError;

/// Reason why numbers are not a valid motion.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the message of each variant describes it and its fields")]
pub enum SegmentError {
    #[error("the motion has {given} positions, but the robot has {expected}")]
    WrongLength { given: usize, expected: usize },
    #[error("joint '{0}': its motion is not finite")]
    NotFinite(String),
    #[error(
        "joint '{joint}': its position, rates and duration may take it as far as {size:e}, farther than the {LARGEST_COORDINATE:e} that \
         can be computed with"
    )]
    TooLarge { joint: String, size: f64 },
    #[error(transparent)]
    Start(#[from] ConfigurationError),
    #[error(
        "a joint goes as far as {0:e}, farther than the {LARGEST_COORDINATE:e} that can be computed with"
    )]
    TooFar(f64),
    #[error("the horizon must be zero or more seconds, but is {0}")]
    Horizon(f64),
    #[error(
        "floating joint '{0}' can only go straight: leave out the velocities of the points between which it moves"
    )]
    FloatingPolynomial(String),
    #[error("tracking tolerance of joint '{joint}' is {value}, but must be finite and not negative")]
    Tube { joint: String, value: f64 },
    #[error("floating joint '{0}' can have no tracking tolerance: give it 0, or leave it out")]
    FloatingTube(String),
    #[error("obstacle '{0}' is to move, but the world has no such obstacle")]
    UnknownObstacle(String),
    #[error("obstacle '{0}' is to move in two ways")]
    ObstacleTwice(String),
    #[error("obstacle '{0}' moves by numbers that are not finite or no rotation")]
    Obstacle(String),
    #[error(transparent)]
    Limit(#[from] LimitError),
}
