//! Bounding volumes at one level of a body's hierarchies, for visualisation only.

use clearance_geometry::math::{Point, Pose, Rotation, Vector};

use crate::bounding_volume::{BoundingVolume, Obb, Outline};
use crate::bvh::{NodeRef, Tree};

/// A volume of a hierarchy, in the frame of its body.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyVolume {
    /// Pose of the volume in the frame of the body.
    pub pose_bv: Pose,
    /// Its shape in its own frame.
    pub shape: VolumeShape,
}

/// Shape of a volume.
#[derive(Clone, Debug, PartialEq)]
pub enum VolumeShape {
    /// A box around the origin.
    Box {
        /// Half extents (m) along the axes.
        half_extents: Vector,
    },
    /// A ball around the origin.
    Ball {
        /// Radius (m).
        radius: f64,
    },
    /// A convex surface of triangles.
    Triangles(Vec<[Point; 3]>),
}

impl BodyVolume {
    /// The volumes of a tree at a given depth below its root, in the frame of the tree.
    pub(super) fn of_tree<L>(tree: &Tree<Obb, L>, level: usize) -> Vec<Self> {
        tree.at_level(level).into_iter().map(|node| Self::of_node(tree, node)).collect()
    }

    fn of_node<L>(tree: &Tree<Obb, L>, node: NodeRef) -> Self {
        let own = || {
            let (volume, axes) = tree.volume(node);
            (volume.outline(), axes.columns())
        };
        let (outline, turn) = tree.other_volumes().own().map_or_else(own, |own| own.outline(node));
        let at = |centre: Point| {
            Pose::from_parts(
                (tree.anchor() + turn * centre.coords).coords.into(),
                Rotation::from_matrix(&turn),
            )
        };
        match outline {
            Outline::Box { centre, half_extents } => {
                Self { pose_bv: at(centre), shape: VolumeShape::Box { half_extents } }
            }
            Outline::Ball { centre, radius } => {
                Self { pose_bv: at(centre), shape: VolumeShape::Ball { radius } }
            }
            Outline::Triangles(triangles) => {
                Self { pose_bv: at(Point::origin()), shape: VolumeShape::Triangles(triangles) }
            }
        }
    }

    /// The volume of a tree placed at `pose_bt` in its body, enlarged by `radius` (m), which surfaces of triangles are not.
    pub(super) fn placed(self, pose_bt: &Pose, radius: f64) -> Self {
        let shape = match self.shape {
            VolumeShape::Box { half_extents } => {
                VolumeShape::Box { half_extents: half_extents.add_scalar(radius) }
            }
            VolumeShape::Ball { radius: own } => VolumeShape::Ball { radius: own + radius },
            triangles @ VolumeShape::Triangles(_) => triangles,
        };
        Self { pose_bv: pose_bt * self.pose_bv, shape }
    }
}
