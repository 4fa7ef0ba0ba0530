use proptest::prelude::*;

use super::*;
use crate::math::Vector;

/// A square in the plane z = 0 with side 1, centred; `asset`, `primitive` and `node` as given.
fn file(asset: &str, primitive: &str, node: &str) -> String {
    format!(
        r##"<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset>{asset}</asset>
<library_geometries><geometry id="g"><mesh>
<source id="s"><float_array id="a" count="12">-.5 -.5 0 .5 -.5 0 .5 .5 0 -.5 .5 0</float_array>
<technique_common><accessor source="#a" count="4" stride="3"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
{primitive}
</mesh></geometry></library_geometries>
<library_nodes><node id="lib"><instance_geometry url="#g"/></node></library_nodes>
<library_visual_scenes><visual_scene id="vs">{node}</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#vs"/></scene></COLLADA>"##
    )
}

const TRIANGLES: &str = r##"<triangles count="2"><input semantic="VERTEX" source="#v" offset="0"/>
<p>0 1 2 0 2 3</p></triangles>"##;
const NODE: &str = r##"<node><instance_geometry url="#g"/></node>"##;

fn extent(read: &ReadMesh) -> Vector {
    let (lo, hi) = read.mesh.bounds();
    hi - lo
}

fn fault(text: &str) -> String {
    read(text).unwrap_err()
}

#[test]
fn the_unit_counts_and_the_up_axis_is_told() {
    let read = read(&file(r#"<unit meter="0.0254"/><up_axis>Y_UP</up_axis>"#, TRIANGLES, NODE)).unwrap();
    assert!((extent(&read) - Vector::new(0.0254, 0.0254, 0.0)).norm() < 1e-15);
    assert!(read.remarks[0].contains("Y_UP"), "{:?}", read.remarks);
}

#[test]
fn node_transforms_apply_inside_out() {
    let node = r##"<node><translate>5 0 0</translate><node><rotate>0 0 1 90</rotate><scale>2 1 1</scale>
        <instance_node url="#lib"/></node></node>"##;
    let read = read(&file("", TRIANGLES, node)).unwrap();
    assert!((extent(&read) - Vector::new(1.0, 2.0, 0.0)).norm() < 1e-15);
    let (lo, hi) = read.mesh.bounds();
    assert!((nalgebra::center(&lo, &hi) - Point::new(5.0, 0.0, 0.0)).norm() < 1e-15);
}

#[test]
fn a_matrix_that_mirrors_turns_the_winding() {
    let node =
        r##"<node><matrix>-1 0 0 3  0 1 0 0  0 0 1 0  0 0 0 1</matrix><instance_geometry url="#g"/></node>"##;
    let read = read(&file("", TRIANGLES, node)).unwrap();
    assert!(read.mesh.triangle(0).normal().z > 0.0);
    assert!((read.mesh.bounds().0.x - 2.5).abs() < 1e-15);
}

#[test]
fn all_kinds_of_polygons() {
    let input = r##"<input semantic="VERTEX" source="#v" offset="0"/>"##;
    for primitive in [
        format!("<polylist count='1'>{input}<vcount>4</vcount><p>0 1 2 3</p></polylist>"),
        format!("<polygons count='1'>{input}<p>0 1 2 3</p></polygons>"),
        format!("<trifans count='1'>{input}<p>0 1 2 3</p></trifans>"),
        format!("<tristrips count='1'>{input}<p>0 1 3 2</p></tristrips>"),
        format!(
            "<triangles count='2'>{input}<input semantic='NORMAL' source='#n' offset='1'/>
            <p>0 9 1 9 2 9 0 9 2 9 3 9</p></triangles>"
        ),
    ] {
        let read = read(&file("", &primitive, NODE)).unwrap();
        assert_eq!(read.mesh.triangles().len(), 2, "{primitive}");
        for i in 0..2 {
            assert!(read.mesh.triangle(i).normal().z > 0.0, "{primitive}");
        }
        assert!(read.remarks.is_empty(), "{:?}", read.remarks);
    }
}

#[test]
fn a_lying_count_is_told() {
    let lie = TRIANGLES.replace("count=\"2\"", "count=\"1000000\"");
    let read = read(&file("", &lie, NODE)).unwrap();
    assert_eq!(read.mesh.triangles().len(), 2);
    assert!(read.remarks[0].contains("1000000"), "{:?}", read.remarks);
}

#[test]
fn faults_are_named() {
    let good = file("", TRIANGLES, NODE);
    assert!(fault(&good.replace("2 3</p>", "2 99</p>")).contains("vertex 99"));
    assert!(fault(&good.replace("2 3</p>", "2</p>")).contains("no triangles"));
    assert!(fault(&good.replace("#v\"", "#w\"")).contains("'w'"));
    assert!(
        fault(&good.replace("accessor source=\"#a\" count=\"4\"", "accessor source=\"#a\" count=\"5\""))
            .contains("count is 5")
    );
    assert!(fault(&good.replace(".5 .5 0 -.5", ".5 nan 0 -.5")).contains("not finite"));
    assert!(fault(&file("", TRIANGLES, "")).contains("no triangles"));
    assert!(fault(&file("<unit meter='0'/>", TRIANGLES, NODE)).contains("unit"));
    assert!(fault(&good[..good.len() / 2]).contains("XML"));
}

#[test]
fn endless_instances_end() {
    let looped = file("", TRIANGLES, r##"<node id="n"><instance_node url="#n"/></node>"##);
    assert!(fault(&looped).contains("without end"));
    let ten_of = |i: usize| format!("<instance_node url='#n{i}'/>").repeat(10);
    let mut nodes: Vec<_> = (0..30).map(|i| format!("<node id='n{i}'>{}</node>", ten_of(i + 1))).collect();
    nodes.push("<node id='n30'><instance_geometry url='#g'/></node>".to_owned());
    let laughing = nodes.concat();
    assert!(fault(&file("", TRIANGLES, &laughing)).contains("without end"));
}

proptest! {
    #[test]
    fn mutations_never_panic(at in 0usize..1500, byte in 32u8..127, cut in 0usize..1500) {
        let good = file("", TRIANGLES, NODE);
        let mut bytes = good.clone().into_bytes();
        let at = at % bytes.len();
        bytes[at] = byte;
        let _ = read(&String::from_utf8_lossy(&bytes));
        let _ = read(&good[..cut % good.len()]);
    }
}
