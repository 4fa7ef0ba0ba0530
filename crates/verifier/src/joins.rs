//! Checks that the segments of a certificate are one connected motion.
//!
//! A segment must start with exactly the numbers with which the last one ended. If it does not, because an end is the rounded sum of a
//! polynomial or of an obstacle's motion, the straight motion across the gap is proven free here, without the certificate.

use clearance_motion::{Join, JoinError, MotionSegment, join};

use super::segment_kinematics::SegmentKinematics;
use super::verifier::{Interval, Pass};
use super::{Refusal, Verifier};

/// A gap is proven in one piece, or in parts halved up to this number of times.
const MOST_HALVINGS: u32 = 6;

/// Rejects a segment that does not continue the last one.
pub(super) fn check(
    verifier: &Verifier,
    segment: usize,
    last: &MotionSegment,
    course: &SegmentKinematics,
) -> Result<(), Refusal> {
    let joined = join(last, &course.motion).map_err(|error| broken(verifier, segment, error))?;
    prove(verifier, segment, joined)
}

/// Rejects a first segment whose obstacles do not start where the world has them.
pub(super) fn check_start(verifier: &Verifier, course: &SegmentKinematics) -> Result<(), Refusal> {
    let standing = course.motion.standing_at_start();
    let joined = join(&standing, &course.motion).map_err(|error| match error {
        JoinError::Obstacle { name, by } => {
            Refusal::ObstacleStart { name, shift: by.translation.vector.norm(), turn: by.rotation.angle() }
        }
        other => broken(verifier, 0, other),
    })?;
    prove(verifier, 0, joined)
}

fn broken(verifier: &Verifier, segment: usize, error: JoinError) -> Refusal {
    match error {
        JoinError::Position { position, from, to } => {
            let position = verifier.robot.position_names().get(position).cloned().unwrap_or_default();
            Refusal::Jump { segment, position, from, to }
        }
        JoinError::Obstacle { name, .. } => Refusal::ObstacleJump { segment, name },
        JoinError::Length { before, after } => Refusal::JoinLength { segment, before, after },
    }
}

fn prove(verifier: &Verifier, segment: usize, joined: Join) -> Result<(), Refusal> {
    let Join::Gap(gap) = joined else { return Ok(()) };
    let course = SegmentKinematics::new(verifier.robot, verifier.world, segment, *gap)?;
    let mut pass = Pass::new(verifier, segment, &course);
    for (number, pair) in verifier.subject.pairs.iter().enumerate() {
        if !stays_apart(&mut pass, number, [0.0, 1.0], MOST_HALVINGS) {
            return Err(Refusal::OpenJoin { segment, pair: pair.names.clone() });
        }
    }
    Ok(())
}

fn stays_apart(pass: &mut Pass, pair: usize, [from, to]: [f64; 2], halvings: u32) -> bool {
    let interval = Interval::new(from, to);
    if pass.is_apart_throughout(pair, interval) {
        return true;
    }
    let middle = interval.middle;
    halvings > 0
        && from < middle
        && middle < to
        && stays_apart(pass, pair, [from, middle], halvings - 1)
        && stays_apart(pass, pair, [middle, to], halvings - 1)
}
