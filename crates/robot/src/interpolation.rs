//! Interpolation between configurations, and their distance.

use clearance_geometry::math::Rotation;

use super::{Configuration, JointKind, RobotModel};

impl RobotModel {
    /// The configuration at t in [0, 1] of the straight line in joint space that motion checks use: every position changes
    /// at constant speed, and floating joints rotate at constant speed by the shortest path.
    ///
    /// Continuous joints pass through all positions between the two, also by more than half a turn. Subtract whole turns
    /// first if they are to take the shorter direction.
    ///
    /// # Panics
    /// If a configuration is of a robot with another number of positions.
    #[must_use]
    pub fn interpolate(&self, from: &Configuration, to: &Configuration, t: f64) -> Configuration {
        let mut q = from.clone();
        self.interpolate_into(from, to, t, &mut q);
        q
    }

    /// As [`Self::interpolate`], into an existing configuration of this robot: allocates nothing.
    ///
    /// # Panics
    /// If a configuration is of a robot with another number of positions.
    pub fn interpolate_into(&self, from: &Configuration, to: &Configuration, t: f64, q: &mut Configuration) {
        let count = self.position_names().len();
        let (a, b) = (from.positions(), to.positions());
        assert!([a.len(), b.len(), q.positions().len()] == [count; 3], "configurations of another robot");
        let t = t.clamp(0.0, 1.0);
        if t == 1.0 {
            q.positions_mut().copy_from_slice(b);
            return;
        }
        for (i, position) in q.positions_mut().iter_mut().enumerate() {
            *position = a[i] + t * (b[i] - a[i]);
        }
        for first in self.quaternions() {
            let (start, turn) = shortest_turn(&a[first..first + 4], &b[first..first + 4]);
            let axis = turn.axis().unwrap_or(nalgebra::Vector3::z_axis());
            let at = (Rotation::from_axis_angle(&axis, turn.angle() * t) * start).coords;
            q.positions_mut()[first..first + 4].copy_from_slice(at.as_slice());
        }
    }

    /// Distance of two configurations in joint space: the Euclidean norm of the differences of all positions (rad, m).
    ///
    /// The orientation of a floating joint counts with its rotation angle (rad). Continuous joints count as they move in
    /// [`Self::interpolate`]: by all positions between the two. It is the length of that line, so distances along it add up.
    ///
    /// # Panics
    /// If a configuration is of a robot with another number of positions.
    #[must_use]
    pub fn joint_space_distance(&self, a: &Configuration, b: &Configuration) -> f64 {
        self.norm_of_difference(a, b, |_| 1.0)
    }

    /// As [`Self::joint_space_distance`], with a factor for each position. The rotation angle of a floating joint has the
    /// factor of its `rot_x`.
    ///
    /// # Panics
    /// If there is not one factor for each position, or if a configuration is of a robot with another number of positions.
    #[must_use]
    pub fn weighted_joint_space_distance(
        &self,
        a: &Configuration,
        b: &Configuration,
        weights: &[f64],
    ) -> f64 {
        assert_eq!(weights.len(), self.position_names().len(), "a weight for every position");
        self.norm_of_difference(a, b, |position| weights[position])
    }

    fn norm_of_difference(&self, a: &Configuration, b: &Configuration, weight: impl Fn(usize) -> f64) -> f64 {
        let (a, b) = (a.positions(), b.positions());
        assert!([a.len(), b.len()] == [self.position_names().len(); 2], "configurations of another robot");
        let square = |position: usize, difference: f64| (weight(position) * difference).powi(2);
        // the components of quaternions do not count
        let is_component = |i: usize| self.quaternions().any(|first| (first..first + 4).contains(&i));
        let positions = (0..a.len()).filter(|i| !is_component(*i)).map(|i| square(i, b[i] - a[i]));
        let turn = |first: usize| shortest_turn(&a[first..first + 4], &b[first..first + 4]).1;
        let turns = self.quaternions().map(|first| square(first, turn(first).angle()));
        let sum: f64 = positions.chain(turns).sum();
        sum.sqrt()
    }

    /// Index of the first component of each floating joint's quaternion.
    fn quaternions(&self) -> impl Iterator<Item = usize> {
        let floating = self.joint_ids().filter(|id| self.joint(*id).kind == JointKind::Floating);
        floating.filter_map(|id| Some(self.first_position(id)? + 3))
    }
}

/// A rotation, and the shortest turn from it to another one; quaternions are x, y, z, w.
fn shortest_turn(from: &[f64], to: &[f64]) -> (Rotation, Rotation) {
    let rotation = |q: &[f64]| Rotation::from_quaternion(nalgebra::Quaternion::new(q[3], q[0], q[1], q[2]));
    let (from, to) = (rotation(from), rotation(to));
    (from, to * from.inverse())
}
