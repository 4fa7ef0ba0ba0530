//! Set cover: few of many candidate balls that contain all sample points. Greedy choice, then local search with weights of points (Gao, Weise
//! and Li 2015, *An efficient local search heuristic with row weighting for the unicost set covering problem*).

use std::collections::BinaryHeap;

use clearance_geometry::math::Point;

use crate::ball::Ball;

/// Largest number of uncovered points that decide which candidate is added.
const MOST_COUNTED: usize = 96;

/// Candidates, and the points to be covered.
pub struct CoverSearch<'p> {
    points: &'p [Point],
    candidates: Vec<Ball>,
    random: fastrand::Rng,
}

/// Chosen candidates with the coverage of the points.
struct State {
    chosen: Vec<usize>,
    /// By chosen candidate: the step at which it was added.
    since: Vec<usize>,
    /// By point: the number of chosen candidates that contain it, and the sum of their places in `chosen`.
    counts: Vec<u32>,
    places: Vec<usize>,
    weights: Vec<f64>,
    uncovered: Vec<usize>,
}

impl<'p> CoverSearch<'p> {
    /// A search over `candidates`.
    pub fn new(points: &'p [Point], candidates: Vec<Ball>) -> Self {
        Self { points, candidates, random: fastrand::Rng::with_seed(11) }
    }

    /// A cover by at most `count` candidates, if one is found in `steps` steps of local search. Without a count: the smallest that is found.
    pub fn find(&mut self, count: Option<usize>, steps: usize) -> Option<Vec<Ball>> {
        let mut best = self.greedy()?;
        if count.is_some_and(|count| best.len() <= count) {
            return Some(self.balls(&best));
        }
        let mut state = State::new(self, best.clone());
        state.remove(state.least(0).unwrap_or(0), self);
        let mut idle = 0;
        for step in 1.. {
            if state.uncovered.is_empty() {
                best.clone_from(&state.chosen);
                idle = 0;
                if best.len() <= count.unwrap_or(1) {
                    break;
                }
                state.remove(state.least(step).unwrap_or(0), self);
                continue;
            }
            idle += 1;
            if idle > steps || step > 8 * steps || state.chosen.is_empty() {
                break;
            }
            self.swap(&mut state, step);
        }
        count.is_none_or(|count| best.len() <= count).then(|| self.balls(&best))
    }

    fn balls(&self, chosen: &[usize]) -> Vec<Ball> {
        chosen.iter().map(|i| self.candidates[*i]).collect()
    }

    /// Candidates by largest gain; `None` if they do not contain all points.
    fn greedy(&self) -> Option<Vec<usize>> {
        let mut open: Vec<usize> = (0..self.points.len()).collect();
        let gain = |candidate: usize, open: &[usize]| {
            open.iter().filter(|p| self.candidates[candidate].contains(&self.points[**p], 0.0)).count()
        };
        let mut heap: BinaryHeap<(usize, std::cmp::Reverse<usize>)> =
            (0..self.candidates.len()).map(|i| (gain(i, &open), std::cmp::Reverse(i))).collect();
        let mut chosen = vec![];
        while !open.is_empty() {
            let (_, std::cmp::Reverse(candidate)) = heap.pop()?;
            let gained = gain(candidate, &open);
            let next = heap.peek().map_or(0, |(gain, _)| *gain);
            if gained < next {
                heap.push((gained, std::cmp::Reverse(candidate)));
            } else if gained == 0 {
                return None;
            } else {
                open.retain(|p| !self.candidates[candidate].contains(&self.points[*p], 0.0));
                chosen.push(candidate);
            }
        }
        Some(chosen)
    }

    /// Replaces the least useful candidate by one that contains a random uncovered point.
    fn swap(&mut self, state: &mut State, step: usize) {
        let Some(place) = state.least(step) else { return };
        let removed = state.chosen[place];
        state.remove(place, self);
        let point = state.uncovered[self.random.usize(..state.uncovered.len())];
        let mut best: Option<(f64, usize)> = None;
        for (i, ball) in self.candidates.iter().enumerate() {
            if i == removed || !ball.contains(&self.points[point], 0.0) || state.chosen.contains(&i) {
                continue;
            }
            let gained =
                state.uncovered.iter().take(MOST_COUNTED).filter(|p| ball.contains(&self.points[**p], 0.0));
            let gain: f64 = gained.map(|p| state.weights[*p]).sum();
            if best.is_none_or(|(most, _)| gain > most) {
                best = Some((gain, i));
            }
        }
        let Some((_, added)) = best else { return };
        state.add(added, step, self);
        for p in &state.uncovered {
            state.weights[*p] += 1.0;
        }
    }
}

impl State {
    fn new(search: &CoverSearch, chosen: Vec<usize>) -> Self {
        let count = search.points.len();
        let mut state = Self {
            chosen: vec![],
            since: vec![],
            counts: vec![0; count],
            places: vec![0; count],
            weights: vec![1.0; count],
            uncovered: (0..count).collect(),
        };
        for candidate in chosen {
            state.add(candidate, 0, search);
        }
        state
    }

    fn add(&mut self, candidate: usize, step: usize, search: &CoverSearch) {
        let place = self.chosen.len();
        self.chosen.push(candidate);
        self.since.push(step);
        let ball = search.candidates[candidate];
        for (p, point) in search.points.iter().enumerate() {
            if ball.contains(point, 0.0) {
                self.counts[p] += 1;
                self.places[p] += place;
            }
        }
        self.uncovered.retain(|p| self.counts[*p] == 0);
    }

    /// Removes the candidate at a place; the last one moves there.
    fn remove(&mut self, place: usize, search: &CoverSearch) {
        let last = self.chosen.len() - 1;
        let (ball, moved) = (search.candidates[self.chosen[place]], search.candidates[self.chosen[last]]);
        for (p, point) in search.points.iter().enumerate() {
            if ball.contains(point, 0.0) {
                self.counts[p] -= 1;
                self.places[p] -= place;
                if self.counts[p] == 0 {
                    self.uncovered.push(p);
                }
            }
            if place != last && moved.contains(point, 0.0) {
                self.places[p] -= last - place;
            }
        }
        self.chosen.swap_remove(place);
        self.since.swap_remove(place);
    }

    /// Place of the candidate whose removal uncovers the least weight, but not of the one added last; the oldest of equal ones.
    fn least(&self, step: usize) -> Option<usize> {
        let mut losses = vec![0.0; self.chosen.len()];
        for (p, count) in self.counts.iter().enumerate() {
            if *count == 1 {
                losses[self.places[p]] += self.weights[p];
            }
        }
        let movable = (0..losses.len()).filter(|i| losses.len() == 1 || self.since[*i] + 1 < step.max(2));
        movable.min_by(|i, j| losses[*i].total_cmp(&losses[*j]).then(self.since[*i].cmp(&self.since[*j])))
    }
}
