//! Test of `clearance check`: distances of the robot from itself and from the world.

use crate::command_line::{TWO_LINK, check, json};

/// The arm is 0.7 m from itself; a ball of 0.1 m hangs beside its tip, whose ball of 0.1 m is at (2, 0, 0).
#[test]
fn distances_of_the_robot_from_itself_and_from_the_world() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ball.yaml");
    let ball = |y: f64| {
        let text = format!(
            "collision_objects:\n- {{id: ball, primitives: [{{type: 2, dimensions: [0.1]}}], \
             primitive_poses: [{{position: {{x: 2.0, y: {y}, z: 0.0}}, orientation: {{w: 1.0}}}}]}}\n"
        );
        std::fs::write(&path, text).unwrap();
        path.display().to_string()
    };
    let result = |y: f64, options: &[&str]| {
        let world = ball(y);
        let arguments = [&["--state", "", "--world", &world, "--format", "json"][..], options].concat();
        json(&check(&TWO_LINK, &arguments))["results"][0].clone()
    };
    let near = |number: &serde_json::Value, expected: f64| (number.as_f64().unwrap() - expected).abs() < 1e-9;
    for query in ["distance", "pair-distances"] {
        let found = result(2.0, &["--query", query]);
        assert!(near(&found["self_distance"], 0.7) && near(&found["world_distance"], 1.8), "{found}");
        assert_eq!(found["self_nearest"], serde_json::json!(["base", "tip"]));
        assert_eq!(found["world_nearest"], serde_json::json!(["ball", "tip"]));
        let [on_ball, on_tip] = [0, 1].map(|i| found["world_witness_points"][i][1].as_f64().unwrap());
        assert!((on_ball - 1.9).abs() < 1e-6 && (on_tip - 0.1).abs() < 1e-6, "{found}");

        let limited = result(2.0, &["--query", query, "--limit", "1"]);
        assert_eq!(limited["self_distance"], found["self_distance"]);
        for field in ["world_distance", "world_nearest", "world_witness_points"] {
            assert!(limited[field].is_null() && limited.get(field).is_some(), "{limited}");
        }
        let touching = result(0.15, &["--query", query]);
        assert_eq!((&touching["world_distance"], &touching["world_collision"]), (&0.0.into(), &true.into()));
        assert_eq!(
            (&touching["self_distance"], &touching["self_collision"]),
            (&found["self_distance"], &false.into())
        );
        for (option, left_out, kept) in [("--no-self", "self", "world"), ("--no-world", "world", "self")] {
            let half = result(2.0, &["--query", query, option]);
            for field in ["distance", "nearest", "witness_points"] {
                assert!(half[format!("{left_out}_{field}")].is_null(), "{half}");
                assert_eq!(half[format!("{kept}_{field}")], found[format!("{kept}_{field}")]);
            }
        }
    }
    let found = result(0.5, &["--query", "distance"]);
    for field in ["distance", "nearest", "witness_points"] {
        assert_eq!(found[field], found[format!("world_{field}")], "the nearer of the two");
    }
    for query in ["free", "pairs"] {
        assert!(result(0.5, &["--query", query]).get("self_distance").is_none());
    }

    let world = ball(2.0);
    let text = |query: &str, options: &[&str]| {
        let arguments = [&["--state", "", "--world", &world, "--query", query][..], options].concat();
        String::from_utf8(check(&TWO_LINK, &arguments).stdout).unwrap()
    };
    let expected = "state 0: free, least distance 0.700000 m: base – tip\n  self:  0.700000 m: base – tip\n  \
                    world: 1.800000 m: ball – tip\n";
    assert!(text("distance", &[]).starts_with(expected), "{}", text("distance", &[]));
    let limited = text("pair-distances", &["--limit", "1"]);
    let expected = "state 0: free\n  self:  0.700000 m: base – tip\n  world: nothing within the limit\n  0.700000 m: base";
    assert!(limited.starts_with(expected), "{limited}");
    assert!(!text("distance", &["--no-world"]).contains("world"));
}
