//! Sets of cubes: voxels, and the points of a cloud, which are cubes of edge zero with a ball around them.
//!
//! They are stored unchanged, and measured in f64, with a tree over them.

use std::sync::Arc;

use clearance_geometry::math::{Extremes, MatrixPose, Point, Pose, Vector};
use clearance_geometry::{Cube, PointCloud, Voxels};

use crate::bounding_volume::Obb;
use crate::bvh::{CubeLeaf, Tree};
use crate::elements::{CoreShape, ElementId, RoundedShape};

/// Cubes along the axes of one frame, each swept by a ball of a common radius.
#[derive(Clone, Debug)]
pub(crate) struct CubeSet {
    /// Tree of the cubes without the balls.
    tree: Tree<Obb, CubeLeaf>,
    /// Pose of the cubes' frame in the body.
    pose_bs: MatrixPose,
    /// Radius of the balls (m).
    radius: f64,
    /// Index among the sets of cubes of the body.
    index: u32,
    source: Source,
    /// Order of the cubes in the leaves.
    order: Vec<u32>,
}

#[derive(Clone, Debug)]
enum Source {
    Points(Arc<PointCloud>),
    Voxels(Arc<Voxels>),
}

impl CubeSet {
    #[inline]
    pub fn of_points(cloud: &Arc<PointCloud>, pose: &Pose, index: u32) -> Self {
        let points = cloud.points().iter().map(|centre| Cube { centre: *centre, half_edge: 0.0 });
        let (tree, order) = Tree::of_cubes(points);
        let source = Source::Points(Arc::clone(cloud));
        Self { tree, pose_bs: pose.into(), radius: cloud.radius(), index, source, order }
    }

    #[inline]
    pub fn of_voxels(voxels: &Arc<Voxels>, pose: &Pose, index: u32) -> Self {
        let (tree, order) = Tree::of_cubes(voxels.cubes().iter().copied());
        let source = Source::Voxels(Arc::clone(voxels));
        Self { tree, pose_bs: pose.into(), radius: 0.0, index, source, order }
    }

    /// Cube `index` in the order of the leaves, as it was given.
    fn cube(&self, index: u32) -> Cube {
        let number = self.order[index as usize] as usize;
        match &self.source {
            Source::Points(cloud) => Cube { centre: cloud.points()[number], half_edge: 0.0 },
            Source::Voxels(voxels) => voxels.cubes()[number],
        }
    }

    /// Tree over the cubes, without the balls.
    #[inline]
    pub fn tree(&self) -> &Tree<Obb, CubeLeaf> {
        &self.tree
    }

    /// Pose of the set's frame in the body.
    #[inline]
    pub fn pose_bs(&self) -> &MatrixPose {
        &self.pose_bs
    }

    /// Radius (m) of the ball around every point of a cube.
    #[inline]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Index among the sets of the body.
    #[inline]
    pub fn index(&self) -> u32 {
        self.index
    }

    /// Identifier of cube `index`, in the order of the leaves.
    #[inline]
    pub fn id(&self, index: u32) -> ElementId {
        ElementId::of_cube(self.index, index)
    }

    /// Centre of cube `index`, in the frame of the body.
    #[inline]
    pub fn centre(&self, index: u32) -> Point {
        &self.pose_bs * Point::from(self.cube(index).centre.map(f64::from))
    }

    /// Cube `index` in the order of the leaves.
    #[inline]
    pub fn shape(&self, index: u32) -> RoundedShape {
        let half_edge = f64::from(self.cube(index).half_edge);
        let core = match self.source {
            Source::Points(_) => CoreShape::Point,
            Source::Voxels(_) => CoreShape::Cuboid(Vector::repeat(half_edge)),
        };
        let translation = self.centre(index).coords;
        RoundedShape {
            core,
            pose: MatrixPose { rotation: self.pose_bs.rotation, translation },
            radius: self.radius,
        }
    }

    /// A sphere around all cubes: its centre and radius (m), in the frame of the body.
    #[inline]
    pub fn ball(&self) -> (Point, f64) {
        let anchor = self.tree.anchor();
        let reach = |cube: Cube| {
            let diagonal = f64::from(cube.half_edge) * 3.0_f64.sqrt();
            nalgebra::distance(anchor, &Point::from(cube.centre.map(f64::from))) + diagonal
        };
        let all = 0..u32::try_from(self.order.len()).expect("cube count fits 31 bits");
        let reach = all.map(|i| reach(self.cube(i))).fold(0.0, f64::greater);
        (&self.pose_bs * *anchor, reach + self.radius)
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
