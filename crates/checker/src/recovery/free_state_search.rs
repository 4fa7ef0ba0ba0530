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

/// Ways (rad, m) are not made shorter than this: where the rounding of poses decides, directions say nothing.
const SHORTEST_WAY: f64 = 1e-6;

/// How often the distance of an exit is bisected.
const BISECTIONS: usize = 8;

/// Budget of the proof that a state which was found is reached, if the search has a deadline: some 10 ms, by which it may end later.
const BUDGET: u64 = 5000;

/// The search ends when a pair keeps the clearance in none of so many random states: within the largest distance, and
/// anywhere.
const NEAR_STATES: usize = 64;
const STATES_ANYWHERE: usize = 512;

/// Lengths (rad, m) by which a way is extended beyond its first free state, in turn, until its end is proven free: right
/// at a contact, the proof may have no room.
const EXTENSIONS: [f64; 5] = [0.0, 1e-6, 1e-5, 1e-4, 1e-3];

/// Number of states after which the limits of the search are tested.
const AT_ONCE: usize = 8;

pub struct FreeStateSearch<'s> {
    checker: &'s CollisionChecker,
    q: &'s Configuration,
    options: &'s RecoveryOptions,
    workspace: &'s mut Workspace,
    random: fastrand::Rng,
    neighbourhood: Neighbourhood<'s>,
    checks: u64,
}

/// The way from the start to a free state.
struct Exit {
    direction: Vec<f64>,
    /// Length (rad, m) of the way along the direction; longer than the distance where the state is on a limit.
    length: f64,
    distance: f64,
}

impl<'s> FreeStateSearch<'s> {
    pub fn new(
        checker: &'s CollisionChecker,
        q: &'s Configuration,
        options: &'s RecoveryOptions,
        workspace: &'s mut Workspace,
    ) -> Self {
        let neighbourhood = Neighbourhood::new(checker, q, options.clearance, workspace);
        let random = fastrand::Rng::with_seed(SEED);
        Self { checker, q, options, workspace, random, neighbourhood, checks: 0 }
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
        self.neighbourhood.restrict(&movable, self.workspace);
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

    /// Searches `count` random directions at growing distances, until a free state is found.
    fn sweep(&mut self, space: &SearchSpace, count: usize) -> Option<FreeState> {
        let mut distance = FIRST_DISTANCE;
        while !self.is_over() {
            let last = distance >= self.options.largest_distance;
            let at = if last { self.options.largest_distance } else { distance };
            let directions = self.directions(space.dimension(), count);
            let hits = self.hits(space, &directions, at);
            let best = self.best_exit(space, hits, at).map(|exit| self.turned(space, exit));
            if let Some(found) = best.and_then(|exit| self.with_room(space, &exit)) {
                return Some(found);
            }
            if last {
                return None;
            }
            distance *= NEXT_DISTANCE;
        }
        None
    }

    /// One of the pairs that keeps the clearance in none of many random states, within the largest distance and anywhere.
    fn never_apart(&mut self, space: &SearchSpace, pairs: &[(BodyId, BodyId)]) -> Option<(BodyId, BodyId)> {
        let near = self.directions(space.dimension(), NEAR_STATES).into_iter();
        let mut states: Vec<Configuration> =
            near.map(|way| space.state(&way, self.random.f64() * self.options.largest_distance)).collect();
        states.extend((0..STATES_ANYWHERE).map(|_| space.anywhere(&mut self.random)));
        pairs.iter().copied().find(|pair| {
            states.iter().all(|state| {
                self.checks += 1;
                !self.is_over() && !self.neighbourhood.pair_keeps_clearance(*pair, state, self.workspace)
            })
        })
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
                if self.neighbourhood.keeps_clearance(state, self.workspace) {
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
        self.neighbourhood.is_free(state, self.workspace)
    }

    /// Whether a state is free, with the clearance.
    fn is_clear(&mut self, state: &Configuration) -> bool {
        self.is_free(state) && self.neighbourhood.keeps_clearance(state, self.workspace)
    }

    /// The nearest exit along the mean of the directions, and along one of them.
    fn best_exit(&mut self, space: &SearchSpace, hits: Vec<Vec<f64>>, distance: f64) -> Option<Exit> {
        let mean = normalized((0..space.dimension()).map(|i| hits.iter().map(|hit| hit[i]).sum()).collect());
        let of_mean = mean.filter(|_| hits.len() > 1).and_then(|mean| self.exit_along(space, mean, distance));
        let of_first = hits.into_iter().next().and_then(|hit| self.exit_along(space, hit, distance));
        [of_mean, of_first].into_iter().flatten().min_by(|a, b| a.distance.total_cmp(&b.distance))
    }

    /// A free state along a direction, as near as bisection finds it; `None` if the state at the largest length is not free.
    fn exit_along(&mut self, space: &SearchSpace, direction: Vec<f64>, largest: f64) -> Option<Exit> {
        if !self.is_clear(&space.state(&direction, largest)) {
            return None;
        }
        let (mut low, mut high) = (0.0, largest);
        for _ in 0..BISECTIONS {
            if high <= SHORTEST_WAY {
                break;
            }
            let middle = 0.5 * (low + high);
            if self.is_clear(&space.state(&direction, middle)) {
                high = middle;
            } else {
                low = middle;
            }
        }
        let distance = space.distance(&space.state(&direction, high));
        Some(Exit { direction, length: high, distance })
    }

    /// Turns the direction of an exit such that the exit comes nearer.
    fn turned(&mut self, space: &SearchSpace, mut best: Exit) -> Exit {
        for turn in TURNS {
            while best.distance > SHORTEST_WAY && !self.is_over() {
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

    /// As [`Self::with_first_exit`], of a state a little farther along the direction where there is no room for a proof.
    fn with_room(&mut self, space: &SearchSpace, found: &Exit) -> Option<FreeState> {
        EXTENSIONS.into_iter().find_map(|extension| {
            let state = space.state(&found.direction, found.length + extension);
            let distance = space.distance(&state);
            let is_within =
                extension == 0.0 || (distance <= self.options.largest_distance && self.is_clear(&state));
            if is_within { self.with_first_exit(space, &state, distance) } else { None }
        })
    }

    /// The free state with its first exit from collision; `None` if the motion from there on is not proven free. The limits of the
    /// search do not end this: a state that was found would be lost.
    fn with_first_exit(
        &mut self,
        space: &SearchSpace,
        state: &Configuration,
        distance: f64,
    ) -> Option<FreeState> {
        let end = state.positions();
        let travel = self.checker.travel(self.q.positions(), end);
        let steps = (travel / FreeState::LONGEST_STEP).ceil().clamp(1.0, FreeState::MOST_STEPS);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // at most MOST_STEPS
        let steps = steps as u32;
        let at = |i: u32| f64::from(i) / f64::from(steps);
        let states: Vec<Configuration> = (0..=steps).map(|i| space.between(at(i), end)).collect();
        let first = u32::try_from(states.iter().position(|state| self.is_free(state))?).ok()?;
        let exit = space.between(at(first), end);
        let segment = MotionSegment::straight(self.checker.robot(), &exit, state);
        let budget = if self.options.deadline.is_some() { BUDGET } else { MotionOptions::default().budget };
        let options = MotionOptions { budget, ..MotionOptions::default() };
        let report = self.checker.check_motion_with(&segment, &options, self.workspace);
        let is_proven = report.verdict == MotionVerdict::Free;
        is_proven.then(|| FreeState { state: state.clone(), distance, exit: at(first), checks: self.checks })
    }
}
