//! Volumes swept by a robot during a motion.

use clearance_geometry::math::Point;
use clearance_geometry::simd::dispatch;
use clearance_scene::BodyId;

use super::checked_motion::CheckedMotion;
use super::interval_midpoint::deviations_within;
use super::motion_scratch::MotionWorkspace;

/// Swept volume of a link or an attached object between two times: it lies within `radius` of the segment from `a` to
/// `b` (root frame, metres). This is the body's capsule in the middle of the interval, grown by the largest motion of
/// any of its points towards either end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweptVolume {
    /// The link or attached object.
    pub body: BodyId,
    /// Start and end of the interval, as fractions of the motion.
    pub t: [f64; 2],
    /// One end of the segment.
    pub a: Point,
    /// The other end of the segment.
    pub b: Point,
    /// Radius (m) around the segment.
    pub radius: f64,
}

/// The swept volumes of all links and attached objects with geometry, in intervals of equal length.
pub fn swept_volumes(
    CheckedMotion { pairs, segment, .. }: CheckedMotion,
    intervals: usize,
    MotionWorkspace { robot, scratch, .. }: MotionWorkspace,
) -> Vec<SweptVolume> {
    let geometry = pairs.robot();
    let mut positions = vec![0.0; segment.position_count()];
    let mut volumes = Vec::new();
    for interval in 0..intervals.max(1) {
        #[allow(clippy::cast_precision_loss)] // small numbers
        let end = |i: usize| i as f64 / intervals.max(1) as f64;
        let t = [end(interval), end(interval + 1)];
        segment.positions_at(0.5 * (t[0] + t[1]), &mut positions);
        for (part, robot_body) in geometry.parts().iter().enumerate() {
            if !robot_body.capsule().radius.is_finite() {
                continue;
            }
            let path = geometry.path_to_root(part);
            let frames = robot.frames_mut();
            dispatch!(scratch.level(), simd => {
                geometry.chain().frames_between(simd, &path, &positions, frames);
            });
            let reach = robot_body.reach_at(&(&frames[robot_body.chain_body()]).into());
            let moved = geometry.part_motion(part, &reach, frames, &deviations_within(segment, t));
            let [a, b] = reach.ends.map(Point::from);
            let radius = (reach.radius + moved.path_length + moved.tolerance) * (1.0 + 1e-9) + 1e-9;
            volumes.push(SweptVolume { body: robot_body.id(), t, a, b, radius });
        }
    }
    volumes
}
