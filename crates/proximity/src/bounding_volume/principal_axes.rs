//! Principal axes: the directions in which points spread most.

use clearance_geometry::math::{RotationMatrix, Vector, symmetric_eigen};

/// Right-handed axes as columns, the direction of largest spread first (eigenvectors of the covariance matrix;
/// Gottschalk, Lin & Manocha 1996, section 4).
#[must_use]
pub fn principal_axes(points: &[Vector]) -> RotationMatrix {
    #[allow(clippy::cast_precision_loss)] // a mean needs no more than 52 bits of the count
    let count = points.len().max(1) as f64;
    let mean = points.iter().fold(Vector::zeros(), |s, p| s + p) / count;
    let covariance = points.iter().fold(RotationMatrix::zeros(), |s, p| {
        let d = p - mean;
        s + d * d.transpose()
    });
    let scale = covariance.amax();
    if scale == 0.0 || !scale.is_finite() {
        return RotationMatrix::identity();
    }
    let eigen = symmetric_eigen(&(covariance / scale));
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| eigen.eigenvalues[j].total_cmp(&eigen.eigenvalues[i]));
    orthonormal(&eigen.eigenvectors.column(order[0]).into(), &eigen.eigenvectors.column(order[1]).into())
}

/// Axes along `first` and, as far as it is normal to that, `second`: orthonormal up to rounding for any input.
fn orthonormal(first: &Vector, second: &Vector) -> RotationMatrix {
    let x = first.normalize();
    let rest = second - x * x.dot(second);
    let y = rest.try_normalize(1e-6).unwrap_or_else(|| any_normal_to(&x));
    RotationMatrix::from_columns(&[x, y, x.cross(&y)])
}

fn any_normal_to(x: &Vector) -> Vector {
    let mut smallest = Vector::zeros();
    smallest[x.iamin()] = 1.0;
    x.cross(&smallest).normalize()
}
