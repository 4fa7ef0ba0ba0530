//! Tests of transforms of planar joints in state files and in `trajectory_start`: read, or rejected by name.

use std::process::Output;

use crate::program::Folder;

/// A cart that drives on the floor.
const ROBOT: &str = "<robot name='r'><link name='floor'/><link name='cart'><collision><geometry><box size='0.2 0.2 0.2'/></geometry>\
</collision></link><joint name='drive' type='planar'><parent link='floor'/><child link='cart'/><axis xyz='0 0 1'/></joint></robot>";

/// A block at x = 5 m.
const WORLD: &str = "world:\n  collision_objects:\n  - {id: block, pose: {position: [5, 0, 0]}, primitives: [{type: box, dimensions: [1, 1, 1]}]}\n";

/// A state as a file of states, and as the start of a trajectory.
fn run_both(folder: &Folder, state: &str) -> [Output; 2] {
    folder.write("s.yaml", state);
    folder.write(
        "t.yaml",
        &format!(
            "trajectory_start: {state}\ntrajectory: [{{joint_trajectory: {{joint_names: [drive/y], points: [{{positions: [0.0]}}, \
             {{positions: [0.1]}}]}}}}]\n"
        ),
    );
    let run =
        |arguments: &[&str]| folder.run(&[arguments, &["--urdf", "r.urdf", "--world", "w.yaml"]].concat());
    [run(&["check", "--states", "s.yaml"]), run(&["motion", "--trajectory", "t.yaml"])]
}

fn state(frame: &str, joint: &str, translation: &str) -> String {
    format!(
        "{{multi_dof_joint_state: {{header: {{frame_id: {frame}}}, joint_names: [{joint}], transforms: [{{translation: {translation}}}]}}}}"
    )
}

#[test]
fn a_robot_is_where_its_transform_says() {
    let folder = Folder::of(ROBOT, WORLD);
    for (translation, code) in [("{x: 5}", 1), ("{x: 2}", 0), ("{x: 5, z: 1.0e-9}", 1), ("{}", 0)] {
        for frame in ["floor", "''", "/floor"] {
            for output in run_both(&folder, &state(frame, "drive", translation)) {
                assert_eq!(output.status.code(), Some(code), "{frame} {translation}: {output:?}");
            }
        }
    }
}

#[test]
fn transforms_that_are_not_read_are_bad_input() {
    let folder = Folder::of(ROBOT, WORLD);
    for (frame, joint, translation, words) in [
        ("floor", "Drive", "{x: 5}", ["'Drive'", "planar or floating are drive"]),
        ("floor", "world_joint", "{x: 5}", ["'world_joint'", "the robot has no joint"]),
        ("floor", "drive/x", "{x: 5}", ["'drive/x'", "the robot has no joint"]),
        ("map", "drive", "{x: 5}", ["'map'", "must be 'floor'"]),
        ("floor", "drive", "{x: 5, z: 5.0e-4}", ["'drive'", "leaves its plane"]),
    ] {
        for output in run_both(&folder, &state(frame, joint, translation)) {
            let message = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(2), "{joint}: {message}");
            assert!(output.stdout.is_empty() && message.lines().count() == 1, "{message}");
            assert!(words.iter().all(|word| message.contains(word)), "{message}");
        }
    }
}
