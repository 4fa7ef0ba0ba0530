//! Search for a colliding and a free state of a pair: random states, then descent of the distance.

use fastrand::Rng;

use crate::options::MatrixOptions;
use crate::pair_problem::{PairProblem, PairWorkspace};

/// Random states, and more for each variable.
const SAMPLES: [usize; 2] = [128, 128];

/// Random states from which the distance descends.
const DESCENTS: usize = 24;

/// Steps of one descent.
const STEPS: usize = 40;

/// States tried when every random state collides.
const MORE_SAMPLES: usize = 4000;

/// States that were found, as values of the variables.
#[derive(Clone, Debug, Default)]
pub struct Witnesses {
    /// The links collide.
    pub colliding: Option<Vec<f64>>,
    /// The links are apart.
    pub free: Option<Vec<f64>>,
    /// Smallest distance (m) and its state.
    pub least: Option<(f64, Vec<f64>)>,
    /// Part of the random states that collide.
    pub contact_share: f64,
}

/// Searches a colliding and a free state until the options end it.
pub fn search(
    problem: &PairProblem,
    random: &mut Rng,
    options: &MatrixOptions,
    workspace: &mut PairWorkspace,
) -> Witnesses {
    let ranges = problem.ranges();
    let count = if ranges.is_empty() { 1 } else { SAMPLES[0] + SAMPLES[1] * ranges.len() };
    let mut found = Witnesses::default();
    let mut starts: Vec<(f64, Vec<f64>)> = Vec::with_capacity(count);
    let mut contacts = 0u32;
    for _ in 0..count {
        if options.is_over() {
            break;
        }
        let values = sample(&ranges, random);
        let distance = problem.rough_distance(&values, workspace);
        if distance <= problem.threshold() {
            contacts += 1;
            found.colliding.get_or_insert(values);
        } else {
            starts.push((distance, values));
        }
    }
    #[expect(clippy::cast_precision_loss, reason = "a share needs few digits")]
    let share = f64::from(contacts) / (contacts as usize + starts.len()).max(1) as f64;
    // few states say nothing about most
    found.contact_share = if contacts as usize + starts.len() == count { share } else { 0.0 };
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.free = starts.last().map(|(_, values)| values.clone());
    found.least = starts.first().cloned();
    if found.colliding.is_none() {
        for (_, values) in starts.into_iter().take(DESCENTS) {
            if options.is_over() {
                break;
            }
            let (distance, values) = descend(problem, &ranges, values, workspace);
            if distance <= problem.threshold() {
                found.colliding = Some(values);
                break;
            }
            if found.least.as_ref().is_none_or(|(least, _)| distance < *least) {
                found.least = Some((distance, values));
            }
        }
    }
    if found.free.is_none() && !ranges.is_empty() {
        let more = (0..MORE_SAMPLES).map(|_| corner_or_sample(&ranges, random));
        let mut more = more.take_while(|_| !options.is_over());
        found.free = more.find(|values| !problem.collides(values, workspace));
    }
    found
}

fn sample(ranges: &[[f64; 2]], random: &mut Rng) -> Vec<f64> {
    ranges.iter().map(|[low, high]| low + (high - low) * random.f64()).collect()
}

/// A random state; some of its variables are at their limits.
fn corner_or_sample(ranges: &[[f64; 2]], random: &mut Rng) -> Vec<f64> {
    let value = |[low, high]: &[f64; 2]| match random.u8(0..4) {
        0 => *low,
        1 => *high,
        _ => low + (high - low) * random.f64(),
    };
    ranges.iter().map(value).collect()
}

/// Descends the distance within the ranges by steps that would reach contact if the distance were linear.
fn descend(
    problem: &PairProblem,
    ranges: &[[f64; 2]],
    mut values: Vec<f64>,
    workspace: &mut PairWorkspace,
) -> (f64, Vec<f64>) {
    let mut gradient = vec![0.0; ranges.len()];
    let mut next_gradient = gradient.clone();
    let mut distance = problem.distance_and_gradient(&values, &mut gradient, workspace);
    let mut scale = 1.0;
    for _ in 0..STEPS {
        if distance <= problem.threshold() || scale < 1e-3 {
            break;
        }
        // variables at a limit do not move beyond it
        for ((slope, value), [low, high]) in gradient.iter_mut().zip(&values).zip(ranges) {
            if (*slope > 0.0 && *value <= *low) || (*slope < 0.0 && *value >= *high) {
                *slope = 0.0;
            }
        }
        let squared: f64 = gradient.iter().map(|slope| slope * slope).sum();
        if squared < 1e-12 {
            break;
        }
        let step = scale * (distance / squared).min(1.0 / squared.sqrt());
        let moved = |((value, slope), [low, high]): ((&f64, &f64), &[f64; 2])| {
            (value - step * slope).clamp(*low, *high)
        };
        let next: Vec<f64> = values.iter().zip(&gradient).zip(ranges).map(moved).collect();
        let reached = problem.distance_and_gradient(&next, &mut next_gradient, workspace);
        if reached < distance {
            (values, distance, scale) = (next, reached, (scale * 1.5f64).min(1.0));
            std::mem::swap(&mut gradient, &mut next_gradient);
        } else {
            scale *= 0.4;
        }
    }
    (distance, values)
}
