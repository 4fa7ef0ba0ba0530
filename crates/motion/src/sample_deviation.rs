//! Estimates how far a smooth motion deviates from the straight motions between its samples.

use clearance_geometry::math::Extremes;
use clearance_robot::Configuration;

/// Deviation (rad, m) of each position between samples of a smooth motion, such as a line or an arc of a link frame: half of
/// the largest second difference of the position. Give it to [`with_tube`](crate::MotionSegment::with_tube).
///
/// The samples are at equal steps of the motion's parameter; `None` for fewer than three, which say nothing about it.
///
/// It is an estimate with a margin of safety, not a proof. Let a be the largest second derivative of a position by the number
/// of the sample. Between two samples the position deviates by at most a / 8 from the straight motion, and every second
/// difference is a second derivative between its samples. The result is therefore large enough if a is at most four times
/// the largest second difference. This fails where the inverse kinematics is near a singularity that the samples miss: use
/// more samples there.
#[must_use]
pub fn sample_deviation(samples: &[Configuration]) -> Option<Vec<f64>> {
    let [first, _, _, ..] = samples else { return None };
    let second = |three: &[Configuration], i: usize| {
        let [a, b, c] = [0, 1, 2].map(|k| three[k].positions()[i]);
        (a - 2.0 * b + c).abs()
    };
    let largest = |i| samples.windows(3).map(|three| second(three, i)).fold(0.0, f64::greater);
    Some((0..first.positions().len()).map(|i| 0.5 * largest(i)).collect())
}

#[cfg(test)]
mod tests {
    use clearance_robot::{MeshFiles, RobotModel};

    use super::*;

    /// A parabola deviates by an eighth of its second difference; a straight motion not at all.
    #[test]
    fn the_deviation_of_a_parabola_is_four_times_the_true_one() {
        let urdf = include_str!("../../../urdf/two_link/two_link.urdf");
        let robot = RobotModel::from_urdf(urdf, &MeshFiles::default()).unwrap();
        let at = |x: f64| robot.configuration(&[0.1 * x * x, 0.2 * x]).unwrap();
        let samples: Vec<Configuration> = (0..5).map(|i| at(f64::from(i))).collect();
        let found = sample_deviation(&samples).unwrap();
        let middle =
            |i: usize| 0.5 * (at(1.0).positions()[i] + at(2.0).positions()[i]) - at(1.5).positions()[i];
        assert!((found[0] - 4.0 * middle(0).abs()).abs() < 1e-12, "{found:?}");
        assert!(found[1] < 1e-12, "{found:?}");
        assert_eq!((sample_deviation(&samples[..2]), sample_deviation(&[])), (None, None));
    }
}
