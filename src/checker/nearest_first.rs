//! A queue of what may be nearest.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::capsules::up;
use super::nearby::Near;
use crate::math::Extremes;

/// A pair, or obstacles near a part, of which the nearest are to be asked first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct QueuedNear {
    /// Nothing of it is nearer than this (m).
    pub lower: f64,
    pub near: Near,
}

/// What is to be looked at, what may be nearest first; of equal ones, what came first.
///
/// Its order is that of single words: a number (m, not negative, f32) that no distance is below, and which one it is.
#[derive(Clone, Debug, Default)]
pub(super) struct NearestFirst {
    order: BinaryHeap<Reverse<u64>>,
    all: Vec<Near>,
}

impl NearestFirst {
    pub fn clear(&mut self) {
        self.order.clear();
        self.all.clear();
    }

    pub fn push(&mut self, QueuedNear { lower, near }: QueuedNear) {
        // rounded down; bits of what is not negative are ordered as the numbers are
        let lower = (-up(-lower)).greater(0.0).to_bits();
        self.order.push(Reverse(u64::from(lower) << 32 | self.all.len() as u64));
        self.all.push(near);
    }

    #[allow(clippy::cast_possible_truncation)] // halves of a word
    pub fn pop(&mut self) -> Option<QueuedNear> {
        let Reverse(word) = self.order.pop()?;
        let lower = f64::from(f32::from_bits((word >> 32) as u32));
        Some(QueuedNear { lower, near: self.all[(word as u32) as usize] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    #[test]
    fn what_may_be_nearest_comes_first_with_a_number_that_is_not_larger() {
        let mut random = Random::new(4);
        let mut queue = NearestFirst::default();
        for round in 0..3 {
            let lowers: Vec<f64> = (0..500).map(|_| random.within(2.0)).chain([0.0, f64::INFINITY]).collect();
            for (index, &lower) in lowers.iter().enumerate() {
                queue.push(QueuedNear { lower, near: Near::Pair(index) });
            }
            let mut last = 0.0;
            for _ in 0..lowers.len() - 100 * round {
                let Some(QueuedNear { lower, near: Near::Pair(index) }) = queue.pop() else {
                    panic!("nothing left")
                };
                let pushed = lowers[index].max(0.0);
                assert!(last <= lower && lower <= pushed && (pushed - lower <= 1e-6 || pushed == lower));
                last = lower;
            }
            assert!(round > 0 || queue.pop().is_none());
            queue.clear();
            assert!(queue.pop().is_none());
        }
    }

    #[test]
    fn of_equal_ones_the_first_comes_first_and_what_is_no_number_before_all() {
        let mut queue = NearestFirst::default();
        for (index, lower) in [0.5, 0.25, 0.5, f64::NAN, -1.0].into_iter().enumerate() {
            queue.push(QueuedNear { lower, near: Near::Pair(index) });
        }
        let order: Vec<Near> = std::iter::from_fn(|| queue.pop()).map(|queued| queued.near).collect();
        assert_eq!(order, [3, 4, 1, 0, 2].map(Near::Pair));
    }
}
