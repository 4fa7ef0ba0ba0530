//! Far field of some faces: their solid angle around a distant point, with a bound on its error (Barill, Dickson, Schmidt, Levin & Jacobson
//! 2018, *Fast winding numbers for soups and clouds*, section 3.2, which has the expansion but no bound).
//!
//! # The expansion
//!
//! Faces with unit normals n have the solid angle Ω(q) = ∫ n·f(x) dA around a point q, where f(x) = (x − q)/|x − q|³. With any centre c,
//! y = x − c, d = c − q and R = |d|, the first three terms of f at c give
//!
//! > Ω(q) ≈ a·d/R³ − 3 S(d)/R⁵ + 15/2 T(d)/R⁷.
//!
//! Here a = ∫ n dA is the area vector, S the harmonic part of the quadratic form ∫ (n·d)(y·d) dA, and T that of the cubic form
//! ∫ (n·d)(y·d)² dA. (The rest of the forms cancels, because f is the gradient of the harmonic function −1/|x − q|.)
//!
//! # The error
//!
//! With ρ = |x − q|, the k-th derivative of 1/ρ along one unit vector is k! P(cos)/ρᵏ⁺¹ up to the sign, with the Legendre polynomial
//! |P| ≤ 1. A symmetric form is largest where all its arguments are the same (Banach 1938), so k!/ρᵏ⁺¹ bounds it along any k unit vectors,
//! and 4!/ρ⁵ the third derivative of n·f. At t from c, ρ ≥ R − t. By Taylor's theorem, n·f at s = |y| < R differs from the three terms by
//! at most
//!
//! > ∫₀ˢ (s − t)²/2 · 24/(R − t)⁵ dt = s³ (4R − 3s)/(R⁴ (R − s)²).
//!
//! The factor of s³ increases with s, so it is largest at the radius r of the faces around c. With I = ∫ |y|² dA,
//!
//! > |error| ≤ I r φ(R)/R⁵,  φ(R) = R (4R − 3r)/(R − r)².
//!
//! φ decreases with R: its value at the nearest permitted distance holds for all larger ones.

use super::moments::{CubicForm, Moments, QuadraticForm};
use crate::math::{Extremes, Point, Vector};

/// Least distance of a point from the centre, as a multiple of the root mean square distance of the faces' points from it.
const NEAREST: f64 = 4.5;

/// Least distance of a point from the centre, as a multiple of the radius of the faces around it.
const NEAREST_RADII: f64 = 1.5;

/// Allowance for rounding, relative to what enters.
const ROUNDING: f64 = 1e-10;

/// Expansion of the solid angle of some faces about their centre.
#[derive(Clone, Copy, Debug)]
pub(super) struct FarField {
    centre: Point,
    area_vector: Vector,
    quadratic: QuadraticForm,
    cubic: CubicForm,
    /// As in [`Moments`].
    edge_products: f64,
    /// Bound on the error of the solid angle times the fifth power of the distance, at the nearest distance and farther.
    remainder: f64,
    /// Square of the nearest distance from the centre at which the field may be used.
    nearest_squared: f64,
}

/// A solid angle as a sum over faces, some of them by their far field.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SolidAngle {
    pub value: f64,
    /// Bound on the error by truncated expansions, before rounding.
    pub truncation: f64,
    /// A ninth of a bound on the sum of the absolute values of all faces' solid angles.
    pub magnitude: f64,
}

impl FarField {
    /// The far field of faces with these moments; `radius` (m) is the largest distance of a corner from their centre.
    pub fn new(moments: &Moments, radius: f64) -> Self {
        let Moments { centre, area_vector, area, second_moment, edge_products, face_count, .. } = *moments;
        let mean_square = if area > 0.0 { second_moment / area } else { 0.0 };
        let nearest = (NEAREST * mean_square.sqrt()).greater(NEAREST_RADII * radius);
        let beyond = nearest - radius;
        let phi =
            if radius > 0.0 { nearest * (4.0 * nearest - 3.0 * radius) / (beyond * beyond) } else { 0.0 };
        Self {
            centre,
            area_vector,
            quadratic: moments.harmonic_quadratic(),
            cubic: moments.harmonic_cubic(),
            edge_products,
            remainder: second_moment * radius * phi * (1.0 + rounding_of_sum(face_count)),
            nearest_squared: nearest * nearest,
        }
    }

    /// Adds the solid angle around a point, if the point is far enough; `sharpness` multiplies the square of the least distance. Returns
    /// true if it was added.
    #[inline]
    pub fn add_to(&self, sum: &mut SolidAngle, point: &Point, sharpness: f64) -> bool {
        let d = self.centre - point;
        let squared = d.norm_squared();
        // nothing is proven by NaN
        let is_far = squared > sharpness * self.nearest_squared;
        if is_far {
            let (x, y, z, inverse) = (d.x, d.y, d.z, 1.0 / squared);
            let [xx, yy, zz, xy, xz, yz] = self.quadratic;
            let quadratic = x * (xx * x + xy * y + xz * z) + y * (yy * y + yz * z) + zz * z * z;
            let [xxx, yyy, zzz, xxy, xxz, yyx, yyz, zzx, zzy, xyz] = self.cubic;
            let cubic = x * x * (xxx * x + xxy * y + xxz * z)
                + y * y * (yyx * x + yyy * y + yyz * z)
                + z * z * (zzx * x + zzy * y + zzz * z)
                + xyz * x * y * z;
            let scaled = self.area_vector.dot(&d) + inverse * (7.5 * inverse * cubic - 3.0 * quadratic);
            let root = inverse.sqrt();
            sum.value += scaled * inverse * root;
            sum.truncation += self.remainder * inverse * inverse * root;
            sum.magnitude += self.edge_products * inverse;
        }
        is_far
    }
}

impl SolidAngle {
    /// Bound on the difference from the sum over all `faces` in any order of rounded additions.
    pub fn error(&self, faces: usize) -> f64 {
        // a face appears at most (1 - 1 / NEAREST_RADII)⁻² times larger than at the centre
        self.truncation * (1.0 + ROUNDING) + 9.0 * self.magnitude * rounding_of_sum(faces)
    }
}

/// Allowance for the rounding of a sum, relative to the sum of absolute values.
#[allow(clippy::cast_precision_loss)] // a bound
fn rounding_of_sum(count: usize) -> f64 {
    ROUNDING + count as f64 * f64::EPSILON
}
