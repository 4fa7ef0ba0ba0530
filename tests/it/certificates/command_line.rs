//! Tests of `clearance verify`: expected motions, start poses of obstacles, and reported differences.

use std::process::Output;

use clearance::motion::Certificate;
use serde_json::{Value, json};
use tempfile::TempDir;

use super::resign;
use crate::program::clearance;

/// Two slides, along y and along x, and a block.
const ROBOT: &str = "<robot name='slides'><link name='base'/>
<joint name='e' type='prismatic'><parent link='base'/><child link='carriage'/><axis xyz='0 1 0'/>
  <limit lower='-10' upper='10' effort='1' velocity='1'/></joint><link name='carriage'/>
<joint name='d' type='prismatic'><parent link='carriage'/><child link='tool'/><axis xyz='1 0 0'/>
  <limit lower='-10' upper='10' effort='1' velocity='1'/></joint>
<link name='tool'><collision><geometry><box size='0.1 0.1 0.1'/></geometry></collision></link>
<link name='post'><collision><geometry><sphere radius='0.05'/></geometry></collision></link>
<joint name='stands' type='fixed'><parent link='base'/><child link='post'/><origin xyz='0 -5 0'/></joint></robot>";

const WORLD: &str = "world:
  collision_objects:
  - {id: wall, pose: {position: [0.5, 0, 0]}, primitives: [{type: box, dimensions: [0.1, 2, 2]}]}
  - {id: cart, pose: {position: [-2, 4, 0]}, primitives: [{type: sphere, dimensions: [0.1]}]}
";

/// From e=0 d=0 to e=0 d=1 with velocities that lead around the wall.
const DETOUR: [f64; 2] = [20.0, -20.0];

struct Case {
    folder: TempDir,
}

impl Case {
    fn new() -> Self {
        let case = Self { folder: tempfile::tempdir().unwrap() };
        case.write("robot.urdf", ROBOT);
        case.write("world.yaml", WORLD);
        case
    }

    fn path(&self, name: &str) -> String {
        self.folder.path().join(name).display().to_string()
    }

    fn write(&self, name: &str, text: &str) -> String {
        let path = self.path(name);
        std::fs::write(&path, text).unwrap();
        path
    }

    fn run(&self, command: &str, arguments: &[&str]) -> Output {
        let given = [command, "--urdf", &self.path("robot.urdf"), "--world", &self.path("world.yaml")];
        clearance(&[&given, arguments].concat())
    }

    /// A certificate of a motion that is free.
    fn certify(&self, arguments: &[&str]) -> String {
        let certificate = self.path("certificate.json");
        let output = self.run("motion", &[arguments, &["--certificate", &certificate]].concat());
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        certificate
    }

    fn accepted(&self, certificate: &str, arguments: &[&str]) -> String {
        let output = self.run("verify", &[&[certificate], arguments].concat());
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {output:?}");
        String::from_utf8(output.stdout).unwrap()
    }

    fn rejected(&self, certificate: &str, arguments: &[&str], words: &[&str]) {
        let output = self.run("verify", &[&[certificate], arguments].concat());
        let answer = String::from_utf8_lossy(&output.stdout);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {output:?}");
        assert_eq!(answer.lines().count(), 1, "{answer}");
        for word in words {
            assert!(answer.contains(word), "{answer} does not name {word}");
        }
    }

    fn bad_input(&self, arguments: &[&str], words: &[&str]) {
        let output = self.run("verify", arguments);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(output.stdout.is_empty());
        for word in words {
            assert!(message.contains(word), "{message} does not name {word}");
        }
    }

    /// A document changed and signed again.
    fn forge(&self, certificate: &str, change: impl Fn(&mut Certificate)) -> String {
        let text = std::fs::read_to_string(certificate).unwrap();
        let mut document = Certificate::from_json(&text).unwrap();
        change(&mut document);
        resign(&mut document);
        self.write("forged.json", &document.to_json())
    }

    /// A trajectory in which `e` goes out and back, and `d` from 0 to 1.
    fn trajectory(&self, start: u32, [out, back]: [f64; 2]) -> String {
        let point = |d: f64, e: f64, sec: u32| json!({"positions": [0.0, d], "velocities": [e, 0.0], "time_from_start": {"sec": sec, "nanosec": 0}});
        let points = [point(0.0, out, start), point(1.0, back, start + 1)];
        self.write("way.json", &json!({"joint_names": ["e", "d"], "points": points}).to_string())
    }
}

const THROUGH: [&str; 4] = ["--from", "", "--to", "d=1"];
const SHORT: [&str; 4] = ["--from", "", "--to", "d=0.25"];

#[test]
fn a_detour_is_not_the_straight_way() {
    let case = Case::new();
    let way = case.trajectory(0, DETOUR);
    let certificate = case.certify(&["--trajectory", &way]);
    let told = case.accepted(&certificate, &[]);
    for word in ["polynomials of degree 3", "e=0.0 d=0.0", "e=0.0 d=1.0", "no expected motion was given"] {
        assert!(told.contains(word), "{told}");
    }
    let told = case.accepted(&certificate, &["--trajectory", &way]);
    assert!(told.contains("this is the expected motion") && !told.contains("not given"), "{told}");
    case.rejected(&certificate, &THROUGH, &["another motion", "segment 0", "degree 3", "a straight line"]);
    let edges = case.write("edges.json", r#"{"joints": ["d"], "edges": [[[0], [1]]]}"#);
    case.rejected(&certificate, &["--edges", &edges], &["degree 3", "a straight line"]);
    let other = case.trajectory(0, [19.0, -20.0]);
    case.rejected(
        &certificate,
        &["--trajectory", &other],
        &["segment 0", "'e'", "off the expected polynomial"],
    );
}

#[test]
fn other_ends_tubes_and_tolerances_are_named() {
    let case = Case::new();
    let tube = [&SHORT[..], &["--tube", "0.01", "--tolerance", "0.001"]].concat();
    let certificate = case.certify(&tube);
    case.accepted(&certificate, &tube);
    case.accepted(&certificate, &["--tube", "e=0.01 d=0.01"]);
    let told = case.accepted(&certificate, &[]);
    for word in [
        "e=0.01 d=0.01",
        "0.001 m",
        "padding 0.0 m",
        "meshes are surfaces",
        "pairs",
        "straight in joint space",
    ] {
        assert!(told.contains(word), "{told} lacks {word}");
    }
    case.rejected(&certificate, &SHORT, &["tracking tolerance of 'e' is 0.01, expected 0.0"]);
    case.rejected(&certificate, &[&SHORT[..], &["--tube", "0.02"]].concat(), &["'d' is 0.01, expected 0.02"]);
    case.rejected(&certificate, &["--tube", "d=0.01"], &["'e' is 0.01, expected 0.0"]);
    case.rejected(&certificate, &["--tolerance", "0.0005"], &["tolerance 0.001 m, expected 0.0005 m"]);
    let elsewhere = ["--from", "d=0.1", "--to", "d=0.25 e=1", "--tube", "0.01"];
    case.rejected(
        &certificate,
        &elsewhere,
        &["starts with d=0.0, expected 0.1", "ends with e=0.0, expected 1.0"],
    );
    let way = case.write(
        "three.json",
        r#"{"joint_names": ["d"], "points": [{"positions": [0]}, {"positions": [0.1]}, {"positions": [0.25]}]}"#,
    );
    case.rejected(&certificate, &["--trajectory", &way], &["1 segment(s), expected 2"]);
}

/// The expected motion itself is proven, not one that differs from it by rounding.
#[test]
fn what_differs_by_rounding_is_proven_as_it_is_expected() {
    let case = Case::new();
    let certificate = case.certify(&SHORT);
    case.accepted(&certificate, &["--from", "", "--to", "d=0.2500000000001"]);
    let certificate = case.certify(&["--from", "", "--to", "d=0.399"]);
    case.accepted(&certificate, &["--from", "", "--to", "d=0.3990000005"]);
    case.rejected(
        &certificate,
        &["--from", "", "--to", "d=0.39900001"],
        &["ends with d=0.399, expected 0.39900001"],
    );
}

const CART: &str = "moving_obstacles: [{name: cart, linear: [0, -1, 0]}]";

#[test]
fn obstacles_start_where_the_world_has_them() {
    let case = Case::new();
    let moving = case.write("moving.yaml", CART);
    let certificate = case.certify(&[&SHORT[..], &["--moving", &moving]].concat());
    let told = case.accepted(&certificate, &["--moving-obstacles"]);
    assert!(told.contains("'cart' in segment 0: shifts by [0.0, -1.0, 0.0] m"), "{told}");
    let told = case.accepted(&certificate, &[&SHORT[..], &["--moving-obstacles"]].concat());
    assert!(told.contains("how obstacles are expected to move was not given"), "{told}");
    // the wall stands in the way, unless one believes that it is elsewhere
    let forged = case.forge(&certificate, |c| {
        let mover = &mut c.segments[0].motion.obstacles[0];
        mover.start = Some(([0.0, 100.0, 0.0], [0.0, 0.0, 0.0, 1.0]));
        (mover.linear, mover.name) = ([0.0; 3], "wall".to_owned());
        c.segments[0].motion.to = Some(vec![0.0, 1.0]);
        for pair in 0..c.pairs.len() {
            let lower = if c.pairs[pair].contains(&"wall".to_owned()) { 50.0 } else { 3.0 };
            c.segments[0].proofs.retain(|p| p.0 != pair);
            c.segments[0].proofs.push(clearance::motion::Proof(pair, 0.0, 1.0, lower, 0.6));
        }
    });
    case.rejected(&forged, &["--moving-obstacles"], &["'wall'", "starts 100 m", "where the world has it"]);
    // however little it is, and however it is turned
    for start in [([0.0, 2e-9, 0.0], [0.0, 0.0, 0.0, 1.0]), ([0.0; 3], [0.0, 0.0, 1.0, 0.0])] {
        let shifted = case.forge(&certificate, |c| c.segments[0].motion.obstacles[0].start = Some(start));
        case.rejected(&shifted, &["--moving-obstacles"], &["'cart'", "where the world has it"]);
    }
}

#[test]
fn other_moving_obstacles_are_named() {
    let case = Case::new();
    let moving = case.write("moving.yaml", CART);
    let expected = [&SHORT[..], &["--moving", &moving]].concat();
    let certificate = case.certify(&expected);
    assert!(case.accepted(&certificate, &expected).contains("this is the expected motion"));
    case.rejected(&certificate, &SHORT, &["obstacle 'cart' moves, expected to stand"]);
    let faster = case.write("faster.yaml", &CART.replace("-1", "-1.5"));
    let faster = [&SHORT[..], &["--moving", &faster]].concat();
    case.rejected(&certificate, &faster, &["'cart' moves otherwise", "[0.0, -1.0, 0.0]", "[0.0, -1.5, 0.0]"]);
    let standing = case.certify(&SHORT);
    case.rejected(&standing, &expected, &["obstacle 'cart' stands, expected to move"]);
    // a clock that begins later has the cart elsewhere at the start: only the expected motion says so
    let way = case.trajectory(1, DETOUR);
    let late = [&["--trajectory", &way[..]][..], &["--moving", &moving]].concat();
    let certificate = case.certify(&late);
    case.accepted(&certificate, &late);
    case.rejected(&certificate, &["--moving-obstacles"], &["'cart' starts 1 m", "where the world has it"]);
    let told = case.accepted(&certificate, &late);
    assert!(told.contains("'cart' in segment 0: starts [0.0, -1.0, 0.0] m"), "{told}");
    // the same orientation in other numbers
    let negated = case.forge(&certificate, |c| {
        let (_, turn) = c.segments[0].motion.obstacles[0].start.as_mut().unwrap();
        *turn = turn.map(|component| -component);
    });
    case.accepted(&negated, &late);
    let turned = case.forge(&certificate, |c| {
        c.segments[0].motion.obstacles[0].start.as_mut().unwrap().1 = [0.0, 0.0, 1.0, 0.0];
    });
    case.rejected(&turned, &late, &["'cart' moves otherwise: its orientation at the start is"]);
}

/// Whatever keeps a proof from being written, no older one stands for it.
#[test]
fn no_certificate_is_left_where_a_motion_is_not_proven() {
    let case = Case::new();
    for failing in [&THROUGH[..], &[&SHORT[..], &["--tube", "0.3"]].concat()] {
        let certificate = case.certify(&SHORT);
        let output = case.run("motion", &[failing, &["--certificate", &certificate]].concat());
        assert!(!std::path::Path::new(&certificate).exists(), "{failing:?}: {output:?}");
        assert!(output.status.code() < Some(2), "{failing:?}: {output:?}");
        case.bad_input(&[&certificate], &["certificate.json"]);
    }
    // behind a link, too
    let (target, link) = (case.certify(&SHORT), case.path("link.json"));
    std::os::unix::fs::symlink(&target, &link).unwrap();
    case.run("motion", &[&THROUGH[..], &["--certificate", &link]].concat());
    assert!(!std::path::Path::new(&target).exists());
    case.run("motion", &[&SHORT[..], &["--certificate", &link]].concat());
    case.accepted(&target, &SHORT);
}

#[test]
fn joints_that_can_have_no_tube_are_named() {
    let case = Case::new();
    case.write(
        "robot.urdf",
        &ROBOT.replace(
            "</robot>",
            "<link name='bird'/><joint name='fly' type='floating'><parent link='base'/><child link='bird'/></joint></robot>",
        ),
    );
    let certificate = case.certify(&[&SHORT[..], &["--tube", "d=0.01 e=0.01"]].concat());
    for arguments in
        [&[&certificate, "--tube", "0.01"][..], &[&[&certificate[..], "--tube", "0.01"], &SHORT[..]].concat()]
    {
        case.bad_input(arguments, &["--tube", "'fly' is floating", "by name", "e, d"]);
    }
    case.bad_input(
        &[&[&certificate[..], "--tube", "fly/trans_x=0.01"], &SHORT[..]].concat(),
        &["'fly'", "give it 0"],
    );
    case.rejected(&certificate, &["--tube", "0"], &["tracking tolerance of 'e' is 0.01"]);
}

#[test]
fn what_differs_of_robot_and_world_is_named() {
    let case = Case::new();
    let certificate = case.certify(&SHORT);
    case.rejected(
        &certificate,
        &["--padding", "0.01"],
        &["another model", "padding of link", "0.0 there, 0.01 here"],
    );
    case.rejected(&certificate, &["--mesh", "solid"], &["meshes are 'surface' there, 'solid' here"]);
    case.rejected(&certificate, &["--no-self"], &["pairs of links are checked: yes there, no here"]);
    let srdf = case.write(
        "robot.srdf",
        "<robot name='slides'><disable_collisions link1='post' link2='tool' reason='Never'/></robot>",
    );
    case.rejected(
        &certificate,
        &["--srdf", &srdf],
        &["'post'", "'tool'", "is not one that has to be checked"],
    );
    for (was, is, words) in [
        ("size='0.1 0.1 0.1'", "size='0.1 0.1 0.11'", vec!["shapes of link 'tool' differ"]),
        ("axis xyz='1 0 0'", "axis xyz='1 0 0.1'", vec!["joint 'd' differs"]),
        ("xyz='0 -5 0'", "xyz='0 -5.1 0'", vec!["joint 'stands' differs"]),
        ("'carriage'", "'wagon'", vec!["link 'wagon' is missing", "there is no link 'carriage'"]),
    ] {
        let robot = ROBOT.replace(was, is);
        case.write("robot.urdf", &robot);
        case.rejected(&certificate, &[], &[&["another model"], &words[..]].concat());
    }
    case.write("robot.urdf", ROBOT);
    for (was, is, words) in [
        ("[-2, 4, 0]", "[-2, 4.1, 0]", vec!["shapes of obstacle 'cart' differ"]),
        ("id: cart", "id: truck", vec!["obstacle 'truck' is missing", "there is no obstacle 'cart'"]),
    ] {
        case.write("world.yaml", &WORLD.replace(was, is));
        case.rejected(&certificate, &[], &[&["another world"], &words[..]].concat());
    }
    // parts that say something else than the hashes
    case.write("world.yaml", WORLD);
    let forged = case.forge(&certificate, |c| c.parts.as_mut().unwrap().links[0].2 = 0.5);
    case.rejected(&forged, &[], &["does not fit its hashes", "padding of link"]);
}

/// Certificates of before are read.
#[test]
fn format_1_is_read() {
    let case = Case::new();
    let certificate = case.certify(&SHORT);
    let old = case.forge(&certificate, |c| {
        c.format = "clearance certificate 1".to_owned();
        (c.parts, c.tolerance) = (None, None);
    });
    let told = case.accepted(&old, &SHORT);
    assert!(told.contains("not recorded in format 1"), "{told}");
    case.rejected(&old, &["--padding", "0.01"], &["links, joints, shapes, paddings or pairs differ"]);
    case.rejected(&old, &["--tolerance", "0.0005"], &["format 1 does not say"]);
    for change in [
        |c: &mut Certificate| c.parts = None,
        |c: &mut Certificate| c.tolerance = None,
        |c: &mut Certificate| c.format = "clearance certificate 3\u{1b}[31m".repeat(1000),
    ] {
        let document = std::fs::read_to_string(&certificate).unwrap();
        let mut document = Certificate::from_json(&document).unwrap();
        change(&mut document);
        resign(&mut document);
        let forged = case.write("other.json", &document.to_json());
        let output = case.run("verify", &[&forged]);
        assert_eq!(output.status.code(), Some(1), "{output:?}");
        assert!(output.stdout.len() < 300 && !output.stdout.contains(&0x1b), "{output:?}");
    }
}

#[test]
fn json_output_reports_the_same() {
    let case = Case::new();
    let certificate = case.certify(&SHORT);
    let answer = |arguments: &[&str]| -> Value {
        let output = case.run("verify", &[&[&certificate, "--format", "json"], arguments].concat());
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let told = answer(&SHORT);
    assert_eq!((&told["verified"], &told["expected_motion_given"]), (&json!(true), &json!(true)));
    assert_eq!((&told["motion"]["degree"], &told["motion"]["segments"]), (&json!(1), &json!(1)));
    assert_eq!((&told["motion"]["to"], &told["tolerance"]), (&json!({"d": 0.25, "e": 0.0}), &json!(5e-4)));
    assert_eq!(told["hashes"]["robot"].as_str().unwrap().len(), 64);
    assert_eq!(answer(&[])["expected_motion_given"], json!(false));
    let refused = answer(&THROUGH);
    assert_eq!(refused["verified"], json!(false));
    assert!(refused["reason"].as_str().unwrap().contains("ends with d=0.25, expected 1.0"), "{refused}");
}

#[test]
fn half_a_question_is_bad_input() {
    let case = Case::new();
    let certificate = case.certify(&SHORT);
    let moving = case.write("moving.yaml", CART);
    let edges = case.write("edges.json", r#"{"joints": ["d"], "edges": [[[0], [1]], [[0], [0.5]]]}"#);
    case.bad_input(&[&certificate, "--moving", &moving], &["--moving", "expected motion", "--trajectory"]);
    case.bad_input(
        &[&certificate, "--continuous", "shortest"],
        &["--continuous", "expected motion", "--trajectory"],
    );
    case.bad_input(&[&certificate, "--edges", &edges], &["one way, but 2"]);
    case.bad_input(&[&certificate, "--from", ""], &["--to"]);
    case.bad_input(&[&certificate, "--from", "x=1", "--to", ""], &["'x'"]);
    case.bad_input(&[&certificate, "--tube", "x=1"], &["'x'"]);
    case.bad_input(&[&certificate, "--tolerance", "-1"], &["--tolerance"]);
    let both = [&[&certificate[..], "--moving-obstacles", "--moving", &moving][..], &SHORT[..]].concat();
    case.bad_input(&both, &["--moving-obstacles", "--moving"]);
    let moves = case.certify(&[&SHORT[..], &["--moving", &moving]].concat());
    case.bad_input(&[&moves], &["'cart' moves", "--moving-obstacles"]);
}
