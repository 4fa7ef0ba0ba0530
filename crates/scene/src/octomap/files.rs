//! Reads OctoMap's `.bt` and `.ot` files: parses their headers, and decodes the tree with `decode`.

use super::{Octomap, OctomapError, decode};

const BINARY: &[u8] = b"# Octomap OcTree binary file";
const FULL: &[u8] = b"# Octomap OcTree file";
/// The first four bytes of the oldest `.bt` files, before the resolution (f64) and the number of nodes (u32).
const OLD_BINARY: [u8; 4] = [3, 0, 0, 0];

/// Content of a header.
struct Header {
    id: String,
    size: usize,
    resolution: f64,
    /// Offset of the tree.
    end: usize,
}

impl Octomap {
    /// True if the bytes start like a `.bt` or `.ot` file.
    #[must_use]
    pub fn is_file(bytes: &[u8]) -> bool {
        bytes.starts_with(BINARY) || bytes.starts_with(FULL)
    }

    /// Reads a `.bt` or `.ot` file, recognised by its content.
    pub fn from_file(bytes: &[u8]) -> Result<Self, OctomapError> {
        if bytes.starts_with(FULL) { Self::from_ot_file(bytes) } else { Self::from_bt_file(bytes) }
    }

    /// Reads a `.bt` file: which cells are occupied and which free.
    pub fn from_bt_file(bytes: &[u8]) -> Result<Self, OctomapError> {
        let header = if bytes.starts_with(BINARY) {
            Header::read(bytes)?
        } else {
            Header::read_old(bytes).ok_or(OctomapError::NoOctomap)?
        };
        let cells = decode::binary(&bytes[header.end..], header.end, header.size)?;
        Self::new(header.resolution, cells)
    }

    /// Reads an `.ot` file: the probability of every cell.
    pub fn from_ot_file(bytes: &[u8]) -> Result<Self, OctomapError> {
        if !bytes.starts_with(FULL) {
            return Err(OctomapError::NoOctomap);
        }
        let header = Header::read(bytes)?;
        // the name in the oldest files
        let id = if header.id == "1" { "OcTree" } else { &header.id };
        if header.size > 0 && bytes.len() == header.end {
            return Err(OctomapError::Truncated { byte: header.end });
        }
        Self::new(header.resolution, decode::full(id, &bytes[header.end..], header.end)?)
    }
}

impl Header {
    fn read(bytes: &[u8]) -> Result<Self, OctomapError> {
        let (mut id, mut size, mut resolution) = (None, None, None);
        let mut at = 0;
        for line in bytes.split_inclusive(|&b| b == b'\n') {
            at += line.len();
            let line = String::from_utf8_lossy(line);
            let mut words = line.split_whitespace();
            let key = words.next().unwrap_or_default();
            let value = &words.collect::<Vec<_>>().join(" ");
            match key {
                "id" => once("id", &mut id, value.clone())?,
                "size" => once("size", &mut size, number("size", value)?)?,
                "res" => once("res", &mut resolution, number("res", value)?)?,
                "data" => {
                    return Ok(Self {
                        id: id.ok_or(OctomapError::Incomplete("id"))?,
                        size: size.ok_or(OctomapError::Incomplete("size"))?,
                        resolution: resolution.ok_or(OctomapError::Incomplete("res"))?,
                        end: at,
                    });
                }
                // comments, and entries added by later versions
                _ => {}
            }
        }
        Err(OctomapError::Incomplete("data"))
    }

    fn read_old(bytes: &[u8]) -> Option<Self> {
        let rest = bytes.strip_prefix(&OLD_BINARY)?;
        let resolution = f64::from_le_bytes(*rest.first_chunk()?);
        let size = u32::from_le_bytes(*rest.get(8..)?.first_chunk()?) as usize;
        Some(Self { id: "OcTree".to_owned(), size, resolution, end: 16 })
    }
}

/// Sets an entry that the header may have once.
fn once<T: PartialEq>(key: &'static str, entry: &mut Option<T>, value: T) -> Result<(), OctomapError> {
    match entry.replace(value) {
        Some(before) if entry.as_ref() != Some(&before) => Err(OctomapError::Contradiction(key)),
        _ => Ok(()),
    }
}

fn number<T: std::str::FromStr>(key: &'static str, value: &str) -> Result<T, OctomapError> {
    let value: String = value.chars().take(40).collect();
    value.parse().map_err(|_| OctomapError::BadHeader { key, value })
}
