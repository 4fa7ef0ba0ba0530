//! Broad phase for comparison: sweep and prune (Cohen, Lin, Manocha & Ponamgi 1995, *I-COLLIDE*).
//!
//! Insertion sort keeps the ends of all boxes in order along three axes. The overlaps of every query box are kept from
//! one query to the next.

use clearance::proximity::bvh::AxisBox;

use super::structures::BroadPhase;

/// Number of comparisons that say whether two boxes overlap: the lower end of each against the upper end of the other, on three axes.
const COMPARISONS: u8 = 6;

/// Ends of boxes along the three axes, and which items overlap each query box.
pub struct SweepAndPrune {
    axes: [Axis; 3],
    queries: Vec<Overlaps>,
    /// Whether each item is in the set.
    is_held: Vec<bool>,
}

/// Sorted ends along one axis.
#[derive(Default)]
struct Axis {
    ends: Vec<End>,
    /// Places of the lower and the upper end of each item.
    of_items: Vec<[usize; 2]>,
    /// Places of both ends of each query box.
    of_queries: Vec<[usize; 2]>,
}

/// One end of a box along an axis.
#[derive(Clone, Copy)]
struct End {
    at: f32,
    owner: Owner,
    is_upper: bool,
}

#[derive(Clone, Copy, PartialEq)]
enum Owner {
    Item(u32),
    Query(u32),
}

/// Overlaps of one query box with the items.
struct Overlaps {
    /// How many of the comparisons with each item are true.
    comparisons: Vec<u8>,
    items: Vec<u32>,
}

impl BroadPhase for SweepAndPrune {
    const NAME: &'static str = "sweep and prune";

    fn build(items: &[(u32, AxisBox)]) -> Self {
        let count = items.iter().map(|(item, _)| *item as usize + 1).max().unwrap_or(0);
        let mut is_held = vec![false; count];
        for (item, _) in items {
            is_held[*item as usize] = true;
        }
        Self {
            axes: std::array::from_fn(|axis| Axis::sorted(items, axis, count)),
            queries: Vec::new(),
            is_held,
        }
    }

    fn set(&mut self, item: u32, bounds: &AxisBox) {
        self.make_room(item);
        let owner = Owner::Item(item);
        if !std::mem::replace(&mut self.is_held[item as usize], true) {
            for overlaps in &mut self.queries {
                overlaps.comparisons[item as usize] = COMPARISONS / 2;
            }
            self.axes.iter_mut().for_each(|axis| axis.append(owner));
        }
        self.place(owner, bounds);
    }

    fn remove(&mut self, item: u32) {
        if self.is_held.get_mut(item as usize).is_some_and(|held| std::mem::replace(held, false)) {
            let beyond = AxisBox { lo: [f32::INFINITY; 3], hi: [f32::INFINITY; 3] };
            self.place(Owner::Item(item), &beyond);
            for axis in &mut self.axes {
                axis.ends.truncate(axis.ends.len() - 2);
            }
        }
    }

    fn overlapping(&mut self, query: u32, with: &AxisBox, found: &mut Vec<u32>) {
        while self.queries.len() <= query as usize {
            let number = u32::try_from(self.queries.len()).expect("a robot has few parts");
            self.queries
                .push(Overlaps { comparisons: vec![COMPARISONS / 2; self.is_held.len()], items: Vec::new() });
            self.axes.iter_mut().for_each(|axis| axis.append(Owner::Query(number)));
        }
        self.place(Owner::Query(query), with);
        found.extend(&self.queries[query as usize].items);
    }
}

impl SweepAndPrune {
    fn make_room(&mut self, item: u32) {
        let count = (item as usize + 1).max(self.is_held.len());
        self.is_held.resize(count, false);
        for axis in &mut self.axes {
            axis.of_items.resize(count, [0; 2]);
        }
        for overlaps in &mut self.queries {
            overlaps.comparisons.resize(count, COMPARISONS / 2);
        }
    }

    /// Moves the ends of a box.
    fn place(&mut self, owner: Owner, bounds: &AxisBox) {
        for (i, axis) in self.axes.iter_mut().enumerate() {
            // the leading end first, so that the ends of one box do not pass each other
            let ends = [(bounds.lo[i], false), (bounds.hi[i], true)];
            let rises = axis.ends[axis.place_of(owner, false)].at < bounds.lo[i];
            for (at, is_upper) in if rises { [ends[1], ends[0]] } else { ends } {
                axis.shift(End { at, owner, is_upper }, &mut self.queries);
            }
        }
    }
}

impl Axis {
    fn sorted(items: &[(u32, AxisBox)], axis: usize, count: usize) -> Self {
        let ends = |(item, bounds): &(u32, AxisBox)| {
            let owner = Owner::Item(*item);
            [(bounds.lo[axis], false), (bounds.hi[axis], true)].map(|(at, is_upper)| End {
                at,
                owner,
                is_upper,
            })
        };
        let mut ends: Vec<End> = items.iter().flat_map(ends).collect();
        ends.sort_by(|a, b| (a.at + 0.0).total_cmp(&(b.at + 0.0)).then(a.is_upper.cmp(&b.is_upper)));
        let mut made = Self { ends, of_items: vec![[0; 2]; count], of_queries: Vec::new() };
        (0..made.ends.len()).for_each(|place| made.note(place));
        made
    }

    /// Adds both ends of a box behind all others.
    fn append(&mut self, owner: Owner) {
        if let Owner::Query(_) = owner {
            self.of_queries.push([0; 2]);
        }
        for is_upper in [false, true] {
            self.ends.push(End { at: f32::INFINITY, owner, is_upper });
            self.note(self.ends.len() - 1);
        }
    }

    /// Moves an end to its new place, past its neighbours one by one.
    fn shift(&mut self, end: End, queries: &mut [Overlaps]) {
        let mut place = self.place_of(end.owner, end.is_upper);
        self.ends[place] = end;
        while place > 0 && end.is_before(&self.ends[place - 1]) {
            self.swap(place - 1, queries);
            place -= 1;
        }
        while place + 1 < self.ends.len() && self.ends[place + 1].is_before(&end) {
            self.swap(place, queries);
            place += 1;
        }
    }

    /// Exchanges the ends at `place` and behind it.
    fn swap(&mut self, place: usize, queries: &mut [Overlaps]) {
        let [first, second] = [self.ends[place], self.ends[place + 1]];
        self.ends.swap(place, place + 1);
        self.note(place);
        self.note(place + 1);
        let ((Owner::Query(query), Owner::Item(item)) | (Owner::Item(item), Owner::Query(query))) =
            (first.owner, second.owner)
        else {
            return;
        };
        if first.is_upper != second.is_upper {
            // true: the lower end of one is now before the upper end of the other
            queries[query as usize].compare(item, first.is_upper);
        }
    }

    fn note(&mut self, place: usize) {
        let End { owner, is_upper, .. } = self.ends[place];
        match owner {
            Owner::Item(item) => self.of_items[item as usize][usize::from(is_upper)] = place,
            Owner::Query(query) => self.of_queries[query as usize][usize::from(is_upper)] = place,
        }
    }

    fn place_of(&self, owner: Owner, is_upper: bool) -> usize {
        let places = match owner {
            Owner::Item(item) => self.of_items[item as usize],
            Owner::Query(query) => self.of_queries[query as usize],
        };
        places[usize::from(is_upper)]
    }
}

impl End {
    /// Boxes that share a point overlap: of equal ends the lower one is first.
    fn is_before(&self, other: &Self) -> bool {
        self.at < other.at || self.at == other.at && !self.is_upper && other.is_upper
    }
}

impl Overlaps {
    /// One of the comparisons with an item has become true or false.
    fn compare(&mut self, item: u32, is_true: bool) {
        let comparisons = &mut self.comparisons[item as usize];
        if is_true {
            *comparisons += 1;
            if *comparisons == COMPARISONS {
                self.items.push(item);
            }
        } else {
            if *comparisons == COMPARISONS {
                self.items.retain(|other| *other != item);
            }
            *comparisons -= 1;
        }
    }
}
