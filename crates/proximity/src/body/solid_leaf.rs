//! Solid primitives of a body: tree leaves that hold one each, and their bounding volumes in f32.

use clearance_geometry::constants::VOLUME_SLACK;
use clearance_geometry::math::{Point, Pose, RotationMatrix, Vector};
use clearance_geometry::{Primitive, VolumeKind};

use crate::bounding_volume::{Axes, Obb};
use crate::bvh::{Content, Leaf, Tree};
use crate::elements::{Element, RoundedShape};

/// A primitive placed in the frame of its body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Solid {
    pub primitive: Primitive,
    pub pose: Pose,
}

/// A solid, and its bounding volume in f32.
#[derive(Clone, Debug)]
pub(crate) struct SolidLeaf {
    pub shape: RoundedShape,
    /// Index in the order of the tree.
    pub index: u32,
    /// Axes of the solid, in the frame of the tree.
    pub axes: Axes,
    /// The centre, relative to the anchor of the tree.
    pub centre: [f32; 3],
    pub hull: Hull,
}

/// Adds volumes of another kind to a tree of solids: around the boxes of the solids.
pub(super) fn set_volumes_of_solids(tree: &mut Tree<Obb, SolidLeaf>, kind: VolumeKind, kinds: &[VolumeKind]) {
    let anchor = *tree.anchor();
    // axes are rounded, so they are neither exactly orthogonal nor exactly of length one
    let slack = VOLUME_SLACK * tree.reach();
    tree.set_volumes(kind, kinds, |leaf: &Leaf<Obb, SolidLeaf>, points| {
        let (centre, half) = (leaf.volume.centre.map(f64::from), leaf.volume.half_extents.map(f64::from));
        let axes = leaf.axes.columns();
        for corner in 0..8_u8 {
            let side = |i: usize| {
                let extent = half[i] + slack;
                centre[i] + if corner >> i & 1 == 0 { -extent } else { extent }
            };
            points.push(anchor + axes * Vector::new(side(0), side(1), side(2)));
        }
    });
}

/// Bounding volume of a solid, in f32, rounded outward: a box, swept by a disc normal to its z axis, swept by a ball.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hull {
    pub half_extents: [f32; 3],
    pub disc: f32,
    pub ball: f32,
}

impl Hull {
    /// The volume of a box.
    #[inline(always)]
    pub fn half_extents_around(&self) -> [f32; 3] {
        let ([x, y, z], across) = (self.half_extents, self.disc + self.ball);
        [x + across, y + across, z + self.ball]
    }
}

impl From<&Primitive> for Hull {
    #[allow(clippy::cast_possible_truncation)] // rounded up right after
    fn from(primitive: &Primitive) -> Self {
        let (half_extents, disc, ball) = match *primitive {
            Primitive::Box { half_extents } => (half_extents, 0.0, 0.0),
            Primitive::Sphere { radius } => ([0.0; 3], 0.0, radius),
            Primitive::Cylinder { radius, half_length } | Primitive::Cone { radius, half_length } => {
                ([0.0, 0.0, half_length], radius, 0.0)
            }
            Primitive::Capsule { radius, half_length } => ([0.0, 0.0, half_length], 0.0, radius),
        };
        let up = |x: f64| if x == 0.0 { 0.0 } else { (x as f32).next_up() };
        Self { half_extents: half_extents.map(up), disc: up(disc), ball: up(ball) }
    }
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
    fn new(anchor: &Point, index: u32, items: &[&Solid]) -> Self {
        let solid = items[0];
        let centre = solid.pose.translation.vector - anchor.coords;
        Self {
            index,
            shape: RoundedShape::from(&Element::Primitive { primitive: solid.primitive, pose: solid.pose }),
            axes: Axes::from_columns(solid.pose.rotation.to_rotation_matrix().matrix()),
            centre: std::array::from_fn(|i| centre[i] as f32),
            hull: Hull::from(&solid.primitive),
        }
    }
}
