//! Parts of a solid: the triangles in the cells of a partition of space by planes.
//!
//! All planes are parallel to one direction. A line of this direction through a point inside a closed surface stays in the point's cell, and
//! meets the surface on both sides of the point. So a convex shape that contains the surface in a cell contains the inside of the solid in
//! this cell, too.

use clearance_geometry::math::{Extremes, Point, RotationMatrix, Vector, symmetric_eigen};

/// The triangles in a cell (m), cut at its planes.
#[derive(Clone, Debug)]
pub struct LinkPart {
    pub triangles: Vec<[Point; 3]>,
}

impl LinkPart {
    /// The corners of all triangles (m): their convex hull contains the part.
    pub fn points(&self) -> impl Iterator<Item = &Point> + Clone {
        self.triangles.iter().flatten()
    }

    /// The parts on both sides of the plane of all points p with `normal` · p = `offset`; `None` if one is empty.
    pub fn split(&self, normal: &Vector, offset: f64) -> Option<[Self; 2]> {
        let mut sides = [vec![], vec![]];
        for triangle in &self.triangles {
            let heights = triangle.map(|p| normal.dot(&p.coords) - offset);
            for (side, sign) in sides.iter_mut().zip([-1.0, 1.0]) {
                let polygon = clipped(triangle, heights.map(|height| sign * height));
                side.extend((2..polygon.len()).map(|i| [polygon[0], polygon[i - 1], polygon[i]]));
            }
        }
        let [below, above] = sides;
        let is_whole = below.is_empty() || above.is_empty();
        (!is_whole).then_some([Self { triangles: below }, Self { triangles: above }])
    }

    /// Smallest and largest coordinate (m) along a direction.
    pub fn range(&self, direction: &Vector) -> [f64; 2] {
        let along = self.points().map(|p| direction.dot(&p.coords));
        along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| [low.lesser(at), high.greater(at)])
    }
}

/// Corners of the part of a triangle where the heights are not negative. A triangle in the plane is on both sides.
fn clipped(triangle: &[Point; 3], heights: [f64; 3]) -> Vec<Point> {
    let mut polygon = vec![];
    for i in 0..3 {
        let j = (i + 1) % 3;
        if heights[i] >= 0.0 {
            polygon.push(triangle[i]);
        }
        if (heights[i] < 0.0) != (heights[j] < 0.0) {
            let t = heights[i] / (heights[i] - heights[j]);
            polygon.push(triangle[i] + (triangle[j] - triangle[i]) * t);
        }
    }
    polygon
}

/// Principal axes of the surface of triangles, the longest first.
pub fn principal_axes(triangles: &[[Point; 3]]) -> [Vector; 3] {
    let (mut weight, mut mean, mut squares) = (0.0, Vector::zeros(), RotationMatrix::zeros());
    for [a, b, c] in triangles {
        // triangles without area count a little
        let area = (b - a).cross(&(c - a)).norm() + 1e-12;
        for p in [a.coords, b.coords, c.coords] {
            weight += area;
            mean += p * area;
            squares += p * p.transpose() * area;
        }
    }
    let mean = mean / weight;
    let eigen = symmetric_eigen(&(squares / weight - mean * mean.transpose()));
    let mut order = [0, 1, 2];
    order.sort_by(|i, j| eigen.eigenvalues[*j].total_cmp(&eigen.eigenvalues[*i]));
    order.map(|i| eigen.eigenvectors.column(i).into_owned())
}
