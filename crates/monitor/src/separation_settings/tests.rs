//! Tests of the speed and separation formulas, also by simulated stops: the robot stops before it reaches the person.

#![expect(clippy::float_cmp, reason = "0 and 1 are said exactly")]

use proptest::prelude::*;

use super::*;

/// A robot of 1 m/s that stops within 0.1 s and 0.25 m.
pub const CELL: SeparationSettings = SeparationSettings {
    human_speed: 1.6,
    robot_speed: 1.0,
    reaction_time: 0.1,
    deceleration: 2.0,
    acceleration: 4.0,
    margin: 0.2,
};

fn settings() -> impl Strategy<Value = SeparationSettings> {
    (0.0..2.5f64, 0.1..3.0f64, 0.02..0.5f64, 0.5..8.0f64, 0.5..8.0f64, 0.0..0.5f64).prop_map(
        |(human_speed, robot_speed, reaction_time, deceleration, acceleration, margin)| SeparationSettings {
            human_speed,
            robot_speed,
            reaction_time,
            deceleration,
            acceleration,
            margin,
        },
    )
}

/// Share of two points on one line.
fn share_of(settings: &SeparationSettings, distance: f64, rate: Option<f64>) -> f64 {
    settings.share(distance, rate, rate)
}

/// Published numbers, with the deceleration that follows from the stopping time.
#[test]
fn published_examples() {
    // <https://github.com/josefchen/robot-wiki>, collaborative operation modes: 0.32 + 0.10 + 0.05 + 0.95 m
    let wiki = SeparationSettings { deceleration: 1.0 / 0.1, margin: 0.95, ..CELL };
    assert!((wiki.protective_distance(1.0) - 1.42).abs() < 1e-12);
    // a lecture's cell: 0.64 + 0.10 + 0.15 + 0.20 + 0.10 + 0.05 m
    let lecture = SeparationSettings { deceleration: 1.0 / 0.3, margin: 0.20 + 0.10 + 0.05, ..CELL };
    assert!((lecture.protective_distance(1.0) - 1.24).abs() < 1e-12);
    // ISO 13855 for a robot that does not move: S = K T + C
    assert!((CELL.protective_distance(0.0) - (1.6 * 0.1 + 0.2)).abs() < 1e-12);
}

#[test]
fn the_scale_follows_the_distance() {
    // 1.6 (0.1 + 0.5) + 0.1 + 0.25 + 0.2, and 2 * 0.1² / 2
    assert!((CELL.protective_distance(1.0) - 1.51).abs() < 1e-12);
    assert!((CELL.range() - 1.52).abs() < 1e-12);
    for (distance, rate, share) in [
        (1.52, Some(0.0), 1.0),
        (0.2 + (2.3f64.powi(2) - 1.6f64.powi(2)) / 4.0, Some(0.0), 0.5),
        (0.36, Some(0.0), 0.0),
        (0.1, None, 0.0),
        // an unknown rate, and a robot at rest: the command may be the largest speed
        (0.2 + (2.3f64.powi(2) - 1.6f64.powi(2)) / 4.0, None, 0.5),
        (0.2 + (2.3f64.powi(2) - 1.6f64.powi(2)) / 4.0, Some(0.5), 0.5),
        // faster than the largest speed
        (0.2 + (2.3f64.powi(2) - 1.6f64.powi(2)) / 4.0, Some(2.0), 0.25),
        // it can move at 0.3 m/s towards the person before a lower scale takes effect, and 0.5 m/s is allowed
        (0.2 + (2.3f64.powi(2) - 1.6f64.powi(2)) / 4.0, Some(-0.1), 1.0),
        // nothing is allowed: only a robot that cannot turn round in the reaction time is not slowed
        (0.2, Some(-0.39), 0.0),
        (0.2, Some(-0.41), 1.0),
    ] {
        let found = share_of(&CELL, distance, rate);
        assert!((found - share).abs() < 1e-9, "{distance} m, {rate:?} m/s: {found}");
    }
    let unknown = SeparationSettings { acceleration: 0.0, ..CELL };
    assert_eq!(share_of(&unknown, 0.2, Some(-5.0)), 0.0, "motion away counts as rest");
}

/// Time step (s) of the simulations.
const STEP: f64 = 1e-3;

/// Least distance (m) while the robot approaches, if it brakes from `speed` the reaction time after the person was at
/// `distance`, and the person approaches all the time.
fn least_distance_of_stop(settings: &SeparationSettings, distance: f64, speed: f64) -> f64 {
    let (mut distance, mut speed, mut time) = (distance, speed, 0.0);
    while speed > 0.0 {
        let braking = if time >= settings.reaction_time { settings.deceleration * STEP } else { 0.0 };
        let after = (speed - braking).greater(0.0);
        distance -= (settings.human_speed + f64::midpoint(speed, after)) * STEP;
        (speed, time) = (after, time + STEP);
    }
    distance
}

/// A robot whose commands are scaled, and a person, on one line.
struct Encounter<'s> {
    settings: &'s SeparationSettings,
    /// Share at a distance (m) and rate (m/s).
    share: fn(&SeparationSettings, f64, f64) -> f64,
    distance: f64,
    /// Number of steps between two states, and from a state to its effect.
    period: usize,
    delay: usize,
}

impl Encounter<'_> {
    /// Least distance (m) in which the robot approached. `commands` and `walks` are shares of the largest speeds, each
    /// for the same time.
    fn least_distance(&self, commands: &[f64], walks: &[f64]) -> f64 {
        const EACH: usize = 200;
        let Self { settings, distance, .. } = *self;
        let (mut distance, mut speed, mut least) = (distance, 0.0, f64::INFINITY);
        let mut shares = Vec::new();
        for step in 0..EACH * commands.len() {
            let is_state = step % self.period == 0;
            let share = if is_state { (self.share)(settings, distance, speed) } else { shares[step - 1] };
            shares.push(share);
            let scale = step.checked_sub(self.delay).map_or(0.0, |step| shares[step]);
            let wanted = commands[step / EACH] * settings.robot_speed * scale;
            let [slower, faster] = [settings.deceleration, settings.acceleration].map(|change| change * STEP);
            let after = wanted.clamp(speed - slower, speed + faster);
            let walked = walks[step / EACH % walks.len()] * settings.human_speed * STEP;
            distance -= walked + f64::midpoint(speed, after) * STEP;
            speed = after;
            if speed > 0.0 {
                least = least.lesser(distance);
            }
        }
        least
    }
}

/// Steps that fit into the reaction time, of which the period takes this share.
fn steps(settings: &SeparationSettings, share: f64) -> (usize, usize) {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 20 to 500")]
    let count = |time: f64| (time / STEP) as usize;
    let period = count(share * settings.reaction_time).max(1);
    (period, count(settings.reaction_time).saturating_sub(period + 1))
}

/// Error of the simulation (m): the motion in a few steps.
fn tolerance(settings: &SeparationSettings) -> f64 {
    4.0 * STEP * (settings.robot_speed + settings.human_speed)
}

/// The robot keeps its speed for the reaction time after each state, so that the sum of the specification alone lets it
/// come too near.
#[test]
fn a_scale_needs_more_distance_than_one_stop() {
    let slow = SeparationSettings { human_speed: 0.0, reaction_time: 0.5, ..CELL };
    let of_one_stop = |settings: &SeparationSettings, distance: f64, _| {
        let (a, t, h) = (settings.deceleration, settings.reaction_time, settings.human_speed);
        let left = (distance - settings.margin).max(0.0);
        (((h * h + (a * t).powi(2) + 2.0 * a * left).sqrt() - a * t - h) / settings.robot_speed).min(1.0)
    };
    let (period, delay) = steps(&slow, 0.1);
    let encounter = |share| Encounter { settings: &slow, share, distance: 3.0, period, delay };
    let nearest = encounter(of_one_stop).least_distance(&[1.0; 40], &[0.0]);
    assert!(nearest < slow.margin - 0.03, "{nearest}");
    let nearest = encounter(|settings, distance, rate| share_of(settings, distance, Some(rate)))
        .least_distance(&[1.0; 40], &[0.0]);
    assert!(nearest >= slow.margin, "{nearest}");
}

proptest! {
    #[test]
    fn a_stop_at_the_protective_distance_ends_at_the_margin(settings in settings(), speed in 0.05..1.0f64) {
        let speed = speed * settings.robot_speed;
        let distance = settings.protective_distance(speed);
        let end = least_distance_of_stop(&settings, distance, speed);
        prop_assert!((end - settings.margin).abs() < tolerance(&settings), "{end}");
    }

    #[test]
    fn the_allowed_speed_solves_the_equation(settings in settings(), speed in 0.0..1.0f64) {
        let speed = speed * settings.robot_speed;
        let lag = settings.deceleration * settings.reaction_time.powi(2) / 2.0;
        let distance = settings.protective_distance(speed) + lag;
        prop_assert!((settings.allowed_speed(distance) - speed).abs() < 1e-9);
        prop_assert!(settings.allowed_speed(settings.range()) >= settings.robot_speed - 1e-9);
    }

    #[test]
    fn whatever_is_commanded_the_robot_stops_in_time(
        settings in settings(), distance in 0.0..4.0f64, share_of_period in 0.05..0.5f64,
        commands in prop::collection::vec(prop_oneof![Just(1.0), Just(-1.0), -1.0..1.0f64], 12),
        walks in prop::collection::vec(prop_oneof![3 => Just(1.0), 1 => -1.0..1.0f64], 12),
    ) {
        let (period, delay) = steps(&settings, share_of_period);
        let share = |settings: &SeparationSettings, distance, rate| share_of(settings, distance, Some(rate));
        let distance = settings.margin + distance;
        let encounter = Encounter { settings: &settings, share, distance, period, delay };
        let nearest = encounter.least_distance(&commands, &walks);
        prop_assert!(nearest >= settings.margin - tolerance(&settings), "{nearest}");
    }

    #[test]
    fn nearer_and_faster_is_never_freer(
        settings in settings(), distance in 0.0..4.0f64, nearer in 0.0..1.0f64,
        rate in -3.0..5.0f64, faster in 0.0..5.0f64,
    ) {
        let share = share_of(&settings, distance, Some(rate));
        prop_assert!((0.0..=1.0).contains(&share));
        prop_assert!(share_of(&settings, distance * nearer, Some(rate)) <= share);
        prop_assert!(share_of(&settings, distance, Some(rate + faster)) <= share);
        prop_assert_eq!(share_of(&settings, distance, None), share_of(&settings, distance, Some(0.0)));
    }
}
