//! How what stands in the room moves past the robot while its root drives.

use std::collections::VecDeque;

use clearance_geometry::math::{Point, Pose, Vector};
use clearance_scene::is_elsewhere;

use super::Time;

/// Time (s) that a motion is measured over at least: `tf` comes in steps.
const WINDOW: f64 = 0.1;

/// Where a frame was in its parent lately, whenever `tf` told of it.
#[derive(Clone, Debug, Default)]
pub(super) struct Track {
    /// By stamp; the first, if there are several, is a window before the last or all that is known.
    places: VecDeque<(Time, Pose)>,
}

impl Track {
    /// `tf` has it there. What it does not tell anew says nothing about how it moves.
    pub fn note(&mut self, stamp: Time, pose_pf: Pose) {
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

    /// Where it was before, and how long (s) ago, if it is elsewhere now.
    pub fn before(&self) -> Option<(&Pose, f64)> {
        let ((from, before), (to, now)) = self.places.front().zip(self.places.back())?;
        is_elsewhere(before, now).then(|| (before, to.seconds_since(*from)))
    }
}

/// What stands in a frame moves with it past the root.
#[derive(Clone, Debug, PartialEq)]
pub struct Drift {
    pub frame: String,
    /// Ways of its points in the root's frame, each by something else that moves, and how long (s) each took; none: it stands still.
    pub(super) motions: Vec<(Pose, f64)>,
}

impl Drift {
    #[must_use]
    pub fn is_none(&self) -> bool {
        self.motions.is_empty()
    }

    /// The way (m) of what is at a point, if it goes on like this for some time (s).
    #[must_use]
    pub fn way_of(&self, point_r: &Point, time: f64) -> Vector {
        self.motions.iter().map(|(way, taken)| (way * point_r - point_r) * (time / taken)).sum()
    }

    /// The most (m) that a point as far (m) from the root moves, if it goes on like this for some time (s).
    #[must_use]
    pub fn farthest(&self, radius: f64, time: f64) -> f64 {
        let of = |(way, taken): &(Pose, f64)| {
            (way.translation.vector.norm() + way.rotation.angle() * radius) * (time / taken)
        };
        self.motions.iter().map(of).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tracked(places: impl IntoIterator<Item = (i64, f64)>) -> Drift {
        let mut track = Track::default();
        for (milliseconds, x) in places {
            track.note(Time::from_nanoseconds(milliseconds * 1_000_000), Pose::translation(x, 0.0, 0.0));
        }
        let moved = track
            .before()
            .map(|(before, taken)| (track.places[track.places.len() - 1].1 * before.inverse(), taken));
        Drift { frame: "map".to_owned(), motions: moved.into_iter().collect() }
    }

    /// Looked at every 5 ms; told of every 20 or 200 ms.
    #[test]
    fn a_motion_in_steps_is_measured_over_a_while() {
        for (looks_a_step, first) in [(4, 30), (40, 40)] {
            let step = 5 * looks_a_step;
            for end in first..200 {
                let at = |i: i64| (i / looks_a_step) * step;
                #[expect(clippy::cast_precision_loss, reason = "seconds")]
                let steps = (0..=end).map(|i| (at(i), -1e-3 * at(i) as f64));
                let way = tracked(steps).way_of(&Point::new(3.0, 0.0, 0.0), 0.5);
                assert!((way.x + 0.5).abs() < 1e-9 && way.y == 0.0, "{way} after {end} looks");
            }
        }
    }

    #[test]
    fn what_stands_still_or_was_seen_once_does_not_drift() {
        assert!(tracked([(0, 1.0)]).is_none());
        assert!(tracked((0..100).map(|i| (10 * i, 1.0))).is_none());
        assert!(tracked([(0, 0.0), (10, 1.0), (20, 1.0), (500, 1.0), (700, 1.0)]).is_none());
        // a clock that is set back begins anew
        assert!(tracked([(10, 0.0), (5, 1.0)]).is_none());
    }

    #[test]
    fn a_turn_moves_what_is_far_away() {
        let turn = clearance_geometry::math::pose_from_xyz_rpy([0.0; 3], [0.0, 0.0, 0.1]);
        let drift = Drift { frame: String::new(), motions: vec![(turn, 0.1)] };
        let way = drift.way_of(&Point::new(2.0, 0.0, 0.0), 0.1);
        assert!((way.norm() - 0.2).abs() < 1e-3 && way.norm() <= drift.farthest(2.0, 0.1));
    }
}
