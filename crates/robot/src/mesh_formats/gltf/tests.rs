//! Tests of the glTF reader: buffers, transforms, primitives, sparse accessors, broken files and endless instances.

use std::f64::consts::FRAC_1_SQRT_2;

use clearance_geometry::math::Vector;
use proptest::prelude::*;
use serde_json::{Value, json};

use super::*;

/// A square of side 1 in the plane z = 0: four positions (f32) and six indices (u16).
fn buffer() -> Vec<u8> {
    let positions = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let indices = [0u16, 1, 2, 0, 2, 3];
    let mut bytes: Vec<u8> = positions.iter().flatten().flat_map(|c| c.to_le_bytes()).collect();
    bytes.extend(indices.iter().flat_map(|i| i.to_le_bytes()));
    bytes
}

fn data_uri(bytes: &[u8]) -> String {
    use base64::Engine;
    format!(
        "data:application/octet-stream;base64,{}",
        base64::engine::general_purpose::STANDARD.encode(bytes)
    )
}

fn document() -> Value {
    json!({
        "asset": {"version": "2.0", "generator": "by hand"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 7}, "indices": 1, "material": 3}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 12}
        ],
        "buffers": [{"byteLength": 60, "uri": data_uri(&buffer())}]
    })
}

fn glb(document: &Value, buffer: &[u8]) -> Vec<u8> {
    let chunk = |kind: &[u8; 4], content: &[u8]| {
        let length = u32::try_from(content.len()).unwrap();
        [&length.to_le_bytes()[..], kind, content].concat()
    };
    let content = [chunk(b"JSON", document.to_string().as_bytes()), chunk(b"BIN\0", buffer)].concat();
    let length = u32::try_from(12 + content.len()).unwrap();
    [b"glTF", &2u32.to_le_bytes()[..], &length.to_le_bytes(), &content].concat()
}

fn no_parts(name: &str) -> Result<Vec<u8>, String> {
    Err(format!("no part '{name}'"))
}

fn of(document: &Value) -> Result<ReadMesh, String> {
    read_text(document.to_string().as_bytes(), &mut no_parts)
}

/// The document with one value replaced, by its JSON pointer.
fn with(pointer: &str, value: Value) -> Value {
    let mut document = document();
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    match document.pointer_mut(parent).unwrap() {
        Value::Array(list) => list[key.parse::<usize>().unwrap()] = value,
        parent => parent[key] = value,
    }
    document
}

fn fault(document: &Value) -> String {
    let message = of(document).unwrap_err();
    assert!(message.starts_with("bad gl") || message.starts_with("bad GL"), "{message}");
    assert!(!message.contains('\n') && message.len() < 400, "{message}");
    message
}

fn extent(read: &ReadMesh) -> Vector {
    let (lo, hi) = read.mesh.bounds();
    hi - lo
}

#[test]
fn text_and_binary_and_buffers_of_all_places() {
    let mut in_glb = document();
    in_glb["buffers"][0] = json!({"byteLength": 60});
    let mut percent = document();
    let escaped: String = buffer().iter().map(|b| format!("%{b:02X}")).collect::<Vec<_>>().concat();
    percent["buffers"][0]["uri"] = json!(format!("Data:,{escaped}"));
    let mut beside = document();
    beside["buffers"][0]["uri"] = json!("parts/square.bin");
    let mut part = |name: &str| if name == "parts/square.bin" { Ok(buffer()) } else { no_parts(name) };
    for read in [
        of(&document()),
        of(&percent),
        read_binary(&glb(&in_glb, &buffer()), &mut no_parts),
        read_text(beside.to_string().as_bytes(), &mut part),
    ] {
        let read = read.unwrap();
        assert_eq!((read.mesh.triangles().len(), read.mesh.vertices().len()), (2, 4));
        assert_eq!(extent(&read), Vector::new(1.0, 1.0, 0.0));
        assert!(read.mesh.triangle(0).normal().z > 0.0 && read.mesh.triangle(1).normal().z > 0.0);
        assert_eq!(read.remarks.len(), 1, "{:?}", read.remarks);
    }
    let surplus = read_binary(&[glb(&in_glb, &buffer()), vec![0; 3]].concat(), &mut no_parts).unwrap();
    assert!(surplus.remarks.iter().any(|r| r.starts_with("3 bytes follow")));
}

#[test]
fn transforms_of_nodes_and_instances() {
    let mut nested = document();
    nested["nodes"] = json!([
        {"children": [1, 2], "translation": [5.0, 0.0, 0.0]},
        {"mesh": 0, "rotation": [0.0, 0.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2], "scale": [2.0, 1.0, 1.0]},
        {"mesh": 0, "matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 3, 1]}
    ]);
    let read = of(&nested).unwrap();
    assert_eq!(read.mesh.triangles().len(), 4);
    let (lo, hi) = read.mesh.bounds();
    assert!(
        (lo - Point::new(4.0, 0.0, 0.0)).norm() < 1e-12 && (hi - Point::new(5.0, 2.0, 3.0)).norm() < 1e-12
    );
    // mirrored faces still look up
    assert!((0..4).all(|i| read.mesh.triangle(i).normal().z > 0.0));
}

#[test]
fn modes_and_index_types() {
    for (mode, indices, triangles) in
        [(4, &[0u32, 1, 2, 0, 2, 3][..], 2), (5, &[0, 1, 3, 2], 2), (6, &[0, 1, 2, 3], 2)]
    {
        for (kind, size) in [(5121, 1), (5123, 2), (5125, 4)] {
            let mut bytes = buffer()[..48].to_vec();
            bytes.extend(indices.iter().flat_map(|i| i.to_le_bytes()[..size].to_vec()));
            let mut document = document();
            document["meshes"][0]["primitives"][0]["mode"] = json!(mode);
            document["accessors"][1]["componentType"] = json!(kind);
            document["accessors"][1]["count"] = json!(indices.len());
            document["bufferViews"][1]["byteLength"] = json!(indices.len() * size);
            document["buffers"][0] = json!({"byteLength": bytes.len(), "uri": data_uri(&bytes)});
            let read = of(&document).unwrap();
            assert_eq!(read.mesh.triangles().len(), triangles);
            assert!((0..triangles).all(|i| read.mesh.triangle(i).normal().z > 0.0), "mode {mode}");
        }
    }
    let mut plain = document();
    plain["meshes"][0]["primitives"][0]["indices"] = Value::Null;
    plain["accessors"][0]["count"] = json!(3);
    assert_eq!(of(&plain).unwrap().mesh.triangles().len(), 1);
    let mut lines = document();
    lines["meshes"][0]["primitives"].as_array_mut().unwrap().push(json!({"attributes": {}, "mode": 1}));
    assert!(of(&lines).unwrap().remarks[0].starts_with("1 lists of lines"));
    lines["meshes"][0]["primitives"].as_array_mut().unwrap().remove(0);
    assert!(fault(&lines).contains("no triangles"));
}

#[test]
fn sparse_quantized_and_strided_elements() {
    // vertex 2 moves to (7, 1, 0)
    let mut bytes = buffer();
    bytes.extend([2, 0]);
    bytes.extend([7.0f32, 1.0, 0.0].iter().flat_map(|c| c.to_le_bytes()));
    let mut sparse = document();
    sparse["buffers"][0] = json!({"byteLength": bytes.len(), "uri": data_uri(&bytes)});
    sparse["bufferViews"]
        .as_array_mut()
        .unwrap()
        .push(json!({"buffer": 0, "byteOffset": 60, "byteLength": 14}));
    sparse["accessors"][0]["sparse"] = json!({
        "count": 1,
        "indices": {"bufferView": 2, "componentType": 5123},
        "values": {"bufferView": 2, "byteOffset": 2}
    });
    assert_eq!(extent(&of(&sparse).unwrap()), Vector::new(7.0, 1.0, 0.0));
    // all other vertices are zero
    sparse["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert_eq!(of(&sparse).unwrap().mesh.bounds(), (Point::origin(), Point::new(7.0, 1.0, 0.0)));
    sparse["accessors"][0]["count"] = json!(1_000_000_000);
    assert!(fault(&sparse).contains("more than the buffers have bytes"));
    let mut none = document();
    none["accessors"][0]["sparse"] = sparse["accessors"][0]["sparse"].clone();
    assert!(fault(&none).contains("sparse: names bufferView 2"));

    // integers of 8 bits, four bytes apart
    let mut bytes: Vec<u8> = [[0u8, 0, 0], [127, 0, 0], [127, 127, 0], [0, 127, 0]]
        .iter()
        .flat_map(|p| [p[0], p[1], p[2], 99])
        .collect();
    bytes.extend(&buffer()[48..]);
    let mut small = document();
    small["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    small["buffers"][0] = json!({"byteLength": bytes.len(), "uri": data_uri(&bytes)});
    small["bufferViews"] = json!([{"buffer": 0, "byteLength": 16, "byteStride": 4}, {"buffer": 0, "byteOffset": 16, "byteLength": 12}]);
    small["accessors"][0]["componentType"] = json!(5120);
    assert_eq!(extent(&of(&small).unwrap()), Vector::new(127.0, 127.0, 0.0));
    small["accessors"][0]["normalized"] = json!(true);
    assert_eq!(extent(&of(&small).unwrap()), Vector::new(1.0, 1.0, 0.0));
    small["bufferViews"][0]["byteStride"] = json!(2);
    assert!(fault(&small).contains("byteStride of 2"));
}

#[test]
fn what_is_not_applied_is_reported() {
    for (document, words) in [
        (with("/nodes/0/skin", json!(0)), "without their skin, where their node is"),
        (with("/meshes/0/primitives/0/targets", json!([{"POSITION": 0}])), "morph"),
        (with("/scenes", json!([{"nodes": [0]}, {}])), "2 scenes"),
        (document(), "+Y is up"),
    ] {
        let read = of(&document).unwrap();
        assert!(read.remarks.iter().any(|r| r.contains(words)), "{:?}", read.remarks);
    }
    let mut no_scene = document();
    no_scene["scenes"] = json!([]);
    no_scene["scene"] = Value::Null;
    no_scene["nodes"] = json!([{"mesh": 0}, {"children": [0]}]);
    assert_eq!(of(&no_scene).unwrap().mesh.triangles().len(), 2);
}

#[test]
fn what_is_not_read_is_named() {
    let primitive = "/meshes/0/primitives/0";
    for (document, words) in [
        (
            with(&format!("{primitive}/extensions"), json!({"KHR_draco_mesh_compression": {}})),
            "KHR_draco_mesh_compression",
        ),
        (
            with("/bufferViews/0/extensions", json!({"EXT_meshopt_compression": {}})),
            "EXT_meshopt_compression",
        ),
        (with("/nodes/0/extensions", json!({"EXT_mesh_gpu_instancing": {}})), "EXT_mesh_gpu_instancing"),
        (with("/extensionsRequired", json!(["KHR_materials_unlit", "ACME_shape"])), "extension ACME_shape"),
        (with("/asset/version", json!("1.0")), "version '1.0'"),
        (with("/buffers/0/uri", json!("http://h/b.bin")), "no part 'http"),
        (with("/buffers/0/uri", json!("data:x")), "no comma"),
        (with("/buffers/0/uri", json!("data:;base64,???")), "base64"),
        (with("/buffers/0/uri", json!("data:;base64,AAAA")), "60 bytes, but there are 3"),
        (with("/buffers/0/uri", Value::Null), "no uri"),
        (with("/accessors/0/count", json!(5)), "5 elements, but bufferView 0 has only 48"),
        (with("/accessors/0/count", json!(u64::MAX)), "elements"),
        (with("/accessors/0/byteOffset", json!(u64::MAX)), "elements"),
        (with("/accessors/0/type", json!("VEC2")), "VEC3"),
        (with("/accessors/0/componentType", json!(1)), "componentType 1"),
        (with("/accessors/0/componentType", json!(5125)), "unsigned"),
        (with("/accessors/1/componentType", json!(5122)), "indices are unsigned"),
        (with("/accessors/1/count", json!(5)), "5 corners"),
        (with("/accessors/0/count", json!(3)), "vertex 3, but there are 3"),
        (with("/bufferViews/0/buffer", json!(9)), "buffer 9"),
        (with("/bufferViews/1/byteOffset", json!(49)), "ends behind"),
        (with("/bufferViews/1/byteOffset", json!(u64::MAX)), "ends behind"),
        (with(&format!("{primitive}/mode"), json!(7)), "mode 7"),
        (with(&format!("{primitive}/attributes"), json!({})), "POSITION"),
        (with(&format!("{primitive}/indices"), json!(9)), "accessor 9"),
        (with("/nodes/0/mesh", json!(9)), "mesh 9"),
        (with("/nodes/0/children", json!([0])), "without end"),
        (with("/nodes/0/children", json!([9])), "node 9"),
        (with("/nodes/0/rotation", json!([0, 0, 0, 0])), "quaternion"),
        (with("/nodes/0/matrix", json!([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])), "last row"),
        (with("/nodes/0/scale", json!([1e300, 1e300, 1e300])), "not finite"),
        (with("/scene", json!(9)), "scene 9"),
        (with("/scenes/0/nodes", json!([])), "no triangles"),
        (with("/meshes/0/primitives/0/indices", json!("a".repeat(10_000))), "invalid type"),
    ] {
        let message = fault(&document);
        assert!(message.contains(words), "{message} does not name {words}");
    }
    let mut nan = buffer();
    nan[..4].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(fault(&with("/buffers/0/uri", json!(data_uri(&nan)))).contains("not finite"));
}

#[test]
fn cut_files_are_named() {
    let mut document = document();
    document["buffers"][0] = json!({"byteLength": 60});
    let whole = glb(&document, &buffer());
    for end in 0..whole.len() {
        let message = read_binary(&whole[..end], &mut no_parts).unwrap_err();
        assert!(message.contains("GLB") && !message.contains('\n'), "{message}");
    }
    let mut other = whole.clone();
    other[4] = 1;
    assert!(read_binary(&other, &mut no_parts).unwrap_err().contains("version 1"));
    let mut lying = whole.clone();
    lying[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(read_binary(&lying, &mut no_parts).unwrap_err().contains("4294967295 bytes"));
    assert!(read_text(b"{", &mut no_parts).unwrap_err().contains("bad glTF"));
    let deep = format!("{}{}", "[".repeat(100_000), "]".repeat(100_000));
    assert!(read_text(deep.as_bytes(), &mut no_parts).is_err());
}

#[test]
fn instances_without_end_end() {
    let mut laughing = document();
    let nodes: Vec<Value> =
        (1..=30).map(|i| json!({"children": vec![i; 10]})).chain([json!({"mesh": 0})]).collect();
    laughing["nodes"] = json!(nodes);
    assert!(fault(&laughing).contains("2000000 nodes, instances counted"));
    let chain = |levels: usize| {
        let mut document = document();
        let nodes: Vec<Value> =
            (1..=levels).map(|i| json!({"children": [i]})).chain([json!({"mesh": 0})]).collect();
        document["nodes"] = json!(nodes);
        document
    };
    assert_eq!(of(&chain(900)).unwrap().mesh.triangles().len(), 2);
    let message = fault(&chain(1001));
    assert!(message.contains("more than 1000 levels") && !message.contains("without end"), "{message}");
    let mut circle = chain(3);
    circle["nodes"][2]["children"] = json!([3, 1]);
    assert!(fault(&circle).contains("node 1 contains itself: nodes without end"));
    let mut many = chain(1);
    many["nodes"] = json!([{"children": vec![1; 1000]}, {"children": vec![2; 101]}, {"mesh": 0}]);
    assert_eq!(of(&many).unwrap().mesh.triangles().len(), 202_000);
}

#[test]
fn transforms_given_twice_and_least_versions() {
    let shift = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 2, 0, 0, 1];
    for (translation, is_read) in
        [(json!([2, 0, 0]), true), (json!([0, 0, 0]), true), (json!([0, 2, 0]), false)]
    {
        let node = json!({"mesh": 0, "matrix": shift, "translation": translation});
        let read = of(&with("/nodes/0", node));
        match read {
            Ok(read) => {
                let low = read.mesh.bounds().0;
                assert!(is_read && (low - Point::new(2.0, 0.0, 0.0)).norm() < 1e-12, "{translation}");
            }
            Err(message) => assert!(!is_read && message.contains("contradicts its translation"), "{message}"),
        }
    }
    for (version, least, is_read) in
        [("2.0", "2.0", true), ("2.5", "2.0", true), ("2.5", "2.5", false), ("2.0", "3.0", false)]
    {
        let read = of(&with("/asset", json!({"version": version, "minVersion": least})));
        assert_eq!(read.is_ok(), is_read, "{version}, {least}: {read:?}");
        assert!(read.err().is_none_or(|message| message.contains(&format!("version '{least}'"))));
    }
    assert!(of(&with("/asset", json!({"version": "2.1"}))).is_ok());
}

/// A document whose positions are replaced by sparse ones with these indices.
fn sparse(count: usize, indices: &[u8]) -> Value {
    let mut bytes = buffer();
    bytes.extend(indices);
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    let values = bytes.len();
    bytes.extend((0..3 * indices.len()).flat_map(|i| f32::from(u16::try_from(i % 7).unwrap()).to_le_bytes()));
    let mut document = with("/buffers/0", json!({"byteLength": bytes.len(), "uri": data_uri(&bytes)}));
    let views = document["bufferViews"].as_array_mut().unwrap();
    views.push(json!({"buffer": 0, "byteOffset": 60, "byteLength": indices.len()}));
    views.push(json!({"buffer": 0, "byteOffset": values, "byteLength": 12 * indices.len()}));
    document["accessors"][0]["sparse"] = json!({
        "count": count,
        "indices": {"bufferView": 2, "componentType": 5121},
        "values": {"bufferView": 3}
    });
    document
}

/// Sparse elements count, whether they are used or not, and are checked once for all instances.
#[test]
fn replaced_elements_are_few_and_in_order() {
    let read = of(&sparse(3, &[0, 1, 3])).unwrap();
    let corners = read.mesh.vertices();
    assert_eq!(corners[1], Point::new(3.0, 4.0, 5.0));
    assert_eq!(corners[2], Point::new(1.0, 1.0, 0.0));
    assert_eq!(corners[3], Point::new(6.0, 0.0, 1.0));
    for (indices, words) in [
        (&[0, 0][..], "do not increase"),
        (&[2, 1], "do not increase"),
        (&[0, 4], "not there"),
        (&[0; 200], "replaces 200 elements, but there are 4"),
    ] {
        let message = fault(&sparse(indices.len(), indices));
        assert!(message.contains(words), "{message}");
    }
    let mut signed = sparse(2, &[0, 1]);
    signed["accessors"][0]["sparse"]["indices"]["componentType"] = json!(5120);
    assert!(fault(&signed).contains("unsigned"));
    let mut instances = sparse(4, &[0, 1, 2, 3]);
    instances["nodes"] = json!([{"children": (1..=20_000).collect::<Vec<_>>()}]);
    instances["nodes"].as_array_mut().unwrap().extend(vec![json!({"mesh": 0}); 20_000]);
    assert_eq!(of(&instances).unwrap().mesh.triangles().len(), 40_000);
}

/// Primitives without elements count, too.
#[test]
fn instances_of_many_primitives_end() {
    let mut many = document();
    many["meshes"][0]["primitives"] = json!(vec![json!({"attributes": {}, "mode": 1}); 10_000]);
    many["nodes"] = json!([{"children": (1..=1000).collect::<Vec<_>>()}]);
    many["nodes"].as_array_mut().unwrap().extend(vec![json!({"mesh": 0}); 1000]);
    assert!(fault(&many).contains("elements, instances counted"));
}

#[test]
fn values_of_json_are_counted_without_strings() {
    assert_eq!(values(br#"{"a": [1, 2], "b\"[,{": "[[[\\"}"#), 4);
    assert_eq!(values(b"\"[,"), 0);
}

proptest! {
    #[test]
    fn mutations_never_panic(
        flips in prop::collection::vec(any::<(u16, u8)>(), 0..6),
        cut in 0usize..2000,
        numbers in prop::collection::vec((0usize..60, prop_oneof![0u64..70, any::<u64>()]), 0..4),
    ) {
        let mut in_glb = document();
        in_glb["buffers"][0] = json!({"byteLength": 60});
        for mut bytes in [document().to_string().into_bytes(), glb(&in_glb, &buffer())] {
            for &(at, bits) in &flips {
                let at = usize::from(at) % bytes.len();
                bytes[at] ^= bits;
            }
            bytes.truncate(bytes.len().saturating_sub(cut / 8));
            let _ = read_text(&bytes, &mut no_parts);
            let _ = read_binary(&bytes, &mut no_parts);
        }
        // wrong numbers
        let mut parts: Vec<String> = Vec::new();
        let mut digits = String::new();
        for c in document().to_string().chars() {
            if c.is_ascii_digit() {
                digits.push(c);
            } else {
                parts.push(std::mem::take(&mut digits));
                parts.push(c.to_string());
            }
        }
        let places: Vec<usize> = (0..parts.len()).filter(|&i| !parts[i].is_empty() && parts[i].bytes().all(|b| b.is_ascii_digit())).collect();
        for &(which, number) in &numbers {
            parts[places[which % places.len()]] = number.to_string();
        }
        let _ = read_text(parts.concat().as_bytes(), &mut no_parts);
    }
}
