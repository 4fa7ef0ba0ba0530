//! Velocity of world-fixed obstacles relative to the moving root link, from recent `tf` poses of their frames.

use std::collections::VecDeque;

use clearance_geometry::math::{Extremes, Point, Pose, Vector};
use clearance_scene::{LEAST_MOTION, is_elsewhere};

use super::Time;
use super::pose_history::{LargestDisplacement, PoseHistory};

/// Shortest time (s) over which a motion is measured, since `tf` changes in steps.
const WINDOW: f64 = 0.1;

/// Recent poses of a frame in its parent, from `tf`.
#[derive(Clone, Debug, Default)]
pub(super) struct FramePoses {
    /// Poses by stamp. If there are several, the first is at least one window older than the last, or the oldest known.
    places: VecDeque<(Time, Pose)>,
    /// Poses since the last motion of the joints began.
    since_state: PoseHistory,
}

impl FramePoses {
    /// Records a pose from `tf`. A transform with the same stamp contains no motion.
    pub fn note(&mut self, stamp: Time, pose_pf: Pose) {
        self.since_state.note(pose_pf);
        match self.places.back_mut() {
            Some((last, place)) if *last == stamp => return *place = pose_pf,
            Some((last, _)) if *last > stamp => self.places.clear(),
            _ => {}
        }
        self.places.push_back((stamp, pose_pf));
        while self.places.get(1).is_some_and(|(second, _)| stamp.seconds_since(*second) >= WINDOW) {
            self.places.pop_front();
        }
    }

    /// The time for which the frame has been observed.
    pub fn observation(&self) -> Observed {
        let ends = self.places.front().zip(self.places.back());
        let time = ends.map_or(0.0, |((from, _), (to, _))| to.seconds_since(*from));
        let last = self.places.back().map(|(stamp, _)| *stamp).unwrap_or_default();
        let stamps = self.places.iter().map(|(stamp, _)| stamp);
        let steps = stamps.clone().zip(stamps.skip(1)).map(|(from, to)| to.seconds_since(*from));
        Observed { time, step: steps.fold(0.0, f64::greater), last }
    }

    /// Records where the frame was before its first pose was read.
    pub fn note_before(&mut self, pose_pf: Pose) {
        if self.since_state.is_empty() {
            self.since_state.note(pose_pf);
        }
    }

    /// Poses since the last motion of the joints began.
    pub fn since_state(&self) -> &PoseHistory {
        &self.since_state
    }

    /// Some poses of the frame were not read.
    pub fn note_lost(&mut self) {
        self.since_state.note_lost();
    }

    /// A motion of the joints begins.
    pub fn start_motion(&mut self) {
        self.since_state.start();
    }

    /// The earlier pose, how long ago (s) that was, and the longest time (s) between two successive poses since; `None` if
    /// the frame has not moved.
    pub fn before(&self) -> Option<(&Pose, f64, f64)> {
        let ((_, before), (_, now)) = self.places.front().zip(self.places.back())?;
        let Observed { time, step, .. } = self.observation();
        is_elsewhere(before, now).then_some((before, time, step))
    }
}

/// Time for which a transform has been observed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Observed {
    /// Time (s) between the first pose that counts and the last one; 0 if there is only one.
    pub time: f64,
    /// Longest time (s) between two poses.
    pub step: f64,
    /// Stamp of the last pose.
    pub last: Time,
}

/// Motion of the points of a frame, in the root frame.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FrameMotion {
    pub way: Pose,
    /// Time (s) that it took.
    pub taken: f64,
    /// Longest time (s) between two transforms.
    pub step: f64,
}

/// Motion of all obstacles in a frame, relative to the root. Two are equal if the frames move in the same way.
#[derive(Clone, Debug)]
pub struct ObstacleMotion {
    /// Name of the frame.
    pub frame: String,
    /// Motions of the frame's points. There is one for each moving transform; none if the frame is at rest.
    pub(super) motions: Vec<FrameMotion>,
    /// Observations of all transforms between the frame and the root that may move.
    pub(super) observed: Vec<Observed>,
    /// Displacements since the last motion of the joints began, by each of these transforms.
    pub(super) since_state: Vec<LargestDisplacement>,
}

impl PartialEq for ObstacleMotion {
    fn eq(&self, other: &Self) -> bool {
        self.frame == other.frame && self.motions == other.motions
    }
}

impl ObstacleMotion {
    /// Whether the frame is at rest.
    #[must_use]
    pub fn is_none(&self) -> bool {
        self.motions.is_empty()
    }

    /// Displacement (m) of an obstacle at a point if the motion continues for this time (s).
    #[must_use]
    pub fn displacement(&self, point_r: &Point, time: f64) -> Vector {
        let of = |FrameMotion { way, taken, .. }: &FrameMotion| (way * point_r - point_r) * (time / taken);
        self.motions.iter().map(of).sum()
    }

    /// Upper bound (m) on the displacement of a point at this distance (m) from the root, if the motion continues for
    /// this time (s).
    #[must_use]
    pub fn largest_displacement(&self, radius: f64, time: f64) -> f64 {
        self.motions.iter().map(|motion| motion.most(radius, time)).sum()
    }

    /// Upper bound (m/s) on the speed, at the end of the observation, of any point at this distance (m) from the root.
    /// The velocity that each transform gives the root changes at most by these accelerations, in m/s² and rad/s²; `None`
    /// if a transform was received only once.
    ///
    /// The mean velocity of a time T differs from the one at its end by at most ½ T times the acceleration. Motion that is
    /// too small to move the obstacles may have taken place in T, too.
    #[must_use]
    pub fn largest_speed(&self, radius: f64, [linear, angular]: [f64; 2]) -> Option<f64> {
        let mut speed = self.largest_displacement(radius, 1.0);
        for Observed { time, .. } in &self.observed {
            if *time <= 0.0 {
                return None;
            }
            speed += 0.5 * time * (linear + angular * radius) + LEAST_MOTION * (1.0 + radius) / time;
        }
        Some(speed)
    }

    /// Upper bound (m/s²) on the acceleration of any point at this distance (m) from the root, with the same limits.
    #[must_use]
    pub fn largest_acceleration(&self, radius: f64, [linear, angular]: [f64; 2]) -> f64 {
        self.observed.iter().map(|_| linear + angular * radius).sum()
    }

    /// Time (s) by which its pose may be older or newer than this stamp: transforms come in steps, and may have stopped.
    #[must_use]
    pub fn age(&self, stamp: Time) -> f64 {
        let steps = self.observed.iter().map(|observed| observed.step);
        steps.fold(self.difference(stamp), f64::greater)
    }

    /// Longest time (s) between this stamp and the transforms that its pose is from.
    pub(super) fn difference(&self, stamp: Time) -> f64 {
        let differences = self.observed.iter().map(|observed| stamp.seconds_since(observed.last).abs());
        differences.fold(0.0, f64::greater)
    }

    /// As [`Self::largest_displacement`], but at least for the longest time between two transforms: they move frames in
    /// steps, and a whole step may fall into a short time.
    #[must_use]
    pub fn largest_step(&self, radius: f64, time: f64) -> f64 {
        self.motions.iter().map(|motion| motion.most(radius, time.greater(motion.step))).sum()
    }

    /// Upper bound (m) on the displacement of a point at this distance (m) from the root since the last motion of the joints
    /// began: a root that is located anew jumps, and may come back.
    pub(super) fn displacement_since_state(&self, radius: f64) -> f64 {
        self.since_state.iter().map(|displacement| displacement.of_radius(radius)).sum()
    }

    /// Whether the frame was at rest since then, and is.
    pub(super) fn rests(&self) -> bool {
        self.is_none() && self.since_state.iter().all(|since| *since == LargestDisplacement::default())
    }
}

impl FrameMotion {
    /// Upper bound (m) on the displacement of a point at this distance (m) from the origin, which may be infinite, in
    /// this time (s).
    fn most(&self, radius: f64, time: f64) -> f64 {
        largest_displacement(&self.way, radius) * (time / self.taken)
    }
}

/// Upper bound (m) on the displacement of a point at this distance (m) from the origin, which may be infinite.
fn largest_displacement(way: &Pose, radius: f64) -> f64 {
    let angle = way.rotation.angle();
    let turned = if angle > 0.0 { angle * radius } else { 0.0 };
    way.translation.vector.norm() + turned
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tracked(places: impl IntoIterator<Item = (i64, f64)>) -> ObstacleMotion {
        let mut track = FramePoses::default();
        for (milliseconds, x) in places {
            track.note(Time::from_nanoseconds(milliseconds * 1_000_000), Pose::translation(x, 0.0, 0.0));
        }
        let moved = track.before().map(|(before, taken, step)| FrameMotion {
            way: track.places[track.places.len() - 1].1 * before.inverse(),
            taken,
            step,
        });
        let observed = vec![track.observation()];
        let motions = moved.into_iter().collect();
        ObstacleMotion { frame: "map".to_owned(), motions, observed, since_state: Vec::new() }
    }

    /// The track is sampled every 5 ms; the pose changes every 20 or 200 ms.
    #[test]
    fn a_motion_in_steps_is_measured_over_a_while() {
        for (looks_a_step, first) in [(4, 30), (40, 40)] {
            let step = 5 * looks_a_step;
            for end in first..200 {
                let at = |i: i64| (i / looks_a_step) * step;
                #[expect(clippy::cast_precision_loss, reason = "seconds")]
                let steps = (0..=end).map(|i| (at(i), -1e-3 * at(i) as f64));
                let way = tracked(steps).displacement(&Point::new(3.0, 0.0, 0.0), 0.5);
                assert!((way.x + 0.5).abs() < 1e-9 && way.y == 0.0, "{way} after {end} looks");
            }
        }
    }

    #[test]
    fn what_stands_still_or_was_seen_once_does_not_drift() {
        assert!(tracked([(0, 1.0)]).is_none());
        assert!(tracked((0..100).map(|i| (10 * i, 1.0))).is_none());
        assert!(tracked([(0, 0.0), (10, 1.0), (20, 1.0), (500, 1.0), (700, 1.0)]).is_none());
        // a clock that is set back restarts the track
        assert!(tracked([(10, 0.0), (5, 1.0)]).is_none());
    }

    #[test]
    fn a_step_of_tf_counts_as_a_whole_also_far_away() {
        let step = |rpy| ObstacleMotion {
            frame: String::new(),
            motions: vec![FrameMotion {
                way: clearance_geometry::math::pose_from_xyz_rpy([0.3, 0.0, 0.0], rpy),
                taken: 0.1,
                step: 0.05,
            }],
            observed: Vec::new(),
            since_state: Vec::new(),
        };
        let shift = step([0.0; 3]);
        for radius in [1.0, f64::INFINITY] {
            assert!((shift.largest_step(radius, 0.001) - 0.15).abs() < 1e-12);
            assert!((shift.largest_step(radius, 0.2) - 0.6).abs() < 1e-12);
        }
        assert_eq!(step([0.0, 0.0, 0.1]).largest_step(f64::INFINITY, 0.001), f64::INFINITY);
    }

    #[test]
    fn a_turn_moves_what_is_far_away() {
        let turn = clearance_geometry::math::pose_from_xyz_rpy([0.0; 3], [0.0, 0.0, 0.1]);
        let obstacle_motion = ObstacleMotion {
            frame: String::new(),
            motions: vec![FrameMotion { way: turn, taken: 0.1, step: 0.1 }],
            observed: Vec::new(),
            since_state: Vec::new(),
        };
        let way = obstacle_motion.displacement(&Point::new(2.0, 0.0, 0.0), 0.1);
        assert!(
            (way.norm() - 0.2).abs() < 1e-3 && way.norm() <= obstacle_motion.largest_displacement(2.0, 0.1)
        );
    }

    /// A root that accelerates along a line, and turns, seen every 10 ms.
    #[test]
    fn no_point_of_the_robot_is_faster_than_the_largest_speed() {
        let limits = [1.5, 0.8];
        let values = [-1.0, -0.3, 0.0, 0.2, 1.0];
        let mut tightest = f64::INFINITY;
        for i in 0..values.len().pow(4) {
            let digit = |place: u32| values[i / values.len().pow(place) % values.len()];
            let velocities = [digit(0), digit(1)];
            let accelerations = [limits[0] * digit(2), limits[1] * digit(3)];
            let pose_rf = |t: f64| {
                let [x, yaw] = [0, 1].map(|i| velocities[i] * t + 0.5 * accelerations[i] * t * t);
                clearance_geometry::math::pose_from_xyz_rpy([x, 0.0, 0.0], [0.0, 0.0, yaw]).inverse()
            };
            let (mut track, mut end) = (FramePoses::default(), 0.0);
            for i in 0..=30 {
                end = 0.01 * f64::from(i);
                track.note(Time::from_nanoseconds(10_000_000 * i64::from(i)), pose_rf(end));
            }
            let moved = track.before().map(|(before, taken, step)| FrameMotion {
                way: pose_rf(end) * before.inverse(),
                taken,
                step,
            });
            let (motions, observed) = (moved.into_iter().collect(), vec![track.observation()]);
            let of = ObstacleMotion { frame: String::new(), motions, observed, since_state: Vec::new() };
            for radius in [0.0, 0.7, 2.0] {
                let found = of.largest_speed(radius, limits).unwrap();
                let [speed, turning] = [0, 1].map(|i| (velocities[i] + end * accelerations[i]).abs());
                assert!(found >= speed + turning * radius - 1e-9, "{found}");
                tightest = tightest.min(found - speed - turning * radius);
            }
        }
        assert!(tightest < 0.01, "{tightest}");
        assert_eq!(tracked([(0, 1.0)]).largest_speed(1.0, [1.0; 2]), None, "received once");
    }
}
