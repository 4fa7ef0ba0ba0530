//! Ranges of positions: joint limits narrowed by mimic joints, contradictory limits, and ranges for samples.

use std::f64::consts::PI;

use clearance_geometry::math::Extremes;

use super::{JointId, RobotModel};

/// Rounding error allowed in bounds that follow from mimic joints, relative to the numbers used: limits of a leader and its followers
/// that are meant to agree must not exclude each other's last digit.
const ROUNDING: f64 = 1e-12;

impl RobotModel {
    /// By position, the values (rad, m) with which its joint and all joints that mimic it are within their limits: lower and upper
    /// bound, infinite where there is none. The lower bound exceeds the upper one if these limits contradict each other.
    ///
    /// Planar and floating joints have no limits.
    #[must_use]
    pub fn position_ranges(&self) -> Vec<[f64; 2]> {
        let mut ranges = vec![[f64::NEG_INFINITY, f64::INFINITY]; self.position_names().len()];
        for id in self.joint_ids() {
            let joint = self.joint(id);
            let Some(limits) = joint.limits.filter(|_| joint.kind.position_suffixes().len() == 1) else {
                continue;
            };
            let (leader, [least, largest]) = match joint.mimic {
                None => (id, [limits.lower, limits.upper]),
                Some(mimic) if mimic.multiplier == 0.0 => continue,
                Some(mimic) => {
                    let of_leader = |limit: f64| (limit - mimic.offset) / mimic.multiplier;
                    let [a, b] = [of_leader(limits.lower), of_leader(limits.upper)];
                    let rounding =
                        |bound: f64| ROUNDING * (bound.abs() + (mimic.offset / mimic.multiplier).abs());
                    let [low, high] = [a.lesser(b), a.greater(b)];
                    (mimic.joint, [low - rounding(low), high + rounding(high)])
                }
            };
            let Some(position) = self.first_position(leader) else { continue };
            let [low, high] = &mut ranges[position];
            *low = low.greater(least);
            *high = high.lesser(largest);
        }
        ranges
    }

    /// The joints whose limits and those of the joints that mimic them exclude each other, with a warning for each.
    pub(super) fn contradictory_limits(&self) -> Vec<(JointId, String)> {
        let ranges = self.position_ranges();
        let empty = |id: JointId| {
            let [low, high] = ranges[self.first_position(id)?];
            let message = || {
                format!(
                    "no position is within its limits and those of the joints that mimic it: they demand at least {low:.6} and at most \
                     {high:.6}"
                )
            };
            (low > high).then(|| (id, message()))
        };
        self.joint_ids().filter_map(empty).collect()
    }

    /// By position, a finite range (rad, m) for random states: [`Self::position_ranges`] where these are bounds. Otherwise a joint that
    /// turns has the turn from -π to π, and other joints have half a metre to either side, shifted as far as a single bound demands.
    /// Contradictory limits give the range between them.
    ///
    /// The entries of planar and floating joints have no meaning.
    #[must_use]
    pub fn sampling_ranges(&self) -> Vec<[f64; 2]> {
        let mut ranges = self.position_ranges();
        for id in self.joint_ids() {
            let Some(first) = self.first_position(id) else { continue };
            let half = if self.joint(id).kind.turns() { PI } else { 0.5 };
            for range in ranges.iter_mut().skip(first).take(self.joint(id).kind.position_suffixes().len()) {
                *range = match (range[0].is_finite(), range[1].is_finite()) {
                    (true, true) => [range[0].lesser(range[1]), range[0].greater(range[1])],
                    (true, false) => [range[0].greater(-half), range[0].greater(-half) + 2.0 * half],
                    (false, true) => [range[1].lesser(half) - 2.0 * half, range[1].lesser(half)],
                    (false, false) => [-half, half],
                };
            }
        }
        ranges
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{MeshFiles, SamplingBox};

    /// A gripper whose second finger follows the first; its limits are the given ones.
    fn gripper(follower: &str, mimic: &str) -> RobotModel {
        let urdf = format!(
            "<robot name='r'><link name='a'/><link name='b'/><link name='c'/><link name='d'/>
            <joint name='first' type='prismatic'><parent link='a'/><child link='b'/><axis xyz='0 0 1'/>
              <limit lower='0' upper='0.08' effort='1' velocity='1'/></joint>
            <joint name='second' type='prismatic'><parent link='b'/><child link='c'/><axis xyz='0 0 1'/>
              <limit {follower} effort='1' velocity='1'/><mimic joint='first' {mimic}/></joint>
            <joint name='wheel' type='continuous'><parent link='c'/><child link='d'/><axis xyz='0 0 1'/></joint></robot>"
        );
        RobotModel::from_urdf(&urdf, &MeshFiles::default()).unwrap()
    }

    #[test]
    fn followers_narrow_the_range_of_their_leader() {
        for (follower, mimic, expected) in [
            ("lower='0' upper='0.04'", "", [0.0, 0.04]),
            ("lower='-0.02' upper='0'", "multiplier='-1'", [0.0, 0.02]),
            ("lower='0.03' upper='1'", "multiplier='2' offset='0.01'", [0.01, 0.08]),
            ("lower='1' upper='2'", "multiplier='0'", [0.0, 0.08]),
        ] {
            let robot = gripper(follower, mimic);
            let ranges = robot.position_ranges();
            let error = (0..2).map(|i| (ranges[0][i] - expected[i]).abs()).fold(0.0, f64::greater);
            assert!(error < 1e-12, "{follower} {mimic}: {:?}", ranges[0]);
            assert_eq!(ranges[1], [f64::NEG_INFINITY, f64::INFINITY]);
            assert_eq!(robot.sampling_ranges()[1], [-PI, PI]);
            let mut random = fastrand::Rng::with_seed(5);
            for _ in 0..200 {
                let states = [
                    robot.random_configuration(&mut random),
                    robot.sample(&SamplingBox::default(), || random.f64()),
                ];
                if !mimic.contains("'0'") {
                    assert!(states.iter().all(|q| robot.outside_limits(q.positions()).next().is_none()));
                }
            }
        }
    }

    #[test]
    fn limits_that_agree_keep_their_last_digit() {
        for (multiplier, upper) in [("0.1", "0.008"), ("-0.7", "0.056"), ("3", "0.24"), ("0.3", "0.024")] {
            let limits = if multiplier.starts_with('-') {
                format!("lower='-{upper}' upper='0'")
            } else {
                format!("lower='0' upper='{upper}'")
            };
            let robot = gripper(&limits, &format!("multiplier='{multiplier}'"));
            assert_eq!(robot.position_ranges()[0][1], 0.08, "{multiplier}");
        }
    }

    #[test]
    fn contradictory_limits_are_an_empty_range_and_still_have_samples() {
        let robot = gripper("lower='0.5' upper='1'", "");
        let [low, high] = robot.position_ranges()[0];
        assert!((low - 0.5).abs() < 1e-11 && high == 0.08);
        let warning =
            robot.warnings.iter().map(ToString::to_string).find(|text| text.contains("mimic it")).unwrap();
        assert!(
            warning.contains("'first'") && warning.contains("at least 0.500000 and at most 0.080000"),
            "{warning}"
        );
        assert!(gripper("lower='0' upper='0.04'", "").contradictory_limits().is_empty());
        assert_eq!(robot.sampling_ranges()[0], [high, low]);
    }
}
