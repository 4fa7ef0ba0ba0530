//! Broad phase for comparison: k-d tree of boxes (Bentley 1975), whose planes across the axes divide space in turn.
//! A box that a plane crosses stays at the plane's node.

use clearance::proximity::bvh::AxisBox;

use super::structures::{BroadPhase, ItemBoxes};

/// Largest number of boxes that are not divided further.
const LEAF: usize = 8;

/// Boxes divided at the median of their centres. After as many edits as there are boxes, the tree is built again.
pub struct KdTree {
    nodes: Vec<Node>,
    boxes: ItemBoxes,
    edits: usize,
    stack: Vec<u32>,
}

#[derive(Default)]
struct Node {
    /// The boxes of a leaf, or those that the plane crosses.
    items: Vec<u32>,
    plane: Option<DividingPlane>,
}

#[derive(Clone, Copy)]
struct DividingPlane {
    axis: usize,
    at: f32,
    /// Numbers of the nodes below and above the plane.
    sides: [u32; 2],
}

/// Where a box lies relative to a plane.
enum Side {
    Below,
    Above,
    Both,
}

impl BroadPhase for KdTree {
    const NAME: &'static str = "k-d tree";

    fn build(items: &[(u32, AxisBox)]) -> Self {
        let mut tree = Self { nodes: Vec::new(), boxes: ItemBoxes::default(), edits: 0, stack: Vec::new() };
        for (item, bounds) in items {
            tree.boxes.insert(*item, bounds);
        }
        tree.divide_all();
        tree
    }

    fn set(&mut self, item: u32, bounds: &AxisBox) {
        self.remove(item);
        self.boxes.insert(item, bounds);
        let node = self.node_of(bounds);
        self.nodes[node].items.push(item);
        self.edits += 1;
        if self.edits > self.boxes.len() {
            self.divide_all();
        }
    }

    fn remove(&mut self, item: u32) {
        if let Some(bounds) = self.boxes.take(item) {
            let node = self.node_of(&bounds);
            self.nodes[node].items.retain(|other| *other != item);
        }
    }

    fn overlapping(&mut self, _: u32, with: &AxisBox, found: &mut Vec<u32>) {
        self.stack.push(0);
        while let Some(number) = self.stack.pop() {
            let node = &self.nodes[number as usize];
            found.extend(node.items.iter().filter(|item| self.boxes.overlaps(**item, with)));
            if let Some(plane) = node.plane {
                match plane.side(with) {
                    Side::Below => self.stack.push(plane.sides[0]),
                    Side::Above => self.stack.push(plane.sides[1]),
                    Side::Both => self.stack.extend(plane.sides),
                }
            }
        }
    }
}

impl KdTree {
    fn divide_all(&mut self) {
        let items = self.boxes.items().collect();
        self.nodes.clear();
        self.edits = 0;
        self.nodes.push(Node { items, plane: None });
        self.divide(0, 0);
    }

    /// Divides a leaf across `axis`, or across another one if the medians of this one divide nothing.
    fn divide(&mut self, number: usize, axis: usize) {
        if self.nodes[number].items.len() <= LEAF {
            return;
        }
        let items = std::mem::take(&mut self.nodes[number].items);
        let planes = (0..3).map(|turn| self.median_plane(&items, (axis + turn) % 3));
        let Some((mut plane, [below, above, crossed])) =
            planes.into_iter().map(|plane| (plane, self.parts(&items, plane))).find(|(_, parts)| {
                let most = items.len() / 2 + items.len() / 4;
                parts.iter().all(|part| part.len() <= most)
            })
        else {
            self.nodes[number].items = items;
            return;
        };
        let first = u32::try_from(self.nodes.len()).expect("fewer nodes than items");
        plane.sides = [first, first + 1];
        self.nodes.extend([below, above].map(|items| Node { items, plane: None }));
        self.nodes[number] = Node { items: crossed, plane: Some(plane) };
        for side in plane.sides {
            self.divide(side as usize, (plane.axis + 1) % 3);
        }
    }

    fn median_plane(&self, items: &[u32], axis: usize) -> DividingPlane {
        let centre = |item: &u32| self.boxes.get(*item).map_or(0.0, |b| 0.5 * (b.lo[axis] + b.hi[axis]));
        let mut centres: Vec<f32> = items.iter().map(centre).collect();
        centres.sort_by(f32::total_cmp);
        DividingPlane { axis, at: centres[centres.len() / 2], sides: [0; 2] }
    }

    /// The items below, above and across a plane.
    fn parts(&self, items: &[u32], plane: DividingPlane) -> [Vec<u32>; 3] {
        let mut parts: [Vec<u32>; 3] = Default::default();
        for &item in items {
            let side = self.boxes.get(item).map_or(Side::Both, |bounds| plane.side(&bounds));
            parts[side as usize].push(item);
        }
        parts
    }

    /// Number of the node that holds a box.
    fn node_of(&self, bounds: &AxisBox) -> usize {
        let mut number = 0;
        while let Some(plane) = self.nodes[number].plane {
            number = match plane.side(bounds) {
                Side::Below => plane.sides[0] as usize,
                Side::Above => plane.sides[1] as usize,
                Side::Both => break,
            };
        }
        number
    }
}

impl DividingPlane {
    fn side(&self, bounds: &AxisBox) -> Side {
        if bounds.hi[self.axis] < self.at {
            Side::Below
        } else if bounds.lo[self.axis] > self.at {
            Side::Above
        } else {
            Side::Both
        }
    }
}
