//! Speed scale: the share of its speed that the robot may have, from the distances of its bodies and their approach
//! rates.
//!
//! Each near pair requests a share: 1 from the slow-down distance on, 0 up to the stop distance, linear between them.
//! The distance of an approaching pair is reduced by its motion in the reaction time, also from beyond the slow-down
//! distance; in this time other points than the nearest ones may come nearer. The distance to an obstacle that may move
//! is reduced by its largest motion in that time, too. A pair that the robot moves apart requests no reduction. The least
//! share counts. If the approach rate of a near pair is unknown, the share does not rise, except for a first state, which
//! counts as at rest. The share falls once a number of states in a row, the trigger count, request less: to the largest
//! of their requests. It rises once a number of states, the release count, request more: to the least of their requests.
//! If the status is not FREE, it is 0 at once.
//!
//! With speed and separation monitoring, pairs with obstacles request the share of
//! [`SeparationRules`](crate::SeparationRules) instead, unless the obstacle rests or the part of the robot
//! cannot move.

use clearance_checker::{CollisionChecker, PairDistance, Workspace};
use clearance_geometry::math::Extremes;
use clearance_robot::{RobotModel, quoted_list};
use clearance_scene::BodyId;
use std::collections::VecDeque;
use std::f64::consts::PI;
use std::sync::Arc;

use super::approach_rate::{
    ApproachTerms, PosesAtOtherTime, approach_rate, carrier, largest_approach_rate, poses_after_step,
    poses_before,
};
use super::predicted_distances::PredictedDistances;
use super::separation_settings::SeparationSettings;
use super::speed_settings::{SpeedDistances, SpeedSettings};
use super::tracked_obstacle::TrackedObstacle;
use super::{CheckedState, MonitorSettings, Separation, Status, Time};

/// Computes the speed scale from successive states.
#[derive(Debug, Default)]
pub(super) struct SpeedGovernor {
    /// Shares that the last states requested, the newest at the end.
    requested: VecDeque<f64>,
    share: f64,
    separation: Option<Separation>,
    /// The last state and its stamp.
    last: Option<(Time, Arc<CheckedState>)>,
    /// Its own workspace, so that it does not overwrite the data that speeds up the stream of states.
    workspace: Option<Workspace>,
}

impl SpeedGovernor {
    /// Current share, in [0, 1].
    pub fn share(&self) -> f64 {
        self.share
    }

    /// Separation of the pair that requests the lowest share in the last state, if it was FREE and separation is
    /// monitored.
    pub fn separation(&self) -> Option<Separation> {
        self.separation
    }

    /// Sets the share to 0: the status is not FREE.
    pub fn stop(&mut self) {
        self.requested.clear();
        self.share = 0.0;
        self.separation = None;
    }

    /// Removes the last poses when the robot changes.
    pub fn discard_poses(&mut self) {
        self.last = None;
    }

    /// Updates the share with an evaluated state.
    pub fn update(
        &mut self,
        checker: &CollisionChecker,
        status: &Status,
        checked_state: Option<&Arc<CheckedState>>,
        stamp: Option<Time>,
        settings: &MonitorSettings,
    ) {
        let (Status::Free, Some(checked_state)) = (status, checked_state) else {
            self.stop();
            self.last = stamp.zip(checked_state.cloned());
            return;
        };
        let Requests { share: requested, are_known, separation } =
            self.requests(checker, checked_state, stamp, settings);
        self.separation = separation;
        let is_new = stamp.zip(self.last.as_ref()).is_none_or(|(stamp, (last, _))| stamp != *last);
        // a state that is evaluated again, or with unknown approach rates, never raises the share; a first state has
        // distances only
        if (is_new && (are_known || self.last.is_none())) || requested < self.share {
            self.follow(requested, &settings.speed);
        }
        // of states with the same stamp the first is kept: later motion is measured from it
        if is_new {
            self.last = stamp.map(|stamp| (stamp, Arc::clone(checked_state)));
        }
    }

    /// The requests of all near pairs of a state that is FREE.
    fn requests(
        &mut self,
        checker: &CollisionChecker,
        checked_state: &CheckedState,
        stamp: Option<Time>,
        settings: &MonitorSettings,
    ) -> Requests {
        let pairs = checked_state.report.pair_distances.iter().chain(&checked_state.approaching_pairs);
        let rules = pairs.map(|pair| (pair, rule_of(pair, checker, checked_state, settings)));
        let near: Vec<_> = rules.filter(|(pair, rule)| rule.concerns(pair, checked_state)).collect();
        // without a near pair, no poses at another time are needed
        let robot = checker.robot();
        let other = near.first().and_then(|_| {
            poses_after_step(robot, checked_state).or_else(|| self.before(robot, checked_state, stamp))
        });
        let predicted = self.predicted(checker, checked_state, other.as_ref(), &near, settings);
        let mut requests = Requests::none(&settings.speed);
        for (pair, rule) in near {
            let turned = turned(pair, checker, checked_state, settings);
            let rate = |within, reached| {
                let terms = ApproachTerms { within, reached, turned };
                approach_rate(checker, pair, checked_state, other.as_ref()?, terms)
            };
            match rule {
                Rule::Nothing => {}
                Rule::Distances { distances, obstacle_motion } => {
                    let reaction_time = settings.speed.reaction_time;
                    let rate = rate(reaction_time, predicted.of(pair));
                    let share = |rate| distances.share(pair.distance, rate, reaction_time, obstacle_motion);
                    // a pair beyond that distance requests no reduction even if its rate is unknown
                    let matters = pair.distance <= distances.reach() + obstacle_motion;
                    requests.add(share(rate), rate.is_some() || !matters);
                }
                Rule::Separation(separation) => {
                    let other = other.as_ref();
                    let largest = other
                        .and_then(|other| largest_approach_rate(checker, pair, checked_state, other, turned));
                    requests.add_separation(pair, [rate(0.0, None), largest], &separation);
                }
            }
        }
        requests
    }

    /// The link poses of the last state, if it is older than this one.
    fn before(
        &self,
        robot: &RobotModel,
        checked_state: &CheckedState,
        stamp: Option<Time>,
    ) -> Option<PosesAtOtherTime> {
        let (last, before) = self.last.as_ref()?;
        let after = last.seconds_since(stamp?);
        (after < 0.0).then(|| poses_before(robot, checked_state, before, after))
    }

    /// The least distances in the reaction time, for pairs whose share is by distances.
    fn predicted(
        &mut self,
        checker: &CollisionChecker,
        checked_state: &CheckedState,
        other: Option<&PosesAtOtherTime>,
        near: &[(&PairDistance, Rule)],
        settings: &MonitorSettings,
    ) -> PredictedDistances {
        let by_distances = near.iter().filter(|(_, rule)| matches!(rule, Rule::Distances { .. }));
        let pairs: Vec<&PairDistance> = by_distances.map(|(pair, _)| *pair).collect();
        let Some(other) = other.filter(|_| !pairs.is_empty()) else { return PredictedDistances::default() };
        let workspace = self.workspace.get_or_insert_with(|| checker.workspace());
        let time = settings.speed.reaction_time;
        PredictedDistances::within(checker, checked_state, other, &pairs, time, workspace)
    }

    /// Updates the share with the requested one.
    fn follow(&mut self, requested: f64, settings: &SpeedSettings) {
        let [trigger, release] =
            [settings.trigger_count, settings.release_count].map(|count| count.max(1) as usize);
        self.requested.push_back(requested);
        while self.requested.len() > trigger.max(release) {
            self.requested.pop_front();
        }
        let latest = |count: usize| {
            (self.requested.len() >= count).then(|| self.requested.iter().rev().take(count).copied())
        };
        let most = latest(trigger).map(|requested| requested.fold(0.0, f64::greater));
        let least = latest(release).map(|requested| requested.fold(1.0, f64::lesser));
        self.share = match (most, least) {
            (Some(most), _) if most < self.share => most,
            (_, Some(least)) if least > self.share => least,
            _ => self.share,
        };
    }
}

/// Least share that pairs of one state request.
struct Requests {
    share: f64,
    /// Whether the approach rates that matter are known.
    are_known: bool,
    separation: Option<Separation>,
}

impl Requests {
    /// No pair is near.
    fn none(settings: &SpeedSettings) -> Self {
        let separation = settings.separation.as_ref().map(|rules| Separation::out_of_range(&rules.usual));
        Self { share: 1.0, are_known: true, separation }
    }

    /// Adds the share of a pair, and whether its approach rate is known or does not matter.
    fn add(&mut self, share: f64, is_known: bool) {
        self.are_known &= is_known;
        self.share = self.share.lesser(share);
    }

    /// Adds a pair whose separation is monitored, with the rates of its nearest points and of any points. An unknown
    /// rate counts as the largest one.
    fn add_separation(
        &mut self,
        pair: &PairDistance,
        rates: [Option<f64>; 2],
        settings: &SeparationSettings,
    ) {
        let separation = Separation::of_pair(settings, (pair.a, pair.b), pair.distance, rates);
        self.share = self.share.lesser(separation.share);
        self.separation = Some(self.separation.map_or(separation, |lowest| lowest.lower(separation)));
    }
}

/// Rule for the share that one pair requests.
enum Rule {
    /// The pair requests no reduction.
    Nothing,
    /// Slow-down and stop distance; the other body moves by at most `obstacle_motion` (m) on its own.
    Distances {
        distances: SpeedDistances,
        obstacle_motion: f64,
    },
    Separation(SeparationSettings),
}

impl Rule {
    /// Whether the pair may request a reduction.
    fn concerns(&self, pair: &PairDistance, checked_state: &CheckedState) -> bool {
        let reach = match self {
            Self::Nothing => return false,
            Self::Distances { distances, .. } => distances.reach(),
            Self::Separation(separation) => separation.range(),
        };
        reach > 0.0 && pair.distance <= reach.greater(checked_state.slowdown_range) || pair.distance <= 0.0
    }
}

fn rule_of(
    pair: &PairDistance,
    checker: &CollisionChecker,
    checked_state: &CheckedState,
    settings: &MonitorSettings,
) -> Rule {
    let speed = &settings.speed;
    let (body, obstacle) = match (pair.a, pair.b) {
        (BodyId::Obstacle(_), body) => (body, pair.a),
        (body, BodyId::Obstacle(_)) => (body, pair.b),
        _ => return Rule::Distances { distances: speed.own, obstacle_motion: 0.0 },
    };
    let name = checker.body_name(obstacle);
    let tracked = checked_state.tracked_obstacles.of(name);
    let by_distances = |obstacle_motion| Rule::Distances { distances: speed.world, obstacle_motion };
    let Some(rules) = &speed.separation else {
        let approach = tracked.map(|tracked| tracked.approach(pair, checker, checked_state, settings));
        return by_distances(
            approach.unwrap_or_else(|| settings.obstacle_motion(name, checked_state.spread)),
        );
    };
    // what was measured to be faster is faster
    let measured = tracked.map(|tracked| tracked.speed(checker, &checked_state.poses, settings));
    let moved =
        |tracked: &TrackedObstacle| tracked.displacement_since_pose(pair, checker, checked_state, settings);
    match rules.of_measured(name, measured.filter(|speed| *speed > 0.0)) {
        None => by_distances(0.0),
        // where the root stays in place, a body that is fixed to it cannot approach
        Some(_) if checked_state.obstacle_motions.is_empty() && is_fixed(checker, body) => Rule::Nothing,
        Some(separation) => {
            let margin = separation.margin + tracked.map_or(0.0, moved);
            Rule::Separation(SeparationSettings { margin, ..separation })
        }
    }
}

/// Angle (rad) by which the obstacle of a pair may lie in another direction than the one from its pose: it has moved since, and may
/// have passed.
fn turned(
    pair: &PairDistance,
    checker: &CollisionChecker,
    checked_state: &CheckedState,
    settings: &MonitorSettings,
) -> f64 {
    let obstacle = [pair.a, pair.b].into_iter().find(|body| matches!(body, BodyId::Obstacle(_)));
    let tracked = obstacle.and_then(|body| checked_state.tracked_obstacles.of(checker.body_name(body)));
    let Some(tracked) = tracked else { return 0.0 };
    let moved = tracked.displacement_since_pose(pair, checker, checked_state, settings);
    if moved < pair.distance { (moved / pair.distance).asin() } else { PI }
}

/// Warning about speeds of obstacles that the world does not have.
pub(super) fn speeds_without_effect(
    checker: &CollisionChecker,
    settings: &MonitorSettings,
) -> Option<String> {
    let rules = settings.speed.separation.as_ref()?;
    let unknown = rules
        .speeds_without_effect(|matches| checker.world().obstacles().any(|obstacle| matches(&obstacle.name)));
    (!unknown.is_empty())
        .then(|| format!("ssm_obstacle_speeds: the world has no obstacle {}", quoted_list(&unknown)))
}

/// Whether no joint moves this body.
fn is_fixed(checker: &CollisionChecker, body: BodyId) -> bool {
    let robot = checker.robot();
    carrier(checker, body).is_some_and(|link| robot.same_rigid_body(link, robot.root()))
}

#[cfg(test)]
mod tests {
    #![expect(clippy::float_cmp, reason = "0 and 1 are said exactly")]

    use proptest::prelude::*;

    use super::*;
    use crate::speed_settings::REST;

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
            // a robot that moves away is never slowed down
            (0.2, Some(-0.1), 1.0),
            (0.01, Some(-0.1), 1.0),
            // beyond the slow-down distance: pairs that will soon be within it
            (0.31, Some(0.0), 1.0),
            (0.31, Some(2.0), 0.05),
            (0.6, Some(2.0), 1.0),
        ] {
            let found = DISTANCES.share(distance, rate, 0.1, 0.0);
            assert!((found - share).abs() < 1e-12, "{distance} m, {rate:?} m/s: {found}");
        }
    }

    #[test]
    fn without_distances_only_contact_stops() {
        let off = SpeedDistances::default();
        assert_eq!(off.share(0.0, None, 0.1, 0.0), 0.0);
        assert_eq!(off.share(1e-6, Some(5.0), 0.1, 0.5), 1.0);
        // a stop distance larger than the slow-down distance makes a step
        let step = SpeedDistances { slowdown: 0.1, stop: 0.2 };
        assert_eq!([step.share(0.2, None, 0.1, 0.0), step.share(0.21, None, 0.1, 0.0)], [0.0, 1.0]);
    }

    fn following(trigger_count: u32, release_count: u32, requested: &[f64]) -> Vec<f64> {
        let settings = SpeedSettings { trigger_count, release_count, ..SpeedSettings::default() };
        let mut speed_governor = SpeedGovernor::default();
        requested
            .iter()
            .map(|&requested| {
                speed_governor.follow(requested, &settings);
                speed_governor.share()
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
        let mut speed_governor = SpeedGovernor::default();
        for (stop, share) in [(false, 0.0), (false, 1.0), (true, 0.0), (false, 0.0), (false, 1.0)] {
            if stop {
                speed_governor.stop();
            } else {
                speed_governor.follow(1.0, &settings);
            }
            assert_eq!(speed_governor.share(), share);
        }
    }

    proptest! {
        #[test]
        fn nearer_and_faster_is_never_freer(
            distance in 0.0..1.0f64, nearer in 0.0..1.0f64, rate in 0.0..5.0f64, faster in 0.0..5.0f64,
            slowdown in 0.0..1.0f64, stop in 0.0..1.0f64, reaction_time in 0.0..1.0f64, obstacle_motion in 0.0..0.5f64,
        ) {
            let distances = SpeedDistances { slowdown, stop };
            let share = |distance, rate| distances.share(distance, Some(rate), reaction_time, obstacle_motion);
            let here = share(distance, rate);
            prop_assert!((0.0..=1.0).contains(&here));
            prop_assert!(share(distance * nearer, rate) <= here);
            prop_assert!(share(distance, rate + faster) <= here);
            prop_assert_eq!(share(distance, -REST - rate - 1e-9), 1.0);
        }

        #[test]
        fn the_share_stays_among_what_was_asked_and_settles_on_it(
            requested in prop::collection::vec(0.0..1.0f64, 1..40), last in 0.0..1.0f64,
            trigger in 1..6u32, release in 1..6u32,
        ) {
            let most = requested.iter().copied().fold(0.0, f64::greater);
            let mut requested = requested;
            let begun = following(trigger, release, &requested);
            prop_assert!(begun.iter().all(|share| (0.0..=most).contains(share)));
            requested.extend([last; 6]);
            let followed = following(trigger, release, &requested);
            prop_assert_eq!(followed.last(), Some(&last));
        }

        #[test]
        fn a_single_state_changes_nothing_where_two_are_needed(share in 0.0..1.0f64, odd in 0.0..1.0f64) {
            let requested = [share, share, odd, share, share];
            prop_assert!(following(2, 2, &requested)[1..].iter().all(|found| *found == share));
        }
    }
}
