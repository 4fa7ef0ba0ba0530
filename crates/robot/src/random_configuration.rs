//! Random configurations: uniform within joint limits, and within a box for planar and floating joints.

use std::f64::consts::{PI, TAU};

use clearance_geometry::math::Extremes;

use super::{Configuration, JointKind, RobotModel};

/// Region from which planar and floating joints are sampled: positions (m) in the joint's frame along x, y and z. A planar
/// joint uses the first two for its `x` and `y`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SamplingBox {
    /// Smallest positions (m).
    pub lower: [f64; 3],
    /// Largest positions (m).
    pub upper: [f64; 3],
}

impl Default for SamplingBox {
    /// One metre to either side.
    fn default() -> Self {
        Self { lower: [-1.0; 3], upper: [1.0; 3] }
    }
}

impl RobotModel {
    /// A configuration that is uniform over [`Self::sampling_ranges`]; planar and floating joints keep their default positions.
    #[must_use]
    pub fn random_configuration(&self, random: &mut fastrand::Rng) -> Configuration {
        let ranges = self.sampling_ranges();
        let mut positions = self.default_configuration().positions().to_vec();
        for id in self.joint_ids().filter(|id| self.joint(*id).kind.position_suffixes().len() == 1) {
            let Some(first) = self.first_position(id) else { continue };
            let [low, high] = ranges[first];
            positions[first] = low + (high - low) * random.f64();
        }
        // if a mimic joint exceeds the largest allowed position, the robot keeps its default configuration
        self.configuration(&positions).unwrap_or_else(|_| self.default_configuration())
    }

    /// A configuration that is uniform over [`Self::sampling_ranges`], from numbers in [0, 1) that `uniform` draws: any random
    /// generator, without a dependency on it. The same numbers give the same configuration; one is drawn for each degree of
    /// freedom, in the order of [`Self::position_names`].
    ///
    /// Planar and floating joints are uniform over `region`, with any orientation (Shoemake 1992, *Uniform random rotations*).
    /// Mimic joints follow.
    #[must_use]
    pub fn sample(&self, region: &SamplingBox, mut uniform: impl FnMut() -> f64) -> Configuration {
        let mut within = |low: f64, high: f64| low + (high - low) * uniform().greater(0.0).lesser(1.0);
        let sampling_ranges = self.sampling_ranges();
        let mut positions = vec![0.0; self.position_names().len()];
        for id in self.joint_ids() {
            let Some(first) = self.first_position(id) else { continue };
            let place = |axis: usize| (region.lower[axis], region.upper[axis]);
            let ranges = match self.joint(id).kind {
                JointKind::Floating => {
                    (0..3).for_each(|axis| positions[first + axis] = within(place(axis).0, place(axis).1));
                    let [share, a, b] = [within(0.0, 1.0), within(0.0, TAU), within(0.0, TAU)];
                    let [small, large] = [(1.0 - share).sqrt(), share.sqrt()];
                    let turn = [small * a.sin(), small * a.cos(), large * b.sin(), large * b.cos()];
                    positions[first + 3..first + 7].copy_from_slice(&turn);
                    continue;
                }
                JointKind::Planar(_) => vec![place(0), place(1), (-PI, PI)],
                JointKind::Fixed => continue,
                JointKind::Revolute(_) | JointKind::Continuous(_) | JointKind::Prismatic(_) => {
                    vec![sampling_ranges[first].into()]
                }
            };
            for (offset, (low, high)) in ranges.into_iter().enumerate() {
                positions[first + offset] = within(low, high);
            }
        }
        // if a mimic joint exceeds the largest allowed position, the robot keeps its default configuration
        self.configuration(&positions).unwrap_or_else(|_| self.default_configuration())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MeshFiles;

    const URDF: &str =
        "<robot name='r'><link name='a'/><link name='b'/><link name='c'/><link name='d'/><link name='e'/>
        <joint name='base' type='floating'><parent link='a'/><child link='b'/></joint>
        <joint name='cart' type='planar'><parent link='b'/><child link='c'/><axis xyz='0 0 1'/></joint>
        <joint name='wheel' type='continuous'><parent link='c'/><child link='d'/><axis xyz='0 0 1'/></joint>
        <joint name='arm' type='revolute'><parent link='d'/><child link='e'/><axis xyz='0 0 1'/>
          <limit lower='0.5' upper='1.5' effort='1' velocity='1'/></joint></robot>";

    #[test]
    fn samples_fill_their_ranges_evenly() {
        let robot = RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap();
        let region = SamplingBox { lower: [1.0, 2.0, 3.0], upper: [2.0, 4.0, 6.0] };
        let mut random = fastrand::Rng::with_seed(3);
        let count = 4000;
        let samples: Vec<Vec<f64>> =
            (0..count).map(|_| robot.sample(&region, || random.f64()).positions().to_vec()).collect();
        let expected = [
            (1.0, 2.0),
            (2.0, 4.0),
            (3.0, 6.0),
            (-1.0, 1.0),
            (-1.0, 1.0),
            (-1.0, 1.0),
            (-1.0, 1.0),
            (1.0, 2.0),
            (2.0, 4.0),
            (-PI, PI),
            (-PI, PI),
            (0.5, 1.5),
        ];
        assert_eq!(robot.position_names().len(), expected.len());
        for (i, (low, high)) in expected.into_iter().enumerate() {
            let mean = samples.iter().map(|q| q[i]).sum::<f64>() / f64::from(count);
            assert!(samples.iter().all(|q| (low..=high).contains(&q[i])), "{i}");
            assert!((mean - 0.5 * (low + high)).abs() < 0.03 * (high - low), "{i}: {mean}");
        }
        // of a random rotation, the square of each component of the quaternion is 1/4 on average, and x y is 0
        for i in 3..7 {
            let square = samples.iter().map(|q| q[i] * q[i]).sum::<f64>() / f64::from(count);
            assert!((square - 0.25).abs() < 0.02, "{i}: {square}");
        }
        let product = samples.iter().map(|q| q[3] * q[4]).sum::<f64>() / f64::from(count);
        assert!(product.abs() < 0.02, "{product}");
    }

    #[test]
    fn the_same_numbers_give_the_same_sample_and_bad_ones_stay_within() {
        let robot = RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap();
        let region = SamplingBox::default();
        let draw = |seed: u64| {
            let mut random = fastrand::Rng::with_seed(seed);
            robot.sample(&region, || random.f64())
        };
        assert!(draw(1) == draw(1) && draw(1) != draw(2));
        for bad in [f64::NAN, -1.0, 2.0, f64::INFINITY] {
            let q = robot.sample(&region, || bad);
            assert!(robot.outside_limits(q.positions()).next().is_none(), "{bad}");
        }
    }
}
