//! Kinematics compiled: the joints of a robot as a short list of steps for one state or eight in lanes.
//!
//! Compiling moves all that never changes out of the way. Links joined by fixed joints become one *body*; each has a
//! *seat*, its constant place in the body. Bodies that carry nothing needed are dropped. Where a body's frame sits in
//! the body is free, so it is chosen to make motion cheap:
//!
//! - A turning body has its joint axis as z, so the motion mixes two columns.
//! - Its x axis is the common normal to its own axis and its first turning child's. The constant turn between the two
//!   axes then is one about x, the *twist* of Denavit and Hartenberg, and mixes two columns also; what turns about z
//!   remain on either side join the joint positions.
//! - A sliding body keeps its parent's orientation and costs no turn at all.
//!
//! A joint then takes 33 multiplications instead of 63. Both kinds of [`Real`] run the same steps in the same order:
//! eight states give the same bits as each one alone.
//!
//! Rotations are not renormalised: a step's columns are off by a few roundings of 1.1e-16, which add up to less than
//! 1e-11 over a chain of 10,000 joints.

mod travel;

use std::ops::Mul;

use crate::math::{MatrixPose, Pose, RotationMatrix, UnitVector, Vector};
use crate::simd::prelude::*;
use crate::simd::{Real, Simd, f64x8, sin_cos};

pub use travel::TravelRates;

/// A rotation, as its columns, and a translation: a frame's axes and origin in another frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame<T> {
    pub r: [[T; 3]; 3],
    pub t: [T; 3],
}

/// Where a joint's position comes from: `multiplier * q[index] + offset`, as mimicking joints need it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source {
    pub index: usize,
    pub multiplier: f64,
    pub offset: f64,
}

/// How a joint moves; axes are in the joint frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    Fixed,
    Revolute(UnitVector, Source),
    Prismatic(UnitVector, Source),
    /// Slides along the first two columns, then turns about the third, by three consecutive positions.
    Planar(RotationMatrix, usize),
    /// `x y z` and a quaternion `x y z w` of length one: seven consecutive positions.
    Floating(usize),
}

/// One joint as the compiler takes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChainJoint {
    pub parent: usize,
    pub child: usize,
    /// Pose of the joint frame in the parent link at position zero.
    pub pose_pj: Pose,
    pub motion: Motion,
}

/// Kinematics compiled.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    /// All bodies but the root's, which is body 0: parents first.
    bodies: Vec<Body>,
    /// By link; `None` for links that were dropped.
    seats: Vec<Option<Seat>>,
}

/// A link's constant place in its body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seat {
    pub body: usize,
    pub place: Frame<f64>,
}

/// A rigid part and how it hangs on its parent.
#[derive(Clone, Debug, PartialEq)]
struct Body {
    parent: usize,
    /// The body's origin in the parent body at position zero.
    origin: [f64; 3],
    step: Step,
}

#[derive(Clone, Debug, PartialEq)]
enum Step {
    /// A constant turn, then one about the new z axis.
    Turn(Turn, Source),
    /// A shift along an axis in the parent body.
    Shift([f64; 3], Source),
    /// A constant turn, then seven positions as they are.
    Float([[f64; 3]; 3], usize),
}

/// A constant turn between two joint axes.
#[derive(Clone, Debug, PartialEq)]
enum Turn {
    /// The parent is the root: nothing to multiply with.
    Root([[f64; 3]; 3]),
    /// About x.
    Twist {
        cos: f64,
        sin: f64,
    },
    Full([[f64; 3]; 3]),
}

impl Chain {
    /// Compiles `joints`, parents first, of a robot whose links are numbered; `needed` says by link whether its frame
    /// will be asked for.
    ///
    /// # Panics
    /// When a joint names a link beyond `needed`, or its parent is not yet placed.
    #[must_use]
    pub fn compile(root: usize, joints: &[ChainJoint], needed: &[bool]) -> Self {
        let mut draft = Draft::new(root, joints, needed.len());
        draft.drop_unneeded(needed);
        let aims = draft.aims();
        let bodies = draft.bodies.iter().zip(&aims).filter_map(|(b, &aim)| b.finish(aim, &aims)).collect();
        let seats = draft.seats.iter().map(|s| Some(s.as_ref()?.aimed(&aims))).collect();
        Self { bodies, seats }
    }

    /// How many frames [`Self::frames`] computes.
    #[must_use]
    pub fn body_count(&self) -> usize {
        self.bodies.len() + 1
    }

    /// Where a link sits; `None` if it was not needed.
    #[must_use]
    pub fn seat(&self, link: usize) -> Option<&Seat> {
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

    /// As [`Self::frames`] for one state, to the same bits, with eight joints' sines in lanes.
    #[inline(always)]
    pub fn frames_of_one<S: Simd>(&self, simd: S, positions: &[f64], frames: &mut [Frame<f64>]) {
        let q = |i: usize| positions[i];
        // most bodies hang on the one before: it is kept at hand, for memory just written is slow to read otherwise
        let mut last = Frame::IDENTITY;
        frames[0] = last;
        for (eight, first) in self.bodies.chunks(8).zip((1..).step_by(8)) {
            let mut angles = [0.0; 8];
            for (angle, body) in angles.iter_mut().zip(eight) {
                *angle = body.angle(q);
            }
            let (sin, cos) = sin_cos(f64x8::simd_from(simd, angles));
            for (lane, body) in eight.iter().enumerate() {
                let parent = if body.parent + 1 == first + lane { last } else { frames[body.parent] };
                last = body.frame((), q, &parent, |_| (sin[lane], cos[lane]));
                frames[first + lane] = last;
            }
        }
    }

    /// The frame of a link in the root, from the frames of all bodies; `None` if the link was not needed.
    #[inline(always)]
    pub fn link_frame<T: Real>(&self, link: usize, frames: &[Frame<T>]) -> Option<Frame<T>> {
        self.seat(link).map(|seat| frames[seat.body].then(&seat.place))
    }
}

impl Body {
    /// The angle that a turning body turns by.
    fn angle(&self, q: impl Fn(usize) -> f64) -> f64 {
        if let Step::Turn(_, source) = &self.step { source.value(&q) } else { 0.0 }
    }

    /// The body's frame in the root; `sin_cos` is asked for a turning body's angle.
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

/// Two axes, turned towards each other's place.
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

    /// A vector of this frame, as seen from outside.
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

    /// A point of this frame, as seen from outside.
    #[inline(always)]
    #[must_use]
    pub fn point<V: Copy>(&self, p: [V; 3]) -> [T; 3]
    where
        T: Mul<V, Output = T>,
    {
        let p = self.turn(p);
        [self.t[0] + p[0], self.t[1] + p[1], self.t[2] + p[2]]
    }

    /// A frame within this one, as seen from outside.
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
    pub const IDENTITY: Self = Self { r: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], t: [0.0; 3] };
}

impl From<&Frame<f64>> for MatrixPose {
    fn from(Frame { r: [x, y, z], t }: &Frame<f64>) -> Self {
        let column = |v: &[f64; 3]| Vector::from(*v);
        let rotation = RotationMatrix::from_columns(&[column(x), column(y), column(z)]);
        Self { rotation, translation: column(t) }
    }
}

impl From<&Pose> for Frame<f64> {
    fn from(pose: &Pose) -> Self {
        Place::from(pose).frame()
    }
}

/// A constant frame while compiling.
#[derive(Clone, Copy, Debug)]
struct Place {
    r: RotationMatrix,
    t: Vector,
}

impl Place {
    fn identity() -> Self {
        Self { r: RotationMatrix::identity(), t: Vector::zeros() }
    }

    /// `self`, then `inner` within it.
    fn then(&self, inner: &Self) -> Self {
        Self { r: self.r * inner.r, t: self.r * inner.t + self.t }
    }

    fn turned_by(&self, r: &RotationMatrix) -> Self {
        Self { r: self.r * r, t: self.t }
    }

    /// This place as seen from a frame that is turned by `aim` about z.
    fn seen_from(&self, aim: f64) -> Self {
        let back = about_z(-aim);
        Self { r: back * self.r, t: back * self.t }
    }

    fn frame(&self) -> Frame<f64> {
        Frame { r: columns(&self.r), t: self.t.into() }
    }
}

impl From<&Pose> for Place {
    fn from(pose: &Pose) -> Self {
        Self { r: pose.rotation.to_rotation_matrix().into_inner(), t: pose.translation.vector }
    }
}

fn columns(r: &RotationMatrix) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|i| r.column(i).into_owned().into())
}

fn about_z(angle: f64) -> RotationMatrix {
    let (sin, cos) = angle.sin_cos();
    RotationMatrix::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0)
}

/// A rotation that takes z to `axis`, by the shortest way.
fn z_onto(axis: &UnitVector) -> RotationMatrix {
    let turn = nalgebra::Rotation3::rotation_between(&Vector::z(), axis);
    turn.map_or(RotationMatrix::from_diagonal(&Vector::new(1.0, -1.0, -1.0)), nalgebra::Rotation3::into_inner)
}

/// Bodies and seats before the frames of turning bodies are aimed at their children.
struct Draft {
    bodies: Vec<DraftBody>,
    seats: Vec<Option<DraftSeat>>,
}

#[derive(Clone, Debug)]
struct DraftBody {
    parent: usize,
    /// Place in the parent body at position zero.
    place: Place,
    motion: DraftMotion,
    /// Whether this is the child that its parent's x axis is made for.
    aimed_at: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum DraftMotion {
    Root,
    /// About z of the body's place.
    Turn(Source),
    /// Along an axis in the parent body.
    Shift(Vector, Source),
    Float(usize),
}

#[derive(Clone, Copy, Debug)]
struct DraftSeat {
    body: usize,
    place: Place,
}

impl Draft {
    fn new(root: usize, joints: &[ChainJoint], links: usize) -> Self {
        let body =
            DraftBody { parent: 0, place: Place::identity(), motion: DraftMotion::Root, aimed_at: false };
        let mut draft = Self { bodies: vec![body], seats: vec![None; links] };
        draft.seats[root] = Some(DraftSeat { body: 0, place: Place::identity() });
        for joint in joints {
            let parent = draft.seats[joint.parent].expect("parents come before children");
            let place = parent.place.then(&Place::from(&joint.pose_pj));
            draft.seats[joint.child] = Some(draft.add(DraftSeat { body: parent.body, place }, &joint.motion));
        }
        draft
    }

    /// The seat of a link that moves in `joint`.
    fn add(&mut self, joint: DraftSeat, motion: &Motion) -> DraftSeat {
        let position = |index| Source { index, multiplier: 1.0, offset: 0.0 };
        match *motion {
            Motion::Fixed => joint,
            Motion::Revolute(axis, source) => self.add_turn(joint, &z_onto(&axis), source),
            Motion::Prismatic(axis, source) => self.add_shift(joint, &axis, source),
            Motion::Planar(plane, first) => {
                let along = |i| plane.column(i).into_owned();
                let joint = self.add_shift(joint, &along(0), position(first));
                let joint = self.add_shift(joint, &along(1), position(first + 1));
                self.add_turn(joint, &plane, position(first + 2))
            }
            Motion::Floating(first) => self.add_body(joint.body, joint.place, DraftMotion::Float(first)),
        }
    }

    /// A body turning about the z column of `axes`; its link's seat undoes those axes.
    fn add_turn(&mut self, joint: DraftSeat, axes: &RotationMatrix, source: Source) -> DraftSeat {
        let seat = self.add_body(joint.body, joint.place.turned_by(axes), DraftMotion::Turn(source));
        DraftSeat { place: seat.place.turned_by(&axes.transpose()), ..seat }
    }

    /// A body that slides and keeps its parent's orientation; its link's seat makes up for the joint's.
    fn add_shift(&mut self, joint: DraftSeat, axis: &Vector, source: Source) -> DraftSeat {
        let Place { r, t } = joint.place;
        let place = Place { r: RotationMatrix::identity(), t };
        let seat = self.add_body(joint.body, place, DraftMotion::Shift(r * axis, source));
        DraftSeat { place: seat.place.turned_by(&r), ..seat }
    }

    fn add_body(&mut self, parent: usize, place: Place, motion: DraftMotion) -> DraftSeat {
        self.bodies.push(DraftBody { parent, place, motion, aimed_at: false });
        DraftSeat { body: self.bodies.len() - 1, place: Place::identity() }
    }

    /// Keeps the seats of needed links, and the bodies they sit on or hang from.
    fn drop_unneeded(&mut self, needed: &[bool]) {
        let mut keep = vec![false; self.bodies.len()];
        keep[0] = true;
        for (seat, _) in self.seats.iter_mut().zip(needed).filter(|(_, needed)| !**needed) {
            *seat = None;
        }
        for seat in self.seats.iter().flatten() {
            keep[seat.body] = true;
        }
        for i in (1..keep.len()).rev() {
            keep[self.bodies[i].parent] |= keep[i];
        }
        let mut kept = 0;
        let renumbered: Vec<usize> = keep.iter().map(|&k| (kept, kept += usize::from(k)).0).collect();
        let mut keeping = keep.iter();
        self.bodies.retain(|_| keeping.next() == Some(&true));
        for body in &mut self.bodies {
            body.parent = renumbered[body.parent];
        }
        for seat in self.seats.iter_mut().flatten() {
            seat.body = renumbered[seat.body];
        }
    }

    /// By how much each body's frame is to be turned about z, so that its x axis is the common normal to its own axis
    /// and its first turning child's. Sliding bodies turn along with their parents.
    fn aims(&mut self) -> Vec<f64> {
        let turns = |body: &DraftBody| matches!(body.motion, DraftMotion::Turn(_));
        let mut aims: Vec<Option<f64>> = vec![None; self.bodies.len()];
        for i in 1..self.bodies.len() {
            let parent = self.bodies[i].parent;
            if turns(&self.bodies[i]) && turns(&self.bodies[parent]) && aims[parent].is_none() {
                aims[parent] = Some(normal_direction(&self.bodies[i].place.r));
                self.bodies[i].aimed_at = true;
            }
        }
        for (i, body) in self.bodies.iter().enumerate() {
            if let DraftMotion::Shift(..) = body.motion {
                aims[i] = aims[body.parent];
            }
        }
        aims.into_iter().map(Option::unwrap_or_default).collect()
    }
}

/// The angle a of `r = Rz(a) Rx(α) Rz(b)` with sin α ≥ 0: its third column is (sin a sin α, −cos a sin α, cos α).
fn normal_direction(r: &RotationMatrix) -> f64 {
    match (r[(0, 2)], -r[(1, 2)]) {
        // parallel axes
        (0.0, 0.0) => 0.0,
        (sin, cos) => sin.atan2(cos),
    }
}

impl DraftBody {
    /// The body with its frame turned by `aim` about z, in a parent turned by its own; `None` for the root's.
    fn finish(&self, aim: f64, aims: &[f64]) -> Option<Body> {
        let place = self.place.seen_from(aims[self.parent]);
        let step = match self.motion {
            DraftMotion::Turn(source) if self.aimed_at => {
                // place.r = Rx(α) Rz(b): first row (cos b, −sin b, 0), third column (0, −sin α, cos α)
                let b = (-place.r[(0, 1)]).atan2(place.r[(0, 0)]);
                let (sin, cos) = (-place.r[(1, 2)], place.r[(2, 2)]);
                let length = sin.hypot(cos);
                Step::Turn(Turn::Twist { cos: cos / length, sin: sin / length }, source.shifted(b + aim))
            }
            DraftMotion::Turn(source) if self.parent == 0 => {
                Step::Turn(Turn::Root(columns(&place.r)), source.shifted(aim))
            }
            DraftMotion::Turn(source) => Step::Turn(Turn::Full(columns(&place.r)), source.shifted(aim)),
            DraftMotion::Shift(axis, source) => {
                Step::Shift((about_z(-aims[self.parent]) * axis).into(), source)
            }
            DraftMotion::Float(first) => Step::Float(columns(&place.r), first),
            DraftMotion::Root => return None,
        };
        Some(Body { parent: self.parent, origin: place.t.into(), step })
    }
}

impl DraftSeat {
    fn aimed(&self, aims: &[f64]) -> Seat {
        Seat { body: self.body, place: self.place.seen_from(aims[self.body]).frame() }
    }
}

impl Source {
    /// The same position counted from elsewhere, less whole turns.
    fn shifted(self, angle: f64) -> Self {
        let turn = std::f64::consts::TAU;
        Self { offset: self.offset + (angle - (angle / turn).round() * turn), ..self }
    }
}

#[cfg(test)]
mod tests;
