//! Boxes of a hierarchy at one level, for visualisation only.

use clearance_geometry::math::{Pose, Rotation, RotationMatrix, Vector};

use crate::bounding_volume::{Axes, Obb};
use crate::bvh::Tree;

/// A box of a hierarchy, in the frame of its body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyVolume {
    /// Pose of the box in the frame of the body.
    pub pose_bv: Pose,
    /// Half extents (m) along the axes of the box.
    pub half_extents: Vector,
}

impl BodyVolume {
    /// The boxes of a tree at a given depth below its root, in the frame of the tree.
    pub(super) fn of_tree<L>(tree: &Tree<Obb, L>, level: usize) -> Vec<Self> {
        let placed = |(volume, axes): (&Obb, &Axes)| {
            let turn = RotationMatrix::from_fn(|i, k| f64::from(axes.0[k][i]));
            let centre = tree.anchor() + turn * Vector::from(volume.centre.map(f64::from));
            Self {
                pose_bv: Pose::from_parts(centre.coords.into(), Rotation::from_matrix(&turn)),
                half_extents: Vector::from(volume.half_extents.map(f64::from)),
            }
        };
        tree.at_level(level).into_iter().map(|node| placed(tree.volume(node))).collect()
    }

    /// The box of a tree placed at `pose_bt` in its body, enlarged by `radius` (m).
    pub(super) fn placed(&self, pose_bt: &Pose, radius: f64) -> Self {
        Self { pose_bv: pose_bt * self.pose_bv, half_extents: self.half_extents.add_scalar(radius) }
    }
}
