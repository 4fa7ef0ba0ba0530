//! Heuristic order in which candidate pairs are tested: those that collided most often recently come first.

/// Maximum number of stored pairs; searching a longer list would cost more than it saves.
const MOST: usize = 16;

/// The pairs that collided most often recently, the most priority first. The order changes no result, only the time
/// until a collision is found.
#[derive(Clone, Debug, Default)]
pub struct PairPriority {
    pairs: Vec<usize>,
}

impl PairPriority {
    pub fn new() -> Self {
        Self { pairs: Vec::with_capacity(MOST) }
    }

    pub fn get(&self, rank: usize) -> Option<usize> {
        self.pairs.get(rank).copied()
    }

    /// Rank of a pair; pairs that did not collide recently come last.
    pub fn rank(&self, pair: usize) -> usize {
        self.pairs.iter().position(|known| *known == pair).unwrap_or(MOST)
    }

    pub fn contains(&self, pair: usize) -> bool {
        self.pairs.contains(&pair)
    }

    /// Records a collision of a pair: moves it one step forward, or inserts it at the last place (Rivest 1976, *On
    /// self-organizing sequential search heuristics*).
    pub fn hit(&mut self, pair: usize) {
        match self.pairs.iter().position(|known| *known == pair) {
            Some(0) => {}
            Some(rank) => self.pairs.swap(rank, rank - 1),
            None if self.pairs.len() < MOST => self.pairs.push(pair),
            None => self.pairs[MOST - 1] = pair,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_hit_most_comes_first_and_none_comes_twice() {
        let mut priority = PairPriority::new();
        for i in 0..1000 {
            priority.hit(if i % 2 == 0 { 7 } else { i });
        }
        assert_eq!(priority.get(0), Some(7));
        let mut all = priority.pairs.clone();
        all.sort_unstable();
        all.dedup();
        assert_eq!((all.len(), priority.get(MOST)), (MOST, None));
    }
}
