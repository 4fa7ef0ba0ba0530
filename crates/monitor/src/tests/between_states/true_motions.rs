//! Tests of the check between states on random motions, compared with dense samples of the true motions.

use clearance_geometry::math::{Extremes, Vector};

use super::*;

/// Deterministic numbers in [0, 1).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        #[expect(clippy::cast_precision_loss, reason = "53 bits")]
        let number = (self.0 >> 11) as f64 / (1_u64 << 53) as f64;
        number
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}

/// A true motion of `turn` and `lift`, with a bound (rad/s², m/s²) on its acceleration.
struct TrueMotion {
    amplitude: [f64; 2],
    frequency: [f64; 2],
    phase: [f64; 2],
}

impl TrueMotion {
    fn random(numbers: &mut Numbers) -> Self {
        Self {
            amplitude: [numbers.between(0.1, 1.0), numbers.between(0.1, 0.5)],
            frequency: [numbers.between(2.0, 30.0), numbers.between(1.0, 10.0)],
            phase: [numbers.between(0.0, 6.3), numbers.between(0.0, 6.3)],
        }
    }

    fn at(&self, seconds: f64) -> [f64; 2] {
        [0, 1].map(|i| self.amplitude[i] * (self.frequency[i] * seconds + self.phase[i]).sin())
    }

    fn acceleration(&self) -> f64 {
        let of = |i: usize| self.amplitude[i] * self.frequency[i] * self.frequency[i];
        of(0).greater(of(1))
    }

    /// Least distance (m) of the ball's surface from the wall in an interval, from many samples.
    fn least_distance(&self, [from, to]: [f64; 2]) -> f64 {
        let distance = |i: u32| {
            let [turn, lift] = self.at(from + (to - from) * f64::from(i) / 400.0);
            let beyond = [turn.cos() - 1.0, turn.sin(), lift];
            let gap = [0, 1, 2].map(|i| (beyond[i].abs() - WALL[i] / 2.0).greater(0.0));
            Vector::from(gap).norm() - RADIUS
        };
        (0..=400).map(distance).fold(f64::INFINITY, f64::lesser)
    }
}

/// Counts over many intervals.
#[derive(Debug, Default)]
struct Counts {
    intervals: u32,
    true_passes: u32,
    missed: u32,
    passed_through: u32,
    without_pass: u32,
    unproven_without_pass: u32,
}

/// Evaluates streams of random motions, and compares them with the true motions.
fn compare(streams: u32, joint_noise: f64, is_bounded: bool) -> Counts {
    let (mut numbers, mut counts) = (Numbers(7), Counts::default());
    for stream in 0..streams {
        let motion = TrueMotion::random(&mut numbers);
        let rate = [25.0, 50.0, 200.0, 1000.0][stream as usize % 4];
        let between_states_acceleration = if is_bounded { motion.acceleration() } else { 0.0 };
        let mut monitor = sweeper(MonitorSettings { joint_noise, between_states_acceleration, ..settings() });
        for step in 0..8 {
            let seconds = f64::from(step) / rate;
            let mut noise = || numbers.between(-joint_noise, joint_noise);
            let [turn, lift] = motion.at(seconds).map(|q| q + noise());
            let evaluation = monitor.on_joint_state(turned(seconds, turn, lift), at(seconds));
            let interval = [seconds - 1.0 / rate, seconds];
            if step == 0 || why(&evaluation).contains("collides itself") {
                continue;
            }
            let least = motion.least_distance(interval);
            let is_claimed_free = evaluation.motion_since_previous == MotionSincePrevious::ProvenFree;
            counts.intervals += 1;
            counts.true_passes += u32::from(least <= 0.0);
            counts.missed += u32::from(least <= 0.0 && is_claimed_free);
            counts.passed_through += u32::from(is_proven(&evaluation));
            counts.without_pass += u32::from(least > 0.0);
            counts.unproven_without_pass += u32::from(least > 0.0 && !is_claimed_free);
        }
    }
    counts
}

#[test]
fn no_pass_of_the_true_motion_is_missed() {
    let counts = compare(1000, 0.0, true);
    assert!(counts.true_passes > 200 && counts.passed_through > 100, "{counts:?}");
    assert_eq!(counts.missed, 0, "{counts:?}");
}

#[test]
fn a_tube_of_one_milliradian_leaves_few_motions_open() {
    let counts = compare(1000, 1e-3, false);
    assert!(counts.true_passes > 200, "{counts:?}");
    assert_eq!(counts.missed, 0, "{counts:?}");
    assert!(100 * counts.unproven_without_pass <= counts.without_pass, "{counts:?}");
}

/// By hand: `cargo test --release -p clearance-monitor -- --ignored --nocapture many_streams`.
#[test]
#[ignore = "takes minutes"]
fn many_streams() {
    for (noise, is_bounded) in [(0.0, true), (1e-3, true), (1e-3, false)] {
        let counts = compare(100_000, noise, is_bounded);
        println!("noise {noise}, acceleration bounded: {is_bounded}: {counts:?}");
        assert_eq!(counts.missed, 0, "{counts:?}");
    }
}
