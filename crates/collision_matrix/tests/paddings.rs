//! Tests of padded links: the distances of decisions have the paddings subtracted.

use std::sync::Arc;

use clearance_collision_matrix::{DecidedPair, Decision, MatrixBuilder, MatrixOptions};
use clearance_robot::{MeshFiles, RobotModel};
use clearance_scene::Settings;

/// `slider` is 0.3 m to 1.3 m from `base`; `post` is fixed 0.8 m from it.
fn robot() -> Arc<RobotModel> {
    let link = |name: &str| {
        format!(
            "<link name='{name}'><collision><geometry><sphere radius='0.1'/></geometry></collision></link>"
        )
    };
    let joint = |child: &str, kind: &str, at: &str| {
        format!(
            "<joint name='j_{child}' type='{kind}'><origin xyz='{at}'/><parent link='base'/><child link='{child}'/>
            <axis xyz='1 0 0'/><limit lower='0' upper='1' effort='1' velocity='1'/></joint>"
        )
    };
    let links = ["base", "slider", "post"].map(link).concat();
    let joints = joint("slider", "prismatic", "0.5 0 0") + &joint("post", "fixed", "0 1 0");
    let text = format!("<robot name='r'>{links}{joints}</robot>");
    Arc::new(RobotModel::from_urdf(&text, &MeshFiles::default()).unwrap())
}

fn decide(settings: &Settings, options: &MatrixOptions) -> Vec<DecidedPair> {
    MatrixBuilder::new(&robot(), settings).unwrap().decide(&[], options, &|_| ())
}

/// Name of the decision about a pair, and its least distance (m).
fn nearest(pairs: &[DecidedPair], link1: &str, link2: &str) -> (&'static str, f64) {
    let pair = pairs.iter().find(|pair| pair.is_of(link1, link2)).unwrap();
    match &pair.decision {
        Decision::Never { least_distance, .. } | Decision::Undecided { least_distance, .. } => {
            (pair.decision.name(), least_distance.unwrap())
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn paddings_are_subtracted_from_the_least_distance() {
    let settings = |padding, pad_self| Settings { padding, pad_self, ..Settings::default() };
    let of_post = Settings { link_padding: [("post".to_owned(), 0.2)].into(), ..settings(0.1, true) };
    let undecided = MatrixOptions { most_boxes: 0, ..MatrixOptions::default() };
    let cases = [
        (settings(0.0, true), [0.3, 0.8]),
        (settings(0.1, true), [0.1, 0.6]),
        (settings(0.1499, true), [0.0002, 0.5002]),
        (settings(0.1, false), [0.3, 0.8]),
        (of_post, [0.1, 0.5]),
    ];
    for (settings, [of_slider, of_post]) in cases {
        for (options, name) in [(MatrixOptions::default(), "never"), (undecided.clone(), "undecided")] {
            let pairs = decide(&settings, &options);
            let (decision, distance) = nearest(&pairs, "base", "slider");
            assert!(decision == name && (distance - of_slider).abs() < 1e-6, "{settings:?}: {distance}");
            // links that are fixed to each other need no search
            let (decision, distance) = nearest(&pairs, "base", "post");
            assert!(decision == "never" && (distance - of_post).abs() < 1e-6, "{settings:?}: {distance}");
        }
    }
}

#[test]
fn the_least_distance_is_zero_where_the_paddings_touch() {
    let settings = Settings { padding: 0.9, pad_self: true, ..Settings::default() };
    let undecided = MatrixOptions { most_boxes: 0, ..MatrixOptions::default() };
    assert_eq!(nearest(&decide(&settings, &undecided), "base", "slider"), ("undecided", 0.0));
}
