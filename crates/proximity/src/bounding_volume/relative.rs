//! Axes of a node frame, and the relative pose of two node frames, in f32.

use clearance_geometry::constants::{PLACEMENT_SLACK, VOLUME_SLACK};
use clearance_geometry::math::{MatrixPose, Point, RotationMatrix, Vector};

use super::rounding::{round, round_up};

/// A rotation about the anchor of a tree: the axes of a node's frame as rows, in the frame of the tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axes(pub [[f32; 3]; 3]);

impl Axes {
    /// The axes of the tree.
    pub const IDENTITY: Self = Self([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);

    /// From axes as columns.
    #[must_use]
    #[inline]
    pub fn from_columns(axes: &RotationMatrix) -> Self {
        Self(std::array::from_fn(|k| std::array::from_fn(|i| round(axes[(i, k)]))))
    }

    /// The axes as columns.
    #[must_use]
    #[inline]
    pub fn columns(&self) -> RotationMatrix {
        RotationMatrix::from_fn(|i, k| f64::from(self.0[k][i]))
    }

    /// Coordinates of a point along exactly these axes, with the rounding that they have.
    #[must_use]
    #[inline]
    pub fn along(&self, point: &Vector) -> Vector {
        let row = |k: usize| Vector::from(self.0[k].map(f64::from)).dot(point);
        Vector::new(row(0), row(1), row(2))
    }

    /// Components of a direction of the tree's frame along these axes.
    #[inline(always)]
    #[must_use]
    pub fn turned(&self, v: &[f32; 3]) -> [f32; 3] {
        turned(&self.0, v)
    }
}

/// The anchor of a tree in the frame of its body, and the largest distance (m, 1-norm) of anything in the tree from it.
#[derive(Clone, Copy, Debug)]
pub struct AnchoredReach<'a> {
    /// Origin of all frames of the tree.
    pub anchor: &'a Point,
    /// Largest distance (m, 1-norm) from the anchor.
    pub reach: f64,
}

/// `point_b = r * point_a + t` for the frames of two nodes, or of two trees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relative {
    /// `r[i][j]` is the component of a's axis `j` along b's axis `i`.
    pub r: [[f32; 3]; 3],
    /// Position of a's anchor (m) in the frame of b.
    pub t: [f32; 3],
    /// Amount (m) by which rounding can increase the computed distance of two volumes.
    pub slack: f32,
}

impl Relative {
    /// The frames of two trees.
    ///
    /// Slack: entries of `r` and `t` after two f32 products of three terms each have an error of less than 16 units of 2⁻²⁴. A coordinate
    /// computed from them has an error of less than 32 units relative to the 1-norm of its inputs. Two such coordinates and two sums of
    /// three extents give [`VOLUME_SLACK`], 64 units.
    #[must_use]
    #[inline]
    pub fn of_trees(pose_ab: &MatrixPose, a: AnchoredReach, b: AnchoredReach) -> Self {
        let rotation = pose_ab.rotation.transpose();
        let t = rotation * (a.anchor.coords - pose_ab.translation) - b.anchor.coords;
        let reach = t.abs().sum() + a.reach + b.reach;
        // rounding error of f64 where anchors and poses nearly cancel
        let entered =
            a.anchor.coords.abs().sum() + b.anchor.coords.abs().sum() + pose_ab.translation.abs().sum();
        Self {
            r: std::array::from_fn(|i| std::array::from_fn(|j| round(rotation[(i, j)]))),
            t: [round(t.x), round(t.y), round(t.z)],
            slack: round_up(VOLUME_SLACK * reach + PLACEMENT_SLACK * entered),
        }
    }

    /// The frame of a node of a in the frame of a node of b, from the frames of the trees.
    #[inline(always)]
    #[must_use]
    pub fn of_nodes(&self, axes_a: &Axes, axes_b: &Axes) -> Self {
        let [x, y, z] = &axes_a.0;
        let in_b = [turned(&self.r, x), turned(&self.r, y), turned(&self.r, z)];
        let [u, v, w] = &axes_b.0;
        let row = |axis: &[f32; 3]| [dot(axis, &in_b[0]), dot(axis, &in_b[1]), dot(axis, &in_b[2])];
        Self { r: [row(u), row(v), row(w)], t: turned(&axes_b.0, &self.t), slack: self.slack }
    }

    /// The frame of b in the frame of a.
    #[inline(always)]
    #[must_use]
    pub fn inverse(&self) -> Self {
        let [x, y, z] = &self.r;
        let r = [[x[0], y[0], z[0]], [x[1], y[1], z[1]], [x[2], y[2], z[2]]];
        let t = turned(&r, &self.t);
        Self { r, t: [-t[0], -t[1], -t[2]], slack: self.slack }
    }

    /// Transforms a point of a's frame to b's frame.
    #[inline(always)]
    #[must_use]
    pub fn point(&self, p: &[f32; 3]) -> [f32; 3] {
        let [x, y, z] = turned(&self.r, p);
        [x + self.t[0], y + self.t[1], z + self.t[2]]
    }

    /// Coordinate of a's origin along a direction of b's frame.
    #[inline(always)]
    #[must_use]
    pub fn offset_along(&self, direction: &[f32; 3]) -> f32 {
        dot(&self.t, direction)
    }

    /// Components of a direction of b's frame along a's axes.
    #[inline(always)]
    #[must_use]
    pub fn along_a(&self, v: &[f32; 3]) -> [f32; 3] {
        let [x, y, z] = &self.r;
        [
            x[0] * v[0] + y[0] * v[1] + z[0] * v[2],
            x[1] * v[0] + y[1] * v[1] + z[1] * v[2],
            x[2] * v[0] + y[2] * v[1] + z[2] * v[2],
        ]
    }
}

#[inline(always)]
fn turned(r: &[[f32; 3]; 3], v: &[f32; 3]) -> [f32; 3] {
    [dot(&r[0], v), dot(&r[1], v), dot(&r[2], v)]
}

#[inline(always)]
fn dot(a: &[f32; 3], b: &[f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
