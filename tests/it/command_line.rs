//! The program from outside: exit codes, JSON, messages.

use std::path::Path;
use std::process::Output;

use serde_json::Value;

use crate::program::clearance;

const ARM: [&str; 4] = ["--urdf", "urdf/demo_arm/demo_arm.urdf", "--srdf", "urdf/demo_arm/demo_arm.srdf"];
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
fn scene_faults_name_object_and_field() {
    let folder = tempfile::tempdir().unwrap();
    let cases = [
        (
            "world: {collision_objects: [{id: o, primitives: [{type: box, dimensions: [1, 2]}]}]}",
            vec!["'o'", "primitives[0]", "dimensions"],
        ),
        (
            "world: {collision_objects: [{id: o, primitives: [{type: prism, dimensions: [1, 2]}]}]}",
            vec!["'o'", "prism"],
        ),
        ("world: {collision_objects: [{id: o, planes: [{coef: [0, 0, 0, 1]}]}]}", vec!["'o'", "planes[0]"]),
        (
            "world: {collision_objects: [{id: o, header: {frame_id: odom}, primitives: [{type: sphere, dimensions: [1]}]}]}",
            vec!["'o'", "odom", "base"],
        ),
        (
            "world: {collision_objects: [{id: o, primitives: [{type: sphere, dimensions: [-1]}]}]}",
            vec!["'o'", "radius", "-1"],
        ),
        (
            "world: {collision_objects: [{id: o, primitives: [{type: sphere, dimensions: [.nan]}]}]}",
            vec!["'o'", "radius"],
        ),
        ("world: {collision_objects: [{id: o, operation: move}]}", vec!["'o'", "operation"]),
        (
            "world: {collision_objects: [{id: o, meshes: [{resource: 'http://x/y.stl'}]}]}",
            vec!["'o'", "http"],
        ),
        ("world: {collision_objects: [{id: o}, {id: o}]}", vec!["'o'", "no shapes"]),
        (
            "robot_state: {attached_collision_objects: [{}]}\nworld: {}",
            vec!["attached_collision_objects[0]", "id"],
        ),
        ("world: {colision_objects: []}", vec!["colision_objects", "collision_objects"]),
        ("world: {collision_objects: [{id: o, primitive_pose: []}]}", vec!["primitive_pose"]),
        (
            "world: {collision_objects: [{id: o, meshes: [{resource: a.stl, vertices: [[0, 0, 0]]}]}]}",
            vec!["'o'", "not both"],
        ),
        (
            "world: {collision_objects: [{id: o, meshes: [{dimensions: [1, 1, 1]}]}]}",
            vec!["'o'", "dimensions"],
        ),
        ("link_padding: [{link_name: nose, padding: 0.1}]\nworld: {}", vec!["link_padding", "nose"]),
        ("colour: blue", vec!["colour"]),
        ("world: [", vec!["world.yaml"]),
    ];
    for (text, words) in cases {
        let path = folder.path().join("world.yaml");
        std::fs::write(&path, text).unwrap();
        let world = path.display().to_string();
        assert_bad_input(&check(&TWO_LINK, &["--state", "", "--world", &world]), &words);
    }
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

/// The long form of messages in YAML, as `ros2 topic echo` prints it.
#[test]
fn scenes_in_the_long_form_of_messages_load() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("world.yaml");
    let text = "
name: ''
world:
  collision_objects:
  - header: {stamp: {sec: 0, nanosec: 0}, frame_id: base}
    pose: {position: {x: 1.0, y: 0.0, z: 0.0}, orientation: {x: 0.0, y: 0.0, z: 0.0, w: 1.0}}
    id: ball
    primitives:
    - {type: 2, dimensions: [0.1], polygon: {points: []}}
    primitive_poses:
    - position: {x: 1.0, y: 0.5, z: 0.0}
      orientation: {x: 0.0, y: 0.0, z: 0.0, w: 1.0}
    meshes:
    - triangles: [{vertex_indices: [0, 1, 2]}]
      vertices: [{x: 9.0, y: 0.0, z: 0.0}, {x: 9.0, y: 1.0, z: 0.0}, {x: 9.0, y: 0.0, z: 1.0}]
    mesh_poses:
    - position: {x: 0.0, y: 0.0, z: 0.0}
      orientation: {x: 0.0, y: 0.0, z: 0.0, w: 0.0}
    operation: 0
";
    std::fs::write(&path, text).unwrap();
    let world = path.display().to_string();
    let arguments = ["--state", "", "--world", &world, "--format", "json", "--query", "distance"];
    let answer = json(&check(&TWO_LINK, &arguments));
    // the tip's ball at (2, 0, 0) has radius 0.1, the obstacle at (2, 0.5, 0) too
    let distance = answer["results"][0]["distance"].as_f64().unwrap();
    assert!((distance - 0.3).abs() < 1e-9, "{answer}");
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

/// The native scenes of MoveIt load as they are.
#[test]
fn native_moveit_scenes_load() {
    let Some(scenes) = crate::tally::shared_folder("scenes/native") else { return };
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/robots");
    let at = |name: &str| robots.join(name).display().to_string();
    let (urdf, srdf) = (
        at("moveit_resources_panda_description/urdf/panda.urdf"),
        at("moveit_resources_panda_description/srdf/panda.srdf"),
    );
    let mut tried = 0;
    for entry in std::fs::read_dir(scenes).unwrap() {
        let path = entry.unwrap().path().display().to_string();
        if !path.contains("-scene") {
            continue;
        }
        let model = ["--urdf", &urdf, "--srdf", &srdf, "--package-path", &at("")];
        let output = check(&model, &["--state", "", "--world", &path, "--format", "json"]);
        assert!(json(&output)["pairs_checked"].as_u64().unwrap() > 30, "{output:?}");
        tried += 1;
    }
    assert_eq!(tried, 3);
}

/// A file of that name and content, and its path.
fn file(folder: &tempfile::TempDir, name: &str, content: impl AsRef<[u8]>) -> String {
    let path = folder.path().join(name);
    std::fs::write(&path, content).unwrap();
    path.display().to_string()
}

/// The two-link arm's tip is a ball of 0.1 m at (2, 0, 0).
fn distance(world: &[&str]) -> f64 {
    let arguments = ["--state", "", "--no-self", "--format", "json", "--query", "distance"];
    let answer = json(&check(&TWO_LINK, &[&arguments[..], world].concat()));
    answer["results"][0]["distance"].as_f64().unwrap_or_else(|| panic!("{answer}"))
}

#[test]
fn worlds_of_all_kinds_take_part() {
    let folder = tempfile::tempdir().unwrap();
    let near =
        |found: f64, wanted: f64| assert!((found - wanted).abs() < 1e-6, "{found} instead of {wanted}");

    let scene = file(&folder, "old.scene", "s\n* o\n1\nsphere\n0.1\n2 0.5 0\n0 0 0 1\n0 0 0 0\n.\n");
    near(distance(&["--world", &scene]), 0.3);
    let newer = "s\n* o\n2 0 0\n0 0 0 1\n1\nsphere\n0.1\n0 0.5 0\n0 0 0 1\n0 0 0 0\n0\n.\n";
    // by what it holds
    near(distance(&["--world", &file(&folder, "new.txt", newer)]), 0.3);

    let points = "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 2\nDATA ascii\n9 9 9\n2 0.5 0\n";
    let cloud = file(&folder, "scan.pcd", points);
    near(distance(&["--cloud", &cloud, "--point-radius", "0.05"]), 0.35);
    near(distance(&["--world", &cloud, "--point-radius", "0.1"]), 0.3);
    let ply = "ply\nformat ascii 1.0\nelement vertex 1\nproperty double y\nproperty float x\nproperty float z\n\
               end_header\n0.4 2 0\n";
    let ply = file(&folder, "scan2.ply", ply);
    near(distance(&["--cloud", &cloud, "--cloud", &ply, "--point-radius", "0.05"]), 0.25);

    // one occupied cell of a metre from (2, 1, 0) to (3, 2, 1), one free cell beside it
    let octomap = file(&folder, "map.bt", octomap());
    near(distance(&["--world", &octomap]), 0.9);
    let unknown = ["--world", octomap.as_str(), "--unknown-space", "occupied"];
    near(distance(&[&unknown[..], &["--world", &scene]].concat()), 0.0);
}

/// Where cells of a metre are occupied at (2, 1, 0) and free at (2, 0, 2): the box around both is 1 by 2 by 3 m.
fn octomap() -> Vec<u8> {
    // from the root's octant 7 down to cells of a metre around the origin's corner
    let child = |index: u32, code: u16| code << (2 * index);
    let mut words = vec![child(7, 3)];
    words.extend(std::iter::repeat_n(child(0, 3), 13));
    // a cube of four metres: octants at x = 2, z = 0 and at x = 2, z = 2
    words.extend([child(1, 3) | child(5, 3), child(2, 2), child(0, 1)]);
    let header = format!("# Octomap OcTree binary file\nid OcTree\nsize {}\nres 1\ndata\n", 1 + 14 + 2 + 2);
    let tree = words.iter().flat_map(|word| word.to_le_bytes());
    header.into_bytes().into_iter().chain(tree).collect()
}

#[test]
fn faults_of_clouds_and_octrees_name_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let points = "FIELDS x y z\nPOINTS 1\nDATA ascii\n1 2 3\n";
    let cloud = file(&folder, "scan.pcd", points);
    let bad = |world: &[&str], words: &[&str]| {
        assert_bad_input(&check(&TWO_LINK, &[&["--state", ""], world].concat()), words);
    };
    bad(&["--cloud", &cloud], &["--point-radius"]);
    bad(&["--point-radius", "0.1"], &["--point-radius has no effect"]);
    bad(
        &["--world", &cloud, "--point-radius", "0.1", "--unknown-space", "occupied"],
        &["--unknown-space occupied has no effect"],
    );
    bad(&["--world", &cloud], &["scan.pcd", "--point-radius"]);
    bad(&["--cloud", &cloud, "--point-radius", "-1"], &["scan.pcd", "radius", "-1"]);
    bad(&["--cloud", &cloud, "--cloud", &cloud, "--point-radius", "1"], &["'scan'", "twice"]);
    let cut = file(&folder, "cut.pcd", &points[..points.len() - 3]);
    bad(&["--cloud", &cut, "--point-radius", "1"], &["cut.pcd", "point 0"]);
    let tip = file(&folder, "tip.pcd", points);
    bad(&["--cloud", &tip, "--point-radius", "1"], &["tip.pcd", "link 'tip'"]);
    let scene = file(&folder, "a.scene", "s\n* o\n1\nsphere\n");
    bad(&["--world", &scene], &["a.scene", "'o'", "radius"]);
    bad(&["--cloud", &scene, "--point-radius", "1"], &["a.scene", "--cloud"]);
    let mut map = octomap();
    map.truncate(map.len() - 1);
    let map = file(&folder, "map.bt", map);
    bad(&["--world", &map], &["map.bt", "byte"]);
    bad(&["--world", &file(&folder, "x.bt", "nothing")], &["x.bt", "octomap"]);
    let whole = file(&folder, "whole.bt", octomap());
    bad(&["--world", &whole, "--world", &whole], &["whole.bt", "second octomap"]);
}

#[test]
fn padding_of_scene_files_counts() {
    let folder = tempfile::tempdir().unwrap();
    let text = "link_padding: [{link_name: tip, padding: 0.2}, {link_name: base, padding: 0}]\n\
                world: {collision_objects: [{id: o, pose: {position: [2, 0.5, 0]}, primitives: [{type: sphere, dimensions: [0.1]}]}]}\n";
    let world = file(&folder, "padded.yaml", text);
    let free = |padding: &[&str]| {
        let arguments = ["--state", "", "--no-self", "--world", &world, "--format", "json"];
        json(&check(&TWO_LINK, &[&arguments[..], padding].concat()))["results"][0]["free"].as_bool().unwrap()
    };
    assert!(free(&[]));
    let text = std::fs::read_to_string(&world).unwrap().replace("padding: 0.2", "padding: 0.31");
    std::fs::write(&world, &text).unwrap();
    assert!(!free(&[]));
    // the larger one counts
    std::fs::write(&world, text.replace("padding: 0.31", "padding: 0.01")).unwrap();
    assert!(free(&["--padding", "0.2"]) && !free(&["--padding", "0.31"]));
    // the tip's ball of 0.1 m becomes one of 0.41 m
    std::fs::write(
        &world,
        text.replace("link_padding", "link_scale")
            .replace("padding: 0.31", "scale: 4.1")
            .replace("padding: 0}", "scale: 1}"),
    )
    .unwrap();
    assert!(!free(&[]));
}

#[test]
fn attached_objects_of_scene_files_move_with_their_link() {
    let folder = tempfile::tempdir().unwrap();
    let text = "robot_state: {attached_collision_objects: [{link_name: tip, touch_links: [upper], object: {id: rod,
        header: {frame_id: tip}, primitives: [{type: box, dimensions: [1, 0.02, 0.02]}], primitive_poses: [{position: [1.5, 0, 0]}]}}]}
world: {collision_objects: [{id: o, pose: {position: [2.8, 0, 0]}, primitives: [{type: sphere, dimensions: [0.1]}]}]}
";
    let world = file(&folder, "held.yaml", text);
    let pairs = |state: &str| {
        let arguments = ["--state", state, "--world", &world, "--format", "json", "--query", "pairs"];
        json(&check(&TWO_LINK, &arguments))["results"][0]["pairs"].clone()
    };
    assert_eq!(pairs(""), serde_json::json!([["o", "rod"]]));
    assert_eq!(pairs("joint1=1.5"), serde_json::json!([]));
    // folded back, the rod lies on the upper link, which may touch it, and on the base, which may not
    let folded = pairs("joint2=3.141592653589793");
    assert!(folded.as_array().unwrap().contains(&serde_json::json!(["base", "rod"])), "{folded}");
    assert!(!folded.as_array().unwrap().contains(&serde_json::json!(["rod", "upper"])), "{folded}");
}

#[test]
fn bench_reports_costs_of_checks_and_compares_broad_phases() {
    let few = ["--states", "20", "--format", "json"];
    let bench = |arguments: &[&str]| json(&clearance(&[&["bench"], &ARM[..], &few, arguments].concat()));
    let answer = bench(&["--obstacles", "5,50"]);
    let worlds = answer["worlds"].as_array().unwrap();
    let counts: Vec<_> = worlds.iter().map(|world| world["obstacles"].as_u64().unwrap()).collect();
    assert_eq!(counts, [5, 50]);
    for world in worlds {
        let names = world["broad_phases"].as_array().unwrap().iter().map(|b| b["name"].as_str().unwrap());
        assert_eq!(
            names.collect::<Vec<_>>(),
            ["tree", "sweep and prune", "hash grid", "loose octree", "k-d tree"]
        );
        assert!(world["boolean_us"].as_f64().unwrap() > 0.0);
    }
    let given = bench(&["--world", "config/demo_world.yaml"]);
    assert_eq!(given["worlds"].as_array().unwrap().len(), 1);
    let text = clearance(&[&["bench"], &ARM[..], &["--states", "5", "--obstacles", "3"]].concat());
    assert!(String::from_utf8_lossy(&text.stdout).contains("sweep and prune"), "{text:?}");
    let bad = clearance(&[&["bench"], &ARM[..], &["--obstacles", "0"]].concat());
    assert_bad_input(&bad, &["--obstacles", "0"]);
}

/// Every kind of volume has the same results, which the command checks; counts and times are those of real work.
#[test]
fn bench_compares_kinds_of_volumes() {
    let volumes = ["bench", "--states", "8", "--compare-volumes"];
    let answer = json(&clearance(&[&volumes[..], &ARM, &["--format", "json"]].concat()));
    let costs = answer["costs"].as_array().unwrap();
    let of = |query: &'static str| costs.iter().filter(move |cost| cost["query"] == query);
    for query in ["free", "least distance", "distance of each pair"] {
        let kinds: Vec<_> = of(query).map(|cost| cost["kind"].as_str().unwrap()).collect();
        assert_eq!(kinds, ["obb", "rss", "lss", "pss", "aabb", "kdop18", "kios"]);
        for cost in of(query) {
            let number = |key: &str| cost[key].as_f64().unwrap_or(f64::NAN);
            assert!(number("volume_tests") > 0.0 && number("query_us") > 0.0, "{cost}");
            assert!(number("volume_test_ns") >= 0.0 && number("primitive_test_ns") >= 0.0, "{cost}");
        }
    }
    assert!(of("free").all(|cost| cost["kind"] != "obb" || cost["relative_time"] == 1.0));
    let tests =
        |kind| of("least distance").find(|cost| cost["kind"] == kind).unwrap()["volume_tests"].as_f64();
    assert!(tests("pss") > tests("obb"));
    let text = clearance(&[&volumes[..], &ARM, &["--world", "config/demo_world.yaml"]].concat());
    assert!(String::from_utf8_lossy(&text.stdout).contains("C_bv (ns)"), "{text:?}");
    let both = clearance(&[&volumes[..], &ARM, &["--volumes", "rss"]].concat());
    assert_bad_input(&both, &["--compare-volumes", "--volumes"]);
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
