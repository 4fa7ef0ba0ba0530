//! Tests of the program's messages about wrong input: one line each, with a hint.

use std::process::Output;

use crate::program::{Folder, clearance};

const TWO_LINK: [&str; 2] = ["--urdf", "urdf/two_link/two_link.urdf"];

fn check(arguments: &[&str]) -> Output {
    clearance(&[&["check"], &TWO_LINK[..], arguments].concat())
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Exit code 2, nothing on stdout, and one line that has all words.
fn assert_rejected(output: &Output, words: &[&str]) {
    let message = stderr(output);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(output.stdout.is_empty());
    assert_eq!(message.lines().count(), 1, "{message}");
    for word in words {
        assert!(message.contains(word), "{message} does not name {word}");
    }
}

#[test]
fn a_state_without_quotes_gets_a_hint() {
    assert_rejected(
        &check(&["--state", "joint1=0.1", "joint2=0.2"]),
        &["'joint2=0.2'", "quote the whole state: --state \"joint1=0.1 joint2=0.2\""],
    );
    let motion = ["motion", TWO_LINK[0], TWO_LINK[1], "--from", "joint1=0", "joint2=0", "--to", "joint1=1"];
    assert_rejected(&clearance(&motion), &["--from \"joint1=0 joint2=0\""]);
    // another mistake keeps the words of the parser
    assert!(
        stderr(&check(&["--state", "joint1=0", "world.yaml"])).contains("unexpected argument 'world.yaml'")
    );
    for (state, words) in [
        ("joint1:1", "write joint1=1"),
        ("joint1 = 1", "no blanks"),
        ("joint1=90deg", "1.57"),
        ("joint3=1", "no joint 'joint3'; it has joint1, joint2"),
        ("joint1=1 joint1=2", "given twice"),
        ("joint1=nan", "not finite"),
    ] {
        assert_rejected(&check(&["--state", state]), &["--state", words]);
    }
}

#[test]
fn states_are_read_as_ros_tools_write_them() {
    let files = Folder::new();
    let message = |q: f64| {
        format!(
            "header: {{}}\nname:\n- joint1\n- joint2\nposition:\n- 0.0\n- {q}\nvelocity: []\neffort: []\n---\n"
        )
    };
    let echo = files.write("echo.yaml", &(message(0.0) + &message(3.0)));
    let answer = check(&["--states", &echo]);
    assert_eq!(answer.status.code(), Some(1), "{answer:?}");
    assert!(String::from_utf8_lossy(&answer.stdout).contains("1 of 2 states free"));
    let robot_state =
        files.write("state.yaml", "joint_state:\n  name: [joint2]\n  position: [0.5]\nis_diff: false\n---\n");
    assert_eq!(check(&["--states", &robot_state]).status.code(), Some(0));
    for (name, text, words) in [
        ("semicolons.csv", "joint1;joint2\n0;0\n", &["semicolons", "commas"][..]),
        ("tabs.csv", "joint1\tjoint2\n0\t0\n", &["tabs"]),
        ("numbers.csv", "0,0\n1,1\n", &["numbers only", "joint1,joint2"]),
        ("empty.csv", "", &["empty", "joint1,joint2"]),
        ("empty.json", "", &["empty", "JointState"]),
        ("names.yaml", "name: [joint1]\nvelocity: [1.0]\n", &["no position"]),
    ] {
        let file = files.write(name, text);
        assert_rejected(&check(&["--states", &file]), &[&[name], words].concat());
    }
}

#[test]
fn an_empty_document_behind_a_world_or_trajectory_is_nothing() {
    let files = Folder::new();
    let world = "collision_objects:\n- id: b\n  header: {frame_id: base}\n  primitives: [{type: sphere, dimensions: [0.1]}]\n  \
                 primitive_poses: [{position: [5, 0, 0]}]\n---\n";
    let one = files.write("world.yaml", world);
    let two = files.write("worlds.yaml", &world.repeat(2));
    assert_eq!(check(&["--world", &one, "--state", ""]).status.code(), Some(0));
    assert_rejected(&check(&["--world", &two, "--state", ""]), &["2 documents", "line 6", "file of its own"]);
    assert_rejected(
        &check(&["--world", &files.write("e.yaml", "---\n"), "--state", ""]),
        &["e.yaml", "empty"],
    );
    let points = "joint_names: [joint1]\npoints:\n- {positions: [0], time_from_start: {secs: 0, nsecs: 0}}\n\
                  - {positions: [1], time_from_start: 2.0}\n";
    let way = |file: &str| clearance(&["motion", TWO_LINK[0], TWO_LINK[1], "--trajectory", file]);
    assert_eq!(way(&files.write("t.yaml", &format!("{points}---\n"))).status.code(), Some(0));
    assert_rejected(
        &way(&files.write("tt.yaml", &format!("{points}---\n{points}"))),
        &["2 documents", "line 5"],
    );
    let base = "joint_trajectory: {joint_names: [joint1], points: []}\n\
                multi_dof_joint_trajectory: {joint_names: [base], points: [{}]}\n";
    assert_rejected(&way(&files.write("base.yaml", base)), &["'base'", "multi_dof_joint_trajectory"]);
    let edges = files.write("e.json", "joints: [joint1]\nedges: [[[0], [1]]]\n---\n");
    assert_eq!(clearance(&["motion", TWO_LINK[0], TWO_LINK[1], "--edges", &edges]).status.code(), Some(0));
}

#[test]
fn confused_files_are_distinguished() {
    let files = Folder::new();
    let srdf = files.write(
        "r.srdf",
        "<robot name='two_link'><disable_collisions link1='base' link2='tip' reason='Never'/></robot>",
    );
    let mesh = files.write("m.stl", "solid m\nendsolid m\n");
    let world = files.write("w.yaml", "world:\n  collision_objects: []\n");
    let empty = files.write("e.urdf", "");
    let xacro = files
        .write("r.xacro", "<robot name='r' xmlns:xacro='http://www.ros.org/wiki/xacro'><xacro:arm/></robot>");
    let urdf = |file: &str| clearance(&["check", "--urdf", file, "--state", ""]);
    assert_rejected(&urdf(&srdf), &["r.srdf", "is an SRDF", "--srdf"]);
    assert_rejected(&urdf(&mesh), &["m.stl", "an STL mesh", "no file for --urdf"]);
    assert_rejected(&urdf(&world), &["w.yaml", "--world"]);
    assert_rejected(&urdf(&empty), &["e.urdf", "empty"]);
    assert_rejected(&urdf(&xacro), &["xacro", "expand it first"]);
    assert_rejected(&check(&["--srdf", TWO_LINK[1], "--state", ""]), &["is a URDF", "--urdf"]);
    let as_world = |file: &str| check(&["--world", file, "--state", ""]);
    assert_rejected(&as_world(TWO_LINK[1]), &["it is a URDF", "--urdf"]);
    assert_rejected(&as_world(&srdf), &["it is an SRDF", "--srdf"]);
    assert_rejected(&as_world(&mesh), &["it is a mesh", "mesh resource"]);
    let missing = "<robot name='r'><link name='a'><collision><geometry><mesh filename='package://arm/a.stl'/></geometry></collision>\
                   <collision><geometry><mesh filename='package://arm/b.stl'/></geometry></collision></link></robot>";
    assert_rejected(
        &urdf(&files.write("p.urdf", missing)),
        &["package 'arm'", "1 more", "--package-path DIR"],
    );
}

#[test]
fn links_that_are_only_displayed_are_warned_of_once() {
    let files = Folder::new();
    let urdf = files.write(
        "r.urdf",
        "<robot name='r'><link name='base'><collision><geometry><sphere radius='0.1'/></geometry></collision></link>\
         <link name='wheel'><visual><geometry><sphere radius='0.5'/></geometry></visual></link>\
         <joint name='j' type='continuous'><parent link='base'/><child link='wheel'/></joint></robot>",
    );
    let answer = clearance(&["check", "--urdf", &urdf, "--state", "j=1"]);
    let warnings = stderr(&answer);
    assert_eq!(answer.status.code(), Some(0), "{warnings}");
    assert_eq!(warnings.matches("'wheel'").count(), 1, "{warnings}");
    assert!(warnings.contains("no <collision> geometry"), "{warnings}");
}

#[test]
fn pairs_that_collide_in_every_state_are_named_with_their_srdf_entry() {
    let files = Folder::new();
    let states = |positions: &[f64]| {
        let rows: Vec<String> = positions.iter().map(|q| format!("{},{q}", q - 3.0)).collect();
        files.write("q.csv", &format!("joint1,joint2\n{}\n", rows.join("\n")))
    };
    let folded: Vec<f64> = (0..25).map(|i| 3.1 + 0.001 * f64::from(i)).collect();
    for query in ["free", "pairs", "distance"] {
        let warnings = stderr(&check(&["--states", &states(&folded), "--query", query, "--threads", "2"]));
        for words in [
            "'base' and 'tip' touch in all 25 states",
            r#"<disable_collisions link1="base" link2="tip" reason="#,
            "hides true",
        ] {
            assert!(warnings.contains(words), "{query}: {warnings}");
        }
    }
    assert!(!stderr(&check(&["--states", &states(&folded[..19])])).contains("disable_collisions"));
    let once_free = [&folded[..], &[0.0]].concat();
    assert!(
        !stderr(&check(&["--states", &states(&once_free), "--query", "pairs"]))
            .contains("disable_collisions")
    );
}
