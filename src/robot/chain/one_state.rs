//! Kinematics of one state, a vector for each column of a frame: the same operations on each coordinate as of eight states in lanes,
//! in the same order, hence the same bits.

use super::{Body, Chain, Frame, Step, Turn};
use crate::simd::prelude::*;
use crate::simd::{Simd, f32x8, f64x4, f64x8, sin_cos};

/// A frame, whose columns are vectors of which the fourth number means nothing.
#[derive(Clone, Copy, Debug)]
pub struct Columns<S: Simd> {
    r: [f64x4<S>; 3],
    t: f64x4<S>,
}

/// Where the angles of eight bodies come from; of those that do not turn any number.
#[derive(Clone, Debug, PartialEq)]
#[repr(align(32))]
pub(super) struct EightSources {
    indices: [usize; 8],
    multipliers: [f64; 8],
    offsets: [f64; 8],
}

impl EightSources {
    /// Of up to eight bodies.
    pub fn of(bodies: &[Body]) -> Self {
        let mut sources = Self { indices: [0; 8], multipliers: [0.0; 8], offsets: [0.0; 8] };
        for (lane, body) in bodies.iter().enumerate() {
            if let Step::Turn(_, source) = &body.step {
                sources.indices[lane] = source.index;
                (sources.multipliers[lane], sources.offsets[lane]) = (source.multiplier, source.offset);
            }
        }
        sources
    }

    #[inline(always)]
    fn angles<S: Simd>(&self, simd: S, positions: &[f64]) -> f64x8<S> {
        // written out, so that no memory is between: what was just written in parts is slow to read as one
        let q = |lane: usize| positions[self.indices[lane]];
        let q = f64x8::simd_from(simd, [q(0), q(1), q(2), q(3), q(4), q(5), q(6), q(7)]);
        q * f64x8::simd_from(simd, self.multipliers) + f64x8::simd_from(simd, self.offsets)
    }
}

impl Chain {
    /// As [`Self::frames`] for one state, to the same bits, with eight joints' sines in lanes. Each frame is shown to `visit` with
    /// the number of its body, while it is at hand.
    #[inline(always)]
    pub fn frames_of_one<S: Simd>(
        &self,
        simd: S,
        positions: &[f64],
        frames: &mut [Frame<f64>],
        mut visit: impl FnMut(usize, &Columns<S>),
    ) {
        frames[0] = Frame::IDENTITY;
        // most bodies hang on the one before: it is kept at hand, for memory just written is slow to read otherwise
        let mut last = Columns::of(simd, &Frame::IDENTITY);
        visit(0, &last);
        for ((eight, sources), first) in self.bodies.chunks(8).zip(&self.angles).zip((1..).step_by(8)) {
            let (sin, cos) = sin_cos(sources.angles(simd, positions));
            for (lane, body) in eight.iter().enumerate() {
                let at_hand = body.parent + 1 == first + lane;
                let parent = if at_hand { last } else { Columns::of(simd, &frames[body.parent]) };
                last = body.columns(simd, positions, &parent, (sin[lane], cos[lane]));
                frames[first + lane] = last.frame();
                visit(first + lane, &last);
            }
        }
    }
}

impl Body {
    /// The body's frame in the root, from the sine and the cosine of its angle.
    #[inline(always)]
    fn columns<S: Simd>(
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
            Step::Float(..) => Columns::of(simd, &self.frame((), q, &parent.frame(), |_| (sin, cos))),
        }
    }
}

impl<S: Simd> Columns<S> {
    #[inline(always)]
    pub fn of(simd: S, Frame { r: [x, y, z], t }: &Frame<f64>) -> Self {
        Self { r: [vector(simd, *x), vector(simd, *y), vector(simd, *z)], t: vector(simd, *t) }
    }

    #[inline(always)]
    fn frame(&self) -> Frame<f64> {
        let [x, y, z] = self.r;
        Frame { r: [numbers(x), numbers(y), numbers(z)], t: numbers(self.t) }
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

    /// In single precision, each twice: the columns, and the way to here from an `origin`, which is but once there.
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

#[inline(always)]
fn numbers<S: Simd>(v: f64x4<S>) -> [f64; 3] {
    let [x, y, z, _] = v.into();
    [x, y, z]
}

/// Two axes, turned towards each other's place.
#[inline(always)]
fn mix<S: Simd>(x: f64x4<S>, y: f64x4<S>, cos: f64, sin: f64) -> [f64x4<S>; 2] {
    [x * cos + y * sin, y * cos - x * sin]
}
