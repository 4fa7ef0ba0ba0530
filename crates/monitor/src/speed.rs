//! The share of its speed that a robot may have, from the distances of its bodies and how fast they approach.
//!
//! Each near pair asks for a share: all of it from the slow-down distance on, none of it up to the stop distance, between them
//! in proportion; what approaches counts as nearer by the way of its reaction time, also from beyond the slow-down distance, what moves away asks
//! for nothing. The least share counts.
//! Where nobody knows how fast something near approaches, the share does not rise, but for a first state, which counts as at rest.
//! It falls when so many states in a row ask for less as the trigger count says, to the most that they ask for, and rises when
//! so many as the release count says ask for more, to the least of them. Where nothing is known it is zero at once.

use clearance_checker::{CollisionChecker, PairDistance};
use clearance_geometry::math::Extremes;
use clearance_scene::BodyId;
use std::collections::VecDeque;
use std::sync::Arc;

use super::approach::{OtherTime, a_moment_later, approach_rate};
use super::{CheckedState, Status, Time};

/// Slower than this (m/s) is at rest: velocities are noisy.
const REST: f64 = 1e-3;

/// Two distances (m).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpeedDistances {
    /// From here on the robot is slowed down; 0: never, unless bodies touch.
    pub slowdown: f64,
    /// From here on it is to stop.
    pub stop: f64,
}

/// What a user decides about the speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedSettings {
    /// Between bodies of the robot.
    pub own: SpeedDistances,
    /// Between the robot and its surroundings.
    pub world: SpeedDistances,
    /// Time (s) for which what approaches goes on as fast.
    pub reaction_time: f64,
    /// States in a row that make the robot slower.
    pub trigger_count: u32,
    /// States in a row that make it faster.
    pub release_count: u32,
}

impl Default for SpeedSettings {
    fn default() -> Self {
        Self {
            own: SpeedDistances::default(),
            world: SpeedDistances::default(),
            reaction_time: 0.1,
            trigger_count: 1,
            release_count: 5,
        }
    }
}

impl SpeedSettings {
    /// The distance (m) up to which pairs have to be known.
    #[must_use]
    pub(super) fn reach(&self) -> f64 {
        self.own.reach().greater(self.world.reach())
    }
}

impl SpeedDistances {
    /// The distance (m) beyond which nothing at rest is slowed.
    fn reach(self) -> f64 {
        self.slowdown.greater(self.stop)
    }

    /// The share that a pair asks for which approaches by `rate` (m/s), if that is known.
    fn share(self, distance: f64, rate: Option<f64>, reaction_time: f64) -> f64 {
        let rate = rate.unwrap_or(0.0);
        let is_off = self.reach() == 0.0 && distance > 0.0;
        if is_off || rate < -REST {
            return 1.0;
        }
        let left = distance - rate.greater(0.0) * reaction_time;
        if left <= self.stop {
            0.0
        } else if left >= self.slowdown {
            1.0
        } else {
            (left - self.stop) / (self.slowdown - self.stop)
        }
    }
}

/// Says how fast the robot may be, state by state.
#[derive(Debug, Default)]
pub(super) struct SpeedGovernor {
    /// What the last states asked for, the newest at the end.
    asked: VecDeque<f64>,
    share: f64,
    /// The last state and its stamp.
    last: Option<(Time, Arc<CheckedState>)>,
}

impl SpeedGovernor {
    /// In [0, 1].
    pub fn share(&self) -> f64 {
        self.share
    }

    /// Nothing is known, or something touches.
    pub fn stop(&mut self) {
        self.asked.clear();
        self.share = 0.0;
    }

    /// Another robot's poses tell nothing about this one.
    pub fn forget_poses(&mut self) {
        self.last = None;
    }

    /// Heeds a state that was judged.
    pub fn heed(
        &mut self,
        checker: &CollisionChecker,
        (status, checked_state): (&Status, Option<&Arc<CheckedState>>),
        stamp: Option<Time>,
        settings: &SpeedSettings,
    ) {
        let (Status::Free, Some(checked_state)) = (status, checked_state) else {
            self.stop();
            self.last = stamp.zip(checked_state.cloned());
            return;
        };
        let near = |pair: &&PairDistance| {
            let reach = distances_of(pair, settings).reach();
            reach > 0.0 && pair.distance <= reach.greater(checked_state.slows_within) || pair.distance <= 0.0
        };
        let mut near =
            checked_state.report.pair_distances.iter().chain(&checked_state.coming).filter(near).peekable();
        // where nothing is near, nothing needs to be moved
        let other = near
            .peek()
            .and_then(|_| a_moment_later(checker.robot(), checked_state).or_else(|| self.before(stamp)));
        let (mut asked, mut are_known) = (1.0_f64, true);
        for pair in near {
            let rate = other.as_ref().and_then(|other| approach_rate(checker, pair, checked_state, other));
            // what is farther than that is known to be slow enough where its rate is not
            are_known &= rate.is_some() || pair.distance > distances_of(pair, settings).reach();
            asked =
                asked.lesser(distances_of(pair, settings).share(pair.distance, rate, settings.reaction_time));
        }
        let is_new = stamp.zip(self.last.as_ref()).is_none_or(|(stamp, (last, _))| stamp != *last);
        // what is judged once more, or approaches nobody knows how fast, is no reason to be faster; a first state has but distances
        if (is_new && (are_known || self.last.is_none())) || asked < self.share {
            self.follow(asked, settings);
        }
        // of what is as old, the first is kept: later motion is seen against it
        if is_new {
            self.last = stamp.map(|stamp| (stamp, Arc::clone(checked_state)));
        }
    }

    /// Where the links were at the last state, if that was before this one.
    fn before(&self, stamp: Option<Time>) -> Option<OtherTime> {
        let (last, checked_state) = self.last.as_ref()?;
        let after = last.seconds_since(stamp?);
        (after < 0.0).then(|| OtherTime { poses: checked_state.poses.clone(), after })
    }

    /// Lets the share follow what is asked for.
    fn follow(&mut self, asked: f64, settings: &SpeedSettings) {
        let [trigger, release] =
            [settings.trigger_count, settings.release_count].map(|count| count.max(1) as usize);
        self.asked.push_back(asked);
        while self.asked.len() > trigger.max(release) {
            self.asked.pop_front();
        }
        let latest =
            |count: usize| (self.asked.len() >= count).then(|| self.asked.iter().rev().take(count).copied());
        let most = latest(trigger).map(|asked| asked.fold(0.0, f64::greater));
        let least = latest(release).map(|asked| asked.fold(1.0, f64::lesser));
        self.share = match (most, least) {
            (Some(most), _) if most < self.share => most,
            (_, Some(least)) if least > self.share => least,
            _ => self.share,
        };
    }
}

fn distances_of(pair: &PairDistance, settings: &SpeedSettings) -> SpeedDistances {
    match (pair.a, pair.b) {
        (BodyId::Obstacle(_), _) | (_, BodyId::Obstacle(_)) => settings.world,
        _ => settings.own,
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::float_cmp, reason = "0 and 1 are said exactly")]

    use proptest::prelude::*;

    use super::*;

    const DISTANCES: SpeedDistances = SpeedDistances { slowdown: 0.3, stop: 0.1 };

    #[test]
    fn between_the_distances_the_share_is_in_proportion() {
        for (distance, rate, share) in [
            (0.5, Some(0.0), 1.0),
            (0.3, Some(0.0), 1.0),
            (0.2, Some(0.0), 0.5),
            (0.2, None, 0.5),
            (0.1, Some(0.0), 0.0),
            (0.0, None, 0.0),
            // a tenth of a second at half a metre a second
            (0.2, Some(0.5), 0.25),
            (0.2, Some(2.0), 0.0),
            // what moves away is never slowed
            (0.2, Some(-0.1), 1.0),
            (0.01, Some(-0.1), 1.0),
            // beyond the slow-down distance what will soon be within it
            (0.31, Some(0.0), 1.0),
            (0.31, Some(2.0), 0.05),
            (0.6, Some(2.0), 1.0),
        ] {
            let found = DISTANCES.share(distance, rate, 0.1);
            assert!((found - share).abs() < 1e-12, "{distance} m, {rate:?} m/s: {found}");
        }
    }

    #[test]
    fn without_distances_only_contact_stops() {
        let off = SpeedDistances::default();
        assert_eq!(off.share(0.0, None, 0.1), 0.0);
        assert_eq!(off.share(1e-6, Some(5.0), 0.1), 1.0);
        // a stop distance beyond the slow-down distance is a step
        let step = SpeedDistances { slowdown: 0.1, stop: 0.2 };
        assert_eq!([step.share(0.2, None, 0.1), step.share(0.21, None, 0.1)], [0.0, 1.0]);
    }

    fn following(trigger_count: u32, release_count: u32, asked: &[f64]) -> Vec<f64> {
        let settings = SpeedSettings { trigger_count, release_count, ..SpeedSettings::default() };
        let mut governor = SpeedGovernor::default();
        asked
            .iter()
            .map(|&asked| {
                governor.follow(asked, &settings);
                governor.share()
            })
            .collect()
    }

    #[test]
    fn so_many_states_in_a_row_as_the_counts_say_change_the_share() {
        assert_eq!(following(1, 1, &[1.0, 0.2, 0.7]), [1.0, 0.2, 0.7]);
        assert_eq!(
            following(1, 3, &[1.0, 0.9, 0.8, 0.2, 1.0, 0.6, 1.0]),
            [0.0, 0.0, 0.8, 0.2, 0.2, 0.2, 0.6]
        );
        assert_eq!(following(2, 1, &[1.0, 0.2, 1.0, 0.3, 0.2]), [1.0, 1.0, 1.0, 1.0, 0.3]);
    }

    #[test]
    fn after_a_stop_the_release_count_begins_anew() {
        let settings = SpeedSettings { release_count: 2, ..SpeedSettings::default() };
        let mut governor = SpeedGovernor::default();
        for (stop, share) in [(false, 0.0), (false, 1.0), (true, 0.0), (false, 0.0), (false, 1.0)] {
            if stop {
                governor.stop();
            } else {
                governor.follow(1.0, &settings);
            }
            assert_eq!(governor.share(), share);
        }
    }

    proptest! {
        #[test]
        fn nearer_and_faster_is_never_freer(
            distance in 0.0..1.0f64, nearer in 0.0..1.0f64, rate in 0.0..5.0f64, faster in 0.0..5.0f64,
            slowdown in 0.0..1.0f64, stop in 0.0..1.0f64, reaction_time in 0.0..1.0f64,
        ) {
            let distances = SpeedDistances { slowdown, stop };
            let share = |distance, rate| distances.share(distance, Some(rate), reaction_time);
            let here = share(distance, rate);
            prop_assert!((0.0..=1.0).contains(&here));
            prop_assert!(share(distance * nearer, rate) <= here);
            prop_assert!(share(distance, rate + faster) <= here);
            prop_assert_eq!(share(distance, -REST - rate - 1e-9), 1.0);
        }

        #[test]
        fn the_share_stays_among_what_was_asked_and_settles_on_it(
            asked in prop::collection::vec(0.0..1.0f64, 1..40), last in 0.0..1.0f64,
            trigger in 1..6u32, release in 1..6u32,
        ) {
            let most = asked.iter().copied().fold(0.0, f64::greater);
            let mut asked = asked;
            let begun = following(trigger, release, &asked);
            prop_assert!(begun.iter().all(|share| (0.0..=most).contains(share)));
            asked.extend([last; 6]);
            let followed = following(trigger, release, &asked);
            prop_assert_eq!(followed.last(), Some(&last));
        }

        #[test]
        fn a_single_state_changes_nothing_where_two_are_needed(share in 0.0..1.0f64, odd in 0.0..1.0f64) {
            let asked = [share, share, odd, share, share];
            prop_assert!(following(2, 2, &asked)[1..].iter().all(|found| *found == share));
        }
    }
}
