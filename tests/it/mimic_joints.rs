//! Tests of the program with values of mimic joints: they move the joints that they mimic, or must agree with them.

use std::process::Output;

use serde_json::Value;

use crate::program::Folder;

/// A ball, 1 m from its axis, that `arm` turns at half the angle of `drive`, an arm without geometry; `still` mimics with multiplier 0.
const ROBOT: &str = "<robot name='r'><link name='base'/><link name='wheel'/><link name='flag'/><link name='ball'><collision>\
<origin xyz='1 0 0'/><geometry><sphere radius='0.1'/></geometry></collision></link>\
<joint name='drive' type='revolute'><parent link='base'/><child link='wheel'/><axis xyz='0 0 1'/>\
<limit lower='-3' upper='3' effort='1' velocity='1'/></joint>\
<joint name='arm' type='revolute'><parent link='base'/><child link='ball'/><axis xyz='0 0 1'/><mimic joint='drive' multiplier='0.5'/>\
<limit lower='-1' upper='1' effort='1' velocity='1'/></joint>\
<joint name='still' type='revolute'><parent link='base'/><child link='flag'/><axis xyz='0 0 1'/>\
<mimic joint='drive' multiplier='0' offset='0.25'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint></robot>";

/// A ball where `arm` is at 0.5 rad.
const WORLD: &str = "world:\n  collision_objects:\n    - id: b\n      header: {frame_id: base}\n      \
primitives: [{type: sphere, dimensions: [0.1]}]\n      \
primitive_poses: [{position: [0.8775825618903728, 0.479425538604203, 0], orientation: [0, 0, 0, 1]}]\n";

/// Where the balls begin to touch (rad of `arm`): 0.2 m apart on a circle of radius 1 m.
fn touch() -> f64 {
    0.5 - 2.0 * 0.1_f64.asin()
}

/// Files of the robot and its world.
struct Case(Folder);

impl Case {
    fn new() -> Self {
        Self(Folder::of(ROBOT, WORLD))
    }

    fn write(&self, name: &str, text: &str) {
        self.0.write(name, text);
    }

    /// `clearance COMMAND` of this robot in this world.
    fn run(&self, command: &str, arguments: &[&str]) -> Output {
        let given = [command, "--urdf", "r.urdf", "--world", "w.yaml", "--format", "json"];
        self.0.run(&[&given, arguments].concat())
    }

    fn result(&self, command: &str, arguments: &[&str]) -> Value {
        let output = self.run(command, arguments);
        let answer: Value =
            serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {output:?}"));
        answer["results"][0].clone()
    }

    /// Exit code 2, nothing on stdout, and one line that names all `words`.
    fn assert_rejected(&self, command: &str, arguments: &[&str], words: &[&str]) {
        let output = self.run(command, arguments);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(output.stdout.is_empty());
        for word in words {
            assert!(message.contains(word), "{arguments:?}: {message} does not name {word}");
        }
    }
}

fn trajectory(joints: &str, points: &[&str]) -> String {
    let point = |(second, numbers): (usize, &&str)| {
        format!("  - {{{numbers}, time_from_start: {{sec: {}, nanosec: 0}}}}\n", 2 * second)
    };
    let points: String = points.iter().enumerate().map(point).collect();
    format!("joint_names: [{joints}]\npoints:\n{points}")
}

#[test]
fn a_value_of_a_mimic_joint_moves_its_leader() {
    let folder = Case::new();
    let is_free = |state: &str| folder.result("check", &["--state", state])["free"].as_bool().unwrap();
    assert!(is_free("arm=0") && !is_free("arm=0.5") && !is_free("arm=0.5 drive=1") && !is_free("drive=1"));
    assert!(is_free("still=0.25"));
    folder.write("s.csv", "arm\n0.5\n");
    assert_eq!(folder.result("check", &["--states", "s.csv"])["free"], false);
    folder.write("s.json", r#"{"joints": ["arm", "drive"], "states": [[0.5, 1.0]]}"#);
    assert_eq!(folder.result("check", &["--states", "s.json"])["free"], false);

    let touches = |arguments: &[&str], at: f64| {
        let result = folder.result("motion", arguments);
        assert_eq!(result["verdict"], "contact", "{arguments:?}");
        let t = [0, 1].map(|i| result["t"][i].as_f64().unwrap());
        assert!(t[0] - 1e-9 <= at && at <= t[1] + 1e-9, "{arguments:?}: {at} is not in {t:?}");
    };
    touches(&["--from", "arm=0", "--to", "arm=1"], touch());
    touches(&["--from", "drive=0", "--to", "arm=1"], touch());
    touches(&["--from", "drive=0 arm=0", "--to", "arm=1 drive=2"], touch());
    folder.write("e.json", r#"{"joints": ["arm"], "edges": [[[0], [1]]]}"#);
    touches(&["--edges", "e.json"], touch());
    folder.write("t.yaml", &trajectory("arm", &["positions: [0.0]", "positions: [1.0]"]));
    touches(&["--trajectory", "t.yaml"], touch());
}

/// With velocities a piece is a cubic, with accelerations a quintic: both are those of the leader, by whatever name.
#[test]
fn velocities_and_accelerations_of_a_mimic_joint_are_those_of_its_leader() {
    let folder = Case::new();
    for (name, more) in
        [("cubic", ["", ""]), ("quintic", [", accelerations: [0.3]", ", accelerations: [-0.2]"])]
    {
        let point = |scale: f64, q: f64, v: f64, more: &str| {
            let acceleration =
                more.replace("0.3", &(0.3 * scale).to_string()).replace("0.2", &(0.2 * scale).to_string());
            format!("positions: [{}], velocities: [{}]{acceleration}", q * scale, v * scale)
        };
        let points = |scale| [point(scale, 0.0, 0.7, more[0]), point(scale, 1.0, 0.1, more[1])];
        let found = [("arm", 1.0), ("drive", 2.0)].map(|(joint, scale)| {
            let points = points(scale);
            let text = trajectory(joint, &[&points[0], &points[1]]);
            folder.write("t.yaml", &text);
            folder.result("motion", &["--trajectory", "t.yaml"])
        });
        assert_eq!(found[0]["verdict"], "contact", "{name}");
        assert_eq!(found[0], found[1], "{name}");
    }
    let moving = |velocities: &str| {
        let points = [
            format!("positions: [0.0, 0.0], velocities: [{velocities}]"),
            "positions: [1.0, 2.0], velocities: [0, 0]".to_owned(),
        ];
        folder.write("t.yaml", &trajectory("arm, drive", &[&points[0], &points[1]]));
    };
    moving("0.5, 1.0");
    assert_eq!(folder.result("motion", &["--trajectory", "t.yaml"])["verdict"], "contact");
    // also where a piece is straight because its other end has none
    folder.write(
        "t.yaml",
        &trajectory("arm, drive", &["positions: [0, 0], velocities: [0.5, 0.25]", "positions: [1, 2]"]),
    );
    folder.assert_rejected("motion", &["--trajectory", "t.yaml"], &["point 0", "'arm'", "'drive'"]);
    moving("0.5, 0.25");
    folder.assert_rejected(
        "motion",
        &["--trajectory", "t.yaml"],
        &["point 0", "'arm'", "velocity 0.5", "'drive'", "0.25"],
    );
}

#[test]
fn a_mimic_joint_that_is_not_where_its_leader_takes_it_is_rejected() {
    let folder = Case::new();
    let both = ["'arm'", "'drive'", "0.5"];
    folder.assert_rejected("check", &["--state", "arm=0.5 drive=0"], &both);
    folder.assert_rejected("check", &["--state", "drive=0 arm=0.5"], &both);
    folder.assert_rejected("check", &["--state", "still=0.5"], &["'still'", "0.5", "'drive'", "0.25"]);
    folder.write("s.csv", "arm,drive\n0.0,0\n0.5,0\n");
    folder.assert_rejected("check", &["--states", "s.csv"], &["state 1", "'arm'", "'drive'", "0.5"]);
    folder.write("s.json", r#"{"joints": ["drive", "arm"], "states": [[0, 0.5]]}"#);
    folder.assert_rejected("check", &["--states", "s.json"], &both);
    folder.assert_rejected(
        "motion",
        &["--from", "drive=0", "--to", "drive=0 arm=0.5"],
        &["--to", "'arm'", "'drive'"],
    );
    folder.assert_rejected("motion", &["--from", "still=0", "--to", "still=1"], &["--from", "'still'"]);
    folder.write("e.json", r#"{"joints": ["arm", "drive"], "edges": [[[0, 0], [0.5, 0]]]}"#);
    folder.assert_rejected("motion", &["--edges", "e.json"], &["edge 0", "'arm'", "'drive'", "0.5"]);
    folder.write("t.yaml", &trajectory("drive, arm", &["positions: [0, 0]", "positions: [0, 0.5]"]));
    folder.assert_rejected("motion", &["--trajectory", "t.yaml"], &["point 1", "'arm'", "'drive'", "0.5"]);
    let state = "robot_state:\n  joint_state: {name: [arm, drive], position: [0.5, 0]}\n";
    folder.write("w.yaml", &format!("{state}{WORLD}"));
    folder.assert_rejected(
        "check",
        &["--state", ""],
        &["robot_state.joint_state", "'arm'", "'drive'", "0.5"],
    );
}

#[test]
fn a_tolerance_of_a_mimic_joint_counts_for_its_leader() {
    let folder = Case::new();
    let way = ["--from", "drive=0", "--to", "drive=0.2", "--tube"];
    let verdict = |tube: &str| folder.result("motion", &[&way[..], &[tube]].concat())["verdict"].clone();
    // arm gets as far as 0.1, and `touch` is 0.2997: 0.2 is too much, and less is proven only as far as bounds are tight
    assert_eq!([verdict("arm=0.14"), verdict("drive=0.28"), verdict("arm=0.1 drive=0.28")], ["free"; 3]);
    assert_ne!(verdict("arm=0.21"), "free");
    assert_ne!(verdict("arm=0.21 drive=0.1"), "free");
    let assert_rejected = |tube: &str, words: &[&str]| {
        folder.assert_rejected("motion", &[&way[..], &[tube]].concat(), &[&["--tube"], words].concat());
    };
    assert_rejected("still=0.1", &["'still'"]);
    assert_rejected("arm=-0.1", &["'arm'", "-0.1"]);
    assert_rejected("arm=0.1 arm=0.1", &["'arm' is given twice"]);
    assert_rejected("drive=0.1 drive=0.2", &["'drive' is given twice"]);
    assert_rejected("finger=0.1", &["'finger'"]);
}

/// `arm` moves half as much as `drive`: `drive` gets twice the number.
#[test]
fn one_tolerance_for_every_joint_is_one_for_mimic_joints_too() {
    let folder = Case::new();
    let way = ["--from", "drive=0", "--to", "drive=0.2", "--tube"];
    folder.assert_rejected(
        "motion",
        &[&way[..], &["0.1"]].concat(),
        &["--tube", "'still'", "multiplier 0", "drive"],
    );
    folder.write("r.urdf", &ROBOT.replace("multiplier='0'", "multiplier='1'"));
    let verdict = |tube: &str| folder.result("motion", &[&way[..], &[tube]].concat())["verdict"].clone();
    assert_eq!([verdict("0.14"), verdict("0")], ["free"; 2]);
    assert_ne!(verdict("0.21"), "free");
    // a proof of less is none of more
    for (tube, code) in [("0.1", 0), ("arm=0.1", 0), ("drive=0.2", 0), ("drive=0.1", 1), ("arm=0.05", 1)] {
        let proven = folder.result("motion", &[&way[..], &[tube, "--certificate", "c.json"]].concat());
        assert_eq!(proven["verdict"], "free", "{tube}");
        for expected in [&way[4..], &way[..]] {
            let verified = folder.run("verify", &[expected, &["0.1", "c.json"]].concat());
            assert_eq!(verified.status.code(), Some(code), "{tube}: {verified:?}");
        }
    }
}

#[test]
fn joints_given_twice_are_rejected_wherever_they_are_given() {
    let folder = Case::new();
    let twice = ["'arm' is given twice"];
    folder.assert_rejected("check", &["--state", "arm=0.1 arm=0.1"], &twice);
    folder.assert_rejected("motion", &["--from", "", "--to", "arm=0.1 arm=0.2"], &twice);
    folder.write("s.csv", "arm,arm\n0,0\n");
    folder.assert_rejected("check", &["--states", "s.csv"], &twice);
    folder.write("e.json", r#"{"joints": ["arm", "arm"], "edges": [[[0, 0], [0, 0]]]}"#);
    folder.assert_rejected("motion", &["--edges", "e.json"], &twice);
    folder.write("t.yaml", &trajectory("arm, arm", &["positions: [0, 0]", "positions: [0, 0]"]));
    folder.assert_rejected("motion", &["--trajectory", "t.yaml"], &twice);
}

/// `arm` may turn by 1 rad, `drive` by three times as much.
#[test]
fn limits_of_mimic_joints_are_warned_of() {
    let folder = Case::new();
    let words = |command: &str, arguments: &[&str]| {
        String::from_utf8_lossy(&folder.run(command, arguments).stderr).into_owned()
    };
    let outside = "'arm' is at 1.25, outside its limits [-1, 1]";
    assert!(words("check", &["--state", "drive=2.5"]).contains(outside));
    assert!(words("check", &["--state", "arm=1.25"]).contains(outside));
    assert!(words("motion", &["--from", "", "--to", "drive=2.5"]).contains(outside));
    assert_eq!(words("check", &["--state", "drive=-1.9"]), "");
}
