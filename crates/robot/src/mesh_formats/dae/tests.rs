//! Tests of the COLLADA reader: units, transforms, polygons, references, skins, broken files and endless instances.

use clearance_geometry::math::{Point, Vector};
use proptest::prelude::*;

use super::*;

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

fn surface(read: &ReadMesh) -> (&[Point], &[[u32; 3]]) {
    (read.mesh.vertices(), read.mesh.triangles())
}

fn fault(text: &str) -> String {
    read(text).unwrap_err()
}

#[test]
fn the_unit_counts_and_the_up_axis_is_reported() {
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
fn a_lying_count_is_reported() {
    let lie = TRIANGLES.replace("count=\"2\"", "count=\"1000000\"");
    let read = read(&file("", &lie, NODE)).unwrap();
    assert_eq!(read.mesh.triangles().len(), 2);
    assert!(read.remarks[0].contains("1000000"), "{:?}", read.remarks);
}

/// Comments between the words of a text change nothing; an element inside a text is an error.
#[test]
fn text_goes_on_behind_comments_instructions_and_sections() {
    let input = r##"<input semantic="VERTEX" source="#v" offset="0"/>"##;
    let primitive = format!("<polylist count='2'>{input}<vcount>3 3</vcount><p>0 1 2 0 2 3</p></polylist>");
    let node = "<node><matrix>2 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1</matrix><translate>1 2 3</translate><scale>1 2 1</scale>\
                <rotate>0 0 1 90</rotate><instance_geometry url='#g'/></node>";
    let good = file("<up_axis> Y_UP </up_axis>", &primitive, node);
    let expected = read(&good).unwrap();
    for name in ["float_array", "vcount", "p", "matrix", "translate", "scale", "rotate", "up_axis"] {
        let tag = good.find(&format!("<{name}>")).or_else(|| good.find(&format!("<{name} "))).unwrap();
        let start = tag + good[tag..].find('>').unwrap() + 1;
        let end = start + good[start..].find('<').unwrap();
        let places = (start..=end).filter(|&at| at == start || at == end || &good[at..=at] == " ");
        for at in places {
            let with = |what: &str| format!("{}{what}{}", &good[..at], &good[at..]);
            for what in ["<!-- 7 -->", "<?x 7?>", "<![CDATA[ ]]>"] {
                let found = read(&with(what)).unwrap_or_else(|e| panic!("{name} with {what}: {e}"));
                assert_eq!(surface(&found), surface(&expected), "{name} with {what}");
                assert_eq!(found.remarks, expected.remarks, "{name} with {what}");
            }
            let message = fault(&with("<extra/>"));
            assert!(message.contains(&format!("<{name}>: has an element <extra>")), "{message}");
        }
    }
    let stray = fault(&good.replace("</p>", "</p> 1 2 3 "));
    assert!(stray.contains("text outside of <p>"), "{stray}");
}

/// For elements that COLLADA allows once, a second one is an error, and is not ignored.
#[test]
fn what_may_stand_once_is_rejected_twice() {
    let input = r##"<input semantic="VERTEX" source="#v" offset="0"/>"##;
    let primitive = format!("<polylist count='2'>{input}<vcount>3 3</vcount><p>0 1 2 0 2 3</p></polylist>");
    let good = file("<unit meter='1'/>", &primitive, NODE);
    for element in [
        input,
        "<vcount>3 3</vcount>",
        "<unit meter='1'/>",
        r##"<input semantic="POSITION" source="#s"/>"##,
        r##"<accessor source="#a" count="4" stride="3"/>"##,
        r##"<scene><instance_visual_scene url="#vs"/></scene>"##,
        r##"<instance_visual_scene url="#vs"/>"##,
    ] {
        assert!(good.contains(element), "{element}");
        let message = fault(&good.replace(element, &element.repeat(2)));
        assert!(message.contains("only one"), "{element}: {message}");
    }
    for second in ["<mesh/>", "<convex_mesh/>"] {
        let message = fault(&good.replace("</mesh>", &format!("</mesh>{second}")));
        assert!(message.contains("only one mesh"), "{message}");
    }
    assert!(fault(&good.replace("<mesh>", "<brep/><mesh>")).contains("boundary representations"));
}

/// The names of the accessor's params give the order of the coordinates.
#[test]
fn params_name_the_coordinates() {
    let with = |params: &str, numbers: &str, stride: usize| {
        let good = file("", TRIANGLES, NODE);
        let good = good.replace("-.5 -.5 0 .5 -.5 0 .5 .5 0 -.5 .5 0", numbers);
        let accessor = format!("stride=\"{stride}\">{params}</accessor>");
        read(&good.replace("stride=\"3\"/>", &accessor))
    };
    let p = |name: &str| format!("<param name='{name}' type='float'/>");
    let (x, y, z, none, other) = (p("X"), p("Y"), p("Z"), "<param type='float'/>".to_owned(), p("W"));
    let xyz = "0 0 3 1 0 3 1 2 3 0 2 3";
    let skipped = "9 0 0 3 8 1 0 3 7 1 2 3 6 0 2 3";
    for (params, numbers, stride) in [
        (vec![], xyz, 3),
        (vec![&x, &y, &z], xyz, 3),
        (vec![&p("x"), &p("y"), &p("z")], xyz, 3),
        (vec![&p("A"), &p("B"), &p("C")], xyz, 3),
        (vec![&none, &x, &y, &z], skipped, 4),
        (vec![&p(""), &p("A"), &p("B"), &p("C")], skipped, 4),
        (vec![&other, &x, &y, &z], skipped, 4),
        (vec![&z, &y, &x], "3 0 0 3 0 1 3 2 1 3 2 0", 3),
        (vec![&x, &none, &y, &none, &z], "0 9 0 9 3 1 9 0 9 3 1 9 2 9 3 0 9 2 9 3", 5),
        (vec![&x, &y, &z, &other], "0 0 3 9 1 0 3 9 1 2 3 9 0 2 3 9", 4),
    ] {
        let params = params.into_iter().cloned().collect::<Vec<_>>().concat();
        let read = with(&params, numbers, stride).unwrap_or_else(|e| panic!("{params}: {e}"));
        assert_eq!(read.mesh.bounds(), (Point::new(0.0, 0.0, 3.0), Point::new(1.0, 2.0, 3.0)), "{params}");
        assert!(read.mesh.triangle(0).normal().z > 0.0);
    }
    for (params, words) in [
        (vec![&x, &y], "2 of its params"),
        (vec![&none, &none, &none], "0 of its params"),
        (vec![&x, &x, &y, &z], "X, Y and Z once"),
        (vec![&x, &y, &other], "X, Y and Z once"),
        (vec![&none, &none, &x, &y, &z], "the stride is 4"),
        (vec![&"<param name='X' type='float3'/>".to_owned()], "more than one number"),
    ] {
        let params = params.into_iter().cloned().collect::<Vec<_>>().concat();
        let message = with(&params, skipped, 4).unwrap_err();
        assert!(message.contains(words), "{params}: {message}");
    }
}

/// No part of a primitive is ignored without a remark.
#[test]
fn primitives_without_indices_are_reported() {
    for (primitive, words) in [
        (
            format!(
                "{TRIANGLES}<triangles count='12'><input semantic='VERTEX' source='#v' offset='0'/></triangles>"
            ),
            "12",
        ),
        (format!("{TRIANGLES}<triangles count='12'><p/></triangles>"), "12"),
        (format!("{TRIANGLES}<polylist count='7'/>"), "7"),
        (format!("{TRIANGLES}<tristrips count='7'/>"), "7"),
    ] {
        let read = read(&file("", &primitive, NODE)).unwrap();
        let remark = format!("the count is {words}, but 0 are there");
        assert!(read.remarks.iter().any(|r| r.contains(&remark)), "{:?}", read.remarks);
    }
    let unknown = read(&file("", &format!("{TRIANGLES}<trimesh/>"), NODE)).unwrap();
    assert!(unknown.remarks[0].contains("1 unknown elements of a mesh"), "{:?}", unknown.remarks);
}

#[test]
fn projective_matrices_are_rejected() {
    for row in ["0 0 0 2", "1 1 0 1", "0 0 0 0", "0 0 1e-9 1"] {
        let node = format!(
            "<node><matrix>1 0 0 0 0 1 0 0 0 0 1 0 {row}</matrix><instance_geometry url='#g'/></node>"
        );
        let message = fault(&file("", TRIANGLES, &node));
        assert!(message.contains("<matrix>: the last row"), "{message}");
    }
}

/// A geometry is read once, for any number of instances; a mesh that does not fit in memory is rejected before allocation.
#[test]
fn instances_without_number_end() {
    let good = file("", TRIANGLES, &NODE.repeat(1000));
    assert_eq!(read(&good).unwrap().mesh.triangles().len(), 2000);
    let lists = "<p>0 1 2</p>".repeat(1000);
    let many = format!("<triangles><input semantic='VERTEX' source='#v' offset='0'/>{lists}</triangles>");
    assert!(fault(&file("", &many, &NODE.repeat(20_001))).contains("triangles, instances counted"));
    let extras = format!("<node id='n'>{}</node>", "<extra/>".repeat(1001));
    let nodes = extras + &"<instance_node url='#n'/>".repeat(10_000);
    assert!(fault(&file("", TRIANGLES, &format!("<node>{nodes}</node>"))).contains("10000000 elements"));
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
fn polygons_of_fewer_than_three_corners_are_skipped_and_counted() {
    let input = r##"<input semantic="VERTEX" source="#v" offset="0"/>"##;
    for (primitive, skipped) in [
        (format!("<polylist count='3'>{input}<vcount>4 2 0</vcount><p>0 1 2 3 1 2</p></polylist>"), 2),
        (format!("<polygons count='4'>{input}<p/><p>0 1 2 3</p><p>1</p><p>0 1</p></polygons>"), 3),
        (format!("<polylist count='1'>{input}<vcount/><p/></polylist>{TRIANGLES}"), 0),
        (format!("<triangles count='0'><p/></triangles><triangles/>{TRIANGLES}"), 0),
        (format!("<trifans count='2'>{input}<p>0 1</p><p>0 1 2 3</p></trifans>"), 1),
        (format!("<tristrips count='3'>{input}<p/><p>0 1 3 2</p><p>0 1</p></tristrips>"), 2),
    ] {
        let read = read(&file("", &primitive, NODE)).unwrap();
        assert_eq!(read.mesh.triangles().len(), 2, "{primitive}");
        let told = read.remarks.iter().find(|r| r.contains("fewer than three"));
        let expected = (skipped > 0).then(|| format!("{skipped} polygons of fewer"));
        assert_eq!(told.is_some(), expected.is_some(), "{primitive}: {told:?}");
        assert!(told.zip(expected).is_none_or(|(told, expected)| told.starts_with(&expected)), "{primitive}");
    }
    let only = format!("<polylist count='1'>{input}<vcount>2</vcount><p>0 1</p></polylist>");
    assert!(fault(&file("", &only, NODE)).contains("no triangles"));
}

#[test]
fn lines_splines_and_holes_are_reported() {
    let input = r##"<input semantic="VERTEX" source="#v" offset="0"/>"##;
    let lines = format!("<lines count='1'>{input}<p>0 1</p></lines>{TRIANGLES}");
    let spline = file("", TRIANGLES, &(NODE.to_owned() + r##"<node><instance_geometry url="#sp"/></node>"##));
    let spline =
        spline.replace("</mesh></geometry>", "</mesh></geometry><geometry id='sp'><spline/></geometry>");
    let hole = format!("<polygons count='1'>{input}<ph><p>0 1 2 3</p><h>0 1 2</h></ph></polygons>");
    for (text, words) in [
        (file("", &lines, NODE), "1 lists of lines"),
        (spline, "1 splines"),
        (file("", &hole, NODE), "1 polygons have holes, which are taken as filled, the first at line"),
    ] {
        let read = read(&text).unwrap();
        assert_eq!(read.mesh.triangles().len(), 2);
        assert!(read.remarks[0].starts_with(words), "{:?}", read.remarks);
    }
    let hull = file("", TRIANGLES, NODE).replace("<mesh>", "<convex_mesh convex_hull_of='#g'>");
    assert!(fault(&hull.replace("</mesh>", "</convex_mesh>")).contains("convex_hull_of"));
}

/// Exporters give a node and its geometry, or a source and its array, one id.
#[test]
fn an_id_counts_among_elements_of_one_kind() {
    let good = file("", TRIANGLES, r##"<node id="n"><instance_geometry url="#g"/></node>"##);
    for (id, same) in [("g", "a"), ("n", "g"), ("vs", "g"), ("a", "s"), ("v", "s"), ("lib", "g"), ("n", "a")]
    {
        let text = [("id=\"ID\"", id), ("\"#ID\"", id)].iter().fold(good.clone(), |text, (form, id)| {
            text.replace(&form.replace("ID", id), &form.replace("ID", same))
        });
        let read = read(&text).unwrap_or_else(|e| panic!("{id} as {same}: {e}"));
        assert_eq!(read.mesh.triangles().len(), 2);
    }
    let escaped = good.replace("id=\"g\"", "id=\"g h\"").replace("#g\"", "#g%20h\"");
    assert!(read(&escaped).is_ok());
    let wrong = fault(&good.replace("instance_geometry url=\"#g\"", "instance_geometry url=\"#vs\""));
    assert!(wrong.contains("no <geometry> has the id 'vs'; a <visual_scene> has it"), "{wrong}");
}

#[test]
fn skinned_meshes_are_read_as_they_were_bound() {
    let node = r##"<node><translate>5 0 0</translate><instance_controller url="#k"/></node>"##;
    let skin = |source: &str| {
        format!(
            "<library_controllers><controller id='k'><skin source='{source}'><bind_shape_matrix>2 0 0 1  0 1 0 0  0 0 1 0  \
             0 0 0 1</bind_shape_matrix></skin></controller><controller id='m'><morph source='#g'/></controller>\
             <controller id='l'><skin source='#k'/></controller><controller id='e'/></library_controllers>"
        )
    };
    let of = |source: &str, node: &str| {
        read(&file("", TRIANGLES, node).replace("<library_nodes>", &(skin(source) + "<library_nodes>")))
    };
    for source in ["#g", "#m"] {
        let read = of(source, node).unwrap();
        assert!((read.mesh.bounds().0 - Point::new(5.0, -0.5, 0.0)).norm() < 1e-15);
        assert!((extent(&read) - Vector::new(2.0, 1.0, 0.0)).norm() < 1e-15);
        assert!(read.remarks[0].contains("skinned"), "{:?}", read.remarks);
    }
    assert!(of("#l", node).unwrap_err().contains("without end"));
    let chain = |count: usize| {
        let links = (1..count).map(|i| {
            let below = if i + 1 == count { "g".to_owned() } else { format!("k{}", i + 1) };
            format!("<controller id='k{i}'><skin source='#{below}'/></controller>")
        });
        let controllers = links.collect::<String>();
        let text = file("", TRIANGLES, node).replace("<library_nodes>", &(skin("#k1") + "<library_nodes>"));
        read(&text.replace("<library_controllers>", &format!("<library_controllers>{controllers}")))
    };
    assert_eq!(chain(50).unwrap().mesh.triangles().len(), 2);
    assert!(chain(101).unwrap_err().contains("more than 100 controllers"));
    assert!(of("#none", node).unwrap_err().contains("'none'"));
    assert!(of("#g", &node.replace("#k", "#e")).unwrap_err().contains("neither"));
}

#[test]
fn endless_instances_end() {
    let looped = file("", TRIANGLES, r##"<node id="n"><instance_node url="#n"/></node>"##);
    assert!(fault(&looped).contains("without end"));
    let ten_of = |i: usize| format!("<instance_node url='#n{i}'/>").repeat(10);
    let mut nodes: Vec<_> = (0..30).map(|i| format!("<node id='n{i}'>{}</node>", ten_of(i + 1))).collect();
    nodes.push("<node id='n30'><instance_geometry url='#g'/></node>".to_owned());
    let laughing = nodes.concat();
    assert!(fault(&file("", TRIANGLES, &laughing)).contains("instances counted"));
    let deep = |levels: usize| {
        let chain = (0..levels).map(|i| format!("<node id='n{i}'><instance_node url='#n{}'/></node>", i + 1));
        let end = format!("<node id='n{levels}'><instance_geometry url='#g'/></node>");
        let library = format!("<library_nodes>{}{end}", chain.collect::<String>());
        let shown = file("", TRIANGLES, "<node><instance_node url='#n0'/></node>");
        read(&shown.replace("<library_nodes>", &library))
    };
    assert_eq!(deep(900).unwrap().mesh.triangles().len(), 2);
    let too_deep = deep(1001).unwrap_err();
    assert!(too_deep.contains("more than 1000 levels") && !too_deep.contains("without end"), "{too_deep}");
}

/// Many instances of a small mesh are within the limit of triangles.
#[test]
fn many_small_instances_are_read() {
    let library = format!("<node id='k'>{}</node>", "<instance_node url='#lib'/>".repeat(1000));
    let shown = file("", TRIANGLES, &format!("<node>{}</node>", "<instance_node url='#k'/>".repeat(101)));
    let read = read(&shown.replace("<library_nodes>", &format!("<library_nodes>{library}"))).unwrap();
    assert_eq!(read.mesh.triangles().len(), 202_000);
    let nested = format!("{}{NODE}{}", "<node>".repeat(130), "</node>".repeat(130));
    assert_eq!(self::read(&file("", TRIANGLES, &nested)).unwrap().mesh.triangles().len(), 2);
}

#[test]
fn other_namespaces_are_no_collada() {
    let good = file(
        "<unit meter='1'/>",
        TRIANGLES,
        "<node><translate>1 0 0</translate><instance_geometry url='#g'/></node>",
    );
    let expected = read(&good).unwrap();
    let with = |old: &str, new: &str| {
        assert!(good.contains(old), "{old}");
        good.replacen(old, new, 1).replacen("<COLLADA ", "<COLLADA xmlns:x='urn:x' ", 1)
    };
    for (old, new, words) in [
        ("<unit meter=", "<unit x:meter='0.5' meter=", "attribute 'meter'"),
        ("<unit ", "<x:unit meter='0.5'/><unit ", "<unit>: has another XML namespace than <COLLADA>"),
        ("<instance_geometry url='", "<instance_geometry x:url='#none' url='", "attribute 'url'"),
        ("<geometry id", "<geometry x:id='h' id", "attribute 'id'"),
        ("<geometry id=\"g\"", "<x:geometry id='g'/><geometry id=\"g\"", "<geometry>: has another"),
        ("<float_array id=\"a\" count=", "<float_array id=\"a\" x:count='9' count=", "attribute 'count'"),
        ("semantic=\"VERTEX\"", "x:semantic='NORMAL' semantic=\"VERTEX\"", "attribute 'semantic'"),
        ("stride=\"3\"", "x:stride='4' stride=\"3\"", "attribute 'stride'"),
        ("<translate>", "<x:matrix>none</x:matrix><translate>", "<matrix>: has another"),
        ("<p>", "<x:p>9 9 9</x:p><p>", "<p>: has another"),
        ("<triangles ", "<x:triangles count='1'><p>9 9 9</p></x:triangles><triangles ", "<triangles>: has"),
        ("<mesh>", "<x:brep/><mesh>", "<brep>: has another"),
    ] {
        let text = with(old, new);
        let found = read(&text).unwrap_or_else(|e| panic!("{new}: {e}"));
        assert_eq!(surface(&found), surface(&expected), "{new}");
        assert_eq!(found.remarks.len(), 1, "{new}: {:?}", found.remarks);
        assert!(found.remarks[0].contains(words), "{new}: {:?}", found.remarks);
    }
    // content of other programs, and names that nothing has without prefix
    for (old, new) in [
        ("<translate>", "<extra><technique profile='P'><x:node x:id='g'/></technique></extra><translate>"),
        ("<translate>", "<x:hint><matrix/></x:hint><translate>"),
        ("<node>", "<node x:sid='n'>"),
    ] {
        let found = read(&with(old, new)).unwrap();
        assert_eq!((surface(&found), found.remarks.len()), (surface(&expected), 0), "{new}");
    }
    // the namespace of the outermost element is COLLADA's, whatever it is
    for namespace in ["", "xmlns='http://www.collada.org/2008/03/COLLADASchema'"] {
        let text = good.replace("xmlns=\"http://www.collada.org/2005/11/COLLADASchema\"", namespace);
        let found = read(&text).unwrap();
        assert_eq!((surface(&found), found.remarks.len()), (surface(&expected), 0), "{namespace}");
    }
    let prefixed = good.replace("</", "\0").replace('<', "<c:").replace('\0', "</c:");
    let prefixed = prefixed.replace("<c:?", "<?").replace("xmlns=", "xmlns:c=");
    assert_eq!(surface(&read(&prefixed).unwrap()), surface(&expected));
}

#[test]
fn what_is_skipped_is_reported() {
    let typo = "<node><translation>1 0 0</translation><instance_geometry url='#g'/><extra/></node>";
    let found = read(&file("", TRIANGLES, typo)).unwrap();
    assert_eq!(found.remarks.len(), 1, "{:?}", found.remarks);
    assert!(found.remarks[0].starts_with("1 unknown elements of a node"), "{:?}", found.remarks);
    let good = file("", TRIANGLES, NODE);
    let twice = good.replace(
        "<library_nodes>",
        "<library_geometries><geometry id='g'/></library_geometries>\n<library_nodes>",
    );
    let found = read(&twice).unwrap();
    assert!(found.remarks[0].contains("the same id, the first at line"), "{:?}", found.remarks);
    let found = read(&good.replace("count=\"12\"", "count=\"15\"")).unwrap();
    assert!(
        found.remarks[0].contains("<float_array>: the count is 15, but 12 are there"),
        "{:?}",
        found.remarks
    );
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
