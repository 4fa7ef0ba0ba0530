//! History of evaluated configurations, divided into nearly straight legs of the past motion.

use std::collections::VecDeque;

use clearance_geometry::math::{Extremes, without_whole_turns};

use super::Time;

/// Length of the history (s), and the shortest time (s) between two stored configurations.
const LONGEST: f64 = 3.0;
const STEP: f64 = 0.005;

/// Deviation (rad, m) from a straight motion above which a leg is divided.
const STRAIGHT: f64 = 1e-3;

/// Largest number of legs; more are replaced by fewer with larger deviations.
const MOST_LEGS: usize = 128;

/// Configurations by their stamps, oldest first. Positions that turn without limits are not wrapped.
#[derive(Debug, Default)]
pub(super) struct PastStates {
    states: VecDeque<(Time, Vec<f64>)>,
}

/// A part of the way as a straight motion, between two times (s) before the last configuration.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Leg {
    pub before: [f64; 2],
    pub ends: [Vec<f64>; 2],
}

impl Leg {
    /// Its duration (s).
    pub fn duration(&self) -> f64 {
        self.before[0] - self.before[1]
    }
}

impl PastStates {
    /// Adds a configuration; `turns`: by position, whether full turns make no difference.
    pub fn note(&mut self, stamp: Time, positions: &[f64], turns: &[bool]) {
        let since = self.states.back().map_or(f64::INFINITY, |(last, _)| stamp.seconds_since(*last));
        if since < 0.0 {
            self.states.clear();
        }
        let mut positions = positions.to_vec();
        if let Some((_, last)) = self.states.back() {
            for ((q, last), turns) in positions.iter_mut().zip(last).zip(turns) {
                *q = if *turns { last + without_whole_turns(*q - last) } else { *q };
            }
        }
        // the last one is always there; those before it are apart
        let before_last = self.states.len().checked_sub(2).map(|i| stamp.seconds_since(self.states[i].0));
        if before_last.is_some_and(|since| since < STEP) {
            self.states.pop_back();
        }
        self.states.push_back((stamp, positions));
        while self.states.front().is_some_and(|(first, _)| stamp.seconds_since(*first) > LONGEST) {
            self.states.pop_front();
        }
    }

    /// The way in a time (s) up to the last configuration, as straight motions; before the first configuration, the robot
    /// counts as standing there.
    pub fn legs(&self, time: f64) -> Vec<Leg> {
        let mut tolerance = STRAIGHT;
        loop {
            let mut legs = Vec::new();
            self.divide([time, 0.0], tolerance, &mut legs);
            if legs.len() <= MOST_LEGS {
                return legs;
            }
            tolerance *= 4.0;
        }
    }

    /// Divides a leg where a configuration deviates most from it (Douglas and Peucker 1973), until the deviations are within the
    /// tolerance (rad, m) or there are too many legs.
    fn divide(&self, before: [f64; 2], tolerance: f64, legs: &mut Vec<Leg>) {
        let ends = before.map(|before| self.at(before));
        let (deviation, at) = self.deviation(before, &ends);
        if deviation <= tolerance || legs.len() > MOST_LEGS {
            legs.push(Leg { before, ends });
            return;
        }
        self.divide([before[0], at], tolerance, legs);
        self.divide([at, before[1]], tolerance, legs);
    }

    /// Largest deviation (rad, m) of a position from the straight motion between two configurations, and its time (s) before the
    /// last configuration.
    fn deviation(&self, before: [f64; 2], [from, to]: &[Vec<f64>; 2]) -> (f64, f64) {
        let Some((last, _)) = self.states.back() else { return (0.0, 0.0) };
        let mut largest = (0.0, 0.0);
        for (stamp, q) in &self.states {
            let at = last.seconds_since(*stamp);
            let share = (before[0] - at) / (before[0] - before[1]);
            // the ends are on it
            if share > 0.0 && share < 1.0 {
                let apart = |i: usize| (from[i] + share * (to[i] - from[i]) - q[i]).abs();
                let deviation = (0..q.len()).map(apart).fold(0.0, f64::greater);
                if deviation > largest.0 {
                    largest = (deviation, at);
                }
            }
        }
        largest
    }

    /// The configuration a time (s) before the last one, between the stored ones.
    fn at(&self, before: f64) -> Vec<f64> {
        let Some((last, newest)) = self.states.back() else { return Vec::new() };
        let age = |i: usize| last.seconds_since(self.states[i].0);
        let later = (0..self.states.len()).find(|i| age(*i) <= before).unwrap_or(self.states.len() - 1);
        let Some(earlier) = later.checked_sub(1) else {
            return self.states.front().map_or_else(|| newest.clone(), |(_, first)| first.clone());
        };
        let share = (age(earlier) - before) / (age(earlier) - age(later));
        let (from, to) = (&self.states[earlier].1, &self.states[later].1);
        from.iter().zip(to).map(|(from, to)| from + share.clamp(0.0, 1.0) * (to - from)).collect()
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    fn time(milliseconds: i64) -> Time {
        Time::from_nanoseconds(milliseconds * 1_000_000)
    }

    #[test]
    fn a_steady_way_is_one_leg_also_over_a_full_turn() {
        let mut past = PastStates::default();
        for i in 0..1000 {
            let q = 0.01 * f64::from(i32::try_from(i).unwrap());
            past.note(time(10 * i), &[without_whole_turns(q), q], &[true, false]);
        }
        let legs = past.legs(1.0);
        assert_eq!(legs.len(), 1);
        let [from, to] = &legs[0].ends;
        assert!((to[0] - from[0] - 1.0).abs() < 1e-9 && (to[1] - from[1] - 1.0).abs() < 1e-9, "{legs:?}");
        assert!((to[0] - 9.99).rem_euclid(TAU).min(TAU - (to[0] - 9.99).rem_euclid(TAU)) < 1e-9);
        assert!(past.states.len() < 310, "{}", past.states.len());
    }

    #[test]
    fn a_robot_that_starts_has_stood_before() {
        let mut past = PastStates::default();
        for i in 0..100 {
            past.note(time(10 * i), &[0.0], &[false]);
        }
        for i in 0..10 {
            past.note(time(1000 + 10 * i), &[0.02 * f64::from(i32::try_from(i).unwrap())], &[false]);
        }
        let legs = past.legs(0.8);
        assert!(legs.len() > 1);
        let moved: Vec<f64> = legs.iter().map(|leg| leg.ends[1][0]).collect();
        assert!(moved[0].abs() < 1e-9 && (moved[moved.len() - 1] - 0.18).abs() < 1e-9, "{moved:?}");
        let total: f64 = legs.iter().map(Leg::duration).sum();
        assert!((total - 0.8).abs() < 1e-12);
        // beyond the history it stands
        assert_eq!(past.legs(30.0)[0].ends[0], [0.0]);
    }

    #[test]
    fn a_short_motion_there_and_back_is_on_the_way() {
        let mut past = PastStates::default();
        for i in 0..1000 {
            let q = if (700..=720).contains(&i) { 0.05 - 0.005 * (f64::from(i) - 710.0).abs() } else { 0.0 };
            past.note(time(5 * i64::from(i)), &[q], &[false]);
        }
        for age in [1.5, 2.0, 2.9, 30.0] {
            let legs = past.legs(age);
            let farthest = legs.iter().flat_map(|leg| &leg.ends).map(|q| q[0]).fold(0.0, f64::greater);
            assert!(farthest > 0.049, "{farthest} in {age} s");
            let total: f64 = legs.iter().map(Leg::duration).sum();
            assert!(legs.len() < 80 && (total - age).abs() < 1e-9, "{} legs", legs.len());
        }
    }

    #[test]
    fn a_trembling_robot_has_a_limited_number_of_legs() {
        let mut past = PastStates::default();
        for i in 0..1000 {
            past.note(time(5 * i64::from(i)), &[0.01 * f64::from(i % 2)], &[false]);
        }
        for age in [0.1, 0.8, 2.9] {
            assert!(past.legs(age).len() <= 128, "{}", past.legs(age).len());
        }
    }

    #[test]
    fn fast_states_are_thinned_and_a_clock_that_is_set_back_begins_anew() {
        let mut past = PastStates::default();
        for i in 0..5000 {
            past.note(time(i), &[f64::from(i32::try_from(i).unwrap())], &[false]);
        }
        assert!(past.states.len() < 800, "{}", past.states.len());
        assert_eq!(past.legs(0.0)[0].ends[1], [4999.0]);
        past.note(time(10), &[1.0], &[false]);
        assert_eq!(past.states.len(), 1);
    }
}
