//! Tests of the PLY point cloud reader: every form of storage, cut or altered files, and faults.

use proptest::prelude::*;

use crate::read_cloud;

/// The bytes of a number in the order of the file.
fn number(kind: &str, value: f64, format: &str) -> Vec<u8> {
    let mut bytes = match kind {
        "float" => (value as f32).to_le_bytes().to_vec(),
        "double" => value.to_le_bytes().to_vec(),
        "short" => (value as i16).to_le_bytes().to_vec(),
        "uchar" => vec![value as u8],
        _ => (value as i32).to_le_bytes().to_vec(),
    };
    if format == "binary_big_endian" {
        bytes.reverse();
    }
    bytes
}

/// A PLY with an element before the vertices, vertices with a list and a colour, and faces after them.
fn file(points: &[[f64; 3]], order: [usize; 3], kind: &str, format: &str) -> Vec<u8> {
    let named: Vec<String> =
        order.iter().map(|&k| format!("property {kind} {}\n", ["x", "y", "z"][k])).collect();
    let mut bytes = format!(
        "ply\nformat {format} 1.0\ncomment made for a test\nelement camera 2\nproperty uchar id\n\
         property list uchar short view\nelement vertex {}\nproperty uchar red\n{}property list int float more\n\
         element face 1\nproperty list uchar int vertex_indices\nend_header\n",
        points.len(),
        named.concat()
    )
    .into_bytes();
    let mut put = |kind: &str, value: f64| match format {
        "ascii" => bytes.extend(format!("{value} ").into_bytes()),
        _ => bytes.extend(number(kind, value, format)),
    };
    for (kind, value) in
        [("uchar", 1.0), ("uchar", 2.0), ("short", -5.0), ("short", 6.0), ("uchar", 2.0), ("uchar", 0.0)]
    {
        put(kind, value);
    }
    for point in points {
        put("uchar", 200.0);
        for k in order {
            put(kind, point[k]);
        }
        put("int", 1.0);
        put("float", 0.5);
    }
    for (kind, value) in [("uchar", 3.0), ("int", 0.0), ("int", 1.0), ("int", 2.0)] {
        put(kind, value);
    }
    bytes
}

fn any_file() -> impl Strategy<Value = (Vec<[f64; 3]>, Vec<u8>)> {
    let coordinate = || (-100i8..100).prop_map(f64::from);
    let points = prop::collection::vec([coordinate(), coordinate(), coordinate()], 0..12);
    let order = Just(vec![0, 1, 2]).prop_shuffle();
    let kind = prop_oneof![Just("float"), Just("double"), Just("short"), Just("int")];
    let format = prop_oneof![Just("ascii"), Just("binary_little_endian"), Just("binary_big_endian")];
    (points, order, kind, format).prop_map(|(points, order, kind, format)| {
        let bytes = file(&points, order.try_into().unwrap(), kind, format);
        (points, bytes)
    })
}

proptest! {
    #[test]
    fn every_form_gives_the_vertices_back((points, bytes) in any_file()) {
        let cloud = read_cloud(&bytes).unwrap();
        let found: Vec<_> = cloud.points.iter().map(|p| p.map(f64::from)).collect();
        prop_assert_eq!(found, points);
        prop_assert!(cloud.remarks[0].contains("faces"));
    }

    #[test]
    fn cut_or_altered_files_never_panic((_, bytes) in any_file(), flips in prop::collection::vec(any::<(u16, u8)>(), 1..6)) {
        for end in 0..bytes.len() {
            let _ = read_cloud(&bytes[..end]);
        }
        let mut altered = bytes;
        for &(at, bits) in &flips {
            let at = usize::from(at) % altered.len();
            altered[at] ^= bits;
        }
        let _ = read_cloud(&altered);
    }
}

#[test]
fn faults_are_named() {
    let head = "ply\nformat ascii 1.0\n";
    let xyz = "property float x\nproperty float y\nproperty float z\n";
    let binary = "ply\nformat binary_little_endian 1.0\n";
    for (text, word) in [
        (head.to_owned(), "end_header"),
        (format!("ply\nelement vertex 1\n{xyz}end_header\n1 2 3"), "format"),
        (format!("{head}end_header\n"), "vertex"),
        (format!("{head}element vertex 1\nproperty float x\nend_header\n1"), "property y"),
        (
            format!("{head}element vertex 1\nproperty list int int x\n{xyz}end_header\n1 5 1 2 3"),
            "property x",
        ),
        (format!("{head}element vertex 2\n{xyz}end_header\n1.0 2.0 3.0\n4.0 5.0"), "vertex 1 of 2"),
        (format!("{head}element vertex 1\n{xyz}end_header\n1 2 far"), "'far'"),
        (format!("{head}element vertex many\n{xyz}end_header\n"), "'many'"),
        (format!("{binary}element vertex 4000000000\n{xyz}end_header\nabc"), "4000000000 records"),
        (
            format!(
                "{binary}element a 9999999999999999999\nproperty int b\nelement vertex 1\n{xyz}end_header\n"
            ),
            "'a'",
        ),
        (format!("{head}property float x\n"), "before any element"),
        (format!("{head}element vertex 1\nproperty quad x\n"), "'quad'"),
        (
            format!("{head}element a 1\nproperty list int int b\nelement vertex 0\n{xyz}end_header\n-1"),
            "-1 entries",
        ),
    ] {
        let error = read_cloud(text.as_bytes()).unwrap_err().to_string();
        assert!(error.contains(word), "{error} does not name {word}");
    }
    // elements without any bytes are skipped, not counted one by one
    let endless = format!("{head}element nothing {}\nelement vertex 0\n{xyz}end_header\n", usize::MAX);
    assert_eq!(read_cloud(endless.as_bytes()).unwrap().points.len(), 0);
}

#[test]
fn what_the_header_does_not_announce_is_rejected() {
    let xyz = "property float x\nproperty float y\nproperty float z\n";
    let head = |format: &str, more: &str, vertices: usize| {
        format!("ply\nformat {format} 1.0\nelement vertex {vertices}\n{xyz}{more}end_header\n")
    };
    let fault = |bytes: &[u8]| read_cloud(bytes).unwrap_err().to_string();
    let faces = "element face 1\nproperty list uchar int vertex_indices\n";
    let of = |more: &str, data: &str| format!("{}{data}", head("ascii", more, 1));
    assert!(read_cloud(of("", "1 2 3\n\n").as_bytes()).unwrap().remarks.is_empty());
    for (more, data, words) in [
        ("", "1 2 3\n4 5 6\n", "3 more words follow"),
        ("", "1 2 3 x\n", "1 more word follows"),
        (faces, "1 2 3\n3 0 0 0\n0 0 0\n", "3 more words follow"),
        (faces, "1 2 3\n3 0 0\n", "element 'face': the file ends here"),
    ] {
        let found = fault(of(more, data).as_bytes());
        assert!(found.contains(words), "{found}");
    }
    // an intensity that the header does not list
    let slid = format!("{}1 2 3 9\n4 5 6 9\n", head("ascii", "", 2));
    assert!(fault(slid.as_bytes()).contains("2 more words follow"));
    for format in ["binary_little_endian", "binary_big_endian"] {
        let of = |count: usize| [head(format, "", 1).into_bytes(), vec![0; count]].concat();
        assert!(fault(&of(24)).contains("12 more bytes follow"));
        assert!(read_cloud(&of(14)).unwrap().remarks[0].contains("2 more bytes follow"));
        assert!(read_cloud(&of(12)).unwrap().remarks.is_empty());
    }
    let two = format!(
        "ply\nformat ascii 1.0\nelement vertex 1\n{xyz}element vertex 1\n{xyz}end_header\n1 2 3 4 5 6"
    );
    assert!(read_cloud(two.as_bytes()).unwrap_err().to_string().contains("more than one element vertex"));
}
