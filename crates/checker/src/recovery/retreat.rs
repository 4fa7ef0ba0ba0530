//! The joint velocity that reduces the penetration fastest.
//!
//! The penetration of a state is the depth of the deepest pair. Its derivative along a velocity is the least over the pairs that are
//! deepest (Danskin's theorem), so the fastest velocity of length one is the nearest point to zero of the convex hull of their
//! gradients, normalized. It is found as by Frank & Wolfe (1956).

use clearance_proximity::UnknownDepth;
use clearance_robot::Configuration;
use clearance_scene::BodyId;

use super::recovery_options::RecoveryOptions;
use super::search_space::ranges;
use crate::clearance::{Clearance, PairClearance};
use crate::collision_checker::CollisionChecker;
use crate::workspace::Workspace;

/// Pairs are equally deep if their depths differ by at most this (m).
const EQUAL_DEPTH: f64 = 1e-6;

/// A position this near (rad, m) to a limit is at the limit.
const AT_LIMIT: f64 = 1e-9;

/// A velocity of length one that changes the depth by less than this (m) does not reduce it.
const LEAST_RATE: f64 = 1e-9;

/// Number of steps to the nearest point of a convex hull.
const STEPS: usize = 200;

/// How a state gets out of collision.
#[derive(Clone, Debug, PartialEq)]
pub enum Retreat {
    /// Nothing collides.
    Free,
    /// This velocity reduces the penetration.
    Direction(RetreatDirection),
    /// No velocity of the joints that may move reduces the depth of this pair, the deepest one, or of all pairs that are equally deep.
    Stuck((BodyId, BodyId)),
    /// No colliding pair has a known depth: the first one, and the reason.
    UnknownDepth((BodyId, BodyId), Option<UnknownDepth>),
}

/// The unit joint velocity that reduces the penetration fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct RetreatDirection {
    /// One velocity for each position (rad/s, m/s); the sum of their squares is 1. Of a planar joint as for its positions.
    pub velocities: Vec<f64>,
    /// Rate (m/s) at which the penetration falls.
    pub rate: f64,
    /// The deepest pair.
    pub pair: (BodyId, BodyId),
    /// Its depth (m): after a translation by this length the pair is proven apart.
    pub depth: f64,
    /// Number of colliding pairs whose depth is not known; the direction does not consider them.
    pub pairs_without_depth: usize,
}

pub fn retreat_direction(
    checker: &CollisionChecker,
    q: &Configuration,
    options: &RecoveryOptions,
    workspace: &mut Workspace,
) -> Retreat {
    let clearance = checker.clearance(q, 0.0, workspace);
    let overlapping = || clearance.pairs.iter().enumerate().filter(|(_, pair)| pair.distance <= 0.0);
    let bodies = |pair: &PairClearance| (pair.a, pair.b);
    let known = || overlapping().filter(|(_, pair)| pair.normal.is_some());
    let Some((_, first)) = overlapping().next() else { return Retreat::Free };
    let Some((_, deepest)) = known().min_by(|(_, a), (_, b)| a.distance.total_cmp(&b.distance)) else {
        return Retreat::UnknownDepth(bodies(first), first.unknown);
    };
    let allowed = Allowed::new(checker, q, options);
    let equal = known().filter(|(_, pair)| pair.distance <= deepest.distance + EQUAL_DEPTH);
    let rows: Vec<Vec<f64>> = equal.map(|(index, _)| allowed.masked(&clearance, index)).collect();
    match fastest(&rows, &allowed) {
        Some((velocities, rate)) => Retreat::Direction(RetreatDirection {
            velocities,
            rate,
            pair: bodies(deepest),
            depth: -deepest.distance,
            pairs_without_depth: overlapping().count() - known().count(),
        }),
        None => Retreat::Stuck(bodies(deepest)),
    }
}

/// The velocities that are allowed: none of joints that stay, none beyond a limit.
struct Allowed {
    movable: Vec<bool>,
    /// By position: whether it may fall, and whether it may rise.
    ways: Vec<[bool; 2]>,
}

impl Allowed {
    fn new(checker: &CollisionChecker, q: &Configuration, options: &RecoveryOptions) -> Self {
        let ranges = ranges(checker.robot(), q.positions());
        let way = |([low, high], q): (&[f64; 2], &f64)| [q - low > AT_LIMIT, high - q > AT_LIMIT];
        Self {
            movable: options.movable(checker.robot()),
            ways: ranges.iter().zip(q.positions()).map(way).collect(),
        }
    }

    /// The gradient of a pair, with zeros for positions that stay.
    fn masked(&self, clearance: &Clearance, pair: usize) -> Vec<f64> {
        let row = clearance.row(pair).iter().zip(&self.movable);
        row.map(|(entry, movable)| if *movable { *entry } else { 0.0 }).collect()
    }

    /// The nearest allowed velocity.
    fn projected(&self, velocity: &[f64]) -> Vec<f64> {
        let each = velocity.iter().zip(&self.ways);
        each.map(|(v, [falls, rises])| if (*v < 0.0 && !falls) || (*v > 0.0 && !rises) { 0.0 } else { *v })
            .collect()
    }
}

/// The allowed velocity of length one for which the least product with a row is largest, and this product.
fn fastest(rows: &[Vec<f64>], allowed: &Allowed) -> Option<(Vec<f64>, f64)> {
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut combined = rows.first()?.clone();
    if rows.len() > 1 {
        for step in 0..STEPS {
            let velocity = allowed.projected(&combined);
            let slowest =
                rows.iter().min_by(|a, b| product(a, &velocity).total_cmp(&product(b, &velocity)))?;
            #[allow(clippy::cast_precision_loss)] // few steps
            let share = 2.0 / (step as f64 + 2.0);
            for (entry, target) in combined.iter_mut().zip(slowest) {
                *entry += share * (target - *entry);
            }
        }
    }
    let velocity = super::search_space::normalized(allowed.projected(&combined))?;
    let rate = rows.iter().map(|row| product(row, &velocity)).min_by(f64::total_cmp)?;
    (rate > LEAST_RATE).then_some((velocity, rate))
}
