//! Derivative of the height of a body point along a direction: one row of the body's Jacobian, projected on the direction.
//!
//! `J` is the Jacobian of the point, the matrix of its derivatives with respect to all positions; a row here is `nᵀ J` (Siciliano,
//! Sciavicco, Villani & Oriolo 2009, *Robotics: Modelling, Planning and Control*, 3.1.3).

use clearance_geometry::math::Vector;

use super::{Body, Chain, Frame, PlacedFrame, Step};

/// A point that moves with a body, and a direction, in the frame that bodies are placed in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointAlong {
    /// The point (m).
    pub point: Vector,
    /// The direction; its length scales the derivative.
    pub direction: Vector,
}

impl Chain {
    /// Adds to `row` the derivative of the point's height along the direction, with respect to each position, by the joints of one side
    /// of a [`KinematicPath`](super::KinematicPath); the point moves with the body at the end of that side. `frames` has the frames
    /// of all bodies on the path and of their parents.
    ///
    /// Entries are in metres per radian or per metre. A mimic joint adds to the entry of the joint that it follows. The entries of a
    /// quaternion are the derivative of the height for the normalised quaternion: their product with the quaternion itself is zero.
    #[inline]
    pub fn add_point_derivative(
        &self,
        side: &[usize],
        along: &PointAlong,
        frames: &[PlacedFrame],
        positions: &[f64],
        row: &mut [f64],
    ) {
        for &i in side {
            self.bodies[i - 1].add_point_derivative(along, &frames[i].frame(), frames, positions, row);
        }
    }
}

impl Body {
    /// Adds the derivative with respect to the positions of this body's joint.
    #[inline]
    fn add_point_derivative(
        &self,
        along: &PointAlong,
        frame: &Frame<f64>,
        frames: &[PlacedFrame],
        positions: &[f64],
        row: &mut [f64],
    ) {
        match &self.step {
            Step::Turn(_, source) => {
                let torque = along.torque(&Vector::from(frame.t));
                row[source.index] += source.multiplier * Vector::from(frame.r[2]).dot(&torque);
            }
            Step::Shift(axis, source) => {
                let axis = Vector::from(frames[self.parent].frame().turn(*axis));
                row[source.index] += source.multiplier * axis.dot(&along.direction);
            }
            Step::Float(columns, first) => {
                let joint = frames[self.parent].frame().then(&Frame { r: *columns, t: self.origin });
                let axes = joint.r.map(Vector::from);
                let torque = along.torque(&Vector::from(frame.t));
                let [x, y, z, w] = [3, 4, 5, 6].map(|k| positions[first + k]);
                let torque = Vector::from(axes.map(|axis| axis.dot(&torque)));
                let (of_vector, of_scalar) = quaternion_derivative(Vector::new(x, y, z), w, &torque);
                for k in 0..3 {
                    row[first + k] += axes[k].dot(&along.direction);
                    row[first + 3 + k] += of_vector[k];
                }
                row[first + 6] += of_scalar;
            }
        }
    }
}

impl PointAlong {
    /// Derivative of the height with respect to a rotation vector about axes through `centre`.
    #[inline]
    fn torque(&self, centre: &Vector) -> Vector {
        (self.point - centre).cross(&self.direction)
    }
}

/// Derivatives with respect to the vector part and the scalar part of a unit quaternion q, of a function whose derivative with respect to
/// rotation vectors is `torque`: a change dq rotates by `2 dq q*`.
#[inline]
fn quaternion_derivative(vector: Vector, scalar: f64, torque: &Vector) -> (Vector, f64) {
    (2.0 * (scalar * torque - vector.cross(torque)), -2.0 * vector.dot(torque))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chain::tests::{frames, random_positions, random_tree};
    use crate::{ChainJoint, Motion};
    use clearance_geometry::testing::Random;

    /// Step (rad, m) of the differences.
    const STEP: f64 = 1e-4;

    fn with_unit_quaternions(mut q: Vec<f64>, joints: &[ChainJoint]) -> Vec<f64> {
        for joint in joints {
            if let Motion::Floating(first) = joint.motion {
                let turn = nalgebra::Vector4::from_column_slice(&q[first + 3..first + 7]).normalize();
                q[first + 3..first + 7].copy_from_slice(turn.as_slice());
            }
        }
        q
    }

    /// Whether a joint follows a component of a quaternion, which no robot has: normalisation would move it.
    fn follows_quaternion(joints: &[ChainJoint]) -> bool {
        let follows = |first: usize, joint: &ChainJoint| match joint.motion {
            Motion::Revolute(_, source) => (first + 3..first + 7).contains(&source.index),
            _ => false,
        };
        joints.iter().any(|joint| match joint.motion {
            Motion::Floating(first) => joints.iter().any(|other| follows(first, other)),
            _ => false,
        })
    }

    /// The row of each body equals differences of kinematics, and only joints between it and the ancestor have entries.
    #[test]
    fn rows_equal_differences() {
        let mut random = Random::new(41);
        let mut worst = 0.0_f64;
        for _ in 0..400 {
            let (joints, count, needed) = random_tree(&mut random, 9);
            if follows_quaternion(&joints) {
                continue;
            }
            let chain = Chain::compile(0, &joints, &needed);
            let paths = chain.paths_to_root();
            let q = random_positions(&mut random, &joints, count);
            let placed = frames(&chain, &q);
            let in_memory: Vec<PlacedFrame> = placed.iter().map(PlacedFrame::from).collect();
            for body in 0..chain.body_count() {
                let local: [f64; 3] = random.vector(1.0).into();
                let direction = random.direction().into_inner();
                let along = PointAlong { point: placed[body].point(local).into(), direction };
                let mut row = vec![0.0; count];
                let side = paths.to_root(body);
                chain.add_point_derivative(side.side(0), &along, &in_memory, &q, &mut row);
                let height = |k: usize, step: f64| {
                    let mut moved = q.clone();
                    moved[k] += step;
                    let moved = frames(&chain, &with_unit_quaternions(moved, &joints));
                    Vector::from(moved[body].point(local)).dot(&direction)
                };
                for (k, entry) in row.iter().enumerate() {
                    let [fine, coarse] =
                        [STEP, 2.0 * STEP].map(|h| (height(k, h) - height(k, -h)) / (2.0 * h));
                    // Richardson extrapolation
                    worst = worst.max((entry - (4.0 * fine - coarse) / 3.0).abs());
                }
                for joint in &joints {
                    let Motion::Floating(first) = joint.motion else { continue };
                    let radial: f64 = (first + 3..first + 7).map(|k| row[k] * q[k]).sum();
                    assert!(radial.abs() < 1e-12, "{radial}");
                }
            }
        }
        println!("worst difference {worst:e}");
        assert!(worst < 1e-9, "{worst:e}");
    }
}
