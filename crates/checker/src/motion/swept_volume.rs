//! Volumes swept by a robot during a motion.

use clearance_geometry::math::Point;
use clearance_geometry::simd::dispatch;
use clearance_motion::MotionSegment;

use super::interval_midpoint::of_whole_interval;
use crate::collision_checker::CollisionChecker;
use crate::workspace::Workspace;
use clearance_scene::BodyId;

/// Swept volume of a link or an attached object between two times: it lies within `radius` of the segment from `a` to `b` (root frame,
/// metres). This is the body's capsule in the middle of the interval, grown by the largest motion of any of its points towards either
/// end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweptVolume {
    pub body: BodyId,
    pub t: [f64; 2],
    pub a: Point,
    pub b: Point,
    pub radius: f64,
}

impl CollisionChecker {
    /// The swept volumes of all links and attached objects with geometry, in intervals of equal length; more intervals give smaller
    /// volumes. Padding is not included. Bodies with a plane, which sweep over everything, have no volume.
    #[must_use]
    pub fn swept_volumes(
        &self,
        segment: &MotionSegment,
        intervals: usize,
        workspace: &mut Workspace,
    ) -> Vec<SweptVolume> {
        self.suit(workspace);
        let mut positions = vec![0.0; segment.position_count()];
        let mut volumes = Vec::new();
        for interval in 0..intervals.max(1) {
            #[allow(clippy::cast_precision_loss)] // small numbers
            let end = |i: usize| i as f64 / intervals.max(1) as f64;
            let t = [end(interval), end(interval + 1)];
            segment.positions_at(0.5 * (t[0] + t[1]), &mut positions);
            let bounded = self.robot_bodies.iter().filter(|robot_body| robot_body.capsule.radius.is_finite());
            for robot_body in bounded {
                let between = self.paths_to_root.to_root(robot_body.body);
                let frames = &mut workspace.frames;
                dispatch!(workspace.scratch.level(), simd => {
                    self.chain.frames_between(simd, &between, &positions, frames);
                });
                let reach = robot_body.reach_at(&(&frames[robot_body.body]).into());
                let motion = of_whole_interval(segment, t);
                let moved = self.chain.side_motion(between.side(0), &reach, frames, &motion);
                let [a, b] = reach.ends.map(Point::from);
                let radius = (reach.radius + moved.path_length + moved.tolerance) * (1.0 + 1e-9) + 1e-9;
                volumes.push(SweptVolume { body: robot_body.id, t, a, b, radius });
            }
        }
        volumes
    }
}
