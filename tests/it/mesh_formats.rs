//! Tests of every mesh format, in a link of a URDF and in an object of a world file.

use std::path::Path;
use std::process::Command;

use clearance::robot::MeshFiles;
use nalgebra::Vector3;
use serde_json::{Value, json};

use crate::tally::shared_folder;

/// The corners of a box from (0, 0, 0) to (1, 2, 3), and its sides seen from outside, counter-clockwise.
const CORNERS: [[f32; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 2.0, 0.0],
    [1.0, 2.0, 0.0],
    [0.0, 0.0, 3.0],
    [1.0, 0.0, 3.0],
    [0.0, 2.0, 3.0],
    [1.0, 2.0, 3.0],
];
const SIDES: [[usize; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

fn words<T: ToString>(numbers: impl IntoIterator<Item = T>) -> String {
    numbers.into_iter().map(|n| n.to_string()).collect::<Vec<_>>().join(" ")
}

fn triangles() -> Vec<[usize; 3]> {
    SIDES.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect()
}

fn stl() -> String {
    let facet = |t: &[usize; 3]| {
        let corners: Vec<String> = t.iter().map(|&c| format!("vertex {}", words(CORNERS[c]))).collect();
        format!("facet normal 0 0 0\nouter loop\n{}\nend loop\nend facet\n", corners.join("\n"))
    };
    format!("solid box\n{}end solid box\n", triangles().iter().map(facet).collect::<Vec<_>>().concat())
}

fn obj() -> String {
    let vertices = CORNERS.iter().map(|c| format!("v {}\n", words(*c)));
    let faces = SIDES.iter().map(|s| format!("f {}\n", words(s.map(|i| i + 1))));
    vertices.chain(faces).collect::<Vec<_>>().concat()
}

fn ply() -> String {
    let vertices = CORNERS.iter().map(|c| format!("{}\n", words(*c)));
    let faces = SIDES.iter().map(|s| format!("4 {}\n", words(*s)));
    let head = "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n\
                element face 6\nproperty list uchar int vertex_indices\nend_header\n";
    head.to_owned() + &vertices.chain(faces).collect::<Vec<_>>().concat()
}

fn dae() -> String {
    format!(
        r##"<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset/>
<library_geometries><geometry id="box"><mesh><source id="p"><float_array id="p" count="24">{}</float_array>
<technique_common><accessor source="#p" count="8" stride="3"/></technique_common></source>
<vertices id="box"><input semantic="POSITION" source="#p"/></vertices>
<polylist count="7"><input semantic="VERTEX" source="#box" offset="0"/><vcount>4 4 4 2 4 4 4</vcount><p>{} 0 1 {}</p></polylist>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="box"><node id="box"><instance_geometry url="#box"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#box"/></scene></COLLADA>"##,
        words(CORNERS.concat()),
        words(SIDES[..3].concat()),
        words(SIDES[3..].concat()),
    )
}

fn buffer() -> Vec<u8> {
    let indices: Vec<u8> = triangles().concat().into_iter().map(|i| u8::try_from(i).unwrap()).collect();
    CORNERS.concat().iter().flat_map(|c| c.to_le_bytes()).chain(indices).collect()
}

fn gltf(buffer: &Value) -> Value {
    json!({
        "asset": {"version": "2.0"},
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5121, "count": 36, "type": "SCALAR"}
        ],
        "bufferViews": [{"buffer": 0, "byteLength": 96}, {"buffer": 0, "byteOffset": 96, "byteLength": 36}],
        "buffers": [buffer]
    })
}

fn glb() -> Vec<u8> {
    let chunk = |kind: &[u8; 4], content: &[u8]| {
        [&u32::try_from(content.len()).unwrap().to_le_bytes()[..], kind, content].concat()
    };
    let json = gltf(&json!({"byteLength": 132})).to_string();
    let content = [chunk(b"JSON", json.as_bytes()), chunk(b"BIN\0", &buffer())].concat();
    let length = u32::try_from(12 + content.len()).unwrap();
    [b"glTF", &2u32.to_le_bytes()[..], &length.to_le_bytes(), &content].concat()
}

/// The box in every format.
fn write_all(folder: &Path) -> [&'static str; 6] {
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.join(name), bytes).unwrap();
    write("box.stl", stl().as_bytes());
    write("box.obj", obj().as_bytes());
    write("box.ply", ply().as_bytes());
    write("box.dae", dae().as_bytes());
    write("box.gltf", gltf(&json!({"byteLength": 132, "uri": "box.bin"})).to_string().as_bytes());
    write("box.bin", &buffer());
    write("box.glb", &glb());
    ["box.stl", "box.obj", "box.ply", "box.dae", "box.gltf", "box.glb"]
}

#[test]
fn every_format_holds_the_same_box() {
    let folder = tempfile::tempdir().unwrap();
    for name in write_all(folder.path()) {
        let files = MeshFiles::under(folder.path());
        let mesh = files.load(name, Vector3::from_element(1.0)).unwrap_or_else(|e| panic!("{e}")).mesh;
        assert_eq!(mesh.triangles().len(), 12, "{name}");
        assert!(mesh.solid().remarks().is_empty() && (mesh.signed_volume() - 6.0).abs() < 1e-12, "{name}");
    }
}

#[test]
fn links_and_objects_take_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    for name in write_all(folder.path()) {
        let urdf = format!(
            "<robot name='r'><link name='base'/><link name='l'><collision><geometry><mesh filename='{name}'/></geometry>\
             </collision></link><joint name='j' type='prismatic'><parent link='base'/><child link='l'/><axis xyz='1 0 0'/>\
             <limit lower='-9' upper='9' velocity='1'/></joint></robot>"
        );
        let world = format!(
            "world: {{collision_objects: [{{id: o, header: {{frame_id: ''}}, meshes: [{{resource: {name}}}], \
             mesh_poses: [{{position: [4, 0, 0]}}]}}]}}"
        );
        std::fs::write(path("r.urdf"), urdf).unwrap();
        std::fs::write(path("w.yaml"), world).unwrap();
        let output = Command::new(env!("CARGO_BIN_EXE_clearance"))
            .args(["check", "--urdf", &path("r.urdf"), "--world", &path("w.yaml"), "--state", "j=1"])
            .args(["--query", "distance", "--format", "json"])
            .output()
            .unwrap();
        let message = String::from_utf8_lossy(&output.stderr);
        let answer: Value =
            serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{name}: {message}"));
        let distance = answer["results"][0]["distance"].as_f64();
        assert!(distance.is_some_and(|d| (d - 2.0).abs() < 1e-9), "{name}: {distance:?}");
    }
}

/// Files of public reports: what was refused is read, and what was left out is told.
#[test]
fn files_of_reports_are_read() {
    let Some(reports) = shared_folder("cases/reports") else { return };
    for (case, mesh, triangles, remark) in [
        ("mesh-viewer-65-polygons", "m.dae", 2, Some("1 polygons of fewer than three corners")),
        ("meshlab-194-end-loop", "m.stl", 12, None),
    ] {
        let files = MeshFiles::under(reports.join(case));
        let loaded = files.load(mesh, Vector3::from_element(1.0)).unwrap_or_else(|e| panic!("{case}: {e}"));
        assert_eq!(loaded.mesh.triangles().len(), triangles, "{case}");
        match remark {
            Some(words) => assert!(loaded.remarks.iter().any(|r| r.contains(words)), "{:?}", loaded.remarks),
            None => assert!(loaded.remarks.is_empty(), "{:?}", loaded.remarks),
        }
    }
}
