//! Kinematics of one state, with one SIMD vector per column of a frame. The operations on each coordinate, and their order, are the same
//! as for eight states in lanes, hence the results are bit-identical.

use clearance_geometry::math::MatrixPose;
use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{Simd, f32x8, f64x4, f64x8, sin_cos};

use super::{Body, Chain, Frame, Step, Turn};

/// A frame whose columns are vectors with an unused fourth element.
#[derive(Clone, Copy, Debug)]
pub struct Columns<S: Simd> {
    r: [f64x4<S>; 3],
    t: f64x4<S>,
}

/// The same frame in memory. It is written and read as a whole: splitting it between two joints would cost more than the joint.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub struct PlacedFrame([[f64; 4]; 4]);

/// Sources of the angles of eight bodies; arbitrary for bodies that are not revolute.
#[derive(Clone, Debug, PartialEq)]
#[repr(align(32))]
pub(super) struct EightSources {
    indices: [usize; 8],
    multipliers: [f64; 8],
    offsets: [f64; 8],
    /// Number of revolute bodies among the eight.
    turning: usize,
}

impl EightSources {
    /// Angle sources of up to eight bodies.
    #[inline]
    pub fn of(bodies: &[Body]) -> Self {
        let mut sources = Self { indices: [0; 8], multipliers: [0.0; 8], offsets: [0.0; 8], turning: 0 };
        for (lane, body) in bodies.iter().enumerate() {
            if let Step::Turn(_, source) = &body.step {
                sources.turning += 1;
                sources.indices[lane] = source.index;
                (sources.multipliers[lane], sources.offsets[lane]) = (source.multiplier, source.offset);
            }
        }
        sources
    }

    /// The sines and cosines of the angles.
    #[inline(always)]
    fn sines<S: Simd>(&self, simd: S, positions: &[f64]) -> (f64x8<S>, f64x8<S>) {
        if self.turning == 0 {
            return (f64x8::splat(simd, 0.0), f64x8::splat(simd, 1.0));
        }
        sin_cos(self.angles(simd, positions))
    }

    #[inline(always)]
    fn angles<S: Simd>(&self, simd: S, positions: &[f64]) -> f64x8<S> {
        // written out, to avoid memory in between: partly written memory is slow to read as a whole
        let q = |lane: usize| positions[self.indices[lane]];
        let q = f64x8::simd_from(simd, [q(0), q(1), q(2), q(3), q(4), q(5), q(6), q(7)]);
        q * f64x8::simd_from(simd, self.multipliers) + f64x8::simd_from(simd, self.offsets)
    }
}

impl Chain {
    /// As [`Self::frames`] for one state, with bit-identical results and eight joints' sines in lanes. Each frame is passed to `visit`
    /// with the number of its body while it is in registers.
    #[inline(always)]
    pub fn frames_of_one<S: Simd>(
        &self,
        simd: S,
        positions: &[f64],
        frames: &mut [PlacedFrame],
        mut visit: impl FnMut(usize, &Columns<S>),
    ) {
        frames[0] = PlacedFrame::IDENTITY;
        // the parent of most bodies is the previous one: it is kept in registers, since memory just written is slow to read
        let mut last = Columns::of(simd, &PlacedFrame::IDENTITY);
        visit(0, &last);
        for ((eight, sources), first) in self.bodies.chunks(8).zip(&self.angles).zip((1..).step_by(8)) {
            let (sin, cos) = sources.sines(simd, positions);
            for (lane, body) in eight.iter().enumerate() {
                let at_hand = body.parent + 1 == first + lane;
                let parent = if at_hand { last } else { Columns::of(simd, &frames[body.parent]) };
                last = body.columns(simd, positions, &parent, (sin[lane], cos[lane]));
                frames[first + lane] = last.placed();
                visit(first + lane, &last);
            }
        }
    }
}

impl Body {
    /// The body's frame in the root, from the sine and the cosine of its angle.
    #[inline(always)]
    pub fn columns<S: Simd>(
        &self,
        simd: S,
        positions: &[f64],
        parent: &Columns<S>,
        (sin, cos): (f64, f64),
    ) -> Columns<S> {
        let q = |i: usize| positions[i];
        match &self.step {
            Step::Turn(turn, _) => {
                let [x, y, z] = match turn {
                    Turn::Root(columns) => columns.map(|column| vector(simd, column)),
                    Turn::Twist { cos, sin } => {
                        let [x, y, z] = parent.r;
                        let [y, z] = mix(y, z, *cos, *sin);
                        [x, y, z]
                    }
                    Turn::Full([x, y, z]) => [parent.turn(*x), parent.turn(*y), parent.turn(*z)],
                };
                let [x, y] = mix(x, y, cos, sin);
                Columns { r: [x, y, z], t: parent.point(self.origin) }
            }
            Step::Shift(axis, source) => {
                let shift = source.value(&q);
                let [x, y, z] = self.origin;
                let shifted = [shift * axis[0] + x, shift * axis[1] + y, shift * axis[2] + z];
                Columns { r: parent.r, t: parent.point(shifted) }
            }
            Step::Float(..) => {
                let frame = self.frame((), q, &parent.placed().frame(), |_| (sin, cos));
                Columns::of(simd, &PlacedFrame::from(&frame))
            }
        }
    }
}

impl PlacedFrame {
    /// The identity transform.
    pub const IDENTITY: Self =
        Self([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0; 4]]);

    /// The frame as plain numbers.
    #[inline(always)]
    #[must_use]
    pub fn frame(&self) -> Frame<f64> {
        let [x, y, z, t] = self.0.map(|[x, y, z, _]| [x, y, z]);
        Frame { r: [x, y, z], t }
    }
}

impl From<&Frame<f64>> for PlacedFrame {
    fn from(Frame { r: [x, y, z], t }: &Frame<f64>) -> Self {
        Self([*x, *y, *z, *t].map(|[x, y, z]| [x, y, z, 0.0]))
    }
}

impl From<&PlacedFrame> for MatrixPose {
    fn from(placed: &PlacedFrame) -> Self {
        Self::from(&placed.frame())
    }
}

impl<S: Simd> Columns<S> {
    /// Loads a stored frame into SIMD registers.
    #[inline(always)]
    pub fn of(simd: S, PlacedFrame([x, y, z, t]): &PlacedFrame) -> Self {
        let vector = |v: &[f64; 4]| f64x4::from_slice(simd, v);
        Self { r: [vector(x), vector(y), vector(z)], t: vector(t) }
    }

    /// Stores the frame.
    #[inline(always)]
    pub fn placed(&self) -> PlacedFrame {
        let [x, y, z] = self.r;
        PlacedFrame([x.into(), y.into(), z.into(), self.t.into()])
    }

    /// As [`Frame::turn`].
    #[inline(always)]
    pub fn turn(&self, v: [f64; 3]) -> f64x4<S> {
        let [x, y, z] = self.r;
        x * v[0] + y * v[1] + z * v[2]
    }

    /// As [`Frame::point`].
    #[inline(always)]
    fn point(&self, p: [f64; 3]) -> f64x4<S> {
        self.t + self.turn(p)
    }

    /// The frame in single precision, each value twice: the columns, and the vector from `origin`, which occurs only once.
    #[inline(always)]
    pub fn doubled(&self, simd: S, origin: f64x4<S>) -> [f32x8<S>; 4] {
        let [x, y, z] = self.r;
        let (t, zero) = (self.t - origin, f64x4::splat(simd, 0.0));
        [x.narrow(x), y.narrow(y), z.narrow(z), t.narrow(zero)]
    }

    /// The origin of the frame.
    #[inline(always)]
    pub fn origin(&self) -> f64x4<S> {
        self.t
    }
}

#[inline(always)]
fn vector<S: Simd>(simd: S, [x, y, z]: [f64; 3]) -> f64x4<S> {
    f64x4::simd_from(simd, [x, y, z, 0.0])
}

/// Rotates two axes in their common plane.
#[inline(always)]
fn mix<S: Simd>(x: f64x4<S>, y: f64x4<S>, cos: f64, sin: f64) -> [f64x4<S>; 2] {
    [x * cos + y * sin, y * cos - x * sin]
}
