//! Tests of the reader of MoveIt's `.scene` text: both dialects, faults, cut and altered files.

use clearance_geometry::Primitive;
use proptest::prelude::*;

use super::*;
use crate::testing::robot;

fn read(text: &str) -> Result<SceneLoader, SceneError> {
    let mut scene = SceneLoader::default();
    scene.read_scene_text(text, "a.scene", &robot()).map(|()| scene)
}

/// A scene with all kinds of shapes, as `MoveIt` writes it: with object pose and subframes in the newer format.
fn scene(newer: bool) -> String {
    let pose = |words: &'static str| if newer { words } else { "" };
    format!(
        "(noname)+\n* table top\n{}3\nbox\n1 2 0.5\n0 0 0.25\n0 0 0 1\n0 0 0 0\ncylinder\n0.1 2\n1 0 0\n0 0 0 1\n0.5 0.5 0.5 1\n\
         cone\n0.2 1\n0 1 0\n0 0 0 1\n0 0 0 0\n{}* floor\n{}2\nplane\n0 0 2 1\n0 0 0\n0 0 0 1\n0 0 0 0\n\
         mesh\n3 1\n0 0 0\n1 0 0\n0 1 0\n0 1 2\n0 0 3\n0 0 0 1\n0 0 0 0\n{}.\n",
        pose("1 1 1\n0 0 0.7071067811865476 0.7071067811865476\n"),
        pose("1\ncorner\n0 0 1\n0 0 0 1\n"),
        pose("0 0 0\n0 0 0 1\n"),
        pose("0\n"),
    )
}

#[test]
fn both_dialects_are_distinguished_by_the_line_after_the_first_id() {
    for newer in [false, true] {
        let read = read(&scene(newer)).unwrap();
        let table = read.scene.world.obstacle_by_name("table top").unwrap();
        let kinds: Vec<_> =
            read.scene.world.obstacles().flat_map(|o| o.shapes.iter()).map(|s| s.shape.kind()).collect();
        assert_eq!(kinds, ["box", "cylinder", "cone", "plane", "mesh"]);
        let Shape::Primitive(cylinder) = table.shapes[1].shape else { panic!("no primitive") };
        assert_eq!(cylinder, Primitive::cylinder(0.1, 2.0).unwrap());
        let (pose, _) = table.placed_shapes().nth(1).unwrap();
        let wanted = if newer { [1.0, 2.0, 1.0] } else { [1.0, 0.0, 0.0] };
        assert!(
            (pose.translation.vector - clearance_geometry::math::Vector::from(wanted)).norm() < 1e-12,
            "{pose}"
        );
        assert_eq!(table.subframes.len(), usize::from(newer));
        assert!(read.warnings.is_empty(), "{:?}", read.warnings);
    }
}

#[test]
fn faults_name_object_and_line() {
    for (text, words) in [
        ("s\n* o\n1\nbox\n1 2\n", vec!["'o'", "line 5", "size"]),
        ("s\n* o\n1\nbox\n1 2 x\n", vec!["'o'", "line 5", "'x'"]),
        ("s\n* o\n1\nbox\n1 2 -3\n0 0 0\n0 0 0 1\n0 0 0 0\n.\n", vec!["'o'", "shape 0", "-3"]),
        ("s\n* o\n1\nbox\n1 2 nan\n0 0 0\n0 0 0 1\n0 0 0 0\n.\n", vec!["'o'", "NaN"]),
        ("s\n* o\n1\nprism\n", vec!["'o'", "'prism'"]),
        ("s\n* o\n1\nsphere\n1\n0 0 inf\n0 0 0 1\n", vec!["'o'", "pose of shape 0", "finite"]),
        (
            "s\n* o\n1\nmesh\n3 1\n0 0 0\n1 0 0\n0 1 0\n0 1 7\n0 0 3\n0 0 0 1\n0 0 0 0\n.\n",
            vec!["'o'", "vertex 7"],
        ),
        ("s\n* o\n1\nmesh\n4000000000 4000000000\n0 0", vec!["'o'", "vertex"]),
        ("s\n* o\n4000000000\n", vec!["'o'", "shape 0"]),
        ("s\n* arm\n1\nsphere\n1\n0 0 0\n0 0 0 1\n0 0 0 0\n.\n", vec!["'arm'", "link"]),
        ("s\n* \n1\nsphere\n1\n0 0 0\n0 0 0 1\n0 0 0 0\n.\n", vec!["id"]),
        ("s\n* <octomap>\n1\nsphere\n1\n0 0 0\n0 0 0 1\n0 0 0 0\n.\n", vec!["octomap"]),
        ("s\n.\n\ns\n* o\n", vec!["line 4", "'s' after the '.'"]),
        ("s\n", vec!["cut"]),
        ("s\nx\n", vec!["line 2", "'*'"]),
        ("", vec!["cut"]),
    ] {
        let error = read(text).unwrap_err().to_string();
        for word in words.into_iter().chain(["a.scene"]) {
            assert!(error.contains(word), "{error} does not name {word}");
        }
    }
}

#[test]
fn what_is_odd_is_reported() {
    let empty = read("s\n.\n\n").unwrap();
    assert!(empty.warnings[0].contains("no objects"));
    let bare = read("s\n* o\n0 0 0\n0 0 0 2\n0\n0\n.\n").unwrap();
    assert!(bare.warnings.iter().any(|w| w.contains("length 2")), "{:?}", bare.warnings);
    assert!(bare.warnings.iter().any(|w| w.contains("'o': no shapes")));
}

#[test]
fn the_format_is_known_by_its_marks() {
    assert!(SceneLoader::is_scene_text(&scene(true)));
    assert!(SceneLoader::is_scene_text("\n* o\n1\n"));
    assert!(SceneLoader::is_scene_text("empty\n.\n"));
    assert!(!SceneLoader::is_scene_text("name: s\nworld: {}\n"));
}

#[test]
fn cut_files_are_rejected() {
    for newer in [false, true] {
        let text = scene(newer);
        for end in 0..text.trim_end().len() {
            assert!(read(&text[..end]).is_err(), "{}", &text[..end]);
        }
    }
}

proptest! {
    #[test]
    fn altered_files_never_panic(newer: bool, flips in prop::collection::vec(any::<(u16, u8)>(), 1..8)) {
        let mut bytes = scene(newer).into_bytes();
        for (at, bits) in flips {
            let at = usize::from(at) % bytes.len();
            bytes[at] ^= bits;
        }
        let _ = read(&String::from_utf8_lossy(&bytes));
    }
}
