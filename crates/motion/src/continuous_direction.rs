//! Direction of rotation of continuous and planar joints: as given, or shortest by subtracting full turns.
//!
//! Positions that differ by full turns are the same pose, but different paths. `joint_trajectory_controller` moves from its current state
//! to the first point in the shortest direction: it subtracts full turns from the current position (`wraparound_joint`), and so does
//! [`shortest_turns`].

use std::f64::consts::{PI, TAU};

use clearance_robot::{Configuration, ConfigurationError, JointId, RobotModel};

/// Deviation (rad) from half a turn within which both directions count as equally short: the joint then follows its given positions.
const HALF_TURN_TOLERANCE: f64 = 1e-9;

/// Direction of a continuous joint from one position to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ContinuousDirection {
    /// Through all positions between the two, for any number of turns.
    #[default]
    AsGiven,
    /// By half a turn at most: full turns are subtracted from the start.
    Shortest,
}

/// A continuous joint that cannot take the shortest direction.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "continuous joint '{joint}' can not go the shortest way from {from} to {to}: '{follower}' mimics it, and would be elsewhere after whole turns"
)]
pub struct HeldTurn {
    /// Name of the joint.
    pub joint: String,
    /// Name of the mimic joint whose pose would differ after full turns.
    pub follower: String,
    /// Position (rad) at the start.
    pub from: f64,
    /// Position (rad) at the end.
    pub to: f64,
}

/// Equivalent configurations such that continuous joints move from each to the next by half a turn at most; the last one is unchanged.
/// Joints that cannot, because another one mimics them, keep their given positions; these joints are returned, too.
///
/// # Errors
/// If a joint position becomes too large for the computation.
pub fn shortest_turns(
    robot: &RobotModel,
    points: Vec<Configuration>,
) -> Result<(Vec<Configuration>, Vec<HeldTurn>), ConfigurationError> {
    let joints: Vec<(JointId, usize)> = continuous(robot).collect();
    let mut held: Vec<HeldTurn> = Vec::new();
    let mut points = points;
    for i in (1..points.len()).rev() {
        let mut positions = points[i - 1].positions().to_vec();
        for &(id, index) in &joints {
            let (from, to) = (positions[index], points[i].positions()[index]);
            let turns = whole_turns(to - from);
            match robot.moved_by_whole_turns(id) {
                _ if turns == 0.0 => {}
                None => positions[index] = from + TAU * turns,
                Some(follower) => {
                    let (joint, follower) = (robot.joint(id).name.clone(), follower.name.clone());
                    held.push(HeldTurn { joint, follower, from, to });
                }
            }
        }
        robot.configuration(&positions)?;
        // quaternions would be normalised again, which rounds them again: a floating joint at rest would move
        points[i - 1] = Configuration::trusted(positions);
    }
    held.reverse();
    Ok((points, held))
}

/// Continuous joints with a position of their own, and planar joints, with the index of their angle.
fn continuous(robot: &RobotModel) -> impl Iterator<Item = (JointId, usize)> {
    let angle = |id| Some((id, robot.first_position(id)? + robot.joint(id).kind.unlimited_angle()?));
    robot.joint_ids().filter_map(angle)
}

/// Number of full turns to subtract from an angle for the shortest direction.
fn whole_turns(angle: f64) -> f64 {
    let turns = (angle / TAU).round();
    let is_half = ((angle - TAU * turns).abs() - PI).abs() <= HALF_TURN_TOLERANCE;
    if is_half { ((angle - PI.copysign(angle)) / TAU).round() } else { turns }
}

#[cfg(test)]
pub(super) mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::{MotionSegment, Trajectory};
    use clearance_robot::MeshFiles;

    /// A continuous joint, a revolute one, and a joint of kind `kind` that mimics the first.
    pub(crate) fn robot(kind: &str, multiplier: f64) -> RobotModel {
        let joint = |name: &str, kind: &str, more: &str| {
            format!(
                "<link name='of_{name}'/><joint name='{name}' type='{kind}'><parent link='base'/><child link='of_{name}'/>\
                 <axis xyz='0 0 1'/><limit lower='-9' upper='9' effort='1' velocity='1'/>{more}</joint>"
            )
        };
        let mimic = format!("<mimic joint='wheel' multiplier='{multiplier}'/>");
        let joints =
            [joint("wheel", "continuous", ""), joint("arm", "revolute", ""), joint("k", kind, &mimic)];
        let urdf = format!("<robot name='r'><link name='base'/>{}</robot>", joints.concat());
        RobotModel::from_urdf(&urdf, &MeshFiles::default()).unwrap()
    }

    fn shortest(robot: &RobotModel, points: &[[f64; 2]]) -> (Vec<f64>, Vec<HeldTurn>) {
        let points = points.iter().map(|q| robot.configuration(q).unwrap()).collect();
        let (points, held) = shortest_turns(robot, points).unwrap();
        (points.iter().map(|q| q.positions()[0]).collect(), held)
    }

    #[test]
    fn whole_turns_are_taken_off_the_start() {
        let robot = robot("fixed", 0.0);
        let (wheel, held) = shortest(&robot, &[[3.0, 3.0], [-3.0, -3.0]]);
        assert!((wheel[0] - (3.0 - TAU)).abs() < 1e-12 && wheel[1] == -3.0 && held.is_empty(), "{wheel:?}");
        let (wheel, _) = shortest(&robot, &[[0.5, 0.0], [100.0 * TAU + 0.4, 0.0]]);
        assert!((wheel[0] - 100.0 * TAU - 0.5).abs() < 1e-9);
        // the arm is not continuous, and points in between are adjusted to the points after them
        let points =
            [[3.0, 3.0], [-3.0, -3.0], [3.0, 3.0]].map(|q| robot.configuration(&q).unwrap()).to_vec();
        let (points, _) = shortest_turns(&robot, points).unwrap();
        assert!(
            [3.0, -3.0 + TAU, 3.0].iter().zip(&points).all(|(q, p)| (q - p.positions()[0]).abs() < 1e-12)
        );
        assert_eq!([0, 1, 2].map(|i| points[i].positions()[1]), [3.0, -3.0, 3.0]);
    }

    #[test]
    fn a_planar_joint_turns_the_short_way_too() {
        let urdf = "<robot name='r'><link name='world'/><link name='base'/><joint name='drive' type='planar'>
            <parent link='world'/><child link='base'/><axis xyz='0 0 1'/></joint></robot>";
        let robot = RobotModel::from_urdf(urdf, &MeshFiles::default()).unwrap();
        let points = [[9.0, -9.0, 2.8], [-9.0, 9.0, -2.8]].map(|q| robot.configuration(&q).unwrap());
        let (points, held) = shortest_turns(&robot, points.to_vec()).unwrap();
        assert!((points[0].positions()[2] - (2.8 - TAU)).abs() < 1e-12 && held.is_empty());
        assert_eq!(
            (&points[0].positions()[..2], points[1].positions()),
            (&[9.0, -9.0][..], &[-9.0, 9.0, -2.8][..])
        );
        let given = [[0.0, 0.0, 2.8], [0.0, 0.0, -2.8]].map(|q| robot.configuration(&q).unwrap());
        let given =
            Trajectory::of_segments(vec![MotionSegment::straight(&robot, &given[0], &given[1])]).unwrap();
        assert!(
            given.long_turn_note(&robot).unwrap().contains("'drive/theta' turns by more than half a turn")
        );
        assert_eq!(given.continuous_turns(&robot)[0].joint, "drive/theta");
    }

    #[test]
    fn positions_of_other_joints_stay_bit_for_bit() {
        let urdf = "<robot name='r'><link name='world'/><link name='body'/><link name='tip'/>
            <joint name='fly' type='floating'><parent link='world'/><child link='body'/></joint>
            <joint name='wheel' type='continuous'><parent link='body'/><child link='tip'/><axis xyz='0 0 1'/></joint>
            </robot>";
        let robot = RobotModel::from_urdf(urdf, &MeshFiles::default()).unwrap();
        for i in 0..200_u32 {
            let [x, y, z, w] = [0.3, -0.5, 0.7, 0.1].map(|c| c + 0.001 * f64::from(i));
            let length = (x * x + y * y + z * z + w * w).sqrt();
            let at = |wheel: f64| {
                let [x, y, z, w] = [x, y, z, w].map(|c| c / length);
                robot.configuration(&[0.1, 0.2, 0.3, x, y, z, w, wheel]).unwrap()
            };
            let given = vec![at(3.0), at(-3.0), at(3.0)];
            let (points, _) = shortest_turns(&robot, given.clone()).unwrap();
            for (point, given) in points.iter().zip(&given) {
                assert_eq!(point.positions()[..7], given.positions()[..7]);
            }
            assert!((points[1].positions()[7] - (TAU - 3.0)).abs() < 1e-12);
        }
    }

    #[test]
    fn exactly_half_a_turn_goes_as_given() {
        let robot = robot("fixed", 0.0);
        for turn_given in [PI, -PI, PI + 1e-10, -PI - 1e-10, PI - 1e-10] {
            assert_eq!(shortest(&robot, &[[0.25, 0.0], [0.25 + turn_given, 0.0]]).0[0], 0.25, "{turn_given}");
        }
        let (wheel, _) = shortest(&robot, &[[0.0, 0.0], [3.0 * PI, 0.0]]);
        assert!((wheel[0] - TAU).abs() < 1e-12, "{wheel:?}");
        let (wheel, _) = shortest(&robot, &[[0.0, 0.0], [-PI - 1e-6, 0.0]]);
        assert!((wheel[0] + TAU).abs() < 1e-12, "{wheel:?}");
    }

    #[test]
    fn joints_whose_mimic_joints_do_not_come_back_go_as_given() {
        for (kind, multiplier, is_held) in [
            ("continuous", 0.5, true),
            ("revolute", 1.0, true),
            ("prismatic", 0.1, true),
            ("continuous", -2.0, false),
            ("prismatic", 0.0, false),
        ] {
            let robot = robot(kind, multiplier);
            let (wheel, held) = shortest(&robot, &[[3.0, 0.0], [-3.0, 0.0]]);
            assert_eq!((wheel[0] == 3.0, held.len()), (is_held, usize::from(is_held)), "{kind} {multiplier}");
            if let Some(held) = held.first() {
                assert!(held.to_string().contains("'wheel'") && held.to_string().contains("'k'"));
            }
            assert!(shortest(&robot, &[[3.0, 0.0], [2.0, 0.0]]).1.is_empty());
        }
    }

    proptest! {
        /// Each motion is by half a turn at most, between the same poses, and the goal is unchanged.
        #[test]
        fn the_shortest_turns_are_short_and_between_the_same_poses(from in -60.0..60.0_f64, to in -60.0..60.0_f64) {
            let robot = robot("continuous", 3.0);
            let (wheel, held) = shortest(&robot, &[[from, 0.0], [to, 0.0]]);
            prop_assert!(held.is_empty() && wheel[1] == to);
            prop_assert!((wheel[1] - wheel[0]).abs() <= PI + 1e-9);
            let turns = (wheel[0] - from) / TAU;
            prop_assert!((turns - turns.round()).abs() < 1e-12);
        }
    }
}
