//! Checks that the segments of a certificate are one connected motion.
//!
//! A segment must start with exactly the numbers with which the last one ended. If it does not, because an end is the rounded sum of a
//! polynomial or of an obstacle's motion, the straight motion across the gap is proven free here, without the certificate.

use clearance_motion::{Join, JoinError, MotionSegment, join};

use super::Rejection;
use super::proof_interval::ProofInterval;
use super::segment_kinematics::SegmentKinematics;
use super::segment_verifier::SegmentVerifier;
use super::verifier_model::VerifierModel;

/// A gap is proven in one piece, or in parts halved up to this number of times.
const MOST_HALVINGS: u32 = 6;

/// Rejects a segment that does not continue the last one. In between, pairs have to keep the margin (m).
pub(super) fn check(
    model: &VerifierModel,
    (segment, margin): (usize, f64),
    last: &MotionSegment,
    kinematics: &SegmentKinematics,
) -> Result<(), Rejection> {
    let joined = join(last, &kinematics.motion).map_err(|error| join_rejection(model, segment, error))?;
    prove(model, (segment, margin), joined)
}

/// Rejects a first segment whose obstacles do not start where the world has them.
pub(super) fn check_start(
    model: &VerifierModel,
    margin: f64,
    kinematics: &SegmentKinematics,
) -> Result<(), Rejection> {
    let standing = kinematics.motion.standing_at_start();
    let joined = join(&standing, &kinematics.motion).map_err(|error| match error {
        JoinError::Obstacle { name, by } => {
            Rejection::ObstacleStart { name, shift: by.translation.vector.norm(), turn: by.rotation.angle() }
        }
        other => join_rejection(model, 0, other),
    })?;
    prove(model, (0, margin), joined)
}

fn join_rejection(model: &VerifierModel, segment: usize, error: JoinError) -> Rejection {
    match error {
        JoinError::Position { position, from, to } => {
            let position = model.robot.position_names().get(position).cloned().unwrap_or_default();
            Rejection::Jump { segment, position, from, to }
        }
        JoinError::Obstacle { name, .. } => Rejection::ObstacleJump { segment, name },
        JoinError::ObstacleLimits => Rejection::ObstacleLimits { segment },
        JoinError::Length { before, after } => Rejection::JoinLength { segment, before, after },
    }
}

fn prove(model: &VerifierModel, (segment, margin): (usize, f64), joined: Join) -> Result<(), Rejection> {
    let Join::Gap(gap) = joined else { return Ok(()) };
    let kinematics = SegmentKinematics::new(model.robot, model.world, segment, *gap)?;
    let mut verifier = SegmentVerifier::new(model, segment, margin, &kinematics);
    for (number, pair) in model.required.pairs.iter().enumerate() {
        if !stays_apart(&mut verifier, number, [0.0, 1.0], MOST_HALVINGS) {
            return Err(Rejection::OpenJoin { segment, pair: pair.names.clone() });
        }
    }
    Ok(())
}

fn stays_apart(verifier: &mut SegmentVerifier, pair: usize, [from, to]: [f64; 2], halvings: u32) -> bool {
    let interval = ProofInterval::new(from, to);
    if verifier.is_apart_throughout(pair, interval) {
        return true;
    }
    let middle = interval.middle;
    halvings > 0
        && from < middle
        && middle < to
        && stays_apart(verifier, pair, [from, middle], halvings - 1)
        && stays_apart(verifier, pair, [middle, to], halvings - 1)
}
