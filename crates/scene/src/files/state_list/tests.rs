//! Tests of the reader of robot state files: all formats, several states, transforms, faults.

use clearance_robot::MeshFiles;

use super::*;

fn robot() -> RobotModel {
    let text = "<robot name='r'><link name='a'/><link name='b'/><link name='c'/><link name='d'/>
        <joint name='j' type='continuous'><parent link='a'/><child link='b'/></joint>
        <joint name='fly' type='floating'><parent link='a'/><child link='c'/></joint>
        <joint name='roam' type='planar'><parent link='a'/><child link='d'/><axis xyz='0 0 1'/></joint></robot>";
    RobotModel::from_urdf(text, &MeshFiles::default()).unwrap()
}

/// Names and positions.
type Row = (Vec<String>, Vec<f64>);

fn read(text: &str) -> Result<Vec<Row>, String> {
    let states = NamedState::list_from_text(text, &robot())?.states;
    Ok(states.into_iter().map(|s| (s.names.to_vec(), s.positions)).collect())
}

fn j(position: f64) -> Row {
    (vec!["j".to_owned()], vec![position])
}

/// The format of `ros2 topic echo`.
fn echo(position: f64) -> String {
    format!(
        "header:\n  stamp:\n    sec: 1\n    nanosec: 2\n  frame_id: ''\nname:\n- j\nposition:\n- {position}\nvelocity: []\neffort: []\n---\n"
    )
}

#[test]
fn one_state_in_every_spelling() {
    let ros1 = echo(0.5).replace("sec:", "secs:").replace("nano", "n");
    for text in [
        r#"{"joints": ["j"], "states": [[0.5]]}"#,
        "joints: [j]\nstates: [[0.5]]\n---\n",
        &echo(0.5),
        &ros1,
        r#"{"name": ["j"], "position": [0.5]}"#,
        "{name: [j], position: [0.5]}",
        "- name: [j]\n  position: [0.5]\n",
        r#"[{"name": ["j"], "position": [0.5]}]"#,
        "joint_state:\n  header: {}\n  name: [j]\n  position: [0.5]\nmulti_dof_joint_state:\n  joint_names: []\n\
         attached_collision_objects: []\nis_diff: false\n---\n",
    ] {
        assert_eq!(read(text), Ok(vec![j(0.5)]), "{text}");
    }
}

#[test]
fn fields_that_are_not_read_may_be_nan() {
    let echoed = echo(0.5).replace("velocity: []\neffort: []", "velocity:\n- .nan\neffort:\n- .inf");
    for text in [
        echoed.as_str(),
        "joint_state: {name: [j], position: [0.5], velocity: [.nan], effort: [-.inf]}\n",
        "joint_state: {name: [j], position: [0.5]}\nmulti_dof_joint_state: {twist: [{linear: {x: .nan}}]}\n",
        // Python's JSON
        r#"{"name": ["j"], "position": [0.5], "effort": [NaN]}"#,
    ] {
        assert_eq!(read(text), Ok(vec![j(0.5)]), "{text}");
    }
    let (names, positions) = read("name: [j]\nposition: [.nan]\n").unwrap().remove(0);
    assert!(robot().configuration_from_names([(&*names[0], positions[0])]).is_err());
    let flying = "joint_state: {}\nmulti_dof_joint_state: {joint_names: [fly], transforms: [{translation: {x: .nan}}]}\n";
    assert!(read(flying).unwrap_err().contains("must be finite"));
}

#[test]
fn several_states_keep_their_order() {
    let all = Ok(vec![j(1.0), j(2.0), j(3.0)]);
    assert_eq!(read(&(echo(1.0) + &echo(2.0) + &echo(3.0))), all);
    assert_eq!(
        read("- {name: [j], position: [1]}\n- name: [j]\n  position: [2]\n---\nname: [j]\nposition: [3]\n"),
        all
    );
    assert_eq!(read("joints: [j]\nstates:\n- [1]\n- [2]\n- [3]\n"), all);
}

#[test]
fn transforms_are_positions_of_joints_with_several() {
    let state = |joint: &str, rotation: &str| {
        let transform = format!("{{translation: {{x: 1, y: 2, z: 0}}, rotation: {rotation}}}");
        read(&format!(
            "joint_state: {{name: [j], position: [3]}}\nmulti_dof_joint_state:\n  joint_names: [{joint}]\n  transforms: [{transform}]\n"
        ))
    };
    let (names, positions) = state("fly", "{x: 0, y: 0, z: 1, w: 0}").unwrap().remove(0);
    assert_eq!(names[1..4], ["fly/trans_x", "fly/trans_y", "fly/trans_z"]);
    assert_eq!(positions, [3.0, 1.0, 2.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    let (names, positions) = state("roam", "{w: 1}").unwrap().remove(0);
    assert_eq!((names.len(), &positions[..]), (4, &[3.0, 1.0, 2.0, 0.0][..]));
    assert!(state("roam", "{x: 1, w: 0}").unwrap_err().contains("leaves its plane"));
    assert!(state("j", "{w: 1}").unwrap_err().contains("'j' is neither planar nor floating"));
}

#[test]
fn faults_name_the_state_or_the_line() {
    for (text, words) in [
        ("", &["empty"][..]),
        ("---\n", &["empty"]),
        ("name: [j]\nposition: []\n", &["state 0", "no position"]),
        ("name: [j]\nvelocity: [1]\n", &["state 0", "no position"]),
        (&(echo(1.0) + "name: [j]\nposition: [1, 2]\n"), &["state 1", "2 positions for 1 names"]),
        (&(echo(1.0) + "name: [j]\nposition: [x]\n"), &["line 14"]),
        ("velocity: [1]\n", &["state 0", "no joint"]),
        ("joints: [j]\n", &["joints without states"]),
        (r#"{"joints": ["j"], "states": [[1], [1, 2]]}"#, &["state 1", "2 positions for 1 joints"]),
        (r#"{"joints": ["j"], "states": [[1]"#, &["line 1 column"]),
        ("name: [j]\nposition: [1]\njoints: [j]\n", &["exclude"]),
        ("nome: [j]\n", &["line 1", "nome"]),
        ("name: [j]\nposition: [1]\nattached_collision_objects: [{object: {id: tool}}]\n", &["exclude"]),
        ("joint_state: {}\nattached_collision_objects: [{object: {id: tool}}]\n", &["'tool'", "--world"]),
    ] {
        let message = read(text).unwrap_err();
        for word in words {
            assert!(message.contains(word), "{text}: {message}");
        }
        assert!(!message.contains('\n'), "{message}");
    }
}

#[test]
fn what_echo_leaves_out_or_adds_is_reported() {
    let cut = echo(0.5).replace("- 0.5\n", "- 0.5\n- '...'\n");
    let message = read(&(echo(0.25) + &cut)).unwrap_err();
    assert!(message.contains("line 22") && message.contains("--full-length"), "{message}");
    let message = read("name: [j, '...']\nposition: [0.5, '...']\n").unwrap_err();
    assert!(message.contains("line 1") && message.contains("--full-length"), "{message}");
    let lost = "A message was lost!!!\n\ttotal count change:1\n\ttotal count: 3---\n";
    let warning = "WARNING: topic [/joint_states] does not appear to be published yet\n";
    let text = [warning, &echo(0.5), lost, &echo(0.25)].concat();
    let StateList { states, remarks } = NamedState::list_from_text(&text, &robot()).unwrap();
    assert_eq!(states.len(), 2);
    assert_eq!(remarks.len(), 2, "{remarks:?}");
    assert!(remarks[1].contains("a message was lost"), "{remarks:?}");
    let message = read(&(echo(0.5) + "name: [j]\nposition:\n- 0.")).unwrap_err();
    assert!(message.contains("is cut"), "{message}");
}
