//! Reasons why a certificate of a motion is rejected.

use clearance_geometry::ScaleError;
use clearance_motion::CertificateError;

use super::CertificateDifferences;

/// The differing part, or the candidates if the document does not contain enough to identify it.
fn or(differences: &CertificateDifferences, otherwise: &str) -> String {
    if differences.is_empty() { otherwise.to_owned() } else { differences.to_string() }
}

/// Reason why a certificate was rejected: the first error found. Names of pairs are links and obstacles; lengths are in metres.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the message of each variant describes it and its fields")]
pub enum Rejection {
    #[error("padding or scale is given for link '{0}', which the robot has not")]
    UnknownLink(String),
    #[error("object '{object}' is attached to link '{link}', which the robot has not")]
    NoCarrier { object: String, link: String },
    #[error("padding of '{of}' is {value}, but must be a finite number of metres, zero or more")]
    BadPadding { of: String, value: f64 },
    #[error("'{of}' cannot be scaled: {why}")]
    CannotScale { of: String, why: ScaleError },
    #[error("the format is '{0}', which is not known, or the document lacks what that format has")]
    Format(String),
    #[error("the digest does not fit the content: something in it was altered")]
    Digest,
    #[error("it is about robot '{given}', not '{expected}'")]
    Robot { given: String, expected: String },
    #[error("it is about another model: {}", or(.0, "links, joints, shapes, paddings or pairs differ"))]
    Model(CertificateDifferences),
    #[error("it is about another world: {}", or(.0, "obstacles or attached objects differ"))]
    World(CertificateDifferences),
    #[error("its list of parts does not fit its hashes: {}", or(.0, "their order differs"))]
    Parts(CertificateDifferences),
    #[error("it is about another motion: {0}")]
    OtherMotion(CertificateDifferences),
    #[error("its tolerance is {0}, but must be a finite number of metres, more than zero")]
    Tolerance(f64),
    #[error("its margin is {0}, but must be a finite number of metres, zero or more")]
    BadMargin(f64),
    #[error("the hash of the motion does not fit the motion")]
    MotionHash,
    #[error("its positions are those of other joints: number {place} is '{given}', but must be '{expected}'")]
    Joints { place: usize, given: String, expected: String },
    #[error("pair '{0}' – '{1}' has to be checked, but is missing")]
    MissingPair(String, String),
    #[error("pair '{0}' – '{1}' is not one that has to be checked")]
    UnknownPair(String, String),
    #[error("pair number {place} is '{}' – '{}', but must be '{}' – '{}'", given[0], given[1], expected[0], expected[1])]
    PairOrder { place: usize, given: [String; 2], expected: [String; 2] },
    #[error("it has no segments")]
    NoSegments,
    #[error("segment {segment} is no motion: {error}")]
    Motion { segment: usize, error: CertificateError },
    #[error("segment {segment} passes through what is no configuration: {error}")]
    Configuration { segment: usize, error: clearance_robot::ConfigurationError },
    #[error("segment {segment} begins with '{position}' at {to}, where the last ended at {from}")]
    Jump { segment: usize, position: String, from: f64, to: f64 },
    #[error("segment {segment} has {after} positions, the last one {before}")]
    JoinLength { segment: usize, before: usize, after: usize },
    #[error(
        "segment {segment} does not start exactly where the last one ends, and '{}' – '{}' are not proven apart in between", pair[0], pair[1]
    )]
    OpenJoin { segment: usize, pair: [String; 2] },
    #[error("obstacle '{name}' starts {shift} m and {turn} rad away from where the world has it")]
    ObstacleStart { name: String, shift: f64, turn: f64 },
    #[error("segment {segment} moves obstacle '{name}', which the world has not")]
    UnknownObstacle { segment: usize, name: String },
    #[error("segment {segment} moves obstacle '{name}' twice")]
    ObstacleTwice { segment: usize, name: String },
    #[error("obstacle '{name}' is not at the start of segment {segment} where it was at the end of the last")]
    ObstacleJump { segment: usize, name: String },
    #[error("segment {segment}: how far obstacles may have moved does not continue from the segment before")]
    ObstacleLimits { segment: usize },
    #[error("segment {segment}, proof {proof}: there is no pair {pair}")]
    PairNumber { segment: usize, proof: usize, pair: usize },
    #[error("segment {segment}, proof {proof}: {from} to {to} is no interval within 0 and 1")]
    Interval { segment: usize, proof: usize, from: f64, to: f64 },
    #[error("segment {segment}, proof {proof}: lower {lower} and bound {bound} are no lengths")]
    Lengths { segment: usize, proof: usize, lower: f64, bound: f64 },
    #[error("segment {segment}: nothing is proven of '{}' – '{}' between {from} and {to}", pair[0], pair[1])]
    Gap { segment: usize, pair: [String; 2], from: f64, to: f64 },
    #[error(
        "segment {segment}, proof {proof}: lower {lower} is not more than bound {bound}, padding and margin {padding}"
    )]
    Short { segment: usize, proof: usize, lower: f64, bound: f64, padding: f64 },
    #[error(
        "segment {segment}, proof {proof}: the pair may come nearer by {found}, more than the bound {bound}"
    )]
    Bound { segment: usize, proof: usize, bound: f64, found: f64 },
    #[error(
        "segment {segment}, proof {proof}: the pair may come nearer by {found}, which lower {lower} does not leave with padding \
         and margin {padding}"
    )]
    Margin { segment: usize, proof: usize, lower: f64, found: f64, padding: f64 },
    #[error("segment {segment}, proof {proof}: '{}' – '{}' were not found {lower} apart at {at}", pair[0], pair[1])]
    Near { segment: usize, proof: usize, pair: [String; 2], at: f64, lower: f64 },
    #[error("the verification was stopped")]
    Stopped,
    #[error("segment {segment}: of '{}' – '{}' one lies inside the other at {at}", pair[0], pair[1])]
    Inside { segment: usize, pair: [String; 2], at: f64 },
}
