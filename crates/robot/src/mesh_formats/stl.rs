//! Reader of STL, binary and ASCII, through `stl_io`.
//!
//! `stl_io` recognises ASCII files by a leading `solid `, reads only the first solid of such a file, and requires lower case. Both kinds
//! are therefore converted first to a form that it reads correctly.

use std::borrow::Cow;
use std::io::Cursor;

use clearance_geometry::TriangleMesh;
use clearance_geometry::math::Point;

use super::ReadMesh;
use super::mesh_builder::MeshBuilder;
use crate::decimal_numbers::shortened;

const HEADER: usize = 84;
const TRIANGLE: usize = 50;

/// True if the file has exactly the length that follows from its triangle count: then it is binary, whatever its header.
pub(super) fn has_binary_length(bytes: &[u8]) -> bool {
    triangle_count(bytes).is_some_and(|count| count > 0 && expected_length(count) == bytes.len())
}

/// True if a text that begins with `solid` continues like an ASCII STL.
pub(super) fn looks_ascii(bytes: &[u8]) -> bool {
    // the name may be longer than the part that is searched
    let name_end = bytes.iter().position(|byte| matches!(byte, b'\n' | b'\r')).unwrap_or_default();
    begins_with_statements(bytes) || begins_with_statements(&bytes[name_end..])
}

fn begins_with_statements(bytes: &[u8]) -> bool {
    let head = bytes[..bytes.len().min(4096)].to_ascii_lowercase();
    let has = |word: &[u8]| head.windows(word.len()).any(|w| w == word);
    has(b"facet") || has(b"endsolid") || has(b"end solid")
}

fn triangle_count(bytes: &[u8]) -> Option<usize> {
    let count: [u8; 4] = bytes.get(80..HEADER)?.try_into().ok()?;
    usize::try_from(u32::from_le_bytes(count)).ok()
}

fn expected_length(count: usize) -> usize {
    count.saturating_mul(TRIANGLE).saturating_add(HEADER)
}

/// # Errors
/// If the length does not match the triangle count: the file is truncated, or is not STL.
pub(super) fn read_binary(mut bytes: Vec<u8>) -> Result<ReadMesh, String> {
    let Some(count) = triangle_count(&bytes) else {
        let (has, hint) = (bytes.len(), text_hint(&bytes));
        return Err(format!("{has} bytes are too few for an STL, which has a header of {HEADER}{hint}"));
    };
    let expected = expected_length(count);
    // real files may end in a few bytes of padding, but not in a whole additional triangle
    if bytes.len() < expected || bytes.len() >= expected + TRIANGLE {
        let hint = text_hint(&bytes);
        if !hint.is_empty() {
            return Err(format!("it is no binary STL{hint}"));
        }
        return Err(format!(
            "the header says {count} triangles, which are {expected} bytes, but the file has {}: it is cut, or no STL",
            bytes.len()
        ));
    }
    // a closed surface has half as many vertices as triangles
    MeshBuilder::default().reserve(count / 2, count)?;
    let surplus = bytes.len() - expected;
    // a header that begins with "solid " would be taken for ASCII
    bytes[..80].fill(0);
    let mut read = indexed(&bytes)?;
    if surplus > 0 {
        read.remarks.push(format!("{surplus} bytes follow the last triangle"));
    }
    Ok(read)
}

/// Hint about the format of a text that was given as an STL; empty for binary data.
fn text_hint(bytes: &[u8]) -> &'static str {
    let head = &bytes[..bytes.len().min(512)];
    if head.is_empty() || !head.iter().all(|b| b.is_ascii_graphic() || b.is_ascii_whitespace()) {
        ""
    } else if looks_ascii(head) {
        "; it looks like an ASCII STL that lacks its first line, 'solid NAME'"
    } else {
        "; it looks like text, but an ASCII STL begins with 'solid'"
    }
}

/// # Errors
/// If a solid has wrong syntax, with its line; all solids of the file are read.
pub(super) fn read_ascii(text: &str) -> Result<ReadMesh, String> {
    let mut solid = String::with_capacity(text.len());
    solid.push_str("solid all\n");
    let mut facets = 0;
    let open = statements(text, |_, statement| {
        facets += usize::from(statement.starts_with("facet"));
        solid.push_str(statement);
        solid.push('\n');
    });
    MeshBuilder::default().reserve(facets / 2, facets)?;
    // a solid without its end means a truncated file
    if !open {
        solid.push_str("endsolid all\n");
    }
    indexed(solid.as_bytes()).map_err(|error| fault(text).unwrap_or(error))
}

/// The first misplaced statement, since `stl_io` reports no line.
fn fault(text: &str) -> Option<String> {
    const FACET: [&str; 7] =
        ["facet", "outer loop", "vertex x y z", "vertex x y z", "vertex x y z", "endloop", "endfacet"];
    let (mut place, mut fault) = (0, None);
    let open = statements(text, |line, statement| {
        let words: Vec<&str> = statement.split(' ').collect();
        let is_number = |word: &&str| word.parse::<f32>().is_ok_and(f32::is_finite);
        let fits = match (FACET[place], &words[..]) {
            ("vertex x y z", ["vertex", xyz @ ..]) => xyz.len() == 3 && xyz.iter().all(is_number),
            ("facet", ["facet", ..]) => true,
            (expected, _) => statement == expected,
        };
        place = (place + 1) % FACET.len();
        if !fits && fault.is_none() {
            let expected = FACET[(place + FACET.len() - 1) % FACET.len()];
            let found = shortened(statement);
            fault = Some(format!(
                "bad STL at line {line}: '{found}' stands where '{expected}' should, with finite numbers"
            ));
        }
    });
    let cut =
        || (open || place != 0).then(|| "bad STL: the file is cut, its last solid has no end".to_owned());
    fault.or_else(cut)
}

/// Calls `emit` with each statement, except the begin and end of solids, and its line; returns true if a solid is not closed.
///
/// Statements are converted to lower case, with one blank between words. They may be on any line, and their ends be written in one word
/// or two (`endloop`, `end loop`). Normals, which are not used, are set to zero, since degenerate facets are often published with the
/// normal `nan nan nan`.
fn statements(text: &str, mut emit: impl FnMut(usize, &str)) -> bool {
    let mut open = false;
    let mut plain = String::new();
    // old files may end lines with CR alone
    let ends_in_cr = !text.contains('\n');
    for (line, number) in text.split('\n').zip(1..) {
        for (line, further) in line.split('\r').zip(0..) {
            let number = if ends_in_cr { number + further } else { number };
            let line = line.to_ascii_lowercase();
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            let mut rest = &words[..];
            while let Some((statement, others)) = first_statement(rest) {
                let arguments = others.iter().position(|word| is_keyword(word)).unwrap_or(others.len());
                rest = &others[arguments..];
                match &*statement {
                    // the rest of the line, up to the next facet, is a name
                    "solid" | "endsolid" => {
                        let begins = |pair: &[&str]| pair == ["facet", "normal"];
                        let facet = others.windows(2).position(begins);
                        open = statement == "solid" || facet.is_some();
                        rest = facet.map_or(&[][..], |at| &others[at..]);
                    }
                    "facet" => emit(number, "facet normal 0 0 0"),
                    // also text that is no statement: stl_io rejects it
                    other => {
                        plain.clear();
                        plain.push_str(other);
                        for argument in &others[..arguments] {
                            plain.push(' ');
                            plain.push_str(argument);
                        }
                        emit(number, &plain);
                    }
                }
            }
        }
    }
    open
}

/// The word that begins a statement, `end loop` as `endloop`, and the words after it.
fn first_statement<'w, 't>(words: &'w [&'t str]) -> Option<(Cow<'t, str>, &'w [&'t str])> {
    match *words {
        [] => None,
        ["end", what, ref rest @ ..] => Some((Cow::Owned(format!("end{what}")), rest)),
        [word, ref rest @ ..] => Some((Cow::Borrowed(word), rest)),
    }
}

/// Words that begin a statement.
fn is_keyword(word: &str) -> bool {
    matches!(word, "solid" | "endsolid" | "facet" | "endfacet" | "outer" | "endloop" | "vertex" | "end")
}

fn indexed(bytes: &[u8]) -> Result<ReadMesh, String> {
    let stl = stl_io::read_stl(&mut Cursor::new(bytes)).map_err(|e| format!("bad STL: {e}"))?;
    let vertices = (stl.vertices.iter()).map(|v| Point::from(v.0.map(f64::from))).collect();
    let triangles = (stl.faces.iter())
        .map(|f| index_triple(f.vertices))
        .collect::<Option<Vec<_>>>()
        .ok_or("more vertices than 32-bit indices can name")?;
    let mesh = TriangleMesh::new(vertices, triangles).map_err(|e| e.to_string())?;
    Ok(mesh.into())
}

fn index_triple(indices: [usize; 3]) -> Option<[u32; 3]> {
    let [a, b, c] = indices.map(u32::try_from);
    Some([a.ok()?, b.ok()?, c.ok()?])
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const FACET: &str = "facet normal nan nan nan\n outer loop\n vertex 0 0 0\n vertex 1 0 0\n vertex 0 1e0 0\n \
                         endloop\nendfacet\n";

    fn binary(header: &[u8], count: u32, triangles: usize) -> Vec<u8> {
        let mut bytes = vec![b' '; 80];
        bytes[..header.len()].copy_from_slice(header);
        bytes.extend(count.to_le_bytes());
        for i in 0..u8::try_from(triangles).unwrap() {
            let corners = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, f32::from(i)];
            bytes.extend(corners.iter().flat_map(|c| c.to_le_bytes()));
            bytes.extend([0, 0]);
        }
        bytes
    }

    #[test]
    fn several_solids_in_any_case_all_count() {
        let text = format!("SOLID\n{FACET}endsolid\nsolid b\n{}EndSolid b", FACET.to_uppercase());
        assert_eq!(read_ascii(&text).unwrap().mesh.triangles().len(), 2);
    }

    #[test]
    fn statements_are_read_however_they_are_spaced() {
        let words = FACET.replace("endloop", "end loop").replace("endfacet", "end facet");
        let text = format!("solid part 7\n{words}end solid part 7\n");
        let on_one_line = text.replace("part 7\n", "part 7\r").replace(" \n", " ").replace("\n ", " ");
        for text in [
            text.clone(),
            text.replace('\n', "\r\n"),
            text.replace('\n', "\r"),
            text.replace(' ', "\t"),
            text.replace(' ', "  \t "),
            text.to_uppercase(),
            text.replace("end loop", "End  Loop").replace("vertex", "Vertex"),
            on_one_line,
            "solid a facet\nfacet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0\nvertex 0 1 0 end loop end facet\nend solid"
                .to_owned(),
            // a name before statements, and a solid on one line
            format!("solid a {}", words.replace('\n', " ")) + " endsolid a\n",
        ] {
            let read = read_ascii(&text).unwrap_or_else(|e| panic!("{e}: {text:?}"));
            assert_eq!(read.mesh.triangles().len(), 1, "{text:?}");
            assert_eq!(read.mesh.bounds().1, Point::new(1.0, 1.0, 0.0));
            assert!(looks_ascii(text.as_bytes()));
        }
    }

    #[test]
    fn ascii_faults() {
        for text in [
            format!("solid a\n{FACET}"),
            format!("solid a\n{}endsolid", FACET.replace("1e0", "1,5")),
            format!("solid a\n{}endsolid", FACET.replace("endloop", "vertex 1 1 1\nendloop")),
            format!("solid a\n{}endsolid", FACET.replace("1e0", "inf")),
            "solid a\nendsolid a".to_owned(),
            format!("solid a\n{}endsolid", FACET.replace("endloop", "end")),
            format!("solid a\n{}endsolid", FACET.replace("endloop", "end hoop")),
            format!("solid a\n{}endsolid", FACET.replace("endloop", "")),
            format!("solid a\n{}endsolid", FACET.replace(" vertex 1 0 0", " vertex 1 0")),
            format!("solid a\n{}endsolid", FACET.replace(" vertex 1 0 0", " vertex 1 0 0 0")),
            format!("solid a\n{}", FACET.replace("endfacet", "end solid")),
        ] {
            assert!(read_ascii(&text).is_err(), "{text}");
        }
    }

    #[test]
    fn ascii_faults_name_the_line() {
        let of = |text: &str| read_ascii(text).unwrap_err();
        let facets = format!("solid a\n{FACET}{FACET}endsolid a\n");
        for (from, to, line) in [
            ("1e0", "1,5", 6),
            ("vertex 1 0 0", "vertex 1 0", 5),
            ("vertex 1 0 0", "vertex 1 0 nan", 5),
            ("outer loop", "outer", 3),
            ("endloop", "end hoop", 7),
            ("endfacet", "endfacet x", 8),
        ] {
            let text = facets.replacen(from, to, 1);
            for text in [text.clone(), text.replace('\n', "\r\n"), text.replace('\n', "\r")] {
                let message = of(&text);
                assert!(message.starts_with(&format!("bad STL at line {line}: ")), "{message}: {text:?}");
            }
        }
        assert!(of(&facets.replace("endsolid a\n", "")).contains("cut"));
        assert!(of(&facets.replacen("endfacet", "", 1)).contains("line 9"));
    }

    #[test]
    fn a_text_that_is_no_stl_is_distinguished_from_a_cut_binary() {
        let facets = FACET.repeat(3);
        assert!(
            read_binary(facets.clone().into_bytes())
                .unwrap_err()
                .contains("lacks its first line, 'solid NAME'")
        );
        assert!(read_binary(b"v 0 0 0\n".repeat(30)).unwrap_err().contains("looks like text"));
        assert!(read_binary(b"hello".to_vec()).unwrap_err().contains("looks like text"));
        assert!(read_binary(binary(b"x", 9, 2)).unwrap_err().contains("9 triangles"));
        for text in [format!("; made by hand\n{facets}"), facets] {
            let message =
                super::super::read(text.into_bytes(), "stl", &mut |_: &str| Err(String::new())).unwrap_err();
            assert!(message.contains("looks like") && !message.contains("triangles"), "{message}");
        }
    }

    #[test]
    fn a_name_may_be_long() {
        for line_end in ["\n", "\r\n", "\r"] {
            let text = format!("solid {}\n{FACET}endsolid", "x".repeat(200_000)).replace('\n', line_end);
            assert!(looks_ascii(text.as_bytes()));
            assert_eq!(read_ascii(&text).unwrap().mesh.triangles().len(), 1);
        }
        assert!(!looks_ascii(&[&b"solid "[..], &[b'x'; 9000], b"\nno statement"].concat()));
    }

    #[test]
    fn a_binary_file_may_begin_with_solid() {
        let bytes = binary(b"solid s", 3, 3);
        assert!(has_binary_length(&bytes));
        assert_eq!(read_binary(bytes).unwrap().mesh.triangles().len(), 3);
    }

    #[test]
    fn counts_must_fit() {
        assert!(read_binary(binary(b"", 3, 2)).unwrap_err().contains("3 triangles"));
        assert!(read_binary(binary(b"", 2, 3)).unwrap_err().contains("2 triangles"));
        assert!(read_binary(binary(b"", u32::MAX, 3)).is_err());
        let mut padded = binary(b"", 2, 2);
        padded.push(0);
        assert_eq!(read_binary(padded).unwrap().remarks.len(), 1);
    }

    proptest! {
        #[test]
        fn mutations_never_panic(at in 0usize..400, byte: u8, cut in 0usize..400) {
            let ascii = format!("solid a\n{FACET}{FACET}endsolid a");
            for mut bytes in [binary(b"x", 3, 3), ascii.into_bytes()] {
                let at = at % bytes.len();
                bytes[at] = byte;
                bytes.truncate(bytes.len() - cut.min(bytes.len()) / 4);
                let _ = super::super::read(bytes, "stl", &mut |_: &str| Err(String::new()));
            }
        }
    }
}
