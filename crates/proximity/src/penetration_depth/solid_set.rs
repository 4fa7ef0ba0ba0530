//! Sets of solids (points with a radius, voxels), and the search for those that may be deepest in a body.

use std::sync::Arc;

use clearance_geometry::math::{Extremes, MatrixPose, Point, Pose};
use clearance_geometry::{PointCloud, Primitive, Shape, Voxels};

use super::solid_body::Union;
use crate::search::Scratch;

/// A cloud or a set of voxels, posed in the frame of its body.
#[derive(Clone, Debug)]
pub(super) enum SolidSet {
    Points { cloud: Arc<PointCloud>, pose: Pose },
    Voxels { voxels: Arc<Voxels>, pose: Pose },
}

impl SolidSet {
    /// The whole set, with its pose.
    pub fn shape(&self) -> (Pose, Shape) {
        match self {
            Self::Points { cloud, pose } => (*pose, Shape::Points(Arc::clone(cloud))),
            Self::Voxels { voxels, pose } => (*pose, Shape::Voxels(Arc::clone(voxels))),
        }
    }

    pub fn count(&self) -> usize {
        match self {
            Self::Points { cloud, .. } => cloud.points().len(),
            Self::Voxels { voxels, .. } => voxels.cubes().len(),
        }
    }

    /// The centre of a ball or cube, and the radius (m) of the ball around it.
    pub fn ball(&self, index: usize) -> (Point, f64) {
        match self {
            Self::Points { cloud, pose } => {
                (pose * Point::from(cloud.points()[index].map(f64::from)), cloud.radius())
            }
            Self::Voxels { voxels, pose } => {
                let cube = &voxels.cubes()[index];
                (pose * Point::from(cube.centre.map(f64::from)), 3.0_f64.sqrt() * f64::from(cube.half_edge))
            }
        }
    }

    /// Radius (m) of the ball inside a ball or cube, from that of the ball around it.
    fn inner_radius(&self, radius: f64) -> f64 {
        match self {
            Self::Points { .. } => radius,
            Self::Voxels { .. } => radius / 3.0_f64.sqrt(),
        }
    }

    /// One of the balls or cubes.
    pub fn solid(&self, index: usize) -> Option<Union> {
        let (centre, radius) = self.ball(index);
        match self {
            Self::Points { pose, .. } => {
                let pose = Pose::from_parts(centre.coords.into(), pose.rotation);
                Union::of_convex(Primitive::Sphere { radius }, &pose)
            }
            Self::Voxels { voxels, pose } => {
                let half = f64::from(voxels.cubes()[index].half_edge);
                let pose = Pose::from_parts(centre.coords.into(), pose.rotation);
                Union::of_convex(Primitive::Box { half_extents: [half; 3] }, &pose)
            }
        }
    }
}

/// Most balls or cubes that are compared by their depths.
const MOST_CANDIDATES: usize = 64;

/// A ball or cube that may be the deepest.
struct Candidate {
    index: usize,
    /// It is not deeper than this (m).
    most: f64,
}

/// Searches for the balls or cubes that may be deepest in a body: those that are possibly deeper than another one certainly is. Of too many,
/// those with the largest bounds.
///
/// The depth of a point changes at most as much as the point moves, so that neighbours of a shallow point are passed over.
pub(super) fn deepest_solids(
    set: &SolidSet,
    body: &Union,
    pose_body_set: &MatrixPose,
    margin: f64,
    scratch: &mut Scratch,
) -> Vec<usize> {
    let bound = body.bounding_sphere();
    let mut candidates: Vec<Candidate> = Vec::new();
    // one of them is at least this deep
    let mut least = 0.0;
    let mut last: Option<(Point, f64)> = None;
    for index in 0..set.count() {
        let (centre, radius) = set.ball(index);
        let centre = pose_body_set * centre;
        if nalgebra::distance(&centre, &bound.centre) > bound.radius + radius + margin - least {
            continue;
        }
        if last.is_some_and(|(p, depth)| depth + nalgebra::distance(&p, &centre) + radius + margin < least) {
            continue;
        }
        let depth = body.depth_of_point(&centre, scratch);
        last = Some((centre, depth));
        let most = depth + radius + margin;
        if most >= least {
            least = least.greater(depth + set.inner_radius(radius) + margin);
            candidates.push(Candidate { index, most });
        }
    }
    candidates.retain(|candidate| candidate.most >= least);
    candidates.sort_by(|a, b| b.most.total_cmp(&a.most).then(a.index.cmp(&b.index)));
    candidates.truncate(MOST_CANDIDATES);
    candidates.into_iter().map(|candidate| candidate.index).collect()
}
