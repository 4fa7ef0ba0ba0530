//! Sums of squared distances from planes (Garland and Heckbert 1997, *Surface simplification using quadric error metrics*).

use clearance_geometry::math::{Point, RotationMatrix, Vector, symmetric_eigen};

/// Eigenvalues below this part of the largest count as zero: planes that differ by less than half a degree are one plane.
const FLAT: f64 = 1e-4;

/// A weighted sum of squared distances (m²) from planes, as a function of the point.
#[derive(Clone, Copy, Debug)]
pub struct Quadric {
    matrix: RotationMatrix,
    vector: Vector,
    constant: f64,
}

impl Quadric {
    /// The sum over no plane.
    pub fn zero() -> Self {
        Self { matrix: RotationMatrix::zeros(), vector: Vector::zeros(), constant: 0.0 }
    }

    /// Adds the plane through `point` with a unit normal.
    pub fn add_plane(&mut self, point: &Point, normal: &Vector, weight: f64) {
        let offset = normal.dot(&point.coords);
        self.matrix += normal * normal.transpose() * weight;
        self.vector -= normal * (weight * offset);
        self.constant += weight * offset * offset;
    }

    /// The sum over the planes of both.
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            matrix: self.matrix + other.matrix,
            vector: self.vector + other.vector,
            constant: self.constant + other.constant,
        }
    }

    /// Value at a point.
    #[cfg(test)]
    fn value(&self, p: &Point) -> f64 {
        let p = &p.coords;
        p.dot(&(self.matrix * p)) + 2.0 * self.vector.dot(p) + self.constant
    }

    /// The point with the least value; where several have it, the nearest to `start`.
    pub fn least(&self, start: &Point) -> Point {
        let slope = self.matrix * start.coords + self.vector;
        let eigen = symmetric_eigen(&self.matrix);
        let least = FLAT * eigen.eigenvalues.amax();
        let mut point = *start;
        for (value, axis) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
            if *value > least {
                point -= axis * (axis.dot(&slope) / value);
            }
        }
        point
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_squared_distances() {
        let mut quadric = Quadric::zero();
        let planes = [
            (Point::new(1.0, 2.0, 3.0), Vector::new(0.6, 0.0, 0.8), 2.0),
            (Point::new(-1.0, 0.5, 0.0), Vector::new(0.0, 1.0, 0.0), 0.5),
        ];
        for (point, normal, weight) in &planes {
            quadric.add_plane(point, normal, *weight);
        }
        let p = Point::new(0.3, -0.7, 0.9);
        let expected: f64 = planes.iter().map(|(q, n, w)| w * n.dot(&(p - q)).powi(2)).sum();
        assert!((quadric.value(&p) - expected).abs() < 1e-12);
        // the line where both planes meet
        let least = quadric.least(&p);
        assert!(quadric.value(&least).abs() < 1e-12);
        let along = Vector::new(0.8, 0.0, -0.6);
        assert!(along.dot(&(least - p)).abs() < 1e-12, "the nearest of all");
    }
}
