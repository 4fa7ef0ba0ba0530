//! Reader of Wavefront OBJ, through `tobj`.
//!
//! Only positions and faces define a surface, and only these are passed to `tobj`. Normals, texture coordinates, colours, groups and
//! material files are removed first, and with them everything that it could reject, fetch or fail on. Polygons are triangulated here,
//! since `tobj` makes a fan of every one, concave or not.

use std::io::{BufRead, Read};

use clearance_geometry::math::Point;

use super::ReadMesh;
use super::mesh_builder::MeshBuilder;
use super::polygon::Triangulator;
use super::remark_counter::{RemarkCounter, TOO_FEW_CORNERS};
use crate::decimal_numbers::decimal;

/// Valid OBJ statements that do not affect the surface.
const OTHER_STATEMENTS: [&str; 31] = [
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
    "cstype",
    "deg",
    "bmat",
    "step",
    "res",
    "parm",
    "trim",
    "hole",
    "scrv",
    "sp",
    "end",
    "con",
    "ctech",
    "stech",
    "bevel",
    "c_interp",
    "d_interp",
    "lod",
    "shadow_obj",
    "trace_obj",
];

/// Statements without surface, each with the name of its count.
const WITHOUT_SURFACE: [(&str, &str); 5] = [
    ("l", "lines (l) are skipped"),
    ("p", "points (p) are skipped"),
    ("curv", "curves (curv) are skipped"),
    ("curv2", "curves (curv2) are skipped"),
    ("cdc", "curves (cdc) are skipped"),
];

/// Statements that would add an unsupported surface, each with instructions.
const NOT_READ: [(&str, &str); 6] = [
    ("surf", "free-form surfaces are not read; save the surface as polygons"),
    ("bzp", "Bezier patches are not read; save the surface as polygons"),
    ("bsp", "B-spline patches are not read; save the surface as polygons"),
    ("cdp", "Cardinal patches are not read; save the surface as polygons"),
    ("call", "other files are not included; write their statements into this one"),
    ("csh", "commands are not run; write what they print into this file"),
];

/// # Errors
/// If a vertex or face has wrong syntax, with its line; if there is no face.
pub(super) fn read(text: &str) -> Result<ReadMesh, String> {
    let surface = Surface::new(text)?;
    MeshBuilder::default().reserve(surface.vertices, surface.triangles)?;
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
    let mut built = MeshBuilder::default();
    let mut remark_counts = RemarkCounter::default();
    let mut triangulator = Triangulator::default();
    for model in &models {
        let first = built.vertices.len();
        let positions = model.mesh.positions.chunks_exact(3).map(|p| Point::new(p[0], p[1], p[2]));
        built.reserve(positions.len(), 0)?;
        built.vertices.extend(positions);
        append_faces(&model.mesh, first, &mut built, &mut triangulator, &mut remark_counts)?;
    }
    // tobj keeps only the vertices that faces refer to
    if let (Some(line), true) = (surface.unreadable.first(), built.vertices.iter().any(|v| v.x.is_nan())) {
        return Err(format!(
            "bad OBJ: a face names a vertex that cannot be read; the first such is at line {line}"
        ));
    }
    if built.triangles.is_empty() {
        return Err("the file has no faces".to_owned());
    }
    let mesh = built.finish()?;
    Ok(ReadMesh { mesh, remarks: surface.remarks().into_iter().chain(remark_counts.remarks()).collect() })
}

/// The statements that define the surface, on the same lines as in the file; other lines are empty.
#[derive(Default)]
struct Surface {
    text: String,
    /// Lines of vertices that cannot be read; they have an index, but no face may refer to them.
    unreadable: Vec<usize>,
    /// Lines that are not valid OBJ.
    unknown: Vec<usize>,
    skipped: RemarkCounter,
    vertices: usize,
    /// Upper bound on the number of triangles.
    triangles: usize,
}

impl Surface {
    fn new(text: &str) -> Result<Self, String> {
        let mut surface = Self::default();
        // a carriage return alone ends a line, too: a comment must not hide what follows it
        let mut lines = text
            .lines()
            .flat_map(|line| line.trim_end_matches('\r').split('\r'))
            .map(without_comment)
            .zip(1..);
        while let Some(((mut line, mut continues), number)) = lines.next() {
            // a path may end in a backslash, too
            if !(continues && is_geometry(line)) {
                surface.add(line.split_whitespace(), number)?;
                surface.text.push('\n');
                continue;
            }
            // a backslash at a line's end joins the next line to it
            let mut words: Vec<&str> = Vec::new();
            let mut count = 1;
            loop {
                words.extend(line.split_whitespace());
                let Some((next, _)) = continues.then(|| lines.next()).flatten() else { break };
                (line, continues) = next;
                count += 1;
            }
            surface.add(words.into_iter(), number)?;
            surface.text.extend(std::iter::repeat_n('\n', count));
        }
        Ok(surface)
    }

    /// Adds a statement that begins at a line.
    fn add<'t>(&mut self, mut words: impl Iterator<Item = &'t str>, number: usize) -> Result<(), String> {
        let Some(word) = words.next() else { return Ok(()) };
        match word {
            "v" => self.add_position(words, number),
            // fo is an obsolete form of f
            "f" | "fo" => self.add_corners(words),
            _ => {
                if let Some((_, what)) = WITHOUT_SURFACE.iter().find(|(name, _)| *name == word) {
                    self.skipped.add(what, u32::try_from(number).ok());
                } else if let Some((_, why)) = NOT_READ.iter().find(|(name, _)| *name == word) {
                    return Err(format!("bad OBJ at line {number}: {word}: {why}"));
                } else if !OTHER_STATEMENTS.contains(&word) {
                    self.add_unknown(word, number)?;
                }
            }
        }
        Ok(())
    }

    /// Geometry statements in upper case are invalid, but ignoring a vertex or face would change the surface.
    fn add_unknown(&mut self, word: &str, number: usize) -> Result<(), String> {
        let lower = word.to_ascii_lowercase();
        if lower != word && (is_geometry(&lower) || NOT_READ.iter().any(|(name, _)| *name == lower)) {
            return Err(format!("bad OBJ at line {number}: '{word}' is no OBJ statement; write '{lower}'"));
        }
        self.unknown.push(number);
        Ok(())
    }

    /// `v x y z`, `v x y z w` (homogeneous), `v x y z r g b` and `v x y z r g b a` (colours, dropped).
    fn add_position<'t>(&mut self, words: impl Iterator<Item = &'t str>, line: usize) {
        self.vertices += 1;
        let mut words: Vec<&str> = words.collect();
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

    /// `1/2/3` refers to position 1, texture coordinate 2, normal 3.
    fn add_corners<'t>(&mut self, words: impl Iterator<Item = &'t str>) {
        self.text.push('f');
        let mut corners = 0_usize;
        for corner in words {
            corners += 1;
            let position = corner.split('/').next().unwrap_or_default();
            // an empty position would be ignored and change the polygon: tobj rejects it
            let position = if position.is_empty() { "?" } else { position };
            self.text.push(' ');
            self.text.push_str(position);
        }
        self.triangles += corners.saturating_sub(2);
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
        .chain(self.skipped.remarks())
        .collect()
    }
}

/// A line without its comment, and whether a backslash joins the next line to it.
fn without_comment(line: &str) -> (&str, bool) {
    let is_start = |at: &usize| *at == 0 || line[..*at].ends_with(char::is_whitespace);
    let comment = line.match_indices('#').map(|(at, _)| at).find(is_start);
    let line = comment.map_or(line, |at| &line[..at]);
    match line.trim_end().strip_suffix('\\') {
        Some(joined) if comment.is_none() => (joined, true),
        _ => (line, false),
    }
}

/// True if a line's statement is part of the geometry.
fn is_geometry(line: &str) -> bool {
    let word = line.split_whitespace().next().unwrap_or_default();
    let is_named = |list: &[(&str, &str)]| list.iter().any(|(name, _)| *name == word);
    matches!(word, "v" | "f" | "fo") || is_named(&WITHOUT_SURFACE) || is_named(&NOT_READ)
}

/// Adds the faces of a model, whose vertices are those of `built` from `first`.
fn append_faces(
    mesh: &tobj::Mesh,
    first: usize,
    built: &mut MeshBuilder,
    triangulator: &mut Triangulator,
    remark_counts: &mut RemarkCounter,
) -> Result<(), String> {
    // tobj leaves the arities empty when all are 3
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
            remark_counts.add(TOO_FEW_CORNERS, None);
            continue;
        }
        let points: Option<Vec<Point>> =
            (corners.iter()).map(|&c| built.vertices.get(first + c as usize).copied()).collect();
        let points = points.ok_or("bad OBJ: a face names a vertex that the file does not have")?;
        for triple in triangulator.triangulate(&points)? {
            built.push(triple.map(|k| first + corners[k] as usize))?;
        }
    }
    Ok(())
}

/// A reader that counts the lines read from it, since `tobj` gives no line in its errors.
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
    fn statements_without_surface_are_counted() {
        for (statement, what) in
            [("l 1 2", "lines"), ("p 1", "points"), ("curv 0 1 1 2", "curves"), ("curv2 1 2", "curves")]
        {
            let text = format!("{SQUARE}{statement}\nf 1 2 3\n{statement} \\\n 3 4\n");
            let read = read(&text).unwrap();
            assert_eq!(read.mesh.triangles().len(), 1);
            assert!(read.remarks[0].starts_with(&format!("2 {what}")), "{:?}", read.remarks);
            assert!(read.remarks[0].ends_with("the first at line 10"), "{:?}", read.remarks);
            assert_eq!(read.remarks.len(), 1);
        }
    }

    #[test]
    fn surfaces_that_are_not_read_are_rejected() {
        for statement in
            ["surf 0 1 0 1 1 2 3 4", "bzp 1 2 3 4", "bsp 1 2 3 4", "cdp 1 2 3 4", "call b.obj", "csh ls"]
        {
            let message = read(&format!("{SQUARE}f 1 2 3\n{statement}\n")).unwrap_err();
            let word = statement.split(' ').next().unwrap();
            assert!(message.contains("line 11") && message.contains(word), "{message}");
        }
        for statement in ["F 2 3 4", "V 0 0 0", "FO 2 3 4", "SURF", "Call b.obj", "L 1 2"] {
            let message = read(&format!("{SQUARE}f 1 2 3\n{statement}\n")).unwrap_err();
            assert!(
                message.contains("line 11") && message.contains("is no OBJ statement; write"),
                "{message}"
            );
        }
        assert_eq!(triangles(&format!("{SQUARE}f 1 2 3\nfo 1 3 4\n")), 2);
    }

    #[test]
    fn every_line_end_ends_a_line() {
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0 # third\nv 0 0 1\nf 1 2 3\n# top\nf 1 2 4\n";
        for mixed in [
            text.to_owned(),
            text.replace('\n', "\r\n"),
            text.replace('\n', "\r\r\n"),
            text.replace('\n', "\r"),
            text.replace("1 2 4", "1 2 \\\n4").replace('\n', "\r\r\n"),
            text.replace("# third\n", "# third\r").replace("# top\n", "# top\r"),
            text.replacen('\n', "\r", 1),
        ] {
            let mesh = read(&mixed).unwrap().mesh;
            assert_eq!((mesh.vertices().len(), mesh.triangles().len()), (4, 2), "{mixed:?}");
        }
    }

    #[test]
    fn lines_are_joined_but_comments_and_paths_are_not() {
        for text in [
            "v 0 0 \\\n 0\nv 1 0 0\nv 1 1 0\nf 1 2 \\\n3",
            "# a comment \\\nv 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3 # end \\\nl 1 2",
            "v 0 0 0\nv 1 0 0\nv 1 1 0\nmtllib C:\\\nf 1 2 3\\",
            "v 0 0 0 # x\nv 1 0 0 # x\nv 1 1 0 #\nf 1 2 3 #x",
        ] {
            let read = read(text).unwrap_or_else(|e| panic!("{e}: {text}"));
            assert_eq!(read.mesh.triangles().len(), 1, "{text}");
            assert_eq!(read.mesh.vertices().len(), 3, "{text}");
        }
        assert!(read("v 0 0 \\\n 0\nv 1 0 0\nv 1 1 0\nf 1 2 \\\n x").unwrap_err().contains("line 5"));
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
    fn foreign_lines_are_reported() {
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
