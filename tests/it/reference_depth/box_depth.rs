//! Test oracle: exact penetration depth of two unions of axis-aligned boxes, by enumeration.
//!
//! Translations after which two boxes overlap form a box, their Minkowski difference; those after which two unions overlap form the union
//! of such boxes. The nearest translation that is inside of none has coordinates that are zero or a face of a box.

use clearance::geometry::math::{Point, Vector};

/// A box along the axes.
#[derive(Clone, Copy, Debug)]
pub struct AxisBox {
    pub low: Point,
    pub high: Point,
}

impl AxisBox {
    pub fn around(centre: [f64; 3], half_extents: [f64; 3]) -> Self {
        let (centre, half) = (Point::from(centre), Vector::from(half_extents));
        Self { low: centre - half, high: centre + half }
    }

    /// The box under a permutation of the axes with signs, then moved.
    pub fn placed(&self, axes: &[(usize, f64); 3], by: &Vector) -> Self {
        let turned = |p: &Point| Point::from(axes.map(|(axis, sign)| p[axis] * sign)) + by;
        let (p, q) = (turned(&self.low), turned(&self.high));
        Self { low: p.inf(&q), high: p.sup(&q) }
    }

    /// Translations of the other box after which both overlap.
    fn difference(&self, other: &Self) -> Self {
        Self { low: Point::from(self.low - other.high), high: Point::from(self.high - other.low) }
    }

    fn holds_inside(&self, x: &Vector) -> bool {
        (0..3).all(|i| self.low[i] < x[i] && x[i] < self.high[i])
    }
}

/// Length (m) of the shortest translation of b after which no boxes of a and b have a common inner point; 0 if they have none.
pub fn depth_of_boxes(a: &[AxisBox], b: &[AxisBox]) -> f64 {
    let blocked: Vec<AxisBox> = a.iter().flat_map(|a| b.iter().map(|b| a.difference(b))).collect();
    let coordinates = |i: usize| -> Vec<f64> {
        blocked.iter().flat_map(|block| [block.low[i], block.high[i]]).chain([0.0]).collect()
    };
    let [xs, ys, zs] = [0, 1, 2].map(coordinates);
    let mut least = f64::INFINITY;
    for x in &xs {
        for y in &ys {
            for z in &zs {
                let translation = Vector::new(*x, *y, *z);
                if translation.norm() < least && !blocked.iter().any(|block| block.holds_inside(&translation))
                {
                    least = translation.norm();
                }
            }
        }
    }
    least
}

#[test]
fn a_peg_leaves_a_gap_by_the_shorter_way() {
    let walls = [
        AxisBox::around([-1.0, 0.0, 0.0], [0.5, 1.0, 1.0]),
        AxisBox::around([1.0, 0.0, 0.0], [0.5, 1.0, 1.0]),
    ];
    let peg = |x: f64| [AxisBox::around([x, 0.0, 0.0], [0.3, 0.2, 0.2])];
    assert_eq!(depth_of_boxes(&walls, &peg(0.1)), 0.0);
    assert!((depth_of_boxes(&walls, &peg(0.4)) - 0.2).abs() < 1e-12);
    assert!((depth_of_boxes(&walls, &peg(1.0)) - 0.8).abs() < 1e-12);
}
