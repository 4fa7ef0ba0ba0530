//! Test of the command `clearance check --gradient`.

use serde_json::Value;

use crate::command_line::{TWO_LINK, assert_bad_input, check, json};

/// Rows of the gradient are in the order of the joints, and of the pairs; they equal differences of distances.
#[test]
fn gradient_of_pair_distances() {
    let answer = |joints: [f64; 2]| {
        let state = format!("joint1={} joint2={}", joints[0], joints[1]);
        let words = ["--state", &state, "--format", "json", "--query", "pair-distances", "--gradient"];
        json(&check(&TWO_LINK, &words))["results"][0].clone()
    };
    // the rod is nearest to an edge of the base
    let joints = [0.1, 2.3];
    let result = answer(joints);
    let number = |value: &Value| value.as_f64().unwrap();
    let distance = number(&result["pair_distances"][0][2]);
    assert_eq!(number(&result["signed_distances"][0]), distance);
    assert_eq!(result["signed_distance_bounds"][0], serde_json::json!([distance, distance]));
    assert_eq!(result["witness_counts"], serde_json::json!(["one"]));
    let row = result["gradient"][0].as_array().unwrap();
    assert_eq!((row.len(), result["gradient"].as_array().unwrap().len()), (2, 1));
    let step = 1e-4;
    for joint in 0..2 {
        let [after, before] = [step, -step].map(|step| {
            let mut moved = joints;
            moved[joint] += step;
            number(&answer(moved)["pair_distances"][0][2])
        });
        let difference = (after - before) / (2.0 * step);
        assert!(difference.abs() > 1e-3 && (number(&row[joint]) - difference).abs() < 1e-6);
    }
    // from the first name of the pair to the second, as the points
    for k in 0..3 {
        let [p, q] = [0, 1].map(|body| number(&result["pair_witness_points"][0][body][k]));
        assert!((number(&result["normals"][0][k]) - (q - p) / distance).abs() < 1e-9);
    }
    let overlapping = answer([0.0, std::f64::consts::PI]);
    assert!(number(&overlapping["signed_distances"][0]) < 0.0 && overlapping["pair_distances"][0][2] == 0.0);
    let text = check(&TWO_LINK, &["--state", "joint2=2.3", "--query", "pair-distances", "--gradient"]);
    assert!(String::from_utf8_lossy(&text.stdout).contains(" m, gradient ["), "{text:?}");
    assert_bad_input(&check(&TWO_LINK, &["--state", "", "--gradient"]), &["--gradient", "pair-distances"]);
}
