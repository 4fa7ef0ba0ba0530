//! Poses of a frame or an obstacle since the last motion of the joints began, and their largest displacement.

use clearance_geometry::math::{Extremes, Pose};
use clearance_scene::is_elsewhere;

/// Largest number of poses that are kept.
const MOST_POSES: usize = 1024;

/// A displacement between two poses is at most this many times the largest one from the last pose.
///
/// Distances are known at two poses P and Q; Q is the last one. At another pose R, they are at least the mean of both, less the mean of
/// the displacements of R from P and from Q. The former is at most that of R from Q and that of Q from P.
const FROM_ANY: f64 = 1.5;

/// Poses of a frame or an obstacle, oldest first. The first is that at the start of the motion.
#[derive(Clone, Debug, Default)]
pub(super) struct PoseHistory {
    poses: Vec<Pose>,
    /// Whether some could not be kept.
    is_cut: bool,
}

/// Bound on the displacements between poses.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct LargestDisplacement {
    /// Of the origin that it was measured at (m).
    pub moved: f64,
    /// Largest angle (rad); infinite where some poses are not known.
    pub turned: f64,
}

impl PoseHistory {
    /// Adds a pose.
    pub fn note(&mut self, pose: Pose) {
        if self.poses.last().is_some_and(|last| !is_elsewhere(last, &pose)) {
            return;
        }
        if self.poses.len() == MOST_POSES {
            self.poses.pop();
            self.is_cut = true;
        }
        self.poses.push(pose);
    }

    /// Some poses are not known.
    pub fn note_lost(&mut self) {
        self.is_cut = true;
    }

    /// A motion of the joints begins: earlier poses no longer matter.
    pub fn start(&mut self) {
        self.poses.drain(..self.poses.len().saturating_sub(1));
        self.is_cut = false;
    }

    pub fn is_empty(&self) -> bool {
        self.poses.is_empty()
    }

    /// Bound on the displacements of all that a frame with these poses carries, from where the last one has it; `place` gives the
    /// frame's pose in the root frame. Measured at the root's origin.
    pub fn displacement_about_root(&self, place: impl Fn(&Pose) -> Pose) -> LargestDisplacement {
        let poses: Vec<Pose> = self.poses.iter().map(place).collect();
        self.largest(&poses, |before, after| (after * before.inverse()).translation.vector.norm())
    }

    /// Bound on the displacements of a body with these poses in the root frame, from where the last one has it. Measured at the
    /// body's origin.
    pub fn displacement_about_itself(&self) -> LargestDisplacement {
        self.largest(&self.poses, |before, after| {
            (after.translation.vector - before.translation.vector).norm()
        })
    }

    /// It is the length of the way, or a multiple of the largest displacement from the last pose if that is less: measured poses
    /// tremble.
    fn largest(&self, places: &[Pose], moved: impl Fn(&Pose, &Pose) -> f64) -> LargestDisplacement {
        if self.is_cut {
            return LargestDisplacement { moved: f64::INFINITY, turned: f64::INFINITY };
        }
        let Some(last) = places.last() else { return LargestDisplacement::default() };
        let between =
            |before: &Pose, after: &Pose| [moved(before, after), before.rotation.angle_to(&after.rotation)];
        let (mut length, mut largest) = ([0.0; 2], [0.0; 2]);
        for (before, after) in places.iter().zip(&places[1..]) {
            let (step, from_last) = (between(before, after), between(before, last));
            for i in 0..2 {
                length[i] += step[i];
                largest[i] = from_last[i].greater(largest[i]);
            }
        }
        let [moved, turned] = [0, 1].map(|i| length[i].lesser(FROM_ANY * largest[i]));
        LargestDisplacement { moved, turned }
    }
}

impl LargestDisplacement {
    /// Upper bound (m) on the displacement of a point at this distance (m) from that origin, which may be infinite.
    pub fn of_radius(&self, radius: f64) -> f64 {
        self.moved + if self.turned > 0.0 { self.turned * radius } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn history(places: &[f64]) -> PoseHistory {
        let mut history = PoseHistory::default();
        for x in places {
            history.note(Pose::translation(*x, 0.0, 0.0));
        }
        history
    }

    fn displacement(places: &[f64]) -> f64 {
        history(places).displacement_about_itself().of_radius(9.0)
    }

    #[test]
    fn the_way_counts_and_not_its_ends() {
        assert_eq!(displacement(&[]), 0.0);
        assert_eq!(displacement(&[1.0]), 0.0);
        assert!((displacement(&[0.0, 0.1, 0.2, 0.3]) - 0.3).abs() < 1e-12);
        // there and back
        assert!((displacement(&[0.0, 2.0, 0.0]) - 3.0).abs() < 1e-12);
        let trembling: Vec<f64> = (0..200).map(|i| f64::from(i % 2) * 0.01).collect();
        assert!((displacement(&trembling) - 0.015).abs() < 1e-12);
        let many: Vec<f64> = (0..1100).map(f64::from).collect();
        assert_eq!(displacement(&many), f64::INFINITY);
    }

    #[test]
    fn a_motion_starts_at_the_last_pose() {
        let mut history = history(&[0.0, 2.0, 0.0]);
        history.note_lost();
        history.start();
        assert_eq!(history.displacement_about_itself(), LargestDisplacement::default());
        history.note(Pose::translation(0.5, 0.0, 0.0));
        assert_eq!(history.displacement_about_itself().of_radius(f64::INFINITY), 0.5);
    }

    #[test]
    fn a_motion_starts_at_the_last_pose_of_many() {
        let many: Vec<f64> = (0..1100).map(f64::from).collect();
        let mut history = history(&many);
        history.start();
        history.note(Pose::translation(1100.0, 0.0, 0.0));
        assert_eq!(history.displacement_about_itself().moved, 1.0);
    }

    /// Something on an arc about the root's origin, which the root's origin itself would not leave.
    #[test]
    fn an_arc_about_the_root_is_a_way() {
        let mut history = PoseHistory::default();
        for yaw in [0.0, 0.4] {
            let turn = clearance_geometry::math::pose_from_xyz_rpy([0.0; 3], [0.0, 0.0, yaw]);
            history.note(turn * Pose::translation(1.5, 0.0, 0.0));
        }
        let LargestDisplacement { moved, turned } = history.displacement_about_itself();
        assert!((moved - 3.0 * 0.2_f64.sin()).abs() < 1e-12 && (turned - 0.4).abs() < 1e-12);
        let about_root = history.displacement_about_root(|pose| *pose);
        assert!(about_root.moved < 1e-12 && about_root.of_radius(1.5) >= moved);
    }
}
