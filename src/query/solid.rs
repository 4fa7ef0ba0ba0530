//! Leaves that hold one solid primitive.

use super::core::RoundedCore;
use super::element::Element;
use crate::bounding_volume::Axes;
use crate::bvh::Content;
use crate::geometry::Primitive;
use crate::math::{Point, Pose, RotationMatrix};

/// A primitive placed in the frame of its body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Solid {
    pub primitive: Primitive,
    pub pose: Pose,
}

/// A solid, and the box around it in f32.
#[derive(Clone, Debug)]
pub(super) struct SolidLeaf {
    pub core: RoundedCore,
    /// In the order of the tree.
    pub number: u32,
    /// The box's axes, in the frame of the tree.
    pub axes: Axes,
    /// The box's centre, from the anchor of the tree.
    pub centre: [f32; 3],
    pub half_extents: [f32; 3],
}

impl Content for SolidLeaf {
    type Item = Solid;

    const CAPACITY: usize = 1;

    fn corners(item: &Solid, corners: &mut Vec<Point>) {
        corners.extend(item.primitive.hull_points().map(|p| item.pose * p));
    }

    fn axes(items: &[&Solid]) -> Option<RotationMatrix> {
        let [solid] = items else { return None };
        Some(*solid.pose.rotation.to_rotation_matrix().matrix())
    }

    #[allow(clippy::cast_possible_truncation)] // rounding is meant
    fn new(anchor: &Point, number: u32, items: &[&Solid]) -> Self {
        let solid = items[0];
        let h = solid.primitive.half_extents();
        let centre = solid.pose.translation.vector - anchor.coords;
        Self {
            number,
            core: RoundedCore::from(&Element::Primitive { primitive: solid.primitive, pose: solid.pose }),
            axes: Axes::from_columns(solid.pose.rotation.to_rotation_matrix().matrix()),
            centre: std::array::from_fn(|i| centre[i] as f32),
            half_extents: std::array::from_fn(|i| (h[i] as f32).next_up()),
        }
    }
}
