//! Which pairs to ask first.

/// More would be looked through for nothing.
const MOST: usize = 16;

/// The pairs that were hit most of late, most likely first. The order of questions changes no answer, only how soon a hit is
/// found.
#[derive(Clone, Debug, Default)]
pub(super) struct PairPriority {
    pairs: Vec<usize>,
}

impl PairPriority {
    pub fn new() -> Self {
        Self { pairs: Vec::with_capacity(MOST) }
    }

    pub fn get(&self, rank: usize) -> Option<usize> {
        self.pairs.get(rank).copied()
    }

    pub fn contains(&self, pair: usize) -> bool {
        self.pairs.contains(&pair)
    }

    /// Notes that a pair is hit: one step forward, or into the last place (Rivest 1976, *On self-organizing sequential search
    /// heuristics*).
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
        let mut likely = PairPriority::new();
        for i in 0..1000 {
            likely.hit(if i % 2 == 0 { 7 } else { i });
        }
        assert_eq!(likely.get(0), Some(7));
        let mut all = likely.pairs.clone();
        all.sort_unstable();
        all.dedup();
        assert_eq!((all.len(), likely.get(MOST)), (MOST, None));
    }
}
