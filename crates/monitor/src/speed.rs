//! Speed scale: the share of its speed that the robot may have, from the distances of its bodies and their approach rates.
//!
//! Each near pair requests a share: 1 from the slow-down distance on, 0 up to the stop distance, linear between them. The distance
//! of an approaching pair is reduced by its motion in the reaction time, also from beyond the slow-down distance. A pair that moves
//! apart requests no reduction. The least share counts.
//! If the approach rate of a near pair is unknown, the share does not rise, except for a first state, which counts as at rest.
//! The share falls once a number of states in a row, the trigger count, request less: to the largest of their requests. It rises
//! once a number of states, the release count, request more: to the least of their requests. If the status is not FREE, it is 0 at
//! once.

use clearance_checker::{CollisionChecker, PairDistance};
use clearance_geometry::math::Extremes;
use clearance_scene::BodyId;
use std::collections::VecDeque;
use std::sync::Arc;

use super::approach::{OtherTime, a_moment_later, approach_rate};
use super::{CheckedState, Status, Time};

/// Approach rates below this (m/s) count as at rest: velocities are noisy.
const REST: f64 = 1e-3;

/// Slow-down and stop distance (m).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpeedDistances {
    /// Distance from which the robot is slowed down; 0: never, unless bodies touch.
    pub slowdown: f64,
    /// Distance from which it has to stop.
    pub stop: f64,
}

/// User settings of the speed scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedSettings {
    /// Distances between bodies of the robot.
    pub own: SpeedDistances,
    /// Distances between the robot and its surroundings.
    pub world: SpeedDistances,
    /// Time (s) for which an approach is assumed to continue at the same rate.
    pub reaction_time: f64,
    /// Number of states in a row after which the robot slows down.
    pub trigger_count: u32,
    /// Number of states in a row after which it speeds up.
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
    /// Distance (m) up to which pairs have to be known.
    #[must_use]
    pub(super) fn reach(&self) -> f64 {
        self.own.reach().greater(self.world.reach())
    }
}

impl SpeedDistances {
    /// Distance (m) beyond which a pair at rest causes no reduction.
    fn reach(self) -> f64 {
        self.slowdown.greater(self.stop)
    }

    /// Share that a pair requests which approaches at `rate` (m/s), if that is known.
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

/// Computes the speed scale from successive states.
#[derive(Debug, Default)]
pub(super) struct SpeedGovernor {
    /// Shares that the last states requested, the newest at the end.
    asked: VecDeque<f64>,
    share: f64,
    /// The last state and its stamp.
    last: Option<(Time, Arc<CheckedState>)>,
}

impl SpeedGovernor {
    /// Current share, in [0, 1].
    pub fn share(&self) -> f64 {
        self.share
    }

    /// Sets the share to 0: the status is not FREE.
    pub fn stop(&mut self) {
        self.asked.clear();
        self.share = 0.0;
    }

    /// Removes the last poses when the robot changes.
    pub fn forget_poses(&mut self) {
        self.last = None;
    }

    /// Updates the share with an evaluated state.
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
        // without a near pair, no poses at another time are needed
        let other = near
            .peek()
            .and_then(|_| a_moment_later(checker.robot(), checked_state).or_else(|| self.before(stamp)));
        let (mut asked, mut are_known) = (1.0_f64, true);
        for pair in near {
            let rate = other.as_ref().and_then(|other| approach_rate(checker, pair, checked_state, other));
            // a pair beyond that distance requests no reduction even if its rate is unknown
            are_known &= rate.is_some() || pair.distance > distances_of(pair, settings).reach();
            asked =
                asked.lesser(distances_of(pair, settings).share(pair.distance, rate, settings.reaction_time));
        }
        let is_new = stamp.zip(self.last.as_ref()).is_none_or(|(stamp, (last, _))| stamp != *last);
        // a state that is evaluated again, or with unknown approach rates, never raises the share; a first state has distances only
        if (is_new && (are_known || self.last.is_none())) || asked < self.share {
            self.follow(asked, settings);
        }
        // of states with the same stamp the first is kept: later motion is measured from it
        if is_new {
            self.last = stamp.map(|stamp| (stamp, Arc::clone(checked_state)));
        }
    }

    /// The link poses of the last state, if it is older than this one.
    fn before(&self, stamp: Option<Time>) -> Option<OtherTime> {
        let (last, checked_state) = self.last.as_ref()?;
        let after = last.seconds_since(stamp?);
        (after < 0.0).then(|| OtherTime { poses: checked_state.poses.clone(), after })
    }

    /// Updates the share with the requested one.
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
            // 0.1 s at 0.5 m/s
            (0.2, Some(0.5), 0.25),
            (0.2, Some(2.0), 0.0),
            // a pair that moves apart is never slowed down
            (0.2, Some(-0.1), 1.0),
            (0.01, Some(-0.1), 1.0),
            // beyond the slow-down distance: pairs that will soon be within it
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
        // a stop distance larger than the slow-down distance makes a step
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
