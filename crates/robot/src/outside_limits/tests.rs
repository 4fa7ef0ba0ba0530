//! Tests of the detection of joints beyond their limits, and of the note about them.

use crate::{MeshFiles, RobotModel};

const ROBOT: &str = r#"<robot name="r"><link name="base"/><link name="a"/><link name="b"/><link name="c"/>
<joint name="turn" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/>
  <limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
<joint name="slide" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
  <limit lower="0" upper="0.5" effort="1" velocity="1"/></joint>
<joint name="wheel" type="continuous"><parent link="b"/><child link="c"/><axis xyz="0 0 1"/></joint></robot>"#;

fn robot() -> RobotModel {
    RobotModel::from_urdf(ROBOT, &MeshFiles::default()).unwrap()
}

#[test]
fn joints_beyond_their_limits_are_reported() {
    let of = |positions: [f64; 3]| -> Vec<String> {
        robot().outside_limits(&positions).map(|joint| joint.to_string()).collect()
    };
    assert!(of([2.0005, -0.0005, 90.0]).is_empty(), "noise, and a wheel");
    assert_eq!(
        of([-3.0, 0.0, 0.0]),
        ["joint 'turn' is at -3, outside its limits [-2, 2] rad: is that degrees?"]
    );
    assert_eq!(of([300.0, 0.0, 0.0]), ["joint 'turn' is at 300, outside its limits [-2, 2]"]);
    assert_eq!(of([0.0, 20.0, 0.0]), ["joint 'slide' is at 20, outside its limits [0, 0.5]"]);
}

#[test]
fn of_many_the_first_is_reported_and_how_many_there_are() {
    let robot = robot();
    let q = |turn: f64| robot.configuration(&[turn, 0.0, 0.0]).unwrap();
    let states = [q(0.0), q(2.1), q(1.0), q(-300.0)];
    let note = robot.limits_note("state", states.iter().map(|q| [q])).unwrap();
    assert!(note.starts_with("state 1: joint 'turn' is at 2.1, outside"), "{note}");
    assert!(note.ends_with(", and 1 more state is outside (checked all the same)"), "{note}");
    assert_eq!(robot.limits_note("state", [[&states[0]]]), None);
    let way = robot.limits_note("way", [[&states[0], &states[3]]]).unwrap();
    assert_eq!(way, "joint 'turn' is at -300, outside its limits [-2, 2] (checked all the same)");
}
