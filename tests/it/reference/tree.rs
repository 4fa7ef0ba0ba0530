//! Test oracle: bounding volume tree, built top down with splits at the median along the longest principal axis.

use clearance::geometry::math::{Point, Vector};
use clearance::proximity::Element;

use super::bounding_volume::{BoundingVolume, principal_axes};
use super::obb::Obb;

/// Most triangles in a leaf. A primitive always has a leaf of its own.
pub const LEAF_TRIANGLES: usize = 2;

/// A binary tree of volumes over elements; node 0 is the root. Splitting at the median keeps it as shallow as the
/// logarithm of the count.
#[derive(Clone, Debug)]
pub struct Tree<B> {
    nodes: Vec<Node<B>>,
    order: Vec<u32>,
}

/// A volume and what it holds.
#[derive(Clone, Debug)]
pub struct Node<B> {
    pub volume: B,
    pub content: Content,
}

/// Two nodes, or a run of elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    Children([u32; 2]),
    /// From and to (exclusive) in the tree's order of elements.
    Leaf(u32, u32),
}

/// The node around everything.
pub const ROOT: u32 = 0;

impl<B: BoundingVolume> Tree<B> {
    /// # Panics
    /// When there are no elements, or more than 2³¹ of them.
    #[must_use]
    pub fn build(elements: &[Element]) -> Self {
        assert!(!elements.is_empty(), "a tree needs elements");
        let count = u32::try_from(elements.len()).expect("element count fits 32 bits");
        let mut builder = Builder {
            elements,
            middles: elements.iter().map(middle).collect(),
            points: Vec::new(),
            nodes: Vec::new(),
        };
        let mut order: Vec<u32> = (0..count).collect();
        builder.node(&mut order, 0);
        Self { nodes: builder.nodes, order }
    }

    #[must_use]
    pub fn node(&self, index: u32) -> &Node<B> {
        &self.nodes[index as usize]
    }

    /// Numbers of the elements of a leaf.
    #[must_use]
    pub fn leaf(&self, from: u32, to: u32) -> &[u32] {
        &self.order[from as usize..to as usize]
    }
}

struct Builder<'a, B> {
    elements: &'a [Element],
    middles: Vec<Point>,
    points: Vec<Point>,
    nodes: Vec<Node<B>>,
}

impl<B: BoundingVolume> Builder<'_, B> {
    /// Builds the node over `order`, which begins at `start` in the whole; returns its index.
    fn node(&mut self, order: &mut [u32], start: u32) -> u32 {
        let index = u32::try_from(self.nodes.len()).expect("node count fits 32 bits");
        let count = u32::try_from(order.len()).expect("element count fits 32 bits");
        let volume = self.volume(order);
        self.nodes.push(Node { volume, content: Content::Leaf(start, start + count) });
        if !self.is_leaf(order) {
            let half = self.split(order);
            let (left, right) = order.split_at_mut(half);
            let middle = start + u32::try_from(half).expect("half of a 32-bit count");
            let children = [self.node(left, start), self.node(right, middle)];
            self.nodes[index as usize].content = Content::Children(children);
        }
        index
    }

    fn volume(&mut self, order: &[u32]) -> B {
        if let [one] = order
            && let Element::Primitive { primitive, pose } = &self.elements[*one as usize]
        {
            return B::around(primitive, pose);
        }
        self.points.clear();
        for &i in order {
            hull_points(&self.elements[i as usize], &mut self.points);
        }
        B::fit(&self.points)
    }

    fn is_leaf(&self, order: &[u32]) -> bool {
        let triangle = |i: &u32| matches!(self.elements[*i as usize], Element::Triangle(_));
        order.len() == 1 || (order.len() <= LEAF_TRIANGLES && order.iter().all(triangle))
    }

    /// Sorts the half with smaller middles along the longest axis to the front; returns how many that are.
    fn split(&mut self, order: &mut [u32]) -> usize {
        self.points.clear();
        self.points.extend(order.iter().map(|&i| self.middles[i as usize]));
        let axis: Vector = principal_axes(&self.points).column(0).into();
        let half = order.len() / 2;
        let key = |i: u32| self.middles[i as usize].coords.dot(&axis);
        order.select_nth_unstable_by(half, |&i, &j| key(i).total_cmp(&key(j)).then(i.cmp(&j)));
        half
    }
}

/// Points whose convex hull holds the element.
pub fn hull_points(element: &Element, points: &mut Vec<Point>) {
    match element {
        Element::Triangle(t) => points.extend(t.corners()),
        Element::Primitive { primitive, pose } => points.extend(Obb::around(primitive, pose).corners()),
    }
}

/// The point by which elements are sorted to one side or the other.
fn middle(element: &Element) -> Point {
    match element {
        Element::Triangle(t) => Point::from((t.a.coords + t.b.coords + t.c.coords) / 3.0),
        Element::Primitive { pose, .. } => Point::from(pose.translation.vector),
    }
}
