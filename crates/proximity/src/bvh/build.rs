//! Top-down construction of a tree: three levels of splits make the eight children of a node.

use clearance_geometry::math::{Extremes, Point, RotationMatrix, Vector};
use clearance_geometry::simd::LANES;

use super::surface_area_heuristic::{Extent, Split, best_split};
use super::tree::{Content, Leaf, Node, NodeRef, Tree};
use crate::bounding_volume::{Axes, BoundingVolume, principal_axes};

impl<B: BoundingVolume, L: Content> Tree<B, L> {
    /// A tree over items, and the order in which its leaves hold them.
    ///
    /// # Panics
    /// When there are no items, or more than 2³¹ of them.
    #[must_use]
    pub fn build(items: &[L::Item]) -> (Self, Vec<u32>) {
        assert!(!items.is_empty(), "a tree needs items");
        let count = u32::try_from(items.len()).expect("item count fits 32 bits");
        let mut corners = Vec::new();
        let mut ends = vec![0];
        for item in items {
            L::corners(item, &mut corners);
            ends.push(corners.len());
        }
        let anchor = middle(&corners);
        let corners: Vec<Vector> = corners.iter().map(|p| p - anchor).collect();
        let mut builder = Builder::<B, L> {
            items,
            centres: ends.windows(2).map(|w| mean(&corners[w[0]..w[1]])).collect(),
            ends,
            nodes: Vec::new(),
            leaves: Vec::with_capacity(items.len() / L::CAPACITY + 1),
            points: Vec::new(),
            extents: Vec::new(),
            anchor,
            corners,
        };
        let mut order: Vec<u32> = (0..count).collect();
        let root = builder.subtree(&mut order, 0);
        let reach = builder.corners.iter().map(|p| p.abs().sum()).fold(0.0, f64::greater);
        builder.nodes.shrink_to_fit();
        builder.leaves.shrink_to_fit();
        (Self::new(anchor, reach, root, builder.nodes, builder.leaves), order)
    }
}

/// The middle of the box around points.
fn middle(points: &[Point]) -> Point {
    let lo = points.iter().fold(Point::from([f64::INFINITY; 3]), |lo, p| lo.inf(p));
    let hi = points.iter().fold(Point::from([f64::NEG_INFINITY; 3]), |hi, p| hi.sup(p));
    nalgebra::center(&lo, &hi)
}

#[allow(clippy::cast_precision_loss)] // an item has few corners
fn mean(points: &[Vector]) -> Vector {
    points.iter().sum::<Vector>() / points.len() as f64
}

struct Builder<'i, B: BoundingVolume, L: Content> {
    items: &'i [L::Item],
    anchor: Point,
    /// Corners of all items in sequence, relative to the anchor.
    corners: Vec<Vector>,
    /// End of each item's corners, after a zero.
    ends: Vec<usize>,
    centres: Vec<Vector>,
    nodes: Vec<Node<B>>,
    leaves: Vec<Leaf<B, L>>,
    /// Scratch.
    points: Vec<Vector>,
    extents: Vec<Extent>,
}

impl<B: BoundingVolume, L: Content> Builder<'_, B, L> {
    /// Builds the subtree of `order`, which begins at `start` in the whole.
    fn subtree(&mut self, order: &mut [u32], start: u32) -> NodeRef {
        if order.len() <= L::CAPACITY {
            return self.leaf(order, start);
        }
        self.gather(order);
        let axes = Axes::from_columns(&B::axes(&self.points));
        self.project(order, &axes);
        let volume = B::fit(&self.points);
        let ends = self.parts(order);
        let index = self.nodes.len();
        let mut volumes = Vec::with_capacity(LANES);
        for part in ends.windows(2) {
            self.project(&order[part[0]..part[1]], &axes);
            volumes.push(B::fit(&self.points));
        }
        self.nodes.push(Node {
            axes,
            volume,
            pack: B::pack(&volumes),
            children: [NodeRef::leaf(0); LANES],
            child_count: u32::try_from(volumes.len()).expect("at most eight"),
        });
        for (child, part) in ends.windows(2).enumerate() {
            let from = start + u32::try_from(part[0]).expect("counts fit 32 bits");
            self.nodes[index].children[child] = self.subtree(&mut order[part[0]..part[1]], from);
        }
        NodeRef::node(index)
    }

    fn leaf(&mut self, order: &[u32], start: u32) -> NodeRef {
        let items: Vec<&L::Item> = order.iter().map(|&i| &self.items[i as usize]).collect();
        self.gather(order);
        let axes = L::axes(&items).unwrap_or_else(|| B::axes(&self.points));
        let axes = Axes::from_columns(&axes);
        self.project(order, &axes);
        let volume = B::fit(&self.points);
        self.leaves.push(Leaf { axes, volume, content: L::new(&self.anchor, start, &items) });
        NodeRef::leaf(self.leaves.len() - 1)
    }

    /// Leaves the corners of some items in `self.points`.
    fn gather(&mut self, order: &[u32]) {
        self.points.clear();
        for &i in order {
            let i = i as usize;
            self.points.extend_from_slice(&self.corners[self.ends[i]..self.ends[i + 1]]);
        }
    }

    /// As [`Self::gather`], along axes.
    fn project(&mut self, order: &[u32], axes: &Axes) {
        self.gather(order);
        for p in &mut self.points {
            *p = axes.along(p);
        }
    }

    /// Sorts items into at most eight groups of neighbours; returns the ends of the groups, after a zero.
    fn parts(&mut self, order: &mut [u32]) -> Vec<usize> {
        let mut ends = vec![0, order.len()];
        for _ in 0..3 {
            let mut finer = vec![0];
            for part in ends.windows(2) {
                if let Some(half) = self.split(&mut order[part[0]..part[1]]) {
                    finer.push(part[0] + half);
                }
                finer.push(part[1]);
            }
            ends = finer;
        }
        ends
    }

    /// Moves the items before the best split to the front; returns their number: a multiple of the leaf capacity, so that leaves are
    /// full.
    fn split(&mut self, order: &mut [u32]) -> Option<usize> {
        if order.len() <= L::CAPACITY {
            return None;
        }
        self.points.clear();
        self.points.extend(order.iter().map(|&i| self.centres[i as usize]));
        let axes = principal_axes(&self.points);
        let mut extents = std::mem::take(&mut self.extents);
        extents.clear();
        extents.extend(order.iter().map(|&i| self.extent(i as usize, &axes)));
        let Split { axis, count, .. } = best_split(&extents, L::CAPACITY);
        self.extents = extents;
        let axis: Vector = axes.column(axis).into();
        let key = |i: u32| self.centres[i as usize].dot(&axis);
        order.select_nth_unstable_by(count, |&i, &j| key(i).total_cmp(&key(j)).then(i.cmp(&j)));
        Some(count)
    }

    /// An item along some axes.
    fn extent(&self, item: usize, axes: &RotationMatrix) -> Extent {
        let mut lo = Vector::repeat(f64::INFINITY);
        let mut hi = Vector::repeat(f64::NEG_INFINITY);
        for p in &self.corners[self.ends[item]..self.ends[item + 1]] {
            let along = axes.tr_mul(p);
            lo = lo.inf(&along);
            hi = hi.sup(&along);
        }
        Extent { centre: axes.tr_mul(&self.centres[item]), lo, hi }
    }
}
