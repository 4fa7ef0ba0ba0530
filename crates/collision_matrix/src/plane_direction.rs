//! Direction of a separating plane, coded as three characters: a point of an octahedron's net of 512 × 512 cells (Meyer et al. 2010, *On
//! floating-point normal vectors*).

use clearance_geometry::math::Vector;

/// Cells along each side of the net.
const CELLS: u32 = 512;

/// The digits: 64 characters that need no escape in JSON.
const DIGITS: &[u8; 64] = b"0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz-_";

/// A direction rounded to a cell of the net.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlaneDirection(u32);

impl PlaneDirection {
    /// The cell of a vector that is not zero.
    #[must_use]
    pub fn nearest(v: &Vector) -> Self {
        let p = v / v.abs().sum();
        let (mut x, mut y) = (p.x, p.y);
        if p.z < 0.0 {
            (x, y) = ((1.0 - p.y.abs()) * 1f64.copysign(p.x), (1.0 - p.x.abs()) * 1f64.copysign(p.y));
        }
        let cell = |c: f64| {
            let scaled = (c * 0.5 + 0.5) * f64::from(CELLS);
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped before")]
            let cell = scaled.clamp(0.0, f64::from(CELLS - 1)) as u32;
            cell
        };
        Self(cell(x) * CELLS + cell(y))
    }

    /// The unit vector at the centre of the cell.
    #[must_use]
    pub fn vector(self) -> Vector {
        let coordinate = |cell: u32| (f64::from(cell) + 0.5) / f64::from(CELLS) * 2.0 - 1.0;
        let (mut x, mut y) = (coordinate(self.0 / CELLS), coordinate(self.0 % CELLS));
        let z = 1.0 - x.abs() - y.abs();
        if z < 0.0 {
            (x, y) = ((1.0 - y.abs()) * 1f64.copysign(x), (1.0 - x.abs()) * 1f64.copysign(y));
        }
        Vector::new(x, y, z).normalize()
    }

    /// The three characters.
    pub fn text(self) -> impl Iterator<Item = char> {
        three_digits(self.0)
    }
}

/// A number below 2¹⁸ as three characters.
pub fn three_digits(number: u32) -> impl Iterator<Item = char> {
    [12, 6, 0].into_iter().map(move |shift| char::from(DIGITS[(number >> shift & 63) as usize]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coded_direction_is_near_the_original() {
        let mut random = fastrand::Rng::with_seed(1);
        for _ in 0..2000 {
            let v = Vector::from_fn(|_, _| random.f64() - 0.5);
            let coded = PlaneDirection::nearest(&v).vector();
            assert!(coded.dot(&v.normalize()) > 0.9999, "{v} {coded}");
        }
    }
}
