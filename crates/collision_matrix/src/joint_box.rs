//! Box of joint positions, and its halves.

/// A box of values of the variables of a path.
#[derive(Clone, Debug, PartialEq)]
pub struct JointBox {
    /// By variable: least and largest value (rad, m).
    pub ranges: Vec<[f64; 2]>,
}

impl JointBox {
    /// Writes the centre and the half widths, by variable. The half widths are rounded up.
    pub fn centre(&self, centre: &mut Vec<f64>, half_widths: &mut Vec<f64>) {
        centre.clear();
        half_widths.clear();
        for &[low, high] in &self.ranges {
            let middle = low.midpoint(high);
            centre.push(middle);
            half_widths.push((middle - low).max(high - middle).next_up());
        }
    }

    /// The two halves of the box along a variable.
    #[must_use]
    pub fn halves(&self, variable: usize) -> [Self; 2] {
        let [low, high] = self.ranges[variable];
        let middle = low.midpoint(high);
        [[low, middle], [middle, high]].map(|range| {
            let mut half = self.clone();
            half.ranges[variable] = range;
            half
        })
    }
}
