//! GLB: a glTF document and its first buffer in one binary file.

/// Magic bytes of a GLB.
pub const MAGIC: &[u8] = b"glTF";
const HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;
const JSON: u32 = u32::from_le_bytes(*b"JSON");
const BINARY: u32 = u32::from_le_bytes(*b"BIN\0");

/// The parts of a GLB.
pub struct Glb<'d> {
    pub json: &'d [u8],
    pub buffer: Option<&'d [u8]>,
    /// Bytes behind the end that the header gives.
    pub surplus: usize,
}

impl<'d> Glb<'d> {
    /// # Errors
    /// If the file is truncated, has another version, or does not begin with its document.
    pub fn open(bytes: &'d [u8]) -> Result<Self, String> {
        let (Some(version), Some(length)) = (number(bytes, 4), number(bytes, 8)) else {
            return Err("bad GLB: the file ends in its header".to_owned());
        };
        if version != 2 {
            return Err(format!("bad GLB: version {version} is not read; version 2 is"));
        }
        let length = length as usize;
        let Some(content) = bytes.get(HEADER..length) else {
            let has = bytes.len();
            return Err(format!(
                "bad GLB: the header says {length} bytes, but the file has {has}: it is cut"
            ));
        };
        let (kind, json, rest) = chunk(content)?;
        if kind != JSON {
            return Err("bad GLB: its first chunk is no JSON".to_owned());
        }
        let buffer = match rest {
            [] => None,
            rest => Some(chunk(rest)?).filter(|(kind, ..)| *kind == BINARY).map(|(_, buffer, _)| buffer),
        };
        Ok(Self { json, buffer, surplus: bytes.len() - length })
    }
}

/// Kind and content of the first chunk, and what follows it.
fn chunk(bytes: &[u8]) -> Result<(u32, &[u8], &[u8]), String> {
    let (length, kind) =
        number(bytes, 0).zip(number(bytes, 4)).ok_or("bad GLB: the file ends in a chunk's header")?;
    let content = bytes.get(CHUNK_HEADER..).unwrap_or_default();
    let (content, rest) = content.split_at_checked(length as usize).ok_or_else(|| {
        format!("bad GLB: a chunk says {length} bytes, but {} follow: the file is cut", content.len())
    })?;
    Ok((kind, content, rest))
}

fn number(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}
