//! Upper bounds on the motion of one link relative to another within a box of joint positions.
//!
//! One link of the path is held still: joints on its one side move the first body, joints on the other side the second. Joints nearer to a
//! body are applied first: the others have not moved yet. A rotation by δ moves a point at the distance ρ from the axis by at most
//! 2ρ sin(δ/2). Along n, a rotation by e about the axis a through o moves a point x by sin(e) n·(a × (x - o)) + (cos(e) - 1) u·(x - o), where u
//! is the part of n across a.

use std::f64::consts::PI;

use clearance_geometry::math::{Extremes, MatrixPose, Point, Vector};

use super::body::Body;
use super::matrix_path::{MatrixAxis, MatrixState};

/// Allowance (m, and relative) for rounding.
const SLACK: f64 = 1e-9;

/// Rounding error (m) of kinematics and distances, per metre of the coordinates used and per radian.
const ROUNDING: f64 = 1e-14;

/// The bodies of two links at the centre of a box, with the half widths of the box by variable.
pub(super) struct MatrixMotion<'m> {
    pub bodies: [&'m Body; 2],
    pub state: &'m MatrixState,
    pub half_widths: &'m [f64],
}

/// Direction of the motion that is bounded.
#[derive(Clone, Copy)]
pub(super) enum MotionAlong<'n> {
    Any,
    Direction(&'n Vector),
}

impl MatrixMotion<'_> {
    /// Upper bound (m) on the motion of points of the bodies relative to each other, rounding included.
    pub fn bound(&self, along: MotionAlong) -> f64 {
        let axes = &self.state.axes;
        let of_first = self.displacements(0, axes.iter(), along);
        let mut of_second = self.displacements(1, axes.iter().rev(), along);
        of_second.reverse();
        let held = |cut: usize| of_first[..cut].iter().chain(&of_second[cut..]).sum::<f64>();
        let least = (0..=axes.len()).map(held).fold(f64::INFINITY, f64::lesser);
        least * (1.0 + SLACK) + SLACK + self.rounding()
    }

    /// By joint, in the given order: the largest displacement (m) by it.
    fn displacements<'a>(
        &self,
        side: usize,
        axes: impl Iterator<Item = &'a MatrixAxis>,
        along: MotionAlong,
    ) -> Vec<f64> {
        let (body, pose) = (self.bodies[side], MatrixPose::from(&self.state.poses[side]));
        let mut moved = 0.0;
        axes.map(|axis| {
            let delta = axis.rate * self.half_widths[axis.variable];
            let any = if axis.turns {
                2.0 * (reach(body, &pose, axis) + moved) * (0.5 * delta.lesser(PI)).sin()
            } else {
                delta
            };
            let found = match along {
                MotionAlong::Any => any,
                MotionAlong::Direction(n) if axis.turns => {
                    let across = n.cross(&axis.direction);
                    let radial = n - axis.direction * n.dot(&axis.direction);
                    let farthest = |v: &Vector| largest_product(body, &pose, axis, v) + v.norm() * moved;
                    any.lesser(delta * (farthest(&across) + 0.5 * delta * farthest(&radial)))
                }
                MotionAlong::Direction(n) => delta * n.dot(&axis.direction).abs(),
            };
            moved += any;
            found
        })
        .collect()
    }

    /// Rounding error (m) of kinematics and distances.
    pub fn rounding(&self) -> f64 {
        let of_axes = self.state.axes.iter().map(|axis| axis.origin.coords.amax());
        let of_poses = self.state.poses.iter().map(|pose| pose.translation.vector.amax());
        let of_bodies = self
            .bodies
            .iter()
            .map(|body| body.box_corners().iter().map(|p| p.coords.norm()).fold(0.0, f64::greater));
        let extent = of_axes.chain(of_poses).fold(0.0, f64::greater) + of_bodies.sum::<f64>();
        ROUNDING * ((10.0 + self.state.size) * extent + 10.0 * self.state.size)
    }
}

/// The largest distance (m) of a body from an axis.
fn reach(body: &Body, pose: &MatrixPose, axis: &MatrixAxis) -> f64 {
    let back = pose.inverse();
    let (origin, direction) = (&back * axis.origin, back.rotation * axis.direction);
    body.greatest(1.0, |p| direction.cross(&(p - origin)).norm())
}

/// The largest |v·(x - o)| (m) over points x of a body, for a point o of the axis.
fn largest_product(body: &Body, pose: &MatrixPose, axis: &MatrixAxis, v: &Vector) -> f64 {
    let back = pose.inverse();
    let (origin, v): (Point, Vector) = (&back * axis.origin, back.rotation * v);
    body.greatest(v.norm() * (1.0 + SLACK), |p| v.dot(&(p - origin)).abs())
}
