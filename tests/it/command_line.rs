//! Tests of the program: exit codes, JSON output, errors; test helpers for other tests of the program.

use std::process::Output;

use serde_json::Value;

use crate::program::clearance;

pub const ARM: [&str; 4] = ["--urdf", "urdf/demo_arm/demo_arm.urdf", "--srdf", "urdf/demo_arm/demo_arm.srdf"];
pub const TWO_LINK: [&str; 2] = ["--urdf", "urdf/two_link/two_link.urdf"];

pub fn check(model: &[&str], arguments: &[&str]) -> Output {
    clearance(&[&["check"], model, arguments].concat())
}

pub fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {output:?}"))
}

/// Exit code 2, one message that names `words`, and nothing on stdout.
pub fn assert_bad_input(output: &Output, words: &[&str]) {
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(output.stdout.is_empty());
    for word in words {
        assert!(message.contains(word), "{message} does not name {word}");
    }
}

#[test]
fn exit_codes_say_free_or_not() {
    let free = check(&TWO_LINK, &["--state", ""]);
    assert_eq!(free.status.code(), Some(0), "{free:?}");
    let folded = check(&TWO_LINK, &["--state", "joint2=3.141592653589793"]);
    assert_eq!(folded.status.code(), Some(1), "{folded:?}");
    assert!(String::from_utf8_lossy(&folded.stdout).contains("COLLIDING with itself"));
}

#[test]
fn joints_beyond_their_limits_are_warned_of() {
    let warning = |output: &Output| String::from_utf8_lossy(&output.stderr).into_owned();
    let degrees = check(&TWO_LINK, &["--state", "joint1=90"]);
    assert_eq!(degrees.status.code(), Some(0), "{degrees:?}");
    let words = warning(&degrees);
    assert!(words.contains("'joint1' is at 90, outside its limits") && words.contains("degrees?"), "{words}");
    let way = ["motion", TWO_LINK[0], TWO_LINK[1], "--from", "joint1=0", "--to", "joint1=90"];
    assert!(warning(&clearance(&way)).contains("'joint1' is at 90, outside its limits"));
    assert_eq!(warning(&check(&TWO_LINK, &["--state", "joint1=3"])), "");
}

#[test]
fn errors_about_files_of_another_kind_name_the_expected_one() {
    let given = |option: &str| check(&TWO_LINK, &[option, "Cargo.toml"]);
    assert_bad_input(&given("--states"), &["Cargo.toml", r#""states": [["#, "CSV"]);
    let world = check(&TWO_LINK, &["--state", "", "--world", "Cargo.toml"]);
    assert_bad_input(&world, &["Cargo.toml", "planning scene", ".bt"]);
    let motion = |option: &str| clearance(&["motion", TWO_LINK[0], TWO_LINK[1], option, "Cargo.toml"]);
    assert_bad_input(&motion("--edges"), &["Cargo.toml", r#""edges": [["#]);
    assert_bad_input(&motion("--trajectory"), &["Cargo.toml", "JointTrajectory"]);
}

#[test]
fn json_of_every_query() {
    let folded = ["--state", "joint2=3.141592653589793", "--format", "json", "--query"];
    let answer = json(&check(&TWO_LINK, &[&folded[..], &["pairs"]].concat()));
    let result = &answer["results"][0];
    assert_eq!(result["free"], false);
    assert_eq!(result["self_collision"], true);
    assert_eq!(result["world_collision"], false);
    assert_eq!(result["pairs"], serde_json::json!([["base", "tip"]]));
    assert_eq!(answer["joints"], serde_json::json!(["joint1", "joint2"]));
    assert_eq!(answer["pairs_checked"], 1);
    assert!(answer["load_seconds"].as_f64().unwrap() > 0.0);
    assert!(answer["stats"]["primitive_tests"].as_u64().unwrap() > 0);
    assert!(answer.get("timing").is_none());

    let straight = ["--state", "", "--format", "json", "--query"];
    let answer = json(&check(&TWO_LINK, &[&straight[..], &["distance"]].concat()));
    let result = &answer["results"][0];
    assert!((result["distance"].as_f64().unwrap() - 0.7).abs() < 1e-9, "{result}");
    assert_eq!(result["nearest"], serde_json::json!(["base", "tip"]));
    assert_eq!(result["witness_points"].as_array().unwrap().len(), 2);
    for field in ["distance", "nearest", "witness_points"] {
        assert_eq!(result[format!("self_{field}")], result[field]);
        assert_eq!(result[format!("world_{field}")], serde_json::Value::Null);
    }

    let limited = json(&check(&TWO_LINK, &[&straight[..], &["distance", "--limit", "0.5"]].concat()));
    let result = &limited["results"][0];
    assert!(result["distance"].is_null() && result["nearest"].is_null() && result["free"] == true);

    let answer = json(&check(&TWO_LINK, &[&straight[..], &["pair-distances", "--repeat", "3"]].concat()));
    assert_eq!(answer["results"][0]["pair_distances"][0][1], "tip");
    assert_eq!(answer["timing"]["passes"], 3);
    assert!(answer["timing"]["us_min"].as_f64().unwrap() <= answer["timing"]["us_median"].as_f64().unwrap());
}

#[test]
fn states_from_json_and_csv_are_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.display().to_string()
    };
    let from_json =
        write("q.json", r#"{"joints": ["joint2", "joint1"], "states": [[3.1, 0], [0, 0.5], [2.0, 0]]}"#);
    let from_csv = write("q.csv", "joint2, joint1\n3.1, 0\n0, 0.5\n2.0, 0\n");
    let results = |file: &str, threads: &str| {
        let format = ["--states", file, "--format", "json", "--query", "distance", "--threads", threads];
        json(&check(&TWO_LINK, &format))["results"].clone()
    };
    let one = results(&from_json, "1");
    assert_eq!(one.as_array().unwrap().len(), 3);
    assert_eq!(one, results(&from_csv, "1"));
    assert_eq!(one, results(&from_json, "3"), "the same bits for any number of threads");

    let bad = write("bad.json", r#"{"joints": ["joint1", "elbow"], "states": [[0, 0]]}"#);
    assert_bad_input(&check(&TWO_LINK, &["--states", &bad]), &["bad.json", "state 0", "elbow", "joint2"]);
    let short = write("short.json", r#"{"joints": ["joint1", "joint2"], "states": [[0, 0], [0]]}"#);
    assert_bad_input(&check(&TWO_LINK, &["--states", &short]), &["state 1", "1 positions for 2 joints"]);
    let nan = write("nan.csv", "joint1\nnan\n");
    assert_bad_input(&check(&TWO_LINK, &["--states", &nan]), &["state 0", "joint1", "not finite"]);
    let word = write("word.csv", "joint1\n0\nfar\n");
    assert_bad_input(&check(&TWO_LINK, &["--states", &word]), &["line 3", "far"]);
}

#[test]
fn bad_input_is_named() {
    assert_bad_input(&check(&[], &["--state", ""]), &["--urdf"]);
    assert_bad_input(&check(&["--urdf", "no/such.urdf"], &["--state", ""]), &["no/such.urdf"]);
    assert_bad_input(&check(&TWO_LINK, &[]), &["--states"]);
    assert_bad_input(&check(&TWO_LINK, &["--state", "joint1"]), &["joint1", "JOINT=NUMBER"]);
    assert_bad_input(&check(&TWO_LINK, &["--state", "joint1=1 joint1=2"]), &["joint1", "twice"]);
    assert_bad_input(&check(&TWO_LINK, &["--state", "elbow=1"]), &["elbow", "joint1"]);
    assert_bad_input(&check(&TWO_LINK, &["--state", "joint 1=1"]), &["'joint'", "--states FILE"]);
    assert_bad_input(&check(&TWO_LINK, &["--state", "", "--limit", "-1"]), &["--limit"]);
    assert_bad_input(&check(&TWO_LINK, &["--state", "", "--padding", "-1"]), &["padding"]);
    assert_bad_input(&check(&TWO_LINK, &["--state", "", "--world", "none.yaml"]), &["none.yaml"]);
    assert_bad_input(&clearance(&["no-such-command"]), &["no-such-command"]);
}

#[test]
fn the_demo_arm_meets_its_world() {
    let world = ["--world", "config/demo_world.yaml", "--format", "json"];
    let home = json(&check(&ARM, &[&world[..], &["--state", "", "--query", "distance"]].concat()));
    assert_eq!(home["results"][0]["free"], true);
    let reaching = "joint1=-0.427 joint2=0.236 joint4=-1.944 joint6=2.18 finger_joint1=0.02";
    let hit = json(&check(&ARM, &[&world[..], &["--state", reaching, "--query", "pairs"]].concat()));
    assert_eq!(hit["results"][0]["world_collision"], true, "{hit}");
    let alone = json(&check(&ARM, &[&world[..], &["--state", reaching, "--no-world"]].concat()));
    assert_eq!(alone["results"][0]["world_collision"], false);
    let padded = [&world[..], &["--state", "", "--padding", "0.5"]].concat();
    assert_eq!(json(&check(&ARM, &padded))["results"][0]["world_collision"], true);
    assert_eq!(
        json(&check(&ARM, &padded))["results"][0]["self_collision"],
        false,
        "padding counts against the world"
    );
}

#[test]
fn dual_arm_finds_its_packages_beside_it() {
    let output = check(
        &["--urdf", "urdf/dual_arm/dual_arm.urdf", "--srdf", "urdf/dual_arm/dual_arm.srdf"],
        &["--state", "", "--format", "json"],
    );
    assert_eq!(json(&output)["results"][0]["free"], true, "{output:?}");
}

/// What touches is within any limit, and what overflows is refused.
#[test]
fn limits_of_zero_and_endless_joints() {
    let touching = ["--state", "joint2=3.141592653589793", "--limit", "0", "--format", "json"];
    for query in ["distance", "pair-distances"] {
        let output = check(&TWO_LINK, &[&touching[..], &["--query", query]].concat());
        assert_eq!(json(&output)["results"][0]["free"], false, "{query}");
        assert_eq!(output.status.code(), Some(1));
    }
    for query in [&[][..], &["--query", "free"], &["--query", "pairs"], &["--contacts", "2"]] {
        assert_bad_input(
            &check(&TWO_LINK, &[&touching[..], query].concat()),
            &["--limit", "--query distance"],
        );
    }
    assert_bad_input(&check(&TWO_LINK, &["--state", "joint1=1e300"]), &["joint1", "1e300"]);
    assert_bad_input(&check(&TWO_LINK, &["--state", "", "--threads", "100000"]), &["--threads"]);

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mimic.urdf");
    let joint = |name: &str, child: &str, mimic: &str| {
        format!(
            "<joint name='{name}' type='continuous'><parent link='base'/><child link='{child}'/>\
             <axis xyz='0 0 1'/>{mimic}</joint>"
        )
    };
    let urdf = format!(
        "<robot name='r'><link name='base'/><link name='a'/><link name='b'/>{}{}</robot>",
        joint("j", "a", ""),
        joint("k", "b", "<mimic joint='j' multiplier='1e300'/>")
    );
    std::fs::write(&path, urdf).unwrap();
    let model = ["--urdf", path.to_str().unwrap()];
    assert_bad_input(&check(&model, &["--state", "j=1e5"]), &["'k'"]);
    let empty = folder.path().join("empty.csv");
    std::fs::write(&empty, "j\n").unwrap();
    assert_bad_input(&check(&model, &["--states", empty.to_str().unwrap()]), &["no states"]);
}

const BENT_ARM: [&str; 4] = ["--from", "joint4=-1.6", "--to", "joint4=-2.2"];

/// The least distance of a motion is bounded, and the motion reaches no margin below the lower bound.
#[test]
fn motions_have_least_distances_and_margins() {
    let motion = |more: &[&str]| clearance(&[&["motion"], &ARM[..], &BENT_ARM, more].concat());
    let found = json(&motion(&["--clearance", "--format", "json"]));
    let least = &found["results"][0]["clearance"];
    let [lower, upper] = ["lower", "upper"].map(|bound| least["self"][bound].as_f64().unwrap());
    assert!(0.0 < lower && lower <= upper && upper - lower < 1.001e-3, "{least}");
    assert!(least["world"].is_null() && least.get("reason").is_none(), "{least}");
    let verdict = |margin: f64| {
        let output = motion(&["--margin", &margin.to_string(), "--format", "json"]);
        json(&output)["results"][0]["verdict"].as_str().unwrap().to_owned()
    };
    assert_eq!(verdict(lower - 1e-3), "free");
    assert_eq!(verdict(upper + 1e-3), "within_margin");
    assert_bad_input(&motion(&["--margin", "-1"]), &["--margin", "-1"]);
}
