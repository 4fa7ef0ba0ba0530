//! Tests of joint groups: setting, reading and checking their positions, and named states of groups.

use super::*;
use crate::MeshFiles;

const URDF: &str = "<robot name='r'><link name='a'/><link name='b'/><link name='c'/><link name='d'/><link name='e'/>
    <joint name='base' type='floating'><parent link='a'/><child link='b'/></joint>
    <joint name='arm' type='revolute'><parent link='b'/><child link='c'/><axis xyz='0 0 1'/>
      <limit lower='-1' upper='2' effort='1' velocity='1'/></joint>
    <joint name='wheel' type='continuous'><parent link='c'/><child link='d'/><axis xyz='0 0 1'/></joint>
    <joint name='finger' type='prismatic'><parent link='d'/><child link='e'/><axis xyz='0 0 1'/>
      <limit lower='0' upper='1' effort='1' velocity='1'/><mimic joint='arm' multiplier='1000'/></joint></robot>";

const SRDF: &str = "<robot name='r'>
    <virtual_joint name='odom' type='planar' parent_frame='map' child_link='a'/>
    <group name='tip'><chain base_link='c' tip_link='e'/></group>
    <group name='hand'><joint name='finger'/></group>
    <group name='all'><group name='tip'/><joint name='base'/><joint name='arm'/><joint name='odom'/></group>
    <group_state name='ready' group='tip'><joint name='wheel' value='3'/><joint name='finger' value='500'/></group_state>
    <group_state name='home' group='tip'><joint name='wheel' value='1'/></group_state>
    <group_state name='home' group='all'><joint name='wheel' value='2'/></group_state>
    <group_state name='bad' group='tip'><joint name='wheel' value='one'/></group_state>
    <group_state name='torn' group='all'><joint name='arm' value='1'/><joint name='finger' value='2'/></group_state>
    <group_state name='placed' group='all'><joint name='base' value='1 2 3 0 0 0 1'/></group_state>
    <group_state name='away' group='all'><joint name='odom' value='1 0 0'/><joint name='wheel' value='1'/></group_state>
    <group_state name='docked' group='all'><joint name='odom' value='0 0 0'/><joint name='wheel' value='1'/></group_state>
    <group name='all/over'><joint name='wheel'/></group>
    <group_state name='there' group='all/over'><joint name='wheel' value='1'/></group_state>
    <group_state name='over/there' group='all'><joint name='wheel' value='2'/></group_state></robot>";

fn model() -> RobotModel {
    RobotModel::from_text(
        &crate::RobotText { urdf: URDF, srdf: Some(SRDF), ..crate::RobotText::default() },
        &MeshFiles::default(),
    )
    .unwrap()
}

#[test]
fn a_group_moves_its_joints_and_nothing_else() {
    let robot = model();
    let tip = robot.joint_group("tip").unwrap();
    // the mimic joint `finger` stands for its leader `arm`
    assert_eq!(tip.joint_names(), ["arm", "wheel"]);
    // and its limits of 0 to 1 m allow the leader 0 to 1 mrad
    assert_eq!((tip.lower(), tip.upper()[1]), (&[0.0, f64::NEG_INFINITY][..], f64::INFINITY));
    assert!((tip.upper()[0] - 0.001).abs() < 1e-14);
    assert_eq!(robot.joint_group("hand").unwrap().joint_names(), ["arm"]);
    let mut q = robot.default_configuration();
    let before = q.clone();
    tip.set(&mut q, &[0.5, -4.0]).unwrap();
    let expected = robot.configuration_over(&before, [("arm", 0.5), ("wheel", -4.0)]).unwrap();
    assert_eq!(q, expected);
    let mut positions = [0.0; 2];
    tip.get(&q, &mut positions);
    assert_eq!(positions, [0.5, -4.0]);

    let all = robot.joint_group("all").unwrap();
    assert_eq!(all.len(), robot.position_names().len());
    let mut positions: Vec<f64> = vec![1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0005, 0.0, 0.0];
    all.set(&mut q, &positions).unwrap();
    assert_eq!(q, robot.configuration(&positions).unwrap());
    all.get(&q, &mut positions);
    assert_eq!(positions, q.positions());
}

#[test]
fn what_is_no_position_of_a_group_is_rejected_and_changes_nothing() {
    let robot = model();
    let [tip, all] = ["tip", "all"].map(|name| robot.joint_group(name).unwrap());
    let mut q = robot.default_configuration();
    for (positions, message) in [
        (&[0.0][..], "1 positions given, but the robot has 2: arm, wheel"),
        (&[0.0, f64::NAN], "joint 'wheel' has position NaN"),
        (&[1e8, 0.0], "joint 'arm' has position 1e8"),
    ] {
        let error = tip.set(&mut q, positions).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
    let error = all.set(&mut q, &[0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0]).unwrap_err().to_string();
    assert!(error.contains("'base'") && error.contains("length 0.5"), "{error}");
    assert_eq!(q, robot.default_configuration());
    let error = robot.joint_group("leg").unwrap_err().to_string();
    assert!(
        error.contains("no group 'leg'") && error.contains("'tip', 'hand', 'all' and 'all/over'"),
        "{error}"
    );
    let bare = RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap();
    assert!(bare.joint_group("tip").is_err() && bare.group_state("ready").is_err());
}

#[test]
fn group_states_are_configurations() {
    let robot = model();
    let ready = robot.group_state("ready").unwrap();
    assert_eq!(ready, robot.configuration_from_names([("wheel", 3.0), ("arm", 0.5)]).unwrap());
    assert_eq!(robot.group_state("tip/ready").unwrap(), ready);
    let over = robot.group_state_over(&ready, "all/home").unwrap();
    assert_eq!(over, robot.configuration_from_names([("wheel", 2.0), ("arm", 0.5)]).unwrap());
    assert_eq!(robot.group_state("placed").unwrap().positions()[..3], [1.0, 2.0, 3.0]);
    let docked = robot.configuration_from_names([("wheel", 1.0)]).unwrap();
    assert_eq!(robot.group_state("docked").unwrap(), docked);
    for (name, message) in [
        ("home", "several group states 'home': give one of 'tip/home' and 'all/home'"),
        ("all/over/there", "several group states 'all/over/there': rename all but one"),
        ("rest", "no group state 'rest'; its SRDF has 'tip/ready', 'tip/home'"),
        ("bad", "group state 'bad' of the SRDF: joint 'wheel': value"),
        ("away", "group state 'away' of the SRDF: virtual joint 'odom' is not at zero"),
        ("torn", "group state 'torn' of the SRDF: joint 'finger' is given position 2"),
    ] {
        let error = robot.group_state(name).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
}
