//! Dynamic bounding box tree: numbered items with boxes, eight per node, inserted, moved and removed in place.
//!
//! An item is inserted where boxes grow least (Catto 2019, *Dynamic bounding volume hierarchies*). After as many changes as there are
//! items, the tree is rebuilt.

use clearance_geometry::math::Extremes;
use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{LANES, Level, Simd, dispatch, low_byte};

use super::axis_box::{AxisBox, EightBoxes};

/// Up to this number of the eight boxes, each is compared with a node's boxes individually.
const FEW_BOXES: u32 = 3;

/// Minimum number of changes before a rebuild, also for a small tree.
const FEW_CHANGES: usize = 64;

/// Items with boxes.
#[derive(Clone, Debug, Default)]
pub struct DynamicTree {
    /// The root is node 0, if there is one.
    nodes: Vec<Node>,
    unused: Vec<u32>,
    /// By item: its place in the tree.
    slots: Vec<Option<Slot>>,
    count: usize,
    changes: usize,
}

/// Eight boxes, and their content.
#[derive(Clone, Debug)]
struct Node {
    boxes: EightBoxes,
    children: [Child; LANES],
    /// The node and lane of which it is a child.
    slot: Option<Slot>,
}

/// Content of a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Child {
    /// The lane is free.
    Nothing,
    /// An item, by its number.
    Item(u32),
    /// A node, by its number.
    Node(u32),
}

/// Place of a child: a lane of a node.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Slot {
    node: u32,
    lane: usize,
}

/// Some of eight boxes.
#[derive(Clone, Copy, Debug)]
pub struct SelectedBoxes<'b> {
    /// All eight boxes.
    pub boxes: &'b EightBoxes,
    /// Bit mask of the selected boxes.
    pub mask: u8,
}

impl DynamicTree {
    /// A tree of items with different numbers.
    #[must_use]
    #[inline]
    pub fn build(items: &[(u32, AxisBox)]) -> Self {
        let mut tree = Self::default();
        tree.fill(&mut items.to_vec());
        tree
    }

    /// Number of items.
    #[must_use]
    #[inline]
    pub fn len(&self) -> usize {
        self.count
    }

    /// True if there are no items.
    #[must_use]
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The root's number, if there are items.
    #[must_use]
    #[inline]
    pub fn root(&self) -> Option<u32> {
        (!self.is_empty()).then_some(0)
    }

    /// Inserts an item, or changes its box.
    #[inline]
    pub fn set(&mut self, item: u32, bounds: AxisBox) {
        self.make_room(item);
        match self.slots[item as usize] {
            Some(slot) if self.nodes[slot.node as usize].holds(&bounds) => self.place(slot, item, &bounds),
            Some(slot) => {
                self.clear(slot);
                self.insert(item, bounds);
            }
            None => {
                self.count += 1;
                self.insert(item, bounds);
            }
        }
        self.note_change();
    }

    /// Removes an item, if it is in the tree.
    #[inline]
    pub fn remove(&mut self, item: u32) {
        let Some(slot) = self.slots.get_mut(item as usize).and_then(Option::take) else { return };
        self.count -= 1;
        self.clear(slot);
        self.note_change();
    }

    /// The boxes of a node, and their content.
    #[inline]
    #[must_use]
    pub fn node(&self, node: u32) -> (&EightBoxes, &[Child; LANES]) {
        let Node { boxes, children, .. } = &self.nodes[node as usize];
        (boxes, children)
    }

    /// Appends the items whose boxes overlap a box to `found`; returns the number of boxes tested. `stack` is scratch memory.
    #[inline]
    pub fn overlapping(
        &self,
        level: Level,
        with: &AxisBox,
        stack: &mut Vec<u32>,
        found: &mut Vec<u32>,
    ) -> u64 {
        dispatch!(level, simd => self.find_overlapping(simd, with, stack, found))
    }

    /// As [`Self::overlapping`], for a caller compiled for its SIMD level.
    #[inline(always)]
    pub fn find_overlapping<S: Simd>(
        &self,
        simd: S,
        with: &AxisBox,
        stack: &mut Vec<u32>,
        found: &mut Vec<u32>,
    ) -> u64 {
        stack.clear();
        stack.extend(self.root());
        let mut tested = 0;
        while let Some(node) = stack.pop() {
            tested += LANES as u64;
            let node = &self.nodes[node as usize];
            let mut near = node.overlaps(simd, with);
            while near != 0 {
                let lane = near.trailing_zeros() as usize;
                near &= near - 1;
                match node.children[lane] {
                    Child::Item(item) => found.push(item),
                    Child::Node(node) => stack.push(node),
                    Child::Nothing => {}
                }
            }
        }
        tested
    }

    /// As [`Self::find_overlapping`], for several boxes at once: each found item has a bit mask of the boxes
    /// that it overlaps.
    #[inline(always)]
    pub fn find_overlapping_any<S: Simd>(
        &self,
        simd: S,
        with: SelectedBoxes,
        stack: &mut Vec<(u32, u8)>,
        found: &mut Vec<(u32, u8)>,
    ) -> u64 {
        stack.clear();
        stack.extend(self.root().map(|node| (node, with.mask)));
        let mut tested = 0;
        while let Some((node, selected)) = stack.pop() {
            tested += u64::from(selected.count_ones()) * LANES as u64;
            let node = &self.nodes[node as usize];
            let (children, mut near) = node.overlaps_any(simd, SelectedBoxes { mask: selected, ..with });
            while near != 0 {
                let lane = near.trailing_zeros() as usize;
                near &= near - 1;
                match node.children[lane] {
                    Child::Item(item) => found.push((item, children[lane])),
                    Child::Node(node) => stack.push((node, children[lane])),
                    Child::Nothing => {}
                }
            }
        }
        tested
    }

    fn make_room(&mut self, item: u32) {
        if self.slots.len() <= item as usize {
            self.slots.resize(item as usize + 1, None);
        }
    }

    fn note_change(&mut self) {
        self.changes += 1;
        if self.changes > self.count.max(FEW_CHANGES) {
            let mut items = self.items();
            *self = Self { slots: vec![None; self.slots.len()], ..Self::default() };
            self.fill(&mut items);
        }
    }

    /// All items with their boxes, by number.
    #[must_use]
    #[inline]
    pub fn items(&self) -> Vec<(u32, AxisBox)> {
        let slots = (0..).zip(&self.slots);
        let placed = slots.filter_map(|(item, slot)| {
            let slot = (*slot)?;
            Some((item, self.nodes[slot.node as usize].boxes.lane(slot.lane)))
        });
        placed.collect()
    }

    fn fill(&mut self, items: &mut [(u32, AxisBox)]) {
        self.count = items.len();
        if let Some(largest) = items.iter().map(|(item, _)| *item).max() {
            self.make_room(largest);
            self.add_node(items, None);
        }
    }

    /// A node over items, which are sorted.
    fn add_node(&mut self, items: &mut [(u32, AxisBox)], slot: Option<Slot>) -> u32 {
        let number = self.new_node(slot);
        let mut parts = Vec::with_capacity(LANES);
        divide(items, LANES, &mut parts);
        for (lane, part) in parts.into_iter().enumerate() {
            let bounds = part.iter().fold(AxisBox::EMPTY, |all, (_, bounds)| all.union(bounds));
            let slot = Slot { node: number, lane };
            let child = match part {
                [(item, _)] => {
                    self.slots[*item as usize] = Some(slot);
                    Child::Item(*item)
                }
                _ => Child::Node(self.add_node(part, Some(slot))),
            };
            self.nodes[number as usize].set(lane, child, &bounds);
        }
        number
    }

    fn new_node(&mut self, slot: Option<Slot>) -> u32 {
        let node = Node::empty(slot);
        if let Some(unused) = self.unused.pop() {
            self.nodes[unused as usize] = node;
            return unused;
        }
        self.nodes.push(node);
        u32::try_from(self.nodes.len() - 1).expect("there are fewer nodes than items")
    }

    /// Finds the place where boxes grow least.
    fn insert(&mut self, item: u32, bounds: AxisBox) {
        if self.nodes.is_empty() {
            self.new_node(None);
        }
        let mut number = 0;
        loop {
            let node = &mut self.nodes[number as usize];
            let free = node.children.iter().position(|child| *child == Child::Nothing);
            let lane = free.unwrap_or_else(|| node.least_growth(&bounds));
            let slot = Slot { node: number, lane };
            match node.children[lane] {
                Child::Nothing => return self.place(slot, item, &bounds),
                Child::Node(child) => {
                    let grown = node.boxes.lane(lane).union(&bounds);
                    node.set(lane, Child::Node(child), &grown);
                    number = child;
                }
                Child::Item(other) => {
                    let old = node.boxes.lane(lane);
                    let pair = self.new_node(Some(slot));
                    let grown = old.union(&bounds);
                    self.nodes[number as usize].set(lane, Child::Node(pair), &grown);
                    self.place(Slot { node: pair, lane: 0 }, other, &old);
                    self.place(Slot { node: pair, lane: 1 }, item, &bounds);
                    return self.refit(number);
                }
            }
        }
    }

    fn place(&mut self, slot: Slot, item: u32, bounds: &AxisBox) {
        self.nodes[slot.node as usize].set(slot.lane, Child::Item(item), bounds);
        self.slots[item as usize] = Some(slot);
        self.refit(slot.node);
    }

    /// Clears a lane, and removes nodes that become empty.
    fn clear(&mut self, mut slot: Slot) {
        loop {
            let node = &mut self.nodes[slot.node as usize];
            node.set(slot.lane, Child::Nothing, &AxisBox::EMPTY);
            let empty = node.children.iter().all(|child| *child == Child::Nothing);
            match node.slot.filter(|_| empty) {
                Some(parent) => {
                    self.unused.push(slot.node);
                    slot = parent;
                }
                None => return self.refit(slot.node),
            }
        }
    }

    /// Updates the boxes above a node.
    fn refit(&mut self, mut number: u32) {
        while let Some(slot) = self.nodes[number as usize].slot {
            let bounds = self.nodes[number as usize].boxes.union();
            let parent = &mut self.nodes[slot.node as usize];
            if parent.boxes.lane(slot.lane) == bounds {
                return;
            }
            parent.set(slot.lane, Child::Node(number), &bounds);
            number = slot.node;
        }
    }
}

/// Divides items among lanes by halves, or into groups if a node and its descendants have room for them.
fn divide<'i>(items: &'i mut [(u32, AxisBox)], lanes: usize, parts: &mut Vec<&'i mut [(u32, AxisBox)]>) {
    match items.len() {
        0 => {}
        count if lanes == 1 || count == 1 => parts.push(items),
        count if lanes == LANES && count <= LANES * LANES => group(items, parts),
        count => {
            split(items, count / 2);
            let (front, back) = items.split_at_mut(count / 2);
            divide(front, lanes / 2, parts);
            divide(back, lanes / 2, parts);
        }
    }
}

/// Divides items into eight groups: joins those groups first whose box will be visited least, up to eight items per group unless no two
/// others are left.
fn group<'i>(items: &'i mut [(u32, AxisBox)], parts: &mut Vec<&'i mut [(u32, AxisBox)]>) {
    let mut groups: Vec<Group> = (0..).zip(&*items).map(|(i, item)| Group::of(i, item.1)).collect();
    while groups.len() > LANES {
        let pairs = (1..groups.len()).flat_map(|j| (0..j).map(move |i| (i, j)));
        let costs = pairs.map(|(i, j)| (groups[i].cost_with(&groups[j]), (i, j)));
        let cheapest = costs.min_by(|((a, p), _), ((b, q), _)| a.cmp(b).then(p.total_cmp(q)));
        let (_, (i, j)) = cheapest.expect("there are more than eight");
        let other = groups.swap_remove(j);
        groups[i].join(other);
    }
    let sorted: Vec<_> = groups.iter().flat_map(|group| &group.members).map(|&i| items[i]).collect();
    items.copy_from_slice(&sorted);
    let mut rest = items;
    for group in &groups {
        let (part, others) = rest.split_at_mut(group.members.len());
        parts.push(part);
        rest = others;
    }
}

/// A group of items that becomes a node, or a single item that does not.
struct Group {
    members: Vec<usize>,
    bounds: AxisBox,
    /// Expected visits of its node, if it has one.
    cost: f32,
}

impl Group {
    fn of(item: usize, bounds: AxisBox) -> Self {
        Self { members: vec![item], bounds, cost: 0.0 }
    }

    fn join(&mut self, other: Self) {
        self.members.extend(other.members);
        self.bounds = self.bounds.union(&other.bounds);
        self.cost = self.bounds.girth();
    }

    /// Whether two groups are too large for one node, and the increase of node visits if they are joined (Goldsmith and Salmon 1987, by
    /// sum of edges instead of area).
    fn cost_with(&self, other: &Self) -> (bool, f32) {
        let too_many = self.members.len() + other.members.len() > LANES;
        (too_many, self.bounds.union(&other.bounds).girth() - self.cost - other.cost)
    }
}

/// Moves the given number of items with the smallest coordinates to the front, along the axis on which centres differ most.
fn split(items: &mut [(u32, AxisBox)], first: usize) {
    let centres = || items.iter().map(|(_, bounds)| bounds.doubled_centre());
    let lo = centres().fold([f32::INFINITY; 3], |lo, c| std::array::from_fn(|i| lo[i].lesser(c[i])));
    let hi = centres().fold([f32::NEG_INFINITY; 3], |hi, c| std::array::from_fn(|i| hi[i].greater(c[i])));
    let axis = (0..3).max_by(|&i, &j| (hi[i] - lo[i]).total_cmp(&(hi[j] - lo[j]))).unwrap_or(0);
    let key = |entry: &(u32, AxisBox)| entry.1.doubled_centre()[axis];
    items.select_nth_unstable_by(first, |p, q| key(p).total_cmp(&key(q)).then(p.0.cmp(&q.0)));
}

/// Transposes a matrix of eight by eight bits (Warren 2012, *Hacker's Delight*, section 7-3).
#[inline(always)]
fn transposed(mut bits: u64) -> u64 {
    for (mask, shift) in
        [(0x00aa_00aa_00aa_00aa, 7), (0x0000_cccc_0000_cccc, 14), (0x0000_0000_f0f0_f0f0, 28)]
    {
        let differing = (bits ^ (bits >> shift)) & mask;
        bits ^= differing ^ (differing << shift);
    }
    bits
}

impl Node {
    fn empty(slot: Option<Slot>) -> Self {
        Self { boxes: EightBoxes::EMPTY, children: [Child::Nothing; LANES], slot }
    }

    fn set(&mut self, lane: usize, child: Child, bounds: &AxisBox) {
        self.children[lane] = child;
        self.boxes.set(lane, bounds);
    }

    fn holds(&self, bounds: &AxisBox) -> bool {
        let all = self.boxes.union();
        all.union(bounds) == all
    }

    fn least_growth(&self, bounds: &AxisBox) -> usize {
        let growth = |lane: usize| {
            let old = self.boxes.lane(lane);
            let grown = old.union(bounds).girth();
            (grown - old.girth(), grown)
        };
        let cost = |lane: &usize| growth(*lane);
        (0..LANES)
            .min_by(|i, j| {
                let ((p, a), (q, b)) = (cost(i), cost(j));
                p.total_cmp(&q).then(a.total_cmp(&b))
            })
            .unwrap_or(0)
    }

    /// Mask of the lanes whose boxes overlap a box.
    #[inline(always)]
    fn overlaps<S: Simd>(&self, simd: S, with: &AxisBox) -> u8 {
        let apart = self.boxes.beyond(simd, 0, with)
            | self.boxes.beyond(simd, 1, with)
            | self.boxes.beyond(simd, 2, with);
        low_byte(!apart.to_bitmask())
    }

    /// For each lane a bit mask of the selected boxes that overlap its box, and the mask of lanes with any overlap.
    #[inline(always)]
    fn overlaps_any<S: Simd>(&self, simd: S, with: SelectedBoxes) -> ([u8; LANES], u8) {
        let SelectedBoxes { boxes, mask } = with;
        if mask.count_ones() > FEW_BOXES {
            return self.overlaps_many(simd, with);
        }
        let (mut by_box, mut any, mut left) = (0, 0, mask);
        while left != 0 {
            let lane = left.trailing_zeros() as usize;
            left &= left - 1;
            let near = self.overlaps(simd, &boxes.lane(lane));
            by_box |= u64::from(near) << (8 * lane);
            any |= near;
        }
        (transposed(by_box).to_le_bytes(), any)
    }

    /// As above, for many boxes: lane by lane.
    #[inline(always)]
    fn overlaps_many<S: Simd>(&self, simd: S, with: SelectedBoxes) -> ([u8; LANES], u8) {
        let SelectedBoxes { boxes, mask } = with;
        let (mut near, mut any) = ([0; LANES], 0);
        for (lane, near) in near.iter_mut().enumerate() {
            let own = self.boxes.lane(lane);
            let apart =
                boxes.beyond(simd, 0, &own) | boxes.beyond(simd, 1, &own) | boxes.beyond(simd, 2, &own);
            *near = low_byte(!apart.to_bitmask()) & mask;
            any |= u8::from(*near != 0) << lane;
        }
        (near, any)
    }
}

#[cfg(test)]
mod tests;
