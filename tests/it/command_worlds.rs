//! Tests of `--world` and `--cloud` of the program: scenes, clouds, octrees, and errors in them.

use std::path::Path;

use crate::command_line::{TWO_LINK, assert_bad_input, check, json};

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
