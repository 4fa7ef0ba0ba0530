//! Tests of text inputs of the program: misspelt names, trajectory starts, other documents, control characters.

use std::process::Output;

use crate::program::clearance_in;

/// A ball that slides along x from the origin of the root, and one that circles far away.
const SLIDER: &str = r#"<robot name="r"><link name="base"/><link name="arm"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="j" type="prismatic"><parent link="base"/><child link="arm"/><axis xyz="1 0 0"/><limit lower="-5" upper="5" velocity="1" effort="1"/></joint>
<link name="other"><collision><origin xyz="0 5 0"/><geometry><sphere radius="0.1"/></geometry></collision></link><joint name="k" type="continuous"><parent link="base"/><child link="other"/></joint></robot>"#;

/// A folder with `r.urdf` and one more file, and the program's answer there.
fn run(urdf: &str, (name, text): (&str, &str), arguments: &[&str]) -> Output {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("r.urdf"), urdf).unwrap();
    std::fs::write(folder.path().join(name), text).unwrap();
    clearance_in(folder.path(), arguments)
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn misspelt_names_are_reported_on_stderr() {
    let urdf = SLIDER.replace("<geometry>", r#"<orgin xyz="3 0 0"/><geometry>"#);
    let output = run(&urdf, ("x", ""), &["check", "--urdf", "r.urdf", "--state", "j=0"]);
    assert_eq!(output.status.code(), Some(0));
    assert!(
        stderr(&output).contains("r.urdf:1: link 'arm': element 'orgin' is not read: did you mean 'origin'"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn starts_that_are_not_first_points_are_no_proof() {
    let text = "trajectory:\n- joint_trajectory:\n    joint_names: [j]\n    points:\n    - {positions: [4.0]}\n    \
                - {positions: [5.0], time_from_start: {sec: 1}}\ntrajectory_start:\n  joint_state: {name: [j], position: [0.0]}\n";
    let arguments = ["motion", "--urdf", "r.urdf", "--trajectory", "t.yaml"];
    let output = run(SLIDER, ("t.yaml", text), &arguments);
    assert_eq!(output.status.code(), Some(2));
    let message = stderr(&output);
    assert!(
        message.contains("t.yaml: trajectory_start has 'j' at 0, but the first point has it at 4"),
        "{message}"
    );
    assert_eq!(message.lines().count(), 1, "{message}");
    let output = run(SLIDER, ("t.yaml", &text.replace("[0.0]", "[4.0]")), &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
}

#[test]
fn joints_that_other_documents_give_are_reported() {
    let arguments = ["check", "--urdf", "r.urdf", "--states", "s.yaml"];
    let one = |joint: &str| format!("name: [{joint}]\nposition: [1.5]\n---\n");
    let output = run(SLIDER, ("s.yaml", &(one("j") + &one("k"))), &arguments);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(0), "{message}");
    assert!(
        message.contains("the states name different joints")
            && message.contains("'j' (1 of 2, 0 there), 'k'"),
        "{message}"
    );
    let output = run(SLIDER, ("s.yaml", &one("j").repeat(2)), &arguments);
    assert_eq!(stderr(&output), "");
}

#[cfg(unix)]
#[test]
fn results_are_written_to_regular_files_only() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("r.urdf"), SLIDER).unwrap();
    assert!(std::process::Command::new("mkfifo").arg(folder.path().join("fifo")).status().unwrap().success());
    let with = |file: &str| {
        clearance_in(
            folder.path(),
            &["motion", "--urdf", "r.urdf", "--from", "j=0", "--to", "j=1", "--certificate", file],
        )
    };
    for file in ["fifo", ".", "/dev/null"] {
        let output = with(file);
        assert_eq!(output.status.code(), Some(2));
        assert!(
            output.stdout.is_empty() && stderr(&output).contains("not a regular file"),
            "{}",
            stderr(&output)
        );
    }
    for _ in 0..2 {
        assert_eq!(with("c.json").status.code(), Some(0));
        let verify = clearance_in(folder.path(), &["verify", "--urdf", "r.urdf", "c.json"]);
        assert_eq!(verify.status.code(), Some(0), "{}", stderr(&verify));
    }
}

#[test]
fn names_are_shown_as_nothing_that_a_terminal_obeys() {
    let readable = |output: &Output, lines: usize| {
        for text in [stdout(output), stderr(output)] {
            assert!(
                !text.chars().any(|c| c.is_control() && c != '\n' || matches!(c, '\u{202a}'..='\u{202e}')),
                "{text:?}"
            );
        }
        assert_eq!(stderr(output).lines().count(), lines, "{}", stderr(output));
    };
    // errors
    let output = run(
        SLIDER,
        ("s.csv", "\"j\nx\u{1b}[31m\u{202e}\"\n1\n"),
        &["check", "--urdf", "r.urdf", "--states", "s.csv"],
    );
    assert_eq!(output.status.code(), Some(2));
    readable(&output, 1);
    let urdf =
        SLIDER.replace("\"base\"/><child link=\"arm\"", "\"a&#10;b&#x9b;\u{202e}\"/><child link=\"arm\"");
    let output = run(&urdf, ("x", ""), &["check", "--urdf", "r.urdf", "--state", "j=0"]);
    assert_eq!(output.status.code(), Some(2));
    readable(&output, 1);
    // results and warnings
    let urdf =
        SLIDER.replace("\"arm\"", "\"a&#10;b&#x9b;\u{202e}\"").replace("<geometry>", "<orgin/><geometry>");
    let world = "world: {collision_objects: [{id: \"b\\nc\\e[31m\", primitives: [{type: sphere, dimensions: [0.1]}], primitive_poses: [{position: [0, 0, 0]}]}]}\n";
    let arguments = ["check", "--urdf", "r.urdf", "--state", "j=0", "--world", "w.yaml", "--query"];
    for query in ["pairs", "distance", "pair-distances"] {
        let output = run(&urdf, ("w.yaml", world), &[&arguments[..], &[query]].concat());
        assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
        readable(&output, 1);
    }
    let motion = ["motion", "--urdf", "r.urdf", "--from", "j=-1", "--to", "j=1", "--world", "w.yaml"];
    let output = run(&urdf, ("w.yaml", world), &motion);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    readable(&output, 1);
}

#[test]
fn long_trajectories_are_read_as_json_and_as_yaml() {
    let points: Vec<String> = (0..30_000)
        .map(|i| format!(r#"{{"positions": [{}.0, 0.0], "velocities": [], "time_from_start": {{"sec": {i}, "nanosec": 0}}}}"#, i % 2))
        .collect();
    let json = format!(r#"{{"joint_names": ["j", "k"], "points": [{}]}}"#, points.join(",\n"));
    let output = run(SLIDER, ("t.json", &json), &["motion", "--urdf", "r.urdf", "--trajectory", "t.json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let output = run(
        SLIDER,
        ("t.yaml", &(json + "\n---\n")),
        &["motion", "--urdf", "r.urdf", "--trajectory", "t.yaml"],
    );
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
}
