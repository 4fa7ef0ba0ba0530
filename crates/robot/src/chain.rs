//! Compiled kinematics: the joints of a robot as a short list of steps, for one state or eight states in SIMD lanes.
//!
//! Compilation precomputes all constant parts. Links joined by fixed joints are merged into one *body*; each link has a *seat*, its
//! constant pose in the body. Bodies that carry no needed link are removed. The frame of a body can be chosen freely in the body, so it
//! is chosen to make motion cheap:
//!
//! - A revolute body has its joint axis as z, so the motion mixes two columns.
//! - Its x axis is the common normal of its own axis and the axis of its first revolute child. The constant rotation between the two
//!   axes is then about x, the *twist* of Denavit and Hartenberg, and also mixes two columns only. The remaining rotations about z on
//!   either side are added to the joint positions.
//! - A prismatic body keeps its parent's orientation and needs no rotation at all.
//!
//! A joint then takes 33 multiplications instead of 63. Both kinds of [`Real`] run the same steps in the same order: eight states give
//! bit-identical results to single states.
//!
//! Rotations are not renormalised: a step's columns have an error of a few roundings of 1.1e-16, which add up to less than 1e-11 over a
//! chain of 10,000 joints.

mod compile;
mod displacement_rates;
mod kinematic_path;
mod motion_bound;
mod one_state;
mod point_derivative;
mod reachable_region;

use std::ops::Mul;

use clearance_geometry::math::{MatrixPose, Pose, RotationMatrix, UnitVector, Vector};
use clearance_geometry::simd::{Real, sin_cos};

pub use displacement_rates::DisplacementRates;
pub use kinematic_path::{Deviation, Deviations, KinematicPath, PathsToRoot, Reach, SideMotion};
pub use motion_bound::MotionBound;
use one_state::EightSources;
pub use one_state::{Columns, PlacedFrame};
pub use point_derivative::PointAlong;
pub use reachable_region::ReachableRegion;

/// A rotation, as its columns, and a translation: a frame's axes and origin in another frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame<T> {
    /// Columns of the rotation matrix: the axes of the frame.
    pub r: [[T; 3]; 3],
    /// Origin (m).
    pub t: [T; 3],
}

/// Source of a joint's position: `multiplier * q[index] + offset`, as mimic joints need it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source {
    /// Index of the position in a configuration.
    pub index: usize,
    /// Factor of the position.
    pub multiplier: f64,
    /// Offset (rad, m), added after multiplication.
    pub offset: f64,
}

/// Motion of a joint; axes are in the joint frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// No motion.
    Fixed,
    /// Rotation (rad) about an axis.
    Revolute(UnitVector, Source),
    /// Translation (m) along an axis.
    Prismatic(UnitVector, Source),
    /// Translates along the first two columns, then rotates about the third, by three consecutive positions.
    Planar(RotationMatrix, usize),
    /// `x y z` and a unit quaternion `x y z w`: seven consecutive positions.
    Floating(usize),
}

/// One joint as input of the compiler.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChainJoint {
    /// Index of the parent link.
    pub parent: usize,
    /// Index of the child link.
    pub child: usize,
    /// Pose of the joint frame in the parent link at position zero.
    pub pose_pj: Pose,
    /// Motion of the joint frame.
    pub motion: Motion,
}

/// Compiled kinematics.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    /// All bodies except the root's, which is body 0: parents first.
    bodies: Vec<Body>,
    /// Angle sources of the bodies, in groups of eight.
    angles: Vec<EightSources>,
    /// By link; `None` for links that were removed.
    seats: Vec<Option<LinkInBody>>,
}

impl Chain {
    /// The body of the root link, which no joint moves.
    pub const ROOT: usize = 0;
}

/// A link's constant pose in its body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkInBody {
    /// Index of the body.
    pub body: usize,
    /// Pose of the link in the frame of the body.
    pub place: Frame<f64>,
}

/// A rigid body and its joint to the parent body.
#[derive(Clone, Debug, PartialEq)]
struct Body {
    parent: usize,
    /// The body's origin in the parent body at position zero.
    origin: [f64; 3],
    step: Step,
}

#[derive(Clone, Debug, PartialEq)]
enum Step {
    /// A constant rotation, then one about the new z axis.
    Turn(Turn, Source),
    /// A translation along an axis in the parent body.
    Shift([f64; 3], Source),
    /// A constant rotation, then seven positions used unchanged.
    Float([[f64; 3]; 3], usize),
}

/// A constant rotation between two joint axes.
#[derive(Clone, Debug, PartialEq)]
enum Turn {
    /// The parent is the root: no multiplication needed.
    Root([[f64; 3]; 3]),
    /// Rotation about x.
    Twist {
        cos: f64,
        sin: f64,
    },
    Full([[f64; 3]; 3]),
}

impl Chain {
    /// Number of frames that [`Self::frames`] computes.
    #[must_use]
    #[inline]
    pub fn body_count(&self) -> usize {
        self.bodies.len() + 1
    }

    /// Pose of a link in its body; `None` if the link was not needed.
    #[must_use]
    #[inline]
    pub fn seat(&self, link: usize) -> Option<&LinkInBody> {
        self.seats[link].as_ref()
    }

    /// Computes the frame of every body in the root, by body, without allocating; `q` gives the positions.
    ///
    /// # Panics
    /// When `frames` has no room for every body.
    #[inline(always)]
    pub fn frames<T: Real>(&self, token: T::Token, q: impl Fn(usize) -> T, frames: &mut [Frame<T>]) {
        frames[0] = Frame::splat(token, &Frame::IDENTITY);
        for (body, i) in self.bodies.iter().zip(1..) {
            frames[i] = body.frame(
                token,
                &q,
                &frames[body.parent],
                #[inline(always)]
                |angle| sin_cos(angle),
            );
        }
    }

    /// The frame of a link in the root, from the frames of all bodies; `None` if the link was not needed.
    #[inline(always)]
    pub fn link_frame<T: Real>(&self, link: usize, frames: &[Frame<T>]) -> Option<Frame<T>> {
        self.seat(link).map(|seat| frames[seat.body].then(&seat.place))
    }
}

impl Body {
    /// The angle of a revolute body.
    fn angle(&self, q: impl Fn(usize) -> f64) -> f64 {
        if let Step::Turn(_, source) = &self.step { source.value(&q) } else { 0.0 }
    }

    /// The body's frame in the root; `sin_cos` computes the sine and cosine of a revolute body's angle.
    #[inline(always)]
    fn frame<T: Real>(
        &self,
        token: T::Token,
        q: impl Fn(usize) -> T,
        parent: &Frame<T>,
        sin_cos: impl FnOnce(T) -> (T, T),
    ) -> Frame<T> {
        match &self.step {
            Step::Turn(turn, source) => {
                let (sin, cos) = sin_cos(source.value(&q));
                let [x, y, z] = match turn {
                    Turn::Root(columns) => Frame::splat(token, &Frame { r: *columns, t: self.origin }).r,
                    Turn::Twist { cos, sin } => {
                        let [x, y, z] = parent.r;
                        let [y, z] = mix(y, z, *cos, *sin);
                        [x, y, z]
                    }
                    Turn::Full(columns) => parent.turn_all(*columns),
                };
                let [x, y] = mix(x, y, cos, sin);
                Frame { r: [x, y, z], t: parent.point(self.origin) }
            }
            Step::Shift(axis, source) => {
                let shift = source.value(&q);
                let [x, y, z] = self.origin;
                let shifted = [shift * axis[0] + x, shift * axis[1] + y, shift * axis[2] + z];
                Frame { r: parent.r, t: parent.point(shifted) }
            }
            Step::Float(columns, first) => {
                let at = parent.then(&Frame { r: *columns, t: self.origin });
                let i = *first;
                let (t, turn) = ([q(i), q(i + 1), q(i + 2)], [q(i + 3), q(i + 4), q(i + 5), q(i + 6)]);
                at.then(&floating(token, t, turn))
            }
        }
    }
}

/// Rotates two axes in their common plane.
#[inline(always)]
fn mix<T, V>(x: [T; 3], y: [T; 3], cos: V, sin: V) -> [[T; 3]; 2]
where
    T: Real + Mul<V, Output = T>,
    V: Copy,
{
    [
        [x[0] * cos + y[0] * sin, x[1] * cos + y[1] * sin, x[2] * cos + y[2] * sin],
        [y[0] * cos - x[0] * sin, y[1] * cos - x[1] * sin, y[2] * cos - x[2] * sin],
    ]
}

impl Source {
    #[inline(always)]
    fn value<T: Real>(&self, q: &impl Fn(usize) -> T) -> T {
        q(self.index) * self.multiplier + self.offset
    }
}

/// The frame of a floating joint's child: `x y z` and a quaternion `x y z w` of length one.
#[inline(always)]
fn floating<T: Real>(token: T::Token, t: [T; 3], [x, y, z, w]: [T; 4]) -> Frame<T> {
    let one = T::splat(token, 1.0);
    let [x2, y2, z2] = [x + x, y + y, z + z];
    let [xx, yy, zz] = [x * x2, y * y2, z * z2];
    let [xy, xz, yz] = [x * y2, x * z2, y * z2];
    let [wx, wy, wz] = [w * x2, w * y2, w * z2];
    Frame {
        r: [
            [one - (yy + zz), xy + wz, xz - wy],
            [xy - wz, one - (xx + zz), yz + wx],
            [xz + wy, yz - wx, one - (xx + yy)],
        ],
        t,
    }
}

impl<T: Real> Frame<T> {
    /// The same frame in every lane.
    #[inline(always)]
    pub fn splat(token: T::Token, frame: &Frame<f64>) -> Self {
        let Frame { r: [x, y, z], t } = *frame;
        Self { r: [splat(token, x), splat(token, y), splat(token, z)], t: splat(token, t) }
    }

    /// Transforms a vector from this frame to the parent frame.
    #[inline(always)]
    #[must_use]
    pub fn turn<V: Copy>(&self, v: [V; 3]) -> [T; 3]
    where
        T: Mul<V, Output = T>,
    {
        let [x, y, z] = self.r;
        [
            x[0] * v[0] + y[0] * v[1] + z[0] * v[2],
            x[1] * v[0] + y[1] * v[1] + z[1] * v[2],
            x[2] * v[0] + y[2] * v[1] + z[2] * v[2],
        ]
    }

    #[inline(always)]
    fn turn_all<V: Copy>(&self, [x, y, z]: [[V; 3]; 3]) -> [[T; 3]; 3]
    where
        T: Mul<V, Output = T>,
    {
        [self.turn(x), self.turn(y), self.turn(z)]
    }

    /// Transforms a point from this frame to the parent frame.
    #[inline(always)]
    #[must_use]
    pub fn point<V: Copy>(&self, p: [V; 3]) -> [T; 3]
    where
        T: Mul<V, Output = T>,
    {
        let p = self.turn(p);
        [self.t[0] + p[0], self.t[1] + p[1], self.t[2] + p[2]]
    }

    /// Transforms a frame within this frame to the parent frame.
    #[inline(always)]
    #[must_use]
    pub fn then<V: Copy>(&self, inner: &Frame<V>) -> Self
    where
        T: Mul<V, Output = T>,
    {
        Self { r: self.turn_all(inner.r), t: self.point(inner.t) }
    }
}

#[inline(always)]
fn splat<T: Real>(token: T::Token, v: [f64; 3]) -> [T; 3] {
    [T::splat(token, v[0]), T::splat(token, v[1]), T::splat(token, v[2])]
}

impl Frame<f64> {
    /// The identity transform.
    pub const IDENTITY: Self = Self { r: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], t: [0.0; 3] };
}

impl From<&Frame<f64>> for MatrixPose {
    fn from(Frame { r: [x, y, z], t }: &Frame<f64>) -> Self {
        let column = |v: &[f64; 3]| Vector::from(*v);
        let rotation = RotationMatrix::from_columns(&[column(x), column(y), column(z)]);
        Self { rotation, translation: column(t) }
    }
}

#[cfg(test)]
mod tests;
