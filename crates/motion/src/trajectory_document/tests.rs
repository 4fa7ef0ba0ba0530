//! Tests of reading trajectory files: every ROS message type, start states, and rejected texts.

use clearance_robot::{MeshFiles, RobotModel, RobotText};

use crate::{ContinuousDirection, Trajectory};

fn robot() -> RobotModel {
    let text = "<robot name='r'><link name='a'/><link name='b'/><link name='c'/>
        <joint name='j' type='continuous'><parent link='a'/><child link='b'/></joint>
        <joint name='k' type='continuous'><parent link='b'/><child link='c'/></joint></robot>";
    RobotModel::from_urdf(text, &MeshFiles::default()).unwrap()
}

fn read(text: &str) -> Result<Trajectory, String> {
    let robot = robot();
    Trajectory::from_yaml(&robot, text, &robot.default_configuration()).map_err(|e| e.to_string())
}

/// From 0 to 1 in two seconds, as `ros2 topic echo` writes it, with this time.
fn points(time: &str) -> String {
    format!(
        "header:\n  stamp: {{sec: 0, nanosec: 0}}\n  frame_id: ''\njoint_names:\n- j\npoints:\n- positions: [0.0]\n  velocities: []\n  \
         accelerations: []\n  effort: []\n  time_from_start: {{sec: 0, nanosec: 0}}\n- positions: [1.0]\n  time_from_start: {time}\n"
    )
}

fn indented(text: &str, first: &str) -> String {
    let rest = " ".repeat(first.len());
    let lines = text.lines().enumerate();
    lines
        .map(|(i, line)| format!("{}{line}\n", if i == 0 { first } else { &rest }))
        .collect::<Vec<_>>()
        .concat()
}

const EMPTY: &str =
    "multi_dof_joint_trajectory:\n  header: {frame_id: ''}\n  joint_names: []\n  points: []\n";

#[test]
fn one_trajectory_in_every_message() {
    let expected = read(&points("{sec: 2, nanosec: 500000000}")).unwrap();
    assert_eq!(expected.time(0, 1.0), Some(2.5));
    let of_robot = format!("joint_trajectory:\n{}{EMPTY}", indented(&points("2.5"), "  "));
    let display = format!(
        "model_id: r\ntrajectory:\n{}trajectory_start: {{joint_state: {{}}}}\n",
        indented(&of_robot, "- ")
    );
    for text in [
        points("{sec: 2, nanosec: 500000000}") + "---\n",
        points("{secs: 2, nsecs: 500000000}"),
        points("2.5"),
        of_robot.clone() + "---\n",
        of_robot.replace(EMPTY, ""),
        display,
    ] {
        assert_eq!(read(&text).as_ref(), Ok(&expected), "{text}");
    }
    assert_eq!(read(&points("2")).unwrap().time(0, 1.0), Some(2.0));
}

#[test]
fn parts_of_a_time_that_are_left_out_are_zero() {
    for (time, seconds) in [
        ("{nanosec: 500000000}", 0.5),
        ("{nsecs: 500000000}", 0.5),
        ("{sec: 5}", 5.0),
        ("{secs: 5}", 5.0),
        ("{sec: 1, nanosec: 0}", 1.0),
    ] {
        assert_eq!(read(&points(time)).unwrap().time(0, 1.0), Some(seconds), "{time}");
    }
    assert!(read(&points("{sec: 1, nsecs: 0}")).is_err());
}

#[test]
fn goals_of_actions_are_trajectories() {
    let expected = read(&points("2.5")).unwrap();
    let plain = indented(&points("2.5"), "  ");
    let of_robot = indented(&format!("joint_trajectory:\n{}{EMPTY}", indented(&points("2.5"), "  ")), "  ");
    let follow = format!(
        "trajectory:\n{plain}multi_dof_trajectory: {{joint_names: [], points: []}}\npath_tolerance: []\ncomponent_path_tolerance: []\n\
         goal_tolerance: [{{name: j, position: 0.1}}]\ngoal_time_tolerance: {{sec: 1, nanosec: 0}}\n"
    );
    let of_ros1 = format!("header: {{}}\ngoal_id: {{id: x}}\ngoal:\n{}", indented(&follow, "  "));
    let execute = format!("trajectory:\n{of_robot}controller_names: []\n");
    for text in [follow.clone(), of_ros1.clone(), execute] {
        assert_eq!(read(&text).as_ref(), Ok(&expected), "{text}");
    }
    for (text, words) in [
        (follow.replace("trajectory: {joint_names: []", "trajectory: {joint_names: [base]"), "'base'"),
        (follow.replace("- j", "- x"), "'x'"),
        (of_ros1 + "joint_names: [j]\n", "goal excludes"),
        ("trajectory: {joint_names: [j]}\n".to_owned(), "trajectory: points is missing"),
        ("trajectory: {}\n".to_owned(), "no joint_names"),
        ("trajectory: 3\n".to_owned(), "a trajectory or a list of trajectories"),
        ("goal: {goal: {}}\n".to_owned(), "another goal"),
    ] {
        let message = read(&text).unwrap_err();
        assert!(message.contains(words) && !message.contains('\n'), "{text}: {message}");
    }
    let robot = robot();
    let loose = follow.replace("\npath_tolerance: []", "\npath_tolerance: [{name: j, position: 0.5}]");
    let read = Trajectory::from_yaml_with_direction(
        &robot,
        &loose,
        &robot.default_configuration(),
        ContinuousDirection::AsGiven,
    );
    assert!(read.unwrap().1[0].contains("path_tolerance is not read"));
}

#[test]
fn the_start_gives_joints_that_the_trajectory_does_not_name() {
    let of_robot = format!("joint_trajectory:\n{}", indented(&points("2.5"), "  "));
    let text = format!(
        "trajectory:\n{}trajectory_start:\n  joint_state: {{name: [k, j], position: [0.75, 0.0]}}\n",
        indented(&of_robot, "- ")
    );
    let trajectory = read(&text).unwrap();
    assert_eq!(trajectory.segments()[0].at(1.0).positions(), [1.0, 0.75]);
}

/// A `DisplayTrajectory` of [`points`] from 0, with this start.
fn displayed(start: &str) -> String {
    let of_robot = format!("joint_trajectory:\n{}", indented(&points("2.5"), "  "));
    format!("trajectory:\n{}trajectory_start: {{joint_state: {start}}}\n", indented(&of_robot, "- "))
}

#[test]
fn a_start_that_is_not_the_first_point_is_rejected() {
    for (start, words) in [
        ("{name: [j], position: [4.0]}", &["trajectory_start", "'j' at 4", "first point has it at 0"][..]),
        ("{name: [k, j], position: [0.5, 0.00001]}", &["'j' at 0.00001"]),
        // a whole turn is a motion where joints go as given
        ("{name: [j], position: [6.283185307179586]}", &["'j' at 6.28"]),
    ] {
        let message = read(&displayed(start)).unwrap_err();
        for word in words {
            assert!(message.contains(word), "{start}: {message}");
        }
    }
    for start in [
        "{name: [j], position: [0.0]}",
        "{name: [j], position: [0.0000000001]}",
        "{name: [k], position: [3.0]}",
        "{}",
    ] {
        assert!(read(&displayed(start)).is_ok(), "{start}");
    }
    let robot = robot();
    let turned = displayed("{name: [j], position: [6.283185307179586]}");
    let rest = robot.default_configuration();
    assert!(
        Trajectory::from_yaml_with_direction(&robot, &turned, &rest, ContinuousDirection::Shortest).is_ok()
    );
    // a mimic joint at half the angle is elsewhere after a whole turn of its leader
    let urdf = "<robot name='r'><link name='a'/><link name='b'/><link name='c'/><link name='d'/>
        <joint name='j' type='continuous'><parent link='a'/><child link='b'/></joint>
        <joint name='k' type='continuous'><parent link='b'/><child link='c'/></joint>
        <joint name='m' type='continuous'><parent link='a'/><child link='d'/><mimic joint='j' multiplier='0.5'/></joint></robot>";
    let geared = RobotModel::from_urdf(urdf, &MeshFiles::default()).unwrap();
    let rest = geared.default_configuration();
    let error = Trajectory::from_yaml_with_direction(&geared, &turned, &rest, ContinuousDirection::Shortest)
        .unwrap_err();
    assert!(error.to_string().contains("'j' at 6.28"), "{error}");
    let plain = points("1.0") + "trajectory_start: {joint_state: {name: [j], position: [0.5]}}\n";
    assert!(read(&plain).unwrap_err().contains("'j' at 0.5"));
}

#[test]
fn starts_of_floating_joints_are_compared_as_rotations() {
    let robot = RobotModel::from_urdf(
        "<robot name='r'><link name='a'/><link name='b'/><joint name='f' type='floating'><parent link='a'/><child link='b'/></joint></robot>",
        &MeshFiles::default(),
    )
    .unwrap();
    let text = |rotation: &str| {
        let names: Vec<String> = ["trans_x", "trans_y", "trans_z", "rot_x", "rot_y", "rot_z", "rot_w"]
            .map(|n| format!("f/{n}"))
            .into();
        let names = names.join(", ");
        format!(
            "joint_names: [{names}]\npoints: [{{positions: [0, 0, 0, 0, 0, 0, 1]}}, {{positions: [1, 0, 0, 0, 0, 0, 1], time_from_start: 1}}]\n\
             trajectory_start: {{multi_dof_joint_state: {{joint_names: [f], transforms: [{{rotation: {rotation}}}]}}}}\n"
        )
    };
    let read =
        |rotation: &str| Trajectory::from_yaml(&robot, &text(rotation), &robot.default_configuration());
    assert!(read("{x: 0, y: 0, z: 0, w: -1}").is_ok());
    assert!(read("{x: 0.6, y: 0, z: 0, w: 0.8}").unwrap_err().to_string().contains("'f/rot_x' at 0.6"));
}

#[test]
fn a_first_point_that_comes_later_is_remarked() {
    let robot = robot();
    let remarks = |text: &str| {
        let read = Trajectory::from_yaml_with_direction(
            &robot,
            text,
            &robot.default_configuration(),
            ContinuousDirection::AsGiven,
        );
        read.unwrap_or_else(|e| panic!("{e}")).1
    };
    let late = points("2.5").replacen(
        "time_from_start: {sec: 0, nanosec: 0}",
        "time_from_start: {sec: 1, nanosec: 500000000}",
        1,
    );
    let told = remarks(&late);
    assert!(told.len() == 1 && told[0].contains("first point is at 1.5 s"), "{told:?}");
    assert_eq!(remarks(&points("2.5")), [""; 0]);
    let with_start = late + "trajectory_start: {joint_state: {name: [j], position: [0.0]}}\n";
    assert_eq!(remarks(&with_start), [""; 0]);
}

#[test]
fn a_trajectory_of_another_robot_is_read_with_a_remark() {
    let robot = robot();
    let remarks = |model: &str| {
        let text = displayed("{}") + &format!("model_id: {model}\n");
        let rest = robot.default_configuration();
        let read = Trajectory::from_yaml_with_direction(&robot, &text, &rest, ContinuousDirection::AsGiven);
        read.unwrap_or_else(|e| panic!("{e}")).1
    };
    assert_eq!(remarks("r"), [""; 0]);
    assert_eq!(remarks("''"), [""; 0]);
    assert_eq!(remarks("panda"), ["model_id: the trajectory is of 'panda', the robot is 'r'"]);
}

#[test]
fn a_start_of_joints_that_the_robot_does_not_have_is_rejected() {
    let robot = robot();
    let start = "{}, multi_dof_joint_state: {joint_names: [odom], transforms: [{translation: {x: 1.0}}]}";
    let read = Trajectory::from_yaml(&robot, &displayed(start), &robot.default_configuration());
    let words = read.unwrap_err().to_string();
    assert!(words.contains("trajectory_start: multi_dof_joint_state") && words.contains("'odom'"), "{words}");
}

#[test]
fn what_is_no_single_joint_trajectory_is_rejected_in_one_line() {
    let of_robot = format!("joint_trajectory:\n{}", indented(&points("2.5"), "  "));
    let one = indented(&of_robot, "- ");
    for (text, words) in [
        (points("1") + "---\n" + &points("1"), &["2 documents", "line 14"][..]),
        (String::new(), &["empty"]),
        ("---\n".to_owned(), &["empty"]),
        (
            format!("{of_robot}multi_dof_joint_trajectory: {{joint_names: [base], points: [{{}}]}}\n"),
            &["'base'", "multi_dof"],
        ),
        (EMPTY.to_owned(), &["joint_trajectory is missing"]),
        (format!("trajectory:\n{one}{one}"), &["2 trajectories"]),
        ("trajectory: []\n".to_owned(), &["trajectory is empty"]),
        ("joint_names: [j]\n".to_owned(), &["points is missing"]),
        ("model_id: r\n".to_owned(), &["no joint_names and points"]),
        (format!("{}{of_robot}", points("1")), &["exclude"]),
        (points("{sec: 1, nsecs: 0}"), &["seconds", "nsecs"]),
        (points("soon"), &["seconds"]),
        (points("-1.0"), &["point 1: time_from_start -1 s is negative"]),
        (
            points("0.0").replacen(
                "time_from_start: {sec: 0, nanosec: 0}",
                "time_from_start: {sec: -1, nanosec: 0}",
                1,
            ),
            &["point 0: time_from_start -1 s is negative"],
        ),
        (points(".nan"), &["point 1", "time_from_start NaN"]),
        (
            format!("trajectory:\n{one}trajectory_start: {{joint_state: {{name: [x], position: [0]}}}}\n"),
            &["trajectory_start", "'x'"],
        ),
        (
            format!(
                "trajectory:\n{one}trajectory_start: {{attached_collision_objects: [{{object: {{id: tool}}}}]}}\n"
            ),
            &["trajectory_start", "'tool'"],
        ),
        ("points: [1\n".to_owned(), &["line"]),
        // every part that stands where it does not count
        (
            format!("{}multi_dof_trajectory: {{joint_names: [base], points: [{{}}]}}\n", points("1")),
            &["multi_dof"],
        ),
        (
            format!("{of_robot}multi_dof_trajectory: {{joint_names: [base], points: [{{}}]}}\n"),
            &["multi_dof"],
        ),
        (
            format!("trajectory:\n{one}multi_dof_trajectory: {{joint_names: [base], points: [{{}}]}}\n"),
            &["multi_dof_trajectory", "exclude"],
        ),
        (
            format!(
                "goal:\n  trajectory:\n{}trajectory_start: {{joint_state: {{name: [j], position: [9]}}}}\n",
                indented(&points("1"), "    ")
            ),
            &["goal excludes", "trajectory_start"],
        ),
    ] {
        let message = read(&text).unwrap_err();
        for word in words {
            assert!(message.contains(word), "{text}\n{message}");
        }
        assert!(!message.contains('\n'), "{message}");
    }
}

#[test]
fn a_motion_of_a_virtual_joint_is_rejected_by_name() {
    let urdf = "<robot name='r'><link name='a'/><link name='b'/>
        <joint name='j' type='continuous'><parent link='a'/><child link='b'/></joint></robot>";
    let srdf = "<robot name='r'><virtual_joint name='odom' type='planar' parent_frame='map' child_link='a'/></robot>";
    let text = RobotText { urdf, srdf: Some(srdf), ..RobotText::default() };
    let robot = RobotModel::from_text(&text, &MeshFiles::default()).unwrap();
    let moved = |joint: &str| {
        let of_robot = format!("joint_trajectory:\n{}", indented(&points("2.5"), "  "));
        let text =
            format!("{of_robot}multi_dof_joint_trajectory: {{joint_names: [{joint}], points: [{{}}]}}\n");
        let read = Trajectory::from_yaml(&robot, &text, &robot.default_configuration());
        read.unwrap_err().to_string()
    };
    let message = moved("odom");
    assert!(message.contains("virtual joint 'odom' can not be moved here") && !message.contains("JOINT/x"));
    assert!(moved("drive").contains("JOINT/x"));
}

#[test]
fn numbers_that_are_not_finite_are_errors_only_where_they_are_used() {
    let text = |first: &str, second: &str| {
        format!(
            "joint_names: [j]\npoints:\n- {{positions: [0.0]{first}}}\n- {{positions: [1.0]{second}, time_from_start: 2.5}}\n"
        )
    };
    let straight = read(&text("", "")).unwrap();
    for (first, second) in [
        (", effort: [.nan]", ", effort: [.inf, -.inf]"),
        (", velocities: [.nan]", ""),
        ("", ", velocities: [.nan], accelerations: [.nan]"),
        (", accelerations: [.nan]", ", accelerations: [.nan]"),
    ] {
        assert_eq!(read(&text(first, second)).as_ref(), Ok(&straight), "{first} {second}");
    }
    let bent = read(&text(", velocities: [1]", ", velocities: [0]")).unwrap();
    let unused = text(", velocities: [1], accelerations: [.nan]", ", velocities: [0]");
    assert_eq!(read(&unused).as_ref(), Ok(&bent));
    for (first, second, words) in [
        (", velocities: [.nan]", ", velocities: [0]", "point 0: its velocities of joint 'j'"),
        (", velocities: [0]", ", velocities: [.inf]", "point 1: its velocities of joint 'j'"),
        (
            ", velocities: [0], accelerations: [0]",
            ", velocities: [0], accelerations: [.nan]",
            "point 1: its accelerations of joint 'j'",
        ),
        (", velocities: [.nan, .nan]", "", "point 0: 2 velocities for 1 joints"),
    ] {
        let message = read(&text(first, second)).unwrap_err();
        assert!(message.contains(words), "{message}");
    }
    let message = read(&text("", "").replace("[1.0]", "[.nan]")).unwrap_err();
    assert!(message.contains("point 1: its positions of joint 'j' is not finite"), "{message}");
}

/// A start is no proof about where the robot does not start.
#[test]
fn transforms_of_the_start_are_read_or_rejected_by_name() {
    let text = "<robot name='r'><link name='a'/><link name='b'/><link name='c'/>
        <joint name='drive' type='planar'><parent link='a'/><child link='b'/><axis xyz='0 0 1'/></joint>
        <joint name='j' type='continuous'><parent link='b'/><child link='c'/></joint></robot>";
    let robot = RobotModel::from_urdf(text, &MeshFiles::default()).unwrap();
    let of_robot = indented(&format!("joint_trajectory:\n{}", indented(&points("2.5"), "  ")), "- ");
    let read = |frame: &str, joint: &str, z: f64| {
        let text = format!(
            "trajectory:\n{of_robot}trajectory_start:\n  multi_dof_joint_state: {{header: {{frame_id: {frame}}}, joint_names: [{joint}], \
             transforms: [{{translation: {{x: 5, z: {z:?}}}}}]}}\n"
        );
        Trajectory::from_yaml(&robot, &text, &robot.default_configuration()).map_err(|e| e.to_string())
    };
    let start = read("a", "drive", 0.0).unwrap();
    assert_eq!(start.segments()[0].at(0.0).positions(), [5.0, 0.0, 0.0, 0.0]);
    for (frame, joint, z, words) in [
        ("a", "Drive", 0.0, ["'Drive'", "planar or floating are drive"]),
        ("world", "world_joint", 0.0, ["'world_joint'", "no joint"]),
        ("a", "j", 0.0, ["'j'", "neither planar nor floating"]),
        ("map", "drive", 0.0, ["'map'", "must be 'a'"]),
        ("a", "drive", 5e-4, ["'drive'", "leaves its plane"]),
    ] {
        let why = read(frame, joint, z).unwrap_err();
        assert!(why.contains("trajectory_start") && words.iter().all(|word| why.contains(word)), "{why}");
    }
}
