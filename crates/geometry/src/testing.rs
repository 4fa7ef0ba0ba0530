//! Test helper for all crates: random numbers, vectors and primitives, and every SIMD level of this machine.

use crate::Primitive;
use crate::math::{Pose, Rotation, UnitVector, Vector};
use crate::simd::Level;

/// A small deterministic random number generator (SplitMix64).
#[derive(Debug)]
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, count: usize) -> usize {
        (self.bits() % count as u64) as usize
    }

    /// Uniform in `[-extent, extent)`.
    pub fn within(&mut self, extent: f64) -> f64 {
        ((self.bits() >> 11) as f64 / (1u64 << 52) as f64 - 1.0) * extent
    }

    pub fn vector(&mut self, extent: f64) -> Vector {
        Vector::new(self.within(extent), self.within(extent), self.within(extent))
    }

    pub fn direction(&mut self) -> UnitVector {
        match self.below(3) {
            // most joint axes of robots are coordinate axes
            0 => [Vector::x_axis(), Vector::y_axis(), Vector::z_axis()][self.below(3)],
            1 => -[Vector::x_axis(), Vector::y_axis(), Vector::z_axis()][self.below(3)],
            _ => UnitVector::new_normalize(self.vector(1.0)),
        }
    }

    pub fn rotation(&mut self) -> Rotation {
        let quarters = [0.0, 0.5, 1.0, -0.5][self.below(4)] * std::f64::consts::PI;
        let angle = if self.below(2) == 0 { quarters } else { self.within(4.0) };
        Rotation::from_axis_angle(&self.direction(), angle)
    }

    pub fn pose(&mut self, extent: f64) -> Pose {
        Pose::from_parts(self.vector(extent).into(), self.rotation())
    }

    /// A primitive of any kind; sizes are from 0.1 to 0.5 m.
    pub fn primitive(&mut self) -> Primitive {
        let [x, y, z] = [(); 3].map(|()| 0.1 + self.within(0.4).abs());
        match self.below(5) {
            0 => Primitive::Box { half_extents: [x, y, z] },
            1 => Primitive::Sphere { radius: x },
            2 => Primitive::Cylinder { radius: x, half_length: y },
            3 => Primitive::Cone { radius: x, half_length: y },
            _ => Primitive::Capsule { radius: x, half_length: y },
        }
    }
}

/// Every SIMD level supported by this machine.
pub fn levels() -> Vec<Level> {
    let best = Level::new();
    let mut levels = Vec::new();
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    {
        levels.extend(best.as_sse2().map(Level::Sse2));
        levels.extend(best.as_sse4_2().map(Level::Sse4_2));
        levels.extend(best.as_avx2().map(Level::Avx2));
    }
    levels.push(best);
    levels
}
