//! Test helper: double-double numbers (106 bits), and vectors and poses of them, for the oracles.
//!
//! A number is an unevaluated sum of two f64 (Dekker 1971, *A floating-point technique for extending the available
//! precision*; Joldes, Muller & Popescu 2017, *Tight and rigorous error bounds for basic building blocks of double-word
//! arithmetic*, algorithms 6, 12 and 17).

use std::ops::{Add, Div, Mul, Neg, Sub};

use clearance::geometry::math::{Point, Pose, Vector};

#[derive(Clone, Copy, Debug)]
pub struct DoubleDouble {
    hi: f64,
    lo: f64,
}

/// The sum and its rounding error.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    (sum, (a - (sum - b_part)) + (b - b_part))
}

/// As [`two_sum`], for `|a| >= |b|`.
fn fast_two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    (sum, b - (sum - a))
}

/// Two halves of 26 bits.
fn split(a: f64) -> (f64, f64) {
    let shifted = 134_217_729.0 * a;
    let hi = shifted - (shifted - a);
    (hi, a - hi)
}

/// The product and its rounding error.
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    let ((a_hi, a_lo), (b_hi, b_lo)) = (split(a), split(b));
    (product, a_lo * b_lo - (((product - a_hi * b_hi) - a_lo * b_hi) - a_hi * b_lo))
}

impl DoubleDouble {
    pub const ZERO: Self = Self { hi: 0.0, lo: 0.0 };

    /// The nearest f64; it has the sign of the number.
    pub fn rounded(self) -> f64 {
        self.hi
    }
}

impl From<f64> for DoubleDouble {
    fn from(hi: f64) -> Self {
        Self { hi, lo: 0.0 }
    }
}

impl Add for DoubleDouble {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let (high, high_error) = two_sum(self.hi, other.hi);
        let (low, low_error) = two_sum(self.lo, other.lo);
        let (high, carried) = fast_two_sum(high, high_error + low);
        let (hi, lo) = fast_two_sum(high, carried + low_error);
        Self { hi, lo }
    }
}

impl Neg for DoubleDouble {
    type Output = Self;
    fn neg(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }
}

impl Sub for DoubleDouble {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for DoubleDouble {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let (high, error) = two_product(self.hi, other.hi);
        let (hi, lo) = fast_two_sum(high, error + (self.hi * other.lo + self.lo * other.hi));
        Self { hi, lo }
    }
}

impl Div for DoubleDouble {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let first = self.hi / other.hi;
        let rest = self - other * Self::from(first);
        let (hi, lo) = fast_two_sum(first, rest.hi / other.hi);
        Self { hi, lo }
    }
}

/// A point or a displacement in 106 bits.
#[derive(Clone, Copy, Debug)]
pub struct Vec3(pub [DoubleDouble; 3]);

impl Vec3 {
    pub const ZERO: Self = Self([DoubleDouble::ZERO; 3]);

    pub fn dot(&self, other: &Self) -> DoubleDouble {
        let ([a, b, c], [d, e, f]) = (self.0, other.0);
        a * d + b * e + c * f
    }

    pub fn cross(&self, other: &Self) -> Self {
        let ([a, b, c], [d, e, f]) = (self.0, other.0);
        Self([b * f - c * e, c * d - a * f, a * e - b * d])
    }

    pub fn norm_squared(&self) -> DoubleDouble {
        self.dot(self)
    }

    pub fn scaled(&self, factor: DoubleDouble) -> Self {
        Self(self.0.map(|c| c * factor))
    }

    pub fn rounded(&self) -> Vector {
        Vector::from(self.0.map(DoubleDouble::rounded))
    }
}

impl From<&Point> for Vec3 {
    fn from(p: &Point) -> Self {
        Self([p.x, p.y, p.z].map(DoubleDouble::from))
    }
}

impl Add for Vec3 {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }
}

impl Sub for Vec3 {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] - other.0[i]))
    }
}

/// A rigid motion in 106 bits. What a pose of rounded numbers means: its quaternion is divided by its length first.
#[derive(Clone, Copy, Debug)]
pub struct ExactPose {
    /// Columns of the rotation matrix.
    axes: [Vec3; 3],
    origin: Vec3,
}

impl From<&Pose> for ExactPose {
    fn from(pose: &Pose) -> Self {
        let q = pose.rotation.quaternion();
        let [w, i, j, k] = [q.w, q.i, q.j, q.k].map(DoubleDouble::from);
        let twice = DoubleDouble::from(2.0) / (w * w + i * i + j * j + k * k);
        let one = DoubleDouble::from(1.0);
        let axes = [
            Vec3([one - (j * j + k * k) * twice, (i * j + w * k) * twice, (i * k - w * j) * twice]),
            Vec3([(i * j - w * k) * twice, one - (i * i + k * k) * twice, (j * k + w * i) * twice]),
            Vec3([(i * k + w * j) * twice, (j * k - w * i) * twice, one - (i * i + j * j) * twice]),
        ];
        Self { axes, origin: Vec3::from(&Point::from(pose.translation.vector)) }
    }
}

impl ExactPose {
    pub fn turned(&self, v: &Vec3) -> Vec3 {
        let [x, y, z] = v.0;
        self.axes[0].scaled(x) + self.axes[1].scaled(y) + self.axes[2].scaled(z)
    }

    pub fn point(&self, p: &Vec3) -> Vec3 {
        self.turned(p) + self.origin
    }

    /// The point in the moved frame.
    pub fn inverse_point(&self, p: &Vec3) -> Vec3 {
        let offset = *p - self.origin;
        Vec3(std::array::from_fn(|i| self.axes[i].dot(&offset)))
    }

    pub fn then(&self, inner: &Self) -> Self {
        Self { axes: inner.axes.map(|a| self.turned(&a)), origin: self.point(&inner.origin) }
    }
}

#[test]
fn double_doubles_keep_what_f64_loses() {
    let (big, small) = (DoubleDouble::from(1.0), DoubleDouble::from(1e-25));
    assert_eq!(((big + small) - big).rounded(), 1e-25);
    let third = big / DoubleDouble::from(3.0);
    let off = third * DoubleDouble::from(3.0) - big;
    assert!(off.rounded().abs() < 1e-31, "{off:?}");
    let square = (big + small) * (big - small) - big;
    assert!(square.rounded().abs() < 1e-31, "{square:?}");
}
