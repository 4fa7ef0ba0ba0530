//! Search of a near free state: random directions at growing distances, then turns of the best direction.
//!
//! A state check costs so little (a microsecond) that thousands of random states are cheaper than one penetration depth of meshes. Near a
//! smooth boundary of the free space, the free directions at twice the least distance are a cone of 60° around the shortest way out; their
//! mean is close to it.

use std::time::Instant;

use clearance_motion::MotionSegment;
use clearance_robot::Configuration;
use clearance_scene::BodyId;

use super::free_state::{FreeState, NoFreeState, Recovery};
use super::neighbourhood::Neighbourhood;
use super::recovery_options::RecoveryOptions;
use super::search_space::{SearchSpace, normalized};
use crate::collision_checker::CollisionChecker;
use crate::motion::{MotionOptions, MotionVerdict};
use crate::question::Question;
use crate::workspace::Workspace;

/// Seed of the random directions.
const SEED: u64 = 1;

/// Number of random directions at each distance, in one sweep after the other.
const DIRECTIONS: [usize; 4] = [32, 128, 512, 2048];

/// Distances of a sweep (rad, m): the first, and the ratio of two in succession.
const FIRST_DISTANCE: f64 = 0.005;
const NEXT_DISTANCE: f64 = 2.0;

/// Directions are turned by about these angles (rad), one after the other, to come nearer.
const TURNS: [f64; 3] = [0.8, 0.4, 0.2];

/// Number of turned directions that are tried at once, and how much nearer the states are than the best one.
const TURNED_DIRECTIONS: usize = 24;
const NEARER: f64 = 0.92;

/// Number of free directions at a distance that are enough.
const MOST_HITS: usize = 6;

/// How often the distance of an exit is bisected.
const BISECTIONS: usize = 8;

/// Budget of the proof that a state which was found is reached, if the search has a deadline: some 10 ms, by which it may end later.
const BUDGET: u64 = 5000;

/// Number of random states in which a pair is tried that no state near the start moves apart.
const ANYWHERE: usize = 64;

/// Number of states that are checked together.
const AT_ONCE: usize = 8;

pub struct FreeStateSearch<'s> {
    checker: &'s CollisionChecker,
    q: &'s Configuration,
    options: &'s RecoveryOptions,
    workspace: &'s mut Workspace,
    random: fastrand::Rng,
    near: Neighbourhood<'s>,
    checks: u64,
}

/// A free state, and the direction from the start to it.
struct Exit {
    direction: Vec<f64>,
    state: Configuration,
    distance: f64,
}

impl<'s> FreeStateSearch<'s> {
    pub fn new(
        checker: &'s CollisionChecker,
        q: &'s Configuration,
        options: &'s RecoveryOptions,
        workspace: &'s mut Workspace,
    ) -> Self {
        let near = Neighbourhood::new(checker, q, options.clearance, workspace);
        Self { checker, q, options, workspace, random: fastrand::Rng::with_seed(SEED), near, checks: 0 }
    }

    pub fn run(mut self) -> Recovery {
        let near = self.near_pairs();
        if near.is_empty() {
            return Recovery::AlreadyFree;
        }
        let allowed = self.options.movable(self.checker.robot());
        let mut movable = vec![false; allowed.len()];
        for pair in &near {
            let moving: Vec<usize> = self.checker.positions_between(*pair).filter(|i| allowed[*i]).collect();
            if moving.is_empty() {
                return self.none_found(Some(*pair));
            }
            for position in moving {
                movable[position] = true;
            }
        }
        self.near.restrict(&movable, self.workspace);
        let space = SearchSpace::new(self.checker.robot(), self.q, &movable);
        for (sweep, count) in DIRECTIONS.into_iter().enumerate() {
            if let Some(found) = self.sweep(&space, count) {
                return Recovery::Found(FreeState { checks: self.checks, ..found });
            }
            if sweep == 0
                && let Some(pair) = self.never_apart(&space, &near)
            {
                return self.none_found(Some(pair));
            }
        }
        self.none_found(None)
    }

    fn none_found(&self, unmoved: Option<(BodyId, BodyId)>) -> Recovery {
        let is_unfinished = unmoved.is_none() && self.is_over();
        Recovery::NoneFound(NoFreeState { unmoved, is_unfinished, checks: self.checks })
    }

    /// The pairs that collide or are nearer than the clearance.
    fn near_pairs(&mut self) -> Vec<(BodyId, BodyId)> {
        self.checks += 1;
        let limit = self.options.clearance;
        if limit == 0.0 {
            return self.checker.check(self.q, Question::Pairs, self.workspace).colliding_pairs;
        }
        let report = self.checker.check(self.q, Question::PairDistances { limit }, self.workspace);
        let near =
            report.pair_distances.iter().filter(|pair| pair.distance < limit).map(|pair| (pair.a, pair.b));
        let mut pairs = report.colliding_pairs.clone();
        pairs.extend(near.filter(|pair| !report.colliding_pairs.contains(pair)));
        pairs
    }

    fn is_over(&self) -> bool {
        self.checks >= self.options.most_checks
            || self.options.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }

    /// Searches so many random directions, at growing distances, until a free state is found.
    fn sweep(&mut self, space: &SearchSpace, count: usize) -> Option<FreeState> {
        let mut distance = FIRST_DISTANCE;
        while !self.is_over() {
            let last = distance >= self.options.largest_distance;
            let at = if last { self.options.largest_distance } else { distance };
            let directions = self.directions(space.dimension(), count);
            let hits = self.hits(space, &directions, at);
            let best = self.best_exit(space, hits, at).map(|exit| self.turned(space, exit));
            if let Some(found) = best.and_then(|exit| self.with_first_exit(space, &exit)) {
                return Some(found);
            }
            if last {
                return None;
            }
            distance *= NEXT_DISTANCE;
        }
        None
    }

    /// One of the pairs that keeps the clearance in none of many random states, however far away; `None` if the search is over.
    fn never_apart(&mut self, space: &SearchSpace, pairs: &[(BodyId, BodyId)]) -> Option<(BodyId, BodyId)> {
        if self.is_over() {
            return None;
        }
        let states: Vec<Configuration> = (0..ANYWHERE).map(|_| space.anywhere(&mut self.random)).collect();
        let keeps = |pair: (BodyId, BodyId), workspace: &mut Workspace| {
            states.iter().any(|state| self.near.pair_keeps_clearance(pair, state, workspace))
        };
        pairs.iter().copied().find(|pair| !keeps(*pair, self.workspace))
    }

    /// Directions along single positions, and random ones.
    fn directions(&mut self, dimension: usize, count: usize) -> Vec<Vec<f64>> {
        let along = (0..2 * dimension).map(|i| {
            let mut axis = vec![0.0; dimension];
            axis[i / 2] = if i % 2 == 0 { 1.0 } else { -1.0 };
            axis
        });
        let mut directions: Vec<Vec<f64>> = along.collect();
        directions.extend((0..count).filter_map(|_| normalized(self.normal_vector(dimension))));
        directions
    }

    /// A vector whose entries have about a normal distribution with variance 1.
    fn normal_vector(&mut self, dimension: usize) -> Vec<f64> {
        (0..dimension).map(|_| (0..12).map(|_| self.random.f64()).sum::<f64>() - 6.0).collect()
    }

    /// Those of the directions in which the state at a distance is free, with the clearance, up to [`MOST_HITS`].
    fn hits(&mut self, space: &SearchSpace, directions: &[Vec<f64>], distance: f64) -> Vec<Vec<f64>> {
        let mut hits = Vec::new();
        for directions in directions.chunks(AT_ONCE) {
            let states: Vec<Configuration> =
                directions.iter().map(|way| space.state(way, distance)).collect();
            let free = self.are_free(&states);
            for ((state, direction), _) in states.iter().zip(directions).zip(free).filter(|(_, free)| *free) {
                if self.near.keeps_clearance(state, self.workspace) {
                    hits.push(direction.clone());
                }
            }
            if hits.len() >= MOST_HITS {
                break;
            }
        }
        hits
    }

    /// For each state, whether it is free; false for those that are not checked before the search is over.
    fn are_free(&mut self, states: &[Configuration]) -> Vec<bool> {
        let mut free = vec![false; states.len()];
        for (states, free) in states.chunks(AT_ONCE).zip(free.chunks_mut(AT_ONCE)) {
            if self.is_over() {
                break;
            }
            for (state, free) in states.iter().zip(free) {
                *free = self.is_free(state);
            }
        }
        free
    }

    fn is_free(&mut self, state: &Configuration) -> bool {
        self.checks += 1;
        self.near.is_free(state, self.workspace)
    }

    /// Whether a state is free, with the clearance.
    fn is_clear(&mut self, state: &Configuration) -> bool {
        self.is_free(state) && self.near.keeps_clearance(state, self.workspace)
    }

    /// The nearest exit along the mean of the directions, and along one of them.
    fn best_exit(&mut self, space: &SearchSpace, hits: Vec<Vec<f64>>, distance: f64) -> Option<Exit> {
        let mean = normalized((0..space.dimension()).map(|i| hits.iter().map(|hit| hit[i]).sum()).collect());
        let of_mean = mean.filter(|_| hits.len() > 1).and_then(|mean| self.exit_along(space, mean, distance));
        let of_first = hits.into_iter().next().and_then(|hit| self.exit_along(space, hit, distance));
        [of_mean, of_first].into_iter().flatten().min_by(|a, b| a.distance.total_cmp(&b.distance))
    }

    /// A free state along a direction, as near as bisection finds it; `None` if the state at the largest distance is not free.
    fn exit_along(&mut self, space: &SearchSpace, direction: Vec<f64>, largest: f64) -> Option<Exit> {
        let mut state = Some(space.state(&direction, largest)).filter(|state| self.is_clear(state))?;
        let (mut low, mut high) = (0.0, largest);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            let nearer = space.state(&direction, middle);
            if self.is_clear(&nearer) {
                (high, state) = (middle, nearer);
            } else {
                low = middle;
            }
        }
        Some(Exit { distance: space.distance(&state), direction, state })
    }

    /// Turns the direction of an exit such that the exit comes nearer.
    fn turned(&mut self, space: &SearchSpace, mut best: Exit) -> Exit {
        for turn in TURNS {
            while !self.is_over() {
                let directions = self.turned_directions(&best.direction, turn);
                let hits = self.hits(space, &directions, NEARER * best.distance);
                match self.best_exit(space, hits, NEARER * best.distance) {
                    Some(exit) if exit.distance < best.distance => best = exit,
                    _ => break,
                }
            }
        }
        best
    }

    fn turned_directions(&mut self, direction: &[f64], turn: f64) -> Vec<Vec<f64>> {
        let dimension = direction.len();
        #[allow(clippy::cast_precision_loss)] // few positions
        let share = turn / (dimension as f64).sqrt();
        let turned = (0..TURNED_DIRECTIONS).filter_map(|_| {
            let by = self.normal_vector(dimension);
            normalized(direction.iter().zip(by).map(|(entry, by)| entry + share * by).collect())
        });
        turned.collect()
    }

    /// The free state with its first exit from collision; `None` if the motion from there on is not proven free. The limits of the
    /// search do not end this: a state that was found would be lost.
    fn with_first_exit(&mut self, space: &SearchSpace, found: &Exit) -> Option<FreeState> {
        let end = found.state.positions();
        let travel = self.checker.travel(self.q.positions(), end);
        let steps = (travel / FreeState::LONGEST_STEP).ceil().clamp(1.0, FreeState::MOST_STEPS);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // at most MOST_STEPS
        let steps = steps as u32;
        let at = |i: u32| f64::from(i) / f64::from(steps);
        let states: Vec<Configuration> = (0..=steps).map(|i| space.between(at(i), end)).collect();
        let first = u32::try_from(states.iter().position(|state| self.is_free(state))?).ok()?;
        let exit = space.between(at(first), end);
        let segment = MotionSegment::straight(self.checker.robot(), &exit, &found.state);
        let budget = if self.options.deadline.is_some() { BUDGET } else { MotionOptions::default().budget };
        let options = MotionOptions { budget, ..MotionOptions::default() };
        let report = self.checker.check_motion_with(&segment, &options, self.workspace);
        let is_proven = report.verdict == MotionVerdict::Free;
        is_proven.then(|| FreeState {
            state: found.state.clone(),
            distance: found.distance,
            exit: at(first),
            checks: self.checks,
        })
    }
}
