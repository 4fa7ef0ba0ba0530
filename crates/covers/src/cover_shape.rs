//! Data types of the capsules and oriented boxes of a cover, and nearest points on them.

use clearance_geometry::math::{Extremes, Point, Pose, Vector, pose_from_xyz_rpy};

use crate::excess::ConvexShape;

/// Dimensions of a shape along the axes of its frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ShapeSize {
    /// Capsule (line-swept sphere) along z: all points within `radius` (m) of a segment of twice `half_length` (m).
    Capsule {
        /// Radius (m).
        radius: f64,
        /// Half the length (m) of the segment.
        half_length: f64,
    },
    /// Box with half of its edges (m).
    Box {
        /// Half of the edges along x, y, z (m).
        half_extents: [f64; 3],
    },
}

/// A capsule or box in the frame of its link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoverShape {
    /// Centre (m).
    pub centre: Point,
    /// Orientation: roll, pitch and yaw (rad), as in a URDF.
    pub rpy: [f64; 3],
    /// Dimensions.
    pub size: ShapeSize,
}

impl CoverShape {
    /// Pose of the shape in the frame of its link.
    #[must_use]
    pub fn pose_ls(&self) -> Pose {
        pose_from_xyz_rpy(self.centre.coords.data.0[0], self.rpy)
    }

    /// Centre (m) of the upper or lower (`side` 1 or −1) end of a capsule's segment; the centre of a box.
    #[must_use]
    pub fn end(&self, side: f64) -> Point {
        match self.size {
            ShapeSize::Capsule { half_length, .. } => {
                self.pose_ls() * Point::new(0.0, 0.0, side * half_length)
            }
            ShapeSize::Box { .. } => self.centre,
        }
    }
}

/// A shape with its pose.
#[derive(Clone, Copy, Debug)]
pub struct PosedShape {
    size: ShapeSize,
    pose_ls: Pose,
}

impl From<&CoverShape> for PosedShape {
    fn from(shape: &CoverShape) -> Self {
        Self { size: shape.size, pose_ls: shape.pose_ls() }
    }
}

impl ConvexShape for PosedShape {
    fn bounds(&self) -> [Point; 2] {
        let axes = self.pose_ls.rotation.to_rotation_matrix();
        let reach = match self.size {
            ShapeSize::Capsule { radius, half_length } => {
                axes.matrix().column(2).abs() * half_length + Vector::repeat(radius)
            }
            ShapeSize::Box { half_extents } => axes.matrix().abs() * Vector::from(half_extents),
        };
        let centre = Point::from(self.pose_ls.translation.vector);
        [centre - reach, centre + reach]
    }

    fn nearest_point(&self, p: &Point) -> Point {
        let local = self.pose_ls.inverse_transform_point(p);
        let nearest = match self.size {
            ShapeSize::Capsule { radius, half_length } => {
                let on_axis = Point::new(0.0, 0.0, local.z.greater(-half_length).lesser(half_length));
                let way = local - on_axis;
                let distance = way.norm();
                if distance <= radius {
                    return *p;
                }
                on_axis + way * (radius / distance)
            }
            ShapeSize::Box { half_extents: half } => {
                let clamped = [0, 1, 2].map(|i| local[i].greater(-half[i]).lesser(half[i]));
                if local == Point::from(clamped) {
                    return *p;
                }
                Point::from(clamped)
            }
        };
        self.pose_ls * nearest
    }
}
