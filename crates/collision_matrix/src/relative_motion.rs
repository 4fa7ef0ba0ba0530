//! Upper bound on the motion of one link relative to another within a box of joint positions.
//!
//! One link of the path between the two is held still. Joints between it and the first link move the first link, the others move the
//! second one. Each of the links can be held: the best choice bounds the motion. Joints are processed from the moved link towards the link
//! that is held, as the box bound in `docs/derivations/motion-bound.md`. A rotation by δ moves a point at the distance ρ by at most
//! 2ρ sin(δ/2).
//!
//! Along a direction n, a rotation by e about the axis a through o moves a point x by sin(e) n·(a × (x - o)) + (cos(e) - 1) u·(x - o), where u
//! is the part of n across a. Rotations about n itself do not count.

use std::f64::consts::PI;

use clearance_geometry::constants::{KINEMATICS_ROUNDING, MOTION_SLACK};
use clearance_geometry::math::Vector;

use crate::joint_path::{PlacedAxis, PlacedPath};
use crate::outline::Outline;

/// Bound on the relative motion of two links in a box, and the contribution of each variable.
#[derive(Clone, Debug, Default)]
pub struct RelativeMotion {
    /// No distance of points of the two links changes by more than this (m), including rounding.
    pub bound: f64,
    /// By variable: its part (m) of the bound.
    pub shares: Vec<f64>,
    /// Rounding error (m) of kinematics and distances.
    rounding: f64,
    of_first: Vec<f64>,
    of_second: Vec<f64>,
}

/// Two outlines in the frame of the first link, and the half widths of a box, by variable.
#[derive(Clone, Copy, Debug)]
pub struct PlacedBox<'p> {
    /// The path at the centre.
    pub placed: &'p PlacedPath,
    /// Outlines of both links.
    pub outlines: [&'p Outline; 2],
    /// Half widths (rad, m), by variable.
    pub half_widths: &'p [f64],
}

impl RelativeMotion {
    /// Computes the bound for a box; no joint position is larger than `size` (rad, m).
    pub fn compute(&mut self, PlacedBox { placed, outlines, half_widths }: PlacedBox, size: f64) {
        let axes = &placed.axes;
        moves(axes.iter(), outlines[0], half_widths, &mut self.of_first);
        moves(axes.iter().rev(), outlines[1], half_widths, &mut self.of_second);
        self.of_second.reverse();
        let cut = self.best_cut();
        self.shares.clear();
        self.shares.resize(half_widths.len(), 0.0);
        let mut total = 0.0;
        for (k, axis) in axes.iter().enumerate() {
            let share = if k < cut { self.of_first[k] } else { self.of_second[k] };
            self.shares[axis.variable] += share;
            total += share;
        }
        let extent: f64 = outlines.iter().map(|outline| outline.size()).sum::<f64>()
            + axes.iter().map(|axis| axis.origin.coords.amax()).fold(0.0, f64::max);
        self.rounding = KINEMATICS_ROUNDING * ((10.0 + size) * 3.0 * extent + 10.0 * size);
        self.bound = self.widened(total);
    }

    /// Bound (m) on the motion along a unit vector, after [`Self::compute`] for the same box.
    #[must_use]
    pub fn along(
        &mut self,
        direction: &Vector,
        PlacedBox { placed, outlines, half_widths }: PlacedBox,
    ) -> f64 {
        let axes = &placed.axes;
        moves_along(direction, axes.iter(), outlines[0], half_widths, &mut self.of_first);
        moves_along(direction, axes.iter().rev(), outlines[1], half_widths, &mut self.of_second);
        self.of_second.reverse();
        let cut = self.best_cut();
        let moves = self.of_first[..cut].iter().chain(&self.of_second[cut..]);
        self.widened(moves.sum())
    }

    fn widened(&self, total: f64) -> f64 {
        total * (1.0 + 2.0 * MOTION_SLACK) + MOTION_SLACK + self.rounding
    }

    /// Number of joints that move the first link so that the sum is least.
    fn best_cut(&self) -> usize {
        let mut sum: f64 = self.of_second.iter().sum();
        let (mut cut, mut least) = (0, sum);
        for k in 0..self.of_first.len() {
            sum += self.of_first[k] - self.of_second[k];
            if sum < least {
                (cut, least) = (k + 1, sum);
            }
        }
        cut
    }
}

/// For each joint, the most distal one first: the largest displacement (m) of a point along a direction by this joint.
fn moves_along<'p>(
    direction: &Vector,
    axes: impl Iterator<Item = &'p PlacedAxis>,
    outline: &Outline,
    half_widths: &[f64],
    found: &mut Vec<f64>,
) {
    found.clear();
    let mut moved = 0.0;
    for axis in axes {
        let delta = axis.factor.abs() * half_widths[axis.variable];
        if !axis.turns {
            found.push(delta * direction.dot(&axis.axis).abs());
            moved += delta;
            continue;
        }
        let across = direction.cross(&axis.axis);
        let radial = direction - axis.axis * direction.dot(&axis.axis);
        let farthest = |v: &Vector| outline.largest_product(v, &axis.origin) + v.norm() * moved;
        let any = displacement_by_turn(axis, outline, moved, delta);
        found.push(any.min(delta * (farthest(&across) + 0.5 * delta * farthest(&radial))));
        moved += any;
    }
}

/// For each joint, the most distal one first: the largest displacement (m) of a point by this joint.
fn moves<'p>(
    axes: impl Iterator<Item = &'p PlacedAxis>,
    outline: &Outline,
    half_widths: &[f64],
    found: &mut Vec<f64>,
) {
    found.clear();
    let mut moved = 0.0;
    for axis in axes {
        let delta = axis.factor.abs() * half_widths[axis.variable];
        let displacement = if axis.turns { displacement_by_turn(axis, outline, moved, delta) } else { delta };
        found.push(displacement);
        moved += displacement;
    }
}

/// Upper bound (m) on the chord of a turn by `delta` (rad) of any point that joints nearer to it have moved by at most `moved` (m).
fn displacement_by_turn(axis: &PlacedAxis, outline: &Outline, moved: f64, delta: f64) -> f64 {
    let reach = outline.reach(&axis.origin, &axis.axis) + moved;
    2.0 * reach * (0.5 * delta.min(PI)).sin()
}
