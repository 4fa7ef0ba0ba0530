//! Tests of the direction in which `clearance motion` turns continuous joints.

use std::f64::consts::TAU;

use serde_json::Value;

use crate::program::Folder;

/// A bar of 1 m on a continuous joint; `k`, if any, mimics it.
fn robot(mimic: &str) -> String {
    format!(
        "<robot name='r'><link name='base'/><link name='bar'><collision><origin xyz='0.5 0 0'/><geometry><box size='1 0.05 0.05'/>\
         </geometry></collision></link><joint name='j' type='continuous'><parent link='base'/><child link='bar'/><axis xyz='0 0 1'/></joint>\
         {mimic}</robot>"
    )
}

/// A ball where the bar is at half a turn.
const WORLD: &str = "world:\n  collision_objects:\n    - id: b\n      header: {frame_id: base}\n      \
primitives: [{type: sphere, dimensions: [0.02]}]\n      primitive_poses: [{position: [-0.8, 0, 0], orientation: [0, 0, 0, 1]}]\n";

/// The result of `clearance motion`, and what stderr says.
fn motion(folder: &Folder, arguments: &[&str]) -> (Value, String) {
    let given = ["motion", "--urdf", "r.urdf", "--world", "w.yaml", "--format", "json"];
    let output = folder.run(&[&given[..], arguments].concat());
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {output:?}"));
    (answer["results"][0].clone(), String::from_utf8_lossy(&output.stderr).into_owned())
}

const WAY: [&str; 4] = ["--from", "j=3", "--to", "j=-3"];
const SHORTEST: [&str; 2] = ["--continuous", "shortest"];

#[test]
fn a_way_is_as_given_unless_the_shortest_is_asked_for() {
    let folder = Folder::of(&robot(""), WORLD);
    folder.write("e.json", r#"{"joints": ["j"], "edges": [[[3], [-3]]]}"#);
    let point =
        |q: f64, sec: u32| format!("  - {{positions: [{q}], time_from_start: {{sec: {sec}, nanosec: 0}}}}\n");
    folder.write("t.yaml", &format!("joint_names: [j]\npoints:\n{}{}", point(3.0, 0), point(-3.0, 2)));
    for way in [&WAY[..], &["--edges", "e.json"], &["--trajectory", "t.yaml"]] {
        for as_given in [&[][..], &["--continuous", "as-given"]] {
            let (result, warning) = motion(&folder, &[way, as_given].concat());
            assert_eq!(result["verdict"], "free", "{way:?}");
            assert_eq!(result["turns"], serde_json::json!([{"joint": "j", "from": 3.0, "to": -3.0}]));
            assert!(warning.contains("'j' turns by more than half a turn, from 3 to -3"), "{warning}");
        }
        let (result, warning) = motion(&folder, &[way, &SHORTEST].concat());
        assert_eq!((result["verdict"].as_str(), warning.as_str()), (Some("contact"), ""), "{way:?}");
        let turn = &result["turns"][0];
        assert!((turn["from"].as_f64().unwrap() - (3.0 - TAU)).abs() < 1e-9 && turn["to"] == -3.0, "{turn}");
    }
}

#[test]
fn the_answer_in_words_names_the_way() {
    let folder = Folder::of(&robot(""), WORLD);
    let said = |more: &[&str]| {
        let given = ["motion", "--urdf", "r.urdf", "--world", "w.yaml"];
        String::from_utf8_lossy(&folder.run(&[&given[..], &WAY, more].concat()).stdout).into_owned()
    };
    assert!(said(&[]).contains("turning j from 3 to -3"));
    assert!(said(&SHORTEST).contains("turning j from -3.28"));
}

#[test]
fn the_certificate_holds_the_way_that_was_proven() {
    let folder = Folder::of(&robot(""), WORLD);
    folder.write("w.yaml", &WORLD.replace("-0.8", "0.8"));
    let (result, _) = motion(&folder, &[&WAY[..], &SHORTEST, &["--certificate", "c.json"]].concat());
    assert_eq!(result["verdict"], "free");
    let verified = folder.run(&["verify", "--urdf", "r.urdf", "--world", "w.yaml", "c.json"]);
    let words = String::from_utf8_lossy(&verified.stdout);
    assert!(
        verified.status.success()
            && words.contains("from        j=-3.28")
            && words.contains("to          j=-3.0\n"),
        "{words}"
    );
    assert_eq!(motion(&folder, &WAY).0["verdict"], "contact");
}

#[test]
fn a_mimic_joint_that_would_be_elsewhere_is_named() {
    let folder = Folder::of(&robot(""), WORLD);
    let mimic = |kind: &str, multiplier: &str| {
        format!(
            "<link name='flag'/><joint name='k' type='{kind}'><parent link='base'/><child link='flag'/><axis xyz='0 0 1'/>\
             <limit lower='-9' upper='9' effort='1' velocity='1'/><mimic joint='j' multiplier='{multiplier}'/></joint>"
        )
    };
    for (kind, multiplier) in [("continuous", "0.5"), ("revolute", "1"), ("prismatic", "0.1")] {
        folder.write("r.urdf", &robot(&mimic(kind, multiplier)));
        let output = folder.run(&[&["motion", "--urdf", "r.urdf"], &WAY[..], &SHORTEST].concat());
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains("'j'") && message.contains("'k'"), "{message}");
        // within half a turn there is nothing to take off
        assert!(
            folder
                .run(&[
                    "motion",
                    "--urdf",
                    "r.urdf",
                    "--from",
                    "j=1",
                    "--to",
                    "j=2",
                    SHORTEST[0],
                    SHORTEST[1]
                ])
                .status
                .success()
        );
    }
    for (kind, multiplier) in [("continuous", "-2"), ("revolute", "0")] {
        folder.write("r.urdf", &robot(&mimic(kind, multiplier)));
        assert_eq!(motion(&folder, &[&WAY[..], &SHORTEST].concat()).0["verdict"], "contact");
    }
}
