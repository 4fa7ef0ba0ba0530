//! Moments of faces about a centre, weighted with the unit normals n of the faces: the coefficients of their far field.

use crate::math::{Point, Vector};

/// Coefficients of x², y², z², xy, xz and yz.
pub(super) type QuadraticForm = [f64; 6];

/// Coefficients of x³, y³, z³, x²y, x²z, y²x, y²z, z²x, z²y and xyz.
pub(super) type CubicForm = [f64; 10];

/// Integrals over faces, where y is the vector from the centre to a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moments {
    /// The mean of all points by area.
    pub centre: Point,
    /// Integral of n (m²).
    pub area_vector: Vector,
    /// Integral of (n·d)(y·d), a form in d (m³).
    pub quadratic: QuadraticForm,
    /// Integral of (n·d)(y·d)², a form in d (m⁴).
    pub cubic: CubicForm,
    pub area: f64,
    /// Integral of |y|² (m⁴).
    pub second_moment: f64,
    /// Sum of the products of two edges (m²): at least twice the area, and what the rounding of area vectors is relative to.
    pub edge_products: f64,
    pub face_count: usize,
}

impl Moments {
    /// Moments of one triangle.
    pub fn of_triangle([a, b, c]: [Point; 3]) -> Self {
        let (ab, ac) = (b - a, c - a);
        let area_vector = 0.5 * ab.cross(&ac);
        let centre = a + (ab + ac) / 3.0;
        let mut moments = Self {
            area: area_vector.norm(),
            edge_products: ab.norm() * ac.norm(),
            face_count: 1,
            ..Self::nothing_at(centre)
        };
        moments.area_vector = area_vector;
        // the means of y yᵀ and |y|² over a triangle around its centre
        for y in [a - centre, b - centre, c - centre] {
            add(&mut moments.cubic, &product_cubic(&product(&(area_vector / 12.0), &y), &y));
            moments.second_moment += moments.area / 12.0 * y.norm_squared();
        }
        moments
    }

    /// Moments of all faces of some others, about their common centre; `None` of none.
    pub fn joined(parts: impl Iterator<Item = Self> + Clone) -> Option<Self> {
        let start = parts.clone().next()?.centre;
        let area: f64 = parts.clone().map(|part| part.area).sum();
        let sum: Vector = parts.clone().map(|part| (part.centre - start) * part.area).sum();
        let mut all = Self::nothing_at(if area > 0.0 { start + sum / area } else { start });
        parts.for_each(|part| all.add(&part));
        Some(all)
    }

    fn nothing_at(centre: Point) -> Self {
        Self {
            centre,
            area_vector: Vector::zeros(),
            quadratic: [0.0; 6],
            cubic: [0.0; 10],
            area: 0.0,
            second_moment: 0.0,
            edge_products: 0.0,
            face_count: 0,
        }
    }

    /// Adds other moments, moved to this centre: y becomes y + v.
    fn add(&mut self, other: &Self) {
        let v = other.centre - self.centre;
        let moved = product(&other.area_vector, &v);
        add(&mut self.cubic, &other.cubic);
        add(&mut self.cubic, &product_cubic(&other.quadratic.map(|c| 2.0 * c), &v));
        add(&mut self.cubic, &product_cubic(&moved, &v));
        add(&mut self.quadratic, &other.quadratic);
        add(&mut self.quadratic, &moved);
        self.area_vector += other.area_vector;
        self.area += other.area;
        // the centre is the mean of the points
        self.second_moment += other.second_moment + other.area * v.norm_squared();
        self.edge_products += other.edge_products;
        self.face_count += other.face_count;
    }

    /// The harmonic part of the quadratic form.
    pub fn harmonic_quadratic(&self) -> QuadraticForm {
        let [xx, yy, zz, xy, xz, yz] = self.quadratic;
        let mean = (xx + yy + zz) / 3.0;
        [xx - mean, yy - mean, zz - mean, xy, xz, yz]
    }

    /// The harmonic part of the cubic form p: p − |d|² Δp/10.
    pub fn harmonic_cubic(&self) -> CubicForm {
        let [xxx, yyy, zzz, xxy, xxz, yyx, yyz, zzx, zzy, xyz] = self.cubic;
        let x = (3.0 * xxx + yyx + zzx) / 5.0;
        let y = (3.0 * yyy + xxy + zzy) / 5.0;
        let z = (3.0 * zzz + xxz + yyz) / 5.0;
        [xxx - x, yyy - y, zzz - z, xxy - y, xxz - z, yyx - x, yyz - z, zzx - x, zzy - y, xyz]
    }
}

fn add<const N: usize>(sum: &mut [f64; N], terms: &[f64; N]) {
    sum.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
}

/// The form (a·d)(b·d).
fn product(a: &Vector, b: &Vector) -> QuadraticForm {
    [a.x * b.x, a.y * b.y, a.z * b.z, a.x * b.y + a.y * b.x, a.x * b.z + a.z * b.x, a.y * b.z + a.z * b.y]
}

/// A quadratic form times b·d.
fn product_cubic([xx, yy, zz, xy, xz, yz]: &QuadraticForm, b: &Vector) -> CubicForm {
    [
        xx * b.x,
        yy * b.y,
        zz * b.z,
        xx * b.y + xy * b.x,
        xx * b.z + xz * b.x,
        yy * b.x + xy * b.y,
        yy * b.z + yz * b.y,
        zz * b.x + xz * b.z,
        zz * b.y + yz * b.z,
        xy * b.z + xz * b.y + yz * b.x,
    ]
}
