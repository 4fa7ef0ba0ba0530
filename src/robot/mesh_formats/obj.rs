//! Wavefront OBJ, through `tobj`.
//!
//! Only positions and faces make a surface. `tobj` sees these alone: normals, texture coordinates, colours, groups and
//! material files are left out before it looks, and with them everything that it could refuse, fetch or stumble over.
//! Polygons are triangulated here, since `tobj` makes a fan of every one, concave or not.

use std::io::{BufRead, Read};

use super::tally::{TOO_FEW_CORNERS, Tally};
use super::{ReadMesh, polygon};
use crate::geometry::{MeshError, TriangleMesh};
use crate::math::Point;
use crate::robot::numbers::decimal;

/// Statements that OBJ knows and that have no part in the surface.
const OTHER_STATEMENTS: [&str; 25] = [
    "vt",
    "vn",
    "vp",
    "g",
    "o",
    "s",
    "mg",
    "usemtl",
    "mtllib",
    "usemap",
    "maplib",
    "l",
    "p",
    "cstype",
    "deg",
    "bmat",
    "step",
    "curv",
    "curv2",
    "surf",
    "parm",
    "trim",
    "end",
    "lod",
    "shadow_obj",
];

/// # Errors
/// When a vertex or face is not written as OBJ asks, with its line; when there is no face.
pub(super) fn read(text: &str) -> Result<ReadMesh, String> {
    let surface = Surface::new(text);
    let options = tobj::LoadOptions {
        single_index: false,
        triangulate: false,
        ignore_points: false,
        ignore_lines: false,
    };
    let mut lines = CountedLines::new(surface.text.as_bytes());
    let no_materials = |_: &std::path::Path| Err(tobj::LoadError::MaterialParseError);
    let models = match tobj::load_obj_buf(&mut lines, &options, no_materials) {
        Ok((models, _)) => models,
        Err(tobj::LoadError::FaceVertexOutOfBounds) => {
            return Err("bad OBJ: a face names a vertex that the file does not have".to_owned());
        }
        Err(error) => return Err(format!("bad OBJ at line {}: {error}", lines.count)),
    };
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    let mut tally = Tally::default();
    for model in &models {
        let first = vertices.len();
        vertices.extend(model.mesh.positions.chunks_exact(3).map(|p| Point::new(p[0], p[1], p[2])));
        append_faces(&model.mesh, &vertices[first..], first, (&mut triangles, &mut tally))?;
    }
    // tobj keeps only the vertices that faces name
    if let (Some(line), true) = (surface.unreadable.first(), vertices.iter().any(|v| v.x.is_nan())) {
        return Err(format!(
            "bad OBJ: a face names a vertex that cannot be read; the first such is at line {line}"
        ));
    }
    let mesh = TriangleMesh::new(vertices, triangles).map_err(|e| match e {
        MeshError::NoTriangles => "the file has no faces".to_owned(),
        other => other.to_string(),
    })?;
    Ok(ReadMesh { mesh, remarks: surface.remarks().into_iter().chain(tally.remarks()).collect() })
}

/// The statements that make the surface, line for line as in the file; other lines are empty.
#[derive(Default)]
struct Surface {
    text: String,
    /// Lines of vertices that cannot be read; they count, but no face may name them.
    unreadable: Vec<usize>,
    /// Lines that OBJ does not know.
    unknown: Vec<usize>,
}

impl Surface {
    fn new(text: &str) -> Self {
        let mut surface = Self::default();
        let mut in_face = false;
        for (line, number) in text.lines().zip(1..) {
            // a backslash at a line's end joins the next line to it
            let (line, continues) = match line.trim_end().strip_suffix('\\') {
                Some(line) => (line, true),
                None => (line, false),
            };
            in_face = surface.add(line, number, in_face) && continues;
            surface.text.push(if in_face { ' ' } else { '\n' });
        }
        surface
    }

    /// Adds a line; `true` when it belongs to a face.
    fn add(&mut self, line: &str, number: usize, in_face: bool) -> bool {
        let mut words = line.split_whitespace();
        if in_face {
            self.add_corners(words);
            return true;
        }
        match words.next() {
            Some("v") => self.add_position(words, number),
            Some("f") => {
                self.text.push('f');
                self.add_corners(words);
                return true;
            }
            Some(word) if !word.starts_with('#') && !OTHER_STATEMENTS.contains(&word) => {
                self.unknown.push(number);
            }
            _ => {}
        }
        false
    }

    /// `v x y z`, `v x y z w` (homogeneous), `v x y z r g b` and `v x y z r g b a` (colours, dropped).
    fn add_position<'t>(&mut self, words: impl Iterator<Item = &'t str>, line: usize) {
        let mut words: Vec<&str> = words.take_while(|w| !w.starts_with('#')).collect();
        if words.len() != 4 {
            words.truncate(3);
        }
        if words.len() < 3 || words.iter().any(|w| decimal(w).is_err()) {
            self.unreadable.push(line);
            words = vec!["nan"; 3];
        }
        self.text.push_str("v ");
        self.text.push_str(&words.join(" "));
    }

    /// `1/2/3` names position 1, texture coordinate 2, normal 3.
    fn add_corners<'t>(&mut self, words: impl Iterator<Item = &'t str>) {
        for corner in words.take_while(|w| !w.starts_with('#')) {
            let position = corner.split('/').next().unwrap_or_default();
            // an empty position would vanish and change the polygon: let tobj refuse it
            let position = if position.is_empty() { "?" } else { position };
            self.text.push(' ');
            self.text.push_str(position);
        }
    }

    fn remarks(&self) -> Vec<String> {
        let remark = |lines: &[usize], what: &str| {
            let first = lines.first()?;
            Some(format!("{} lines {what}, the first of them line {first}; skipped", lines.len()))
        };
        [
            remark(&self.unknown, "are no OBJ statements"),
            remark(&self.unreadable, "are vertices that cannot be read"),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}

fn append_faces(
    mesh: &tobj::Mesh,
    vertices: &[Point],
    first: usize,
    (triangles, tally): (&mut Vec<[u32; 3]>, &mut Tally),
) -> Result<(), String> {
    // tobj leaves the arities out when all are 3
    let arities: Vec<usize> = if mesh.face_arities.is_empty() {
        vec![3; mesh.indices.len() / 3]
    } else {
        mesh.face_arities.iter().map(|&a| a as usize).collect()
    };
    let mut rest = mesh.indices.as_slice();
    for arity in arities {
        let Some((corners, others)) = rest.split_at_checked(arity) else {
            return Err("bad OBJ: a face is cut".to_owned());
        };
        rest = others;
        if arity < 3 {
            tally.add(TOO_FEW_CORNERS, None);
            continue;
        }
        let points: Option<Vec<Point>> =
            (corners.iter()).map(|&c| vertices.get(c as usize).copied()).collect();
        let points = points.ok_or("bad OBJ: a face names a vertex that the file does not have")?;
        for triple in polygon::triangulate(&points)? {
            let global = |k: usize| u32::try_from(first + corners[k] as usize);
            let [a, b, c] = triple.map(global);
            match (a, b, c) {
                (Ok(a), Ok(b), Ok(c)) => triangles.push([a, b, c]),
                _ => return Err("more vertices than 32-bit indices can name".to_owned()),
            }
        }
    }
    Ok(())
}

/// A reader that knows how many lines were taken from it, since `tobj` names no line in its errors.
struct CountedLines<'t> {
    rest: &'t [u8],
    count: usize,
}

impl<'t> CountedLines<'t> {
    fn new(text: &'t [u8]) -> Self {
        Self { rest: text, count: 0 }
    }
}

impl Read for CountedLines<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        self.rest.read(buffer)
    }
}

impl BufRead for CountedLines<'_> {
    fn fill_buf(&mut self) -> std::io::Result<&[u8]> {
        Ok(self.rest)
    }

    fn consume(&mut self, amount: usize) {
        let (taken, rest) = self.rest.split_at(amount.min(self.rest.len()));
        self.count += taken.iter().filter(|&&b| b == b'\n').count();
        self.rest = rest;
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const SQUARE: &str =
        "mtllib /etc/passwd\nv 0 0 0 1 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nvt 0 0\no s\nusemtl x\n";

    fn triangles(text: &str) -> usize {
        read(text).unwrap().mesh.triangles().len()
    }

    #[test]
    fn faces_of_all_kinds() {
        assert_eq!(triangles(&format!("{SQUARE}f 1 2 3 4")), 2);
        assert_eq!(triangles(&format!("{SQUARE}f 1/1/1 2/1/1 3//1\nf -1 -2 -4\nl 1 2\np 1")), 2);
        assert_eq!(triangles(&format!("{SQUARE}f 1 2 \\\n 3 4\nf 1 2 3")), 3);
    }

    #[test]
    fn coordinates_keep_all_their_digits() {
        let mesh = read("v 0.1 0 0\nv 1 0 0 2\nv 0 1 0\nf 1 2 3").unwrap().mesh;
        assert!((mesh.vertices()[0].x - 0.1).abs() < 1e-17);
        assert!((mesh.vertices()[1].x - 0.5).abs() < 1e-17);
    }

    #[test]
    fn indices_that_would_wrap_are_harmless() {
        for corner in ["1/1/-9", "1//-9223372036854775808", "1/9223372036854775807/1"] {
            assert_eq!(triangles(&format!("{SQUARE}f {corner} 2 3")), 1);
        }
        for corner in ["0", "-9", "5", "9223372036854775807", "-9223372036854775808", "1.5", "/1"] {
            assert!(read(&format!("{SQUARE}f {corner} 2 3")).is_err(), "{corner}");
        }
    }

    #[test]
    fn faults_name_the_line() {
        assert!(read("v 0 0 0\nv 1 2\nf 1 2 1").unwrap_err().contains("line 2"));
        assert!(read("v 0 0 0\n\nf 1 x 1\n").unwrap_err().contains("line 3"));
        assert_eq!(read("v 0 0 0\nv 1 0 0").unwrap_err(), "the file has no faces");
        assert_eq!(read(&format!("{SQUARE}f 1 2")).unwrap_err(), "the file has no faces");
    }

    #[test]
    fn points_and_lines_are_skipped_and_counted() {
        let read = read(&format!("{SQUARE}f 1 2\nf 1 2 3\nf 4\nf 2/1 1/1")).unwrap();
        assert_eq!(read.mesh.triangles().len(), 1);
        assert!(read.remarks[0].starts_with("3 polygons of fewer"), "{:?}", read.remarks);
    }

    #[test]
    fn a_vertex_that_no_face_names_may_be_unreadable() {
        let read = read("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 3.1+e2 0 0\nv 1e99 0 0\nf 1 2 3").unwrap();
        assert_eq!(read.mesh.vertices().len(), 3);
        assert!(read.remarks[0].contains("line 4;"), "{:?}", read.remarks);
    }

    #[test]
    fn foreign_lines_are_told() {
        let read = read(&format!("648 216\n{SQUARE}f 1 2 3")).unwrap();
        assert!(read.remarks[0].contains("line 1;"), "{:?}", read.remarks);
    }

    proptest! {
        #[test]
        fn mutations_never_panic(at in 0usize..200, byte in 9u8..127, cut in 0usize..60) {
            let mut bytes = format!("{SQUARE}f 1/1/1 2/1/1 3/1/1 4/1/1\nf -1 -2 -3").into_bytes();
            let at = at % bytes.len();
            bytes[at] = byte;
            bytes.truncate(bytes.len() - cut);
            let _ = read(&String::from_utf8_lossy(&bytes));
        }
    }
}
