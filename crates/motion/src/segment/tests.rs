//! Tests of motion segments: interpolation, and motions that are too large or not finite.

use clearance_robot::MeshFiles;
use proptest::prelude::*;

use super::*;

const URDF: &str = "<robot name='r'><link name='a'/><link name='b'/><link name='c'/><link name='d'/>
    <joint name='wheel' type='continuous'><parent link='a'/><child link='b'/><axis xyz='0 0 1'/></joint>
    <joint name='base' type='floating'><parent link='b'/><child link='c'/></joint>
    <joint name='arm' type='revolute'><parent link='c'/><child link='d'/><axis xyz='0 0 1'/>
      <limit lower='-4' upper='4' effort='1' velocity='1'/></joint></robot>";

fn numbers() -> impl Strategy<Value = [f64; 18]> {
    proptest::array::uniform18(-4.0..4.0_f64)
}

#[test]
fn motions_that_are_too_large_are_told_from_those_that_are_not_finite() {
    let urdf = "<robot name='r'><link name='a'/><link name='b'/>
        <joint name='wheel' type='continuous'><parent link='a'/><child link='b'/><axis xyz='0 0 1'/></joint></robot>";
    let robot = RobotModel::from_urdf(urdf, &MeshFiles::default()).unwrap();
    let why = |rate: f64| {
        MotionSegment::polynomial(&robot, vec![[0.0, rate, 0.0, 0.0, 0.0, 0.0]]).unwrap_err().to_string()
    };
    for rate in [f64::NAN, f64::INFINITY] {
        assert_eq!(why(rate), "joint 'wheel': its motion is not finite");
    }
    let text = why(1e9);
    assert!(text.starts_with("joint 'wheel': ") && text.contains("as far as 1e9, farther than"), "{text}");
}

proptest! {
    /// The robot's interpolation is the straight motion, bit for bit, and its distance the length of that motion.
    #[test]
    fn interpolation_is_the_straight_motion(numbers in numbers(), t in 0.0..=1.0_f64) {
        let robot = RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap();
        let state = |numbers: &[f64]| {
            let mut positions = numbers.to_vec();
            let turn = Rotation::from_scaled_axis(Vector::new(numbers[4], numbers[5], numbers[6]));
            positions[4..8].copy_from_slice(turn.coords.as_slice());
            robot.configuration(&positions).unwrap()
        };
        let (from, to) = (state(&numbers[..9]), state(&numbers[9..]));
        let segment = MotionSegment::straight(&robot, &from, &to);
        for t in [0.0, t, 1.0] {
            prop_assert_eq!(robot.interpolate(&from, &to, t), segment.at(t));
        }
        let at = robot.interpolate(&from, &to, t);
        let whole = robot.joint_space_distance(&from, &to);
        prop_assert!((robot.joint_space_distance(&from, &at) - t * whole).abs() < 1e-7);
        prop_assert!((robot.joint_space_distance(&at, &to) - (1.0 - t) * whole).abs() < 1e-7);
        let weights = [2.0; 9];
        prop_assert!((robot.weighted_joint_space_distance(&from, &to, &weights) - 2.0 * whole).abs() < 1e-9);
        prop_assert!(robot.joint_space_distance(&from, &from) < 1e-12);
    }
}
