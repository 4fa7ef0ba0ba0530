//! Sweep and prune (Cohen, Lin, Manocha & Ponamgi 1995, *I-COLLIDE*): boxes sorted along one axis.

use clearance::proximity::bvh::AxisBox;

use super::structures::{BroadPhase, overlap};

/// Boxes in the order of their lower bounds, along the axis with the largest spread.
pub struct SweepAndPrune {
    axis: usize,
    sorted: Vec<(u32, AxisBox)>,
    /// Lower bound of each item, used to find it.
    keys: Vec<f32>,
    /// Upper bound on the size of all boxes along the axis (m).
    longest: f32,
}

impl BroadPhase for SweepAndPrune {
    const NAME: &'static str = "sweep and prune";

    fn build(items: &[(u32, AxisBox)]) -> Self {
        let spread = |axis: usize| {
            let sides = || items.iter().map(|(_, bounds)| bounds.lo[axis]);
            sides().fold(f32::NEG_INFINITY, f32::max) - sides().fold(f32::INFINITY, f32::min)
        };
        let axis = (0..3).max_by(|&i, &j| spread(i).total_cmp(&spread(j))).unwrap_or(0);
        let mut made = Self { axis, sorted: items.to_vec(), keys: Vec::new(), longest: 0.0 };
        made.sorted.sort_by(|(_, a), (_, b)| a.lo[axis].total_cmp(&b.lo[axis]));
        for (item, bounds) in items {
            made.note(*item, bounds);
        }
        made
    }

    fn set(&mut self, item: u32, bounds: &AxisBox) {
        self.remove(item);
        let at = self.sorted.partition_point(|(_, other)| other.lo[self.axis] < bounds.lo[self.axis]);
        self.sorted.insert(at, (item, *bounds));
        self.note(item, bounds);
    }

    fn remove(&mut self, item: u32) {
        let Some(&key) = self.keys.get(item as usize).filter(|key| !key.is_nan()) else { return };
        let from = self.sorted.partition_point(|(_, other)| other.lo[self.axis] < key);
        let held = self.sorted[from..].iter().position(|(other, _)| *other == item);
        self.sorted.remove(from + held.expect("what has a key is held"));
        self.keys[item as usize] = f32::NAN;
    }

    fn overlapping(&mut self, with: &AxisBox, found: &mut Vec<u32>) {
        let [low, high] = [with.lo[self.axis] - self.longest, with.hi[self.axis]];
        let from = self.sorted.partition_point(|(_, other)| other.lo[self.axis] < low);
        let swept = self.sorted[from..].iter().take_while(|(_, other)| other.lo[self.axis] <= high);
        found.extend(swept.filter(|(_, other)| overlap(other, with)).map(|(item, _)| *item));
    }
}

impl SweepAndPrune {
    fn note(&mut self, item: u32, bounds: &AxisBox) {
        if self.keys.len() <= item as usize {
            self.keys.resize(item as usize + 1, f32::NAN);
        }
        self.keys[item as usize] = bounds.lo[self.axis];
        // rounded up, as the difference in a search is rounded too
        self.longest = self.longest.max((bounds.hi[self.axis] - bounds.lo[self.axis]) * 1.000_001 + 1e-6);
    }
}
