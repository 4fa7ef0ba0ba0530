//! Tests of `--mesh solid`: meshes with inconsistent winding contain what is inside; open ones are named.

use std::fmt::Write;
use std::path::Path;
use std::process::Output;

use crate::program::clearance_in;

/// Corners of a cube's faces, seen from outside against the clock.
const QUADS: [[usize; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

/// The facets of a cube with this half edge, inside out if asked.
fn cube(half: f64, middle: f64, inward: bool) -> Vec<[[f64; 3]; 3]> {
    let corner = |i: usize| [0, 1, 2].map(|k| if i >> k & 1 == 0 { -half } else { half } + middle);
    let triangles = QUADS.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
    triangles.map(|[a, b, c]| if inward { [a, c, b] } else { [a, b, c] }.map(corner)).collect()
}

fn write(path: &Path, facets: &[[[f64; 3]; 3]]) {
    let mut text = "solid s\n".to_owned();
    for facet in facets {
        text += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in facet {
            writeln!(text, "vertex {x} {y} {z}").unwrap();
        }
        text += "endloop\nendfacet\n";
    }
    std::fs::write(path, text + "endsolid s\n").unwrap();
}

const URDF: &str = r#"<robot name="r">
  <link name="a"><collision><geometry><mesh filename="large.stl"/></geometry></collision></link>
  <joint name="j" type="prismatic"><parent link="a"/><child link="m"/><axis xyz="1 0 0"/><limit lower="-5" upper="5" effort="1" velocity="1"/></joint>
  <link name="m"/>
  <joint name="k" type="prismatic"><parent link="m"/><child link="b"/><axis xyz="0 1 0"/><limit lower="-5" upper="5" effort="1" velocity="1"/></joint>
  <link name="b"><collision><geometry><mesh filename="small.stl"/></geometry></collision></link>
</robot>"#;

/// Runs the program on a small cube inside a mesh of these facets.
fn clearance(facets: &[[[f64; 3]; 3]], arguments: &[&str]) -> Output {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("r.urdf"), URDF).unwrap();
    write(&folder.path().join("large.stl"), facets);
    write(&folder.path().join("small.stl"), &cube(0.05, 0.0, false));
    clearance_in(folder.path(), arguments)
}

/// Whether the small cube touches, with the warnings.
fn touches(facets: &[[[f64; 3]; 3]]) -> (bool, String) {
    let output = clearance(facets, &["check", "--urdf", "r.urdf", "--mesh", "solid", "--state", ""]);
    let code = output.status.code().unwrap();
    assert!(code < 2, "{output:?}");
    (code == 1, String::from_utf8(output.stderr).unwrap())
}

#[test]
fn whatever_the_winding_what_is_inside_touches() {
    assert_eq!(touches(&cube(0.5, 0.0, false)), (true, String::new()));
    assert_eq!(touches(&cube(0.5, 0.0, true)), (true, String::new()));
    let both = [cube(0.5, 0.0, false), cube(0.5, 0.0, true)].concat();
    let overlapping = [cube(0.5, 0.0, false), cube(0.5, 0.3, true)].concat();
    let mut flipped = cube(0.5, 0.0, false);
    flipped[4].swap(0, 1);
    for (facets, word) in [
        (both, "12 of 24 faces are there in both windings"),
        (overlapping, "1 of 2 closed shells are wound the other way"),
        (flipped, "1 of 12 faces are wound the other way"),
    ] {
        let (touches, warning) = touches(&facets);
        assert!(
            touches && warning.contains("mesh of link 'a' (collision 0): ") && warning.contains(word),
            "{warning}"
        );
    }
}

#[test]
fn what_is_open_or_hollow_is_free_inside_and_named() {
    let (is_touched, warning) = touches(&cube(0.5, 0.0, false)[1..]);
    assert!(!is_touched && warning.contains("not closed, so it stays a surface"), "{warning}");
    let (is_touched, warning) = touches(&[cube(0.5, 0.0, false), cube(0.3, 0.0, true)].concat());
    assert!(!is_touched && warning.contains("1 of 2 closed shells are cavities"), "{warning}");
}

#[test]
fn no_motion_inside_is_proven_and_warnings_are_those_of_check() {
    let both = [cube(0.5, 0.0, false), cube(0.5, 0.0, true)].concat();
    let motion = ["motion", "--urdf", "r.urdf", "--mesh", "solid", "--from", "j=0", "--to", "j=0.1"];
    let output = clearance(&both, &motion);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    assert!(String::from_utf8_lossy(&output.stderr).contains("in both windings"), "{output:?}");
    // as surfaces nothing is to be said
    let surface = ["check", "--urdf", "r.urdf", "--state", ""];
    let output = clearance(&both, &surface);
    assert_eq!((output.status.code(), output.stderr.as_slice()), (Some(0), &b""[..]));
}
