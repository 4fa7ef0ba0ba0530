//! How what stands in the room moves past the robot while its root drives.

use std::collections::VecDeque;
use std::time::Duration;

use super::scene::is_elsewhere;
use crate::math::{Point, Pose, Vector};

/// Time that a motion is measured over: `tf` comes in steps.
const WINDOW: Duration = Duration::from_millis(100);

/// Where a frame was in the root's frame lately.
#[derive(Clone, Debug, Default)]
pub(super) struct Track {
    /// The last of them is where it is now; the first, if there are several, a window ago or all that is known.
    places: VecDeque<(Duration, Pose)>,
    /// As `tf` has it.
    now: Pose,
}

impl Track {
    /// The same, with the frame somewhere else.
    pub fn to(self, pose_rf: Pose) -> Self {
        Self { now: pose_rf, ..self }
    }

    /// That is where it is at a time.
    pub fn note(&mut self, at: Duration) {
        match self.places.back_mut() {
            Some((last, place)) if *last == at => return *place = self.now,
            Some((last, _)) if *last > at => self.places.clear(),
            _ => {}
        }
        self.places.push_back((at, self.now));
        while self.places.get(1).is_some_and(|(second, _)| at.saturating_sub(*second) >= WINDOW) {
            self.places.pop_front();
        }
    }

    pub fn drift(&self, frame: &str) -> Drift {
        let ends = self.places.front().zip(self.places.back());
        let moved = ends.filter(|((_, before), (_, now))| is_elsewhere(before, now));
        let motion = moved.map(|((from, before), (to, now))| {
            (now * before.inverse(), to.saturating_sub(*from).as_secs_f64())
        });
        Drift { frame: frame.to_owned(), motion }
    }
}

/// What stands in a frame moves with it past the root.
#[derive(Clone, Debug, PartialEq)]
pub struct Drift {
    pub frame: String,
    /// The way of its points in the root's frame, and how long (s) it took; `None`: it stands still.
    motion: Option<(Pose, f64)>,
}

impl Drift {
    #[must_use]
    pub fn is_none(&self) -> bool {
        self.motion.is_none()
    }

    /// The way (m) of what is at a point, if it goes on like this for some time (s).
    #[must_use]
    pub fn way_of(&self, point_r: &Point, time: f64) -> Vector {
        let way = self.motion.map(|(way, taken)| (way * point_r - point_r) * (time / taken));
        way.unwrap_or_else(Vector::zeros)
    }

    /// The most (m) that a point as far (m) from the root moves, if it goes on like this for some time (s).
    #[must_use]
    pub fn farthest(&self, radius: f64, time: f64) -> f64 {
        self.motion.map_or(0.0, |(way, taken)| {
            (way.translation.vector.norm() + way.rotation.angle() * radius) * (time / taken)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tracked(places: impl IntoIterator<Item = (u64, f64)>) -> Drift {
        let mut track = Track::default();
        for (milliseconds, x) in places {
            track = track.to(Pose::translation(x, 0.0, 0.0));
            track.note(Duration::from_millis(milliseconds));
        }
        track.drift("map")
    }

    /// Looked at every 5 ms; told of every 20 ms.
    #[test]
    fn a_motion_in_steps_is_measured_over_a_while() {
        for end in 30..60_u32 {
            let steps = (0..end).map(|i| (u64::from(5 * i), -0.02 * f64::from(i / 4)));
            let way = tracked(steps).way_of(&Point::new(3.0, 0.0, 0.0), 0.5);
            // a metre a second, and a step more or less
            assert!((way.x + 0.5).abs() <= 0.11 && way.y == 0.0, "{way}");
        }
    }

    #[test]
    fn what_stands_still_or_was_seen_once_does_not_drift() {
        assert!(tracked([(0, 1.0)]).is_none());
        assert!(tracked((0..100).map(|i| (10 * i, 1.0))).is_none());
        assert!(tracked([(0, 0.0), (10, 1.0), (20, 1.0), (500, 1.0), (700, 1.0)]).is_none());
        // a steady clock that is set back begins anew
        assert!(tracked([(10, 0.0), (5, 1.0)]).is_none());
    }

    #[test]
    fn a_turn_moves_what_is_far_away() {
        let turn = crate::math::pose_from_xyz_rpy([0.0; 3], [0.0, 0.0, 0.1]);
        let drift = Drift { frame: String::new(), motion: Some((turn, 0.1)) };
        let way = drift.way_of(&Point::new(2.0, 0.0, 0.0), 0.1);
        assert!((way.norm() - 0.2).abs() < 1e-3 && way.norm() <= drift.farthest(2.0, 0.1));
    }
}
