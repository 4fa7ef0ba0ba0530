//! Grains: clouds of points and sets of voxels, stored unchanged in f64, with a tree over them.

use std::sync::Arc;

use clearance_geometry::math::{Extremes, MatrixPose, Point, Pose, Vector};
use clearance_geometry::{Cube, PointCloud, Voxels};

use super::core::{Core, RoundedCore};
use super::element::ElementNumber;
use super::element_pair::separation_within;
use super::incumbent::Incumbent;
use crate::bounding_volume::{BoundingVolume, Relative};
use crate::bvh::{Grain, GrainLeaf, Tree};

/// Points or cubes of one frame, each with a ball of a common radius around it.
#[derive(Clone, Debug)]
pub(super) struct Grains<B: BoundingVolume> {
    /// Tree of the grains without the balls.
    pub tree: Tree<B, GrainLeaf>,
    /// Pose of the grains' frame in the body.
    pub pose_bg: MatrixPose,
    /// Radius of the balls (m).
    pub radius: f64,
    /// Index among the sets of grains of the body.
    pub set: u32,
    source: Source,
    /// Order of the grains in the leaves.
    order: Vec<u32>,
}

#[derive(Clone, Debug)]
enum Source {
    Points(Arc<PointCloud>),
    Voxels(Arc<Voxels>),
}

impl<B: BoundingVolume> Grains<B> {
    #[inline]
    pub fn of_points(cloud: &Arc<PointCloud>, pose: &Pose, set: u32) -> Self {
        let points = cloud.points().iter().map(|centre| Grain { centre: *centre, half_edge: 0.0 });
        let (tree, order) = Tree::of_grains(points);
        let source = Source::Points(Arc::clone(cloud));
        Self { tree, pose_bg: pose.into(), radius: cloud.radius(), set, source, order }
    }

    #[inline]
    pub fn of_voxels(voxels: &Arc<Voxels>, pose: &Pose, set: u32) -> Self {
        let cubes = voxels.cubes().iter().map(|&Cube { centre, half_edge }| Grain { centre, half_edge });
        let (tree, order) = Tree::of_grains(cubes);
        let source = Source::Voxels(Arc::clone(voxels));
        Self { tree, pose_bg: pose.into(), radius: 0.0, set, source, order }
    }

    /// Grain `index` in the order of the leaves, as it was given.
    fn grain(&self, index: u32) -> Grain {
        let number = self.order[index as usize] as usize;
        match &self.source {
            Source::Points(cloud) => Grain { centre: cloud.points()[number], half_edge: 0.0 },
            Source::Voxels(voxels) => {
                let Cube { centre, half_edge } = voxels.cubes()[number];
                Grain { centre, half_edge }
            }
        }
    }

    /// Centre of grain `index`, in the frame of the body.
    #[inline]
    pub fn centre(&self, index: u32) -> Point {
        &self.pose_bg * Point::from(self.grain(index).centre.map(f64::from))
    }

    /// Grain `index` in the order of the leaves.
    #[inline]
    pub fn core(&self, index: u32) -> RoundedCore {
        let half_edge = f64::from(self.grain(index).half_edge);
        let core = match self.source {
            Source::Points(_) => Core::Point,
            Source::Voxels(_) => Core::Cuboid(Vector::repeat(half_edge)),
        };
        let translation = self.centre(index).coords;
        RoundedCore {
            core,
            pose: MatrixPose { rotation: self.pose_bg.rotation, translation },
            radius: self.radius,
        }
    }

    /// A sphere around all grains: its centre and radius (m), in the frame of the body.
    #[inline]
    pub fn ball(&self) -> (Point, f64) {
        let anchor = self.tree.anchor();
        let reach = |grain: Grain| {
            let diagonal = f64::from(grain.half_edge) * 3.0_f64.sqrt();
            nalgebra::distance(anchor, &Point::from(grain.centre.map(f64::from))) + diagonal
        };
        let all = 0..u32::try_from(self.order.len()).expect("grain count fits 31 bits");
        let reach = all.map(|i| reach(self.grain(i))).fold(0.0, f64::greater);
        (&self.pose_bg * *anchor, reach + self.radius)
    }

    #[inline]
    pub fn count(&self) -> usize {
        self.order.len()
    }

    /// Memory in bytes.
    #[inline]
    pub fn bytes(&self) -> usize {
        let own = match &self.source {
            Source::Points(cloud) => size_of_val(cloud.points()),
            Source::Voxels(voxels) => size_of_val(voxels.cubes()),
        };
        own + self.order.capacity() * size_of::<u32>() + self.tree.bytes()
    }
}

/// Grains of one body, and the elements of the other body found near them. The tree of grains is the second in a traversal.
pub(super) struct GrainSearch<'s, 'w, B: BoundingVolume> {
    pub grains: &'s Grains<B>,
    /// True if the grains belong to body a.
    pub grains_are_a: bool,
    pub pose_ab: &'s MatrixPose,
    /// Pose of the other tree in that of the grains.
    pub relative: &'s Relative,
    /// Of the balls around what the trees hold (m).
    pub radius: f64,
    pub incumbent: &'s mut Incumbent<'w>,
}

impl<B: BoundingVolume> GrainSearch<'_, '_, B> {
    /// Trees farther apart than this (m) are skipped.
    #[inline]
    pub fn threshold(&self) -> f32 {
        widened(self.incumbent.threshold(), self.radius)
    }

    /// The direction of the best separation, in the frame of the grains' tree; length at most one.
    #[allow(clippy::cast_possible_truncation)] // bounds hold for any direction
    #[inline]
    pub fn direction(&self) -> [f32; 3] {
        let Some(best) = &self.incumbent.best else { return [0.0; 3] };
        let [p, q] = best.witness_points;
        let along = (q - p).try_normalize(0.0).unwrap_or_else(Vector::zeros);
        let in_body = if self.grains_are_a { along } else { self.pose_ab.rotation.tr_mul(&along) };
        let along = self.grains.pose_bg.rotation.tr_mul(&in_body) * (1.0 - f64::from(8.0 * f32::EPSILON));
        [along.x as f32, along.y as f32, along.z as f32]
    }

    /// Measures one element of the other body and one grain.
    #[inline]
    pub fn test(&mut self, (other, number): (&RoundedCore, ElementNumber), grain: u32) {
        self.incumbent.work.primitive_tests += 1;
        let core = &self.grains.core(grain);
        let own = ElementNumber::of_grain(self.grains.set, grain);
        let ((a, b), numbers) =
            if self.grains_are_a { ((core, other), (own, number)) } else { ((other, core), (number, own)) };
        if let Some(found) = separation_within(a, b, self.pose_ab, self.incumbent.bound()) {
            self.incumbent.offer_numbered(found, numbers);
        }
    }
}

/// A threshold for elements with balls of a given radius (m) around them; rounded up.
#[allow(clippy::cast_possible_truncation)] // rounded up right after
#[inline]
pub(super) fn widened(threshold: f32, radius: f64) -> f32 {
    if radius == 0.0 || threshold == f32::NEG_INFINITY {
        return threshold;
    }
    ((f64::from(threshold) + radius) as f32).next_up()
}
