//! Trees of very many cubes, built quickly: halves of equal count across the widest axis; all frames are along the
//! axes of the tree.
//!
//! Surfaces get a more carefully built tree, since they are queried during the whole life of a robot. A cloud is replaced at the next
//! camera image.

use clearance_geometry::Cube;
use clearance_geometry::math::{Extremes, Point, Vector};
use clearance_geometry::simd::LANES;

use super::cube_leaf::{CubeLeaf, corners_of};
use super::tree::{Leaf, Node, NodeRef, Tree};
use crate::bounding_volume::{Axes, BoundingVolume};

impl<B: BoundingVolume> Tree<B, CubeLeaf> {
    /// A tree over cubes, and the order in which its leaves hold them.
    ///
    /// # Panics
    /// When there are no cubes, or more than 2³¹ of them.
    #[must_use]
    #[inline]
    pub fn of_cubes(cubes: impl Iterator<Item = Cube>) -> (Self, Vec<u32>) {
        let mut seeds: Vec<Seed> = cubes.zip(0..).map(|(cube, number)| Seed { cube, number }).collect();
        assert!(!seeds.is_empty(), "a tree needs cubes");
        assert!(seeds.len() >> 31 == 0, "cube count fits 31 bits");
        let whole = Cuboid::around_centres(&seeds);
        let anchor = Point::from(whole.low.map(f64::from)) + whole.widths() * 0.5;
        let leaves = Vec::with_capacity(seeds.len() / LANES + 1);
        let mut builder = Builder { anchor, nodes: Vec::new(), leaves, reach: 0.0 };
        let (root, _) = builder.subtree(&mut seeds, 0);
        let Builder { anchor, mut nodes, leaves, reach } = builder;
        nodes.shrink_to_fit();
        let order = seeds.iter().map(|seed| seed.number).collect();
        (Self::new(anchor, reach, root, nodes, leaves), order)
    }
}

/// A cube, with its index in the input.
#[derive(Clone, Copy)]
struct Seed {
    cube: Cube,
    number: u32,
}

/// A box along the axes, in the frame of the cubes.
struct Cuboid {
    low: [f32; 3],
    high: [f32; 3],
}

impl Cuboid {
    fn around_centres(seeds: &[Seed]) -> Self {
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for seed in seeds {
            for i in 0..3 {
                low[i] = low[i].lesser(seed.cube.centre[i]);
                high[i] = high[i].greater(seed.cube.centre[i]);
            }
        }
        Self { low, high }
    }

    fn widths(&self) -> Vector {
        Vector::from(self.high.map(f64::from)) - Vector::from(self.low.map(f64::from))
    }
}

struct Builder<B: BoundingVolume> {
    anchor: Point,
    nodes: Vec<Node<B>>,
    leaves: Vec<Leaf<B, CubeLeaf>>,
    /// Largest distance (m, 1-norm) from the anchor so far.
    reach: f64,
}

impl<B: BoundingVolume> Builder<B> {
    /// Builds the subtree of some cubes, which begin at `start` in the whole; returns the corners of the box around them.
    fn subtree(&mut self, seeds: &mut [Seed], start: u32) -> (NodeRef, [Vector; 2]) {
        if seeds.len() <= LANES {
            return self.leaf(seeds, start);
        }
        let ends = parts(seeds);
        let index = self.nodes.len();
        self.nodes.push(Node {
            axes: Axes::IDENTITY,
            volume: B::fit(&[Vector::zeros()]),
            pack: B::pack(&[B::fit(&[Vector::zeros()])]),
            children: [NodeRef::leaf(0); LANES],
            child_count: 0,
        });
        let mut children = [NodeRef::leaf(0); LANES];
        let mut volumes = Vec::with_capacity(LANES);
        let mut corners: Option<[Vector; 2]> = None;
        for (child, part) in ends.windows(2).enumerate() {
            let from = start + u32::try_from(part[0]).expect("counts fit 32 bits");
            let (made, [low, high]) = self.subtree(&mut seeds[part[0]..part[1]], from);
            children[child] = made;
            // all frames are the same
            volumes.push(*self.volume(made));
            corners = Some(corners.map_or([low, high], |[l, h]| [l.inf(&low), h.sup(&high)]));
        }
        let corners = corners.expect("there are parts");
        let child_count = u32::try_from(volumes.len()).expect("at most eight");
        let (volume, pack) = (around(&corners), B::pack(&volumes));
        self.nodes[index] = Node { axes: Axes::IDENTITY, volume, pack, children, child_count };
        (NodeRef::node(index), corners)
    }

    fn leaf(&mut self, seeds: &[Seed], start: u32) -> (NodeRef, [Vector; 2]) {
        let mut cubes = [seeds[0].cube; LANES];
        let mut corners = corners_of(&seeds[0].cube, &self.anchor);
        for (cube, seed) in cubes.iter_mut().zip(seeds) {
            *cube = seed.cube;
            let [low, high] = corners_of(cube, &self.anchor);
            corners = [corners[0].inf(&low), corners[1].sup(&high)];
        }
        self.reach = self.reach.greater(corners[0].abs().sup(&corners[1].abs()).sum());
        self.leaves.push(Leaf {
            axes: Axes::IDENTITY,
            volume: around(&corners),
            content: CubeLeaf::new(&self.anchor, start, &cubes[..seeds.len()]),
        });
        (NodeRef::leaf(self.leaves.len() - 1), corners)
    }

    fn volume(&self, of: NodeRef) -> &B {
        if of.is_leaf() { &self.leaves[of.index()].volume } else { &self.nodes[of.index()].volume }
    }
}

/// A volume around a box.
fn around<B: BoundingVolume>([low, high]: &[Vector; 2]) -> B {
    let side = |i: usize, bit: usize, axis: usize| if i & bit == 0 { low[axis] } else { high[axis] };
    let corners: [Vector; 8] =
        std::array::from_fn(|i| Vector::new(side(i, 1, 0), side(i, 2, 1), side(i, 4, 2)));
    B::fit(&corners)
}

/// Sorts cubes into at most eight groups of neighbours; returns the ends of the groups, after a zero.
fn parts(seeds: &mut [Seed]) -> Vec<usize> {
    let mut ends = vec![0, seeds.len()];
    for _ in 0..3 {
        let mut finer = Vec::with_capacity(2 * ends.len());
        finer.push(0);
        for part in ends.windows(2) {
            if let Some(half) = split(&mut seeds[part[0]..part[1]]) {
                finer.push(part[0] + half);
            }
            finer.push(part[1]);
        }
        ends = finer;
    }
    ends
}

/// Moves the lower half along the widest axis to the front; returns its size: a multiple of the leaf capacity, so that leaves are full.
fn split(seeds: &mut [Seed]) -> Option<usize> {
    if seeds.len() <= LANES {
        return None;
    }
    let axis = Cuboid::around_centres(seeds).widths().imax();
    let half = seeds.len().div_ceil(LANES) / 2 * LANES;
    seeds.select_nth_unstable_by(half, |p, q| p.cube.centre[axis].total_cmp(&q.cube.centre[axis]));
    Some(half)
}
