//! Join between two consecutive segments of a motion: exact, or with a small gap that is a motion of its own.
//!
//! Each segment is proven free by itself, up to its own end. If the next one starts with exactly the same numbers, there is no gap.
//! Otherwise, however small the difference, the robot passes through configurations that belong to neither segment: thin surfaces can be
//! crossed there, and a mimic joint with a large multiplier makes any difference large. The gap is therefore checked as a separate
//! motion.

use clearance_geometry::math::{Extremes, Point, Pose};

use super::moving_obstacle::NO_DISPLACEMENT;
use super::{MotionSegment, MovingObstacle, ObstacleUncertainty};

/// Largest gap (rad, m, relative to the size of the value) that rounding explains; a larger one means a different motion.
const LARGEST_GAP: f64 = 1e-9;

/// Kind of join between two consecutive segments.
#[derive(Clone, Debug, PartialEq)]
pub enum Join {
    /// The second segment starts with exactly the numbers with which the first ends.
    Exact,
    /// The straight motion across the gap. Its tolerances include those of both segments and the rounding of the end.
    Gap(Box<MotionSegment>),
}

/// Reason why two segments are not a connected motion.
#[derive(Clone, Debug, PartialEq)]
pub enum JoinError {
    /// They belong to different robots.
    Length {
        /// Number of positions of the first segment.
        before: usize,
        /// Number of positions of the second segment.
        after: usize,
    },
    /// A position (by its index) jumps from one number to another.
    Position {
        /// Index of the position.
        position: usize,
        /// Value (rad, m) at the end of the first segment.
        from: f64,
        /// Value (rad, m) at the start of the second segment.
        to: f64,
    },
    /// An obstacle jumps by this displacement.
    Obstacle {
        /// Name of the obstacle.
        name: String,
        /// Displacement between the two segments, in the root frame.
        by: Pose,
    },
    /// Less is unknown about obstacles in the second segment than at the end of the first.
    ObstacleLimits,
}

/// The join from `before` to `after`.
pub fn join(before: &MotionSegment, after: &MotionSegment) -> Result<Join, JoinError> {
    let counts = [before, after].map(MotionSegment::position_count);
    if counts[0] != counts[1] {
        return Err(JoinError::Length { before: counts[0], after: counts[1] });
    }
    let mut ends: Vec<[f64; 2]> = (0..counts[0]).map(|position| before.end(position)).collect();
    let starts: Vec<f64> = after.starts().collect();
    turn_alike(before.quaternions(), &mut ends, &starts);
    for (position, ([from, rounding], to)) in ends.iter().zip(&starts).enumerate() {
        let joined = (from - to).abs() <= LARGEST_GAP * (1.0 + from.abs()) + rounding;
        if !joined {
            return Err(JoinError::Position { position, from: *from, to: *to });
        }
    }
    if !limits_continue(before.uncertainty(), after.uncertainty()) {
        return Err(JoinError::ObstacleLimits);
    }
    let (movers, obstacles_join) = obstacles(before, after)?;
    if obstacles_join && ends.iter().zip(&starts).all(|([from, rounding], to)| from == to && *rounding == 0.0)
    {
        return Ok(Join::Exact);
    }
    let from: Vec<f64> = ends.iter().map(|[from, _]| *from).collect();
    let tolerance = |i: usize| {
        let of = |segment: &MotionSegment| segment.tube().get(i).copied().unwrap_or(0.0);
        of(before).greater(of(after)) + ends[i][1]
    };
    let tube = (0..ends.len()).map(tolerance).collect();
    Ok(Join::Gap(Box::new(after.between(&from, &starts).into_gap(tube, movers, before.size()))))
}

/// True if nothing is known about obstacles in the second segment that was not known at the end of the first.
fn limits_continue(before: Option<&ObstacleUncertainty>, after: Option<&ObstacleUncertainty>) -> bool {
    match (before, after) {
        (None, None) => true,
        (Some(before), Some(after)) => after.continues(before),
        (Some(_), None) | (None, Some(_)) => false,
    }
}

/// A quaternion and its negative are the same rotation: selects the one nearer to the other configuration's.
fn turn_alike(quaternions: &[usize], ends: &mut [[f64; 2]], starts: &[f64]) {
    for first in quaternions {
        let (ends, starts) = (&mut ends[*first..first + 4], &starts[*first..first + 4]);
        if ends.iter().zip(starts).map(|([p, _], q)| p * q).sum::<f64>() < 0.0 {
            for [c, _] in ends {
                *c = -*c;
            }
        }
    }
}

/// Motion of the obstacles in the gap, and whether all of them join exactly.
fn obstacles(
    before: &MotionSegment,
    after: &MotionSegment,
) -> Result<(Vec<MovingObstacle>, bool), JoinError> {
    let mut names: Vec<&str> =
        before.obstacles().iter().chain(after.obstacles()).map(|o| o.name.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    let (mut movers, mut all_join) = (Vec::new(), true);
    for name in names {
        let [last, next] =
            [before, after].map(|segment| segment.obstacles().iter().find(|mover| mover.name == name));
        all_join &= last.is_none_or(MovingObstacle::stands) && same_displacement(last, next);
        let from = last.map_or_else(Pose::identity, |mover| mover.displacement(1.0));
        let to = next.map_or_else(Pose::identity, |mover| mover.displacement(0.0));
        if !is_small(&from, &to) {
            return Err(JoinError::Obstacle { name: name.to_owned(), by: to * from.inverse() });
        }
        movers.push(MovingObstacle::between(name, Point::origin(), &from, &to));
    }
    Ok((movers, all_join))
}

/// True if two obstacles have exactly the same displacement at t = 0; one that does not move has its pose in the world.
fn same_displacement(a: Option<&MovingObstacle>, b: Option<&MovingObstacle>) -> bool {
    let [a, b] = [a, b].map(|mover| mover.map_or(NO_DISPLACEMENT, MovingObstacle::start_numbers));
    a.0 == b.0 && (a.1 == b.1 || a.1 == b.1.map(|c| -c))
}

fn is_small(from: &Pose, to: &Pose) -> bool {
    let shift = (to.translation.vector - from.translation.vector).amax();
    let size = 1.0 + from.translation.vector.amax();
    let turn = (to.rotation * from.rotation.inverse()).scaled_axis().amax();
    shift <= LARGEST_GAP * size && turn <= LARGEST_GAP
}
