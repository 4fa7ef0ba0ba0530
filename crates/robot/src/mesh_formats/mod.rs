//! Mesh file readers. A format is recognised by the content of the file; the name only decides ambiguous cases.

mod dae;
mod gltf;
mod mesh_builder;
pub(super) mod mesh_memory;
mod obj;
mod ply;
mod polygon;
mod remark_counter;
mod stl;

use clearance_files::ply_format::is_ply;
use clearance_geometry::TriangleMesh;

/// A mesh in the file's own units (metres for COLLADA, which contains its unit), with remarks.
#[derive(Debug)]
pub(super) struct ReadMesh {
    pub mesh: TriangleMesh,
    pub remarks: Vec<String>,
}

impl From<TriangleMesh> for ReadMesh {
    fn from(mesh: TriangleMesh) -> Self {
        Self { mesh, remarks: Vec::new() }
    }
}

/// Reads a file that a mesh file references by name.
pub(super) type Parts<'f> = &'f mut dyn FnMut(&str) -> Result<Vec<u8>, String>;

/// Memory of a parsed text, as a multiple of its size.
const COPIES: usize = 3;

const FORMATS: &str = "STL, OBJ, DAE, PLY, glTF and GLB";

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    BinaryStl,
    AsciiStl,
    Obj,
    Dae,
    Ply,
    Gltf,
    Glb,
}

/// Reads a mesh file; `extension` is in lower case.
///
/// # Errors
/// The reason why the file contains no mesh, without quotes of its content.
pub(super) fn read(bytes: Vec<u8>, extension: &str, parts: Parts) -> Result<ReadMesh, String> {
    let format = recognise(&bytes, extension)?;
    mesh_memory::check(bytes.len().saturating_mul(COPIES))
        .map_err(|e| format!("its {} bytes {e}", bytes.len()))?;
    let mut read = match format {
        Format::BinaryStl => stl::read_binary(bytes),
        Format::AsciiStl => stl::read_ascii(&text(&bytes)),
        Format::Obj => obj::read(&text(&bytes)),
        Format::Dae => dae::read(&text(&bytes)),
        Format::Ply => ply::read(&bytes),
        Format::Gltf => gltf::read_text(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes), parts),
        Format::Glb => gltf::read_binary(&bytes, parts),
    }?;
    let (name, usual) = match format {
        Format::BinaryStl => ("a binary STL", "stl"),
        Format::AsciiStl => ("an ASCII STL", "stl"),
        Format::Obj => ("an OBJ", "obj"),
        Format::Dae => ("a COLLADA file", "dae"),
        Format::Ply => ("a PLY", "ply"),
        Format::Gltf => ("a glTF", "gltf"),
        Format::Glb => ("a binary glTF", "glb"),
    };
    if extension != usual {
        let remark = format!("is {name} by what it holds, though its name ends in '.{extension}'");
        read.remarks.push(remark);
    }
    Ok(read)
}

fn recognise(bytes: &[u8], extension: &str) -> Result<Format, String> {
    let start = bytes.trim_ascii_start();
    let start = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(start).trim_ascii_start();
    if bytes.is_empty() {
        return Err("the file is empty".to_owned());
    }
    if is_ply(bytes) {
        return Ok(Format::Ply);
    }
    if bytes.starts_with(gltf::MAGIC) {
        return Ok(Format::Glb);
    }
    if stl::has_binary_length(bytes) {
        return Ok(Format::BinaryStl);
    }
    if [&b"\xff\xfe"[..], b"\xfe\xff"].iter().any(|mark| bytes.starts_with(mark)) || is_utf16(bytes) {
        return Err("the file is UTF-16 text; save it as UTF-8".to_owned());
    }
    if [&b"\x1f\x8b"[..], b"PK\x03\x04"].iter().any(|mark| bytes.starts_with(mark)) {
        return Err("the file is compressed; unpack it".to_owned());
    }
    if start.starts_with(b"<") {
        return Ok(Format::Dae);
    }
    if starts_with_word(start, b"solid") && stl::looks_ascii(start) {
        return Ok(Format::AsciiStl);
    }
    if start.starts_with(b"{") {
        return Ok(Format::Gltf);
    }
    match extension {
        "ply" => Ok(Format::Ply),
        "gltf" => Ok(Format::Gltf),
        "glb" => Ok(Format::Glb),
        "stl" => Ok(Format::BinaryStl),
        "obj" => Ok(Format::Obj),
        "dae" => Ok(Format::Dae),
        other => Err(format!("'.{other}' is no mesh format that is read; those are {FORMATS}")),
    }
}

fn starts_with_word(bytes: &[u8], word: &[u8]) -> bool {
    bytes.split_at_checked(word.len()).is_some_and(|(head, rest)| {
        head.eq_ignore_ascii_case(word) && rest.first().is_none_or(u8::is_ascii_whitespace)
    })
}

/// ASCII characters with a zero byte between them.
fn is_utf16(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(64) & !1];
    let zeros = |odd: usize| head.iter().skip(odd).step_by(2).all(|&b| b == 0);
    let letters = |odd: usize| {
        head.iter().skip(odd).step_by(2).all(|b| b.is_ascii_graphic() || b.is_ascii_whitespace())
    };
    head.len() >= 8 && ((zeros(0) && letters(1)) || (zeros(1) && letters(0)))
}

/// Names and comments may be in any encoding; the numbers are ASCII in all of them.
fn text(bytes: &[u8]) -> std::borrow::Cow<'_, str> {
    String::from_utf8_lossy(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn no_parts(name: &str) -> Result<Vec<u8>, String> {
        Err(format!("no part {name}"))
    }

    #[test]
    fn the_content_decides() {
        let ascii = b"solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n\
            endloop\nendfacet\nendsolid s";
        let mesh = read(ascii.to_vec(), "obj", &mut no_parts).unwrap();
        assert_eq!(mesh.mesh.triangles().len(), 1);
        assert!(mesh.remarks[0].contains("ASCII STL"), "{:?}", mesh.remarks);
        assert!(read(ascii.to_vec(), "stl", &mut no_parts).unwrap().remarks.is_empty());
    }

    #[test]
    fn what_is_no_mesh_is_named() {
        for (bytes, extension, word) in [
            (&b""[..], "stl", "empty"),
            (b"\xff\xfev\x000\x00", "obj", "UTF-16"),
            (b"\0v\0 \x000\0 \x000\0 ", "obj", "UTF-16"),
            (b"\x1f\x8b\x08", "stl", "compressed"),
            (b"<html><body>not found</body></html>", "stl", "COLLADA"),
            (b"hello", "stl", "bytes"),
            (b"hello", "fbx", "'.fbx'"),
            (b"hello", "ply", "PLY"),
            (b"hello", "glb", "GLB"),
            (b"hello", "gltf", "glTF"),
            (b"{}", "stl", "glTF"),
            (b"glTF", "stl", "GLB"),
            (b"ply\n", "stl", "PLY"),
        ] {
            let message = read(bytes.to_vec(), extension, &mut no_parts).unwrap_err();
            assert!(message.contains(word), "{message}");
        }
    }
}
