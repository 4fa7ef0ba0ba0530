//! Set cover: few of many candidate balls that contain all sample points. Greedy choice, then local search with weights of points (Gao, Weise
//! and Li 2015, *An efficient local search heuristic with row weighting for the unicost set covering problem*).

use std::collections::BinaryHeap;

use clearance_geometry::math::Point;

use crate::ball::Ball;
use crate::search_limit::SearchLimit;

/// Largest number of uncovered points that decide which candidate is added.
const MOST_COUNTED: usize = 96;

/// Candidates, and the points to be covered.
pub struct CoverSearch<'p> {
    points: &'p [Point],
    candidates: Vec<Ball>,
    /// By candidate: one bit for each point, set if the candidate contains it.
    bits: Vec<u64>,
    /// Number of words of a candidate.
    words: usize,
    random: fastrand::Rng,
    limit: &'p SearchLimit,
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
    pub fn new(points: &'p [Point], candidates: Vec<Ball>, limit: &'p SearchLimit) -> Self {
        let words = points.len().div_ceil(64);
        let mut bits = vec![0; words * candidates.len()];
        for (ball, row) in candidates.iter().zip(bits.chunks_exact_mut(words.max(1))) {
            for (word, points) in row.iter_mut().zip(points.chunks(64)) {
                *word = points.iter().rev().fold(0, |word, p| word << 1 | u64::from(ball.contains(p, 0.0)));
            }
        }
        Self { points, candidates, bits, words, random: fastrand::Rng::with_seed(11), limit }
    }

    fn row(&self, candidate: usize) -> &[u64] {
        &self.bits[candidate * self.words..(candidate + 1) * self.words]
    }

    fn contains(&self, candidate: usize, point: usize) -> bool {
        self.bits[candidate * self.words + point / 64] >> (point % 64) & 1 == 1
    }

    /// The points in a candidate.
    fn points_in(&self, candidate: usize) -> impl Iterator<Item = usize> {
        self.row(candidate).iter().enumerate().flat_map(|(i, word)| {
            let rest = |word: &u64| Some(word & (word - 1)).filter(|word| *word != 0);
            std::iter::successors(Some(*word).filter(|word| *word != 0), rest)
                .map(move |word| 64 * i + word.trailing_zeros() as usize)
        })
    }

    /// A cover by at most `count` candidates, if one is found in `steps` steps of local search, before the limit ends it. Without a count: the smallest that is found.
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
            if idle > steps || step > 8 * steps || state.chosen.is_empty() || self.limit.is_over() {
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
        let mut open = vec![u64::MAX; self.words];
        if let (Some(last), 1..) = (open.last_mut(), self.points.len() % 64) {
            *last = (1 << (self.points.len() % 64)) - 1;
        }
        let gain = |candidate: usize, open: &[u64]| -> u32 {
            self.row(candidate).iter().zip(open).map(|(own, open)| (own & open).count_ones()).sum()
        };
        let mut heap: BinaryHeap<(u32, std::cmp::Reverse<usize>)> =
            (0..self.candidates.len()).map(|i| (gain(i, &open), std::cmp::Reverse(i))).collect();
        let mut chosen = vec![];
        while open.iter().any(|word| *word != 0) {
            if self.limit.is_over() {
                return None;
            }
            let (_, std::cmp::Reverse(candidate)) = heap.pop()?;
            let gained = gain(candidate, &open);
            let next = heap.peek().map_or(0, |(gain, _)| *gain);
            if gained < next {
                heap.push((gained, std::cmp::Reverse(candidate)));
            } else if gained == 0 {
                return None;
            } else {
                open.iter_mut().zip(self.row(candidate)).for_each(|(open, own)| *open &= !own);
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
        for i in 0..self.candidates.len() {
            if i == removed || !self.contains(i, point) || state.chosen.contains(&i) {
                continue;
            }
            let gained = state.uncovered.iter().take(MOST_COUNTED).filter(|p| self.contains(i, **p));
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
        for p in search.points_in(candidate) {
            self.counts[p] += 1;
            self.places[p] += place;
        }
        self.uncovered.retain(|p| self.counts[*p] == 0);
    }

    /// Removes the candidate at a place; the last one moves there.
    fn remove(&mut self, place: usize, search: &CoverSearch) {
        let last = self.chosen.len() - 1;
        for p in search.points_in(self.chosen[place]) {
            self.counts[p] -= 1;
            self.places[p] -= place;
            if self.counts[p] == 0 {
                self.uncovered.push(p);
            }
        }
        if place != last {
            for p in search.points_in(self.chosen[last]) {
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
