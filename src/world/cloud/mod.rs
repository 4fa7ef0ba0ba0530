//! Clouds of points from files (PCD, PLY), and from any bytes that hold records.
//!
//! The parsers are our own: the crates that read these formats build a value for every number of every field, or do not
//! know compressed PCD, and trust the counts of the header.

mod lzf;
mod pcd;
mod ply;
mod points;

pub use points::{ByteOrder, CloudError, CloudPoints, Column, Columns, NumberKind};

/// Whether the bytes begin as a cloud file does that [`read_cloud`] knows.
#[must_use]
pub fn is_cloud(bytes: &[u8]) -> bool {
    ply::is_ply(bytes) || pcd::is_pcd(bytes)
}

/// The points of a PCD or PLY file, which is recognised by what it holds.
///
/// # Errors
/// What the file lacks or where it contradicts itself.
pub fn read_cloud(bytes: &[u8]) -> Result<CloudPoints, CloudError> {
    if ply::is_ply(bytes) {
        ply::read(bytes)
    } else if pcd::is_pcd(bytes) {
        pcd::read(bytes)
    } else {
        Err(CloudError("the file is neither a PCD nor a PLY by what it holds".to_owned()))
    }
}

/// A line without its end, and what follows; `None` at the end.
fn next_line(bytes: &[u8]) -> Option<(std::borrow::Cow<'_, str>, &[u8])> {
    if bytes.is_empty() {
        return None;
    }
    let end = bytes.iter().position(|&b| b == b'\n');
    let (line, rest) = end.map_or((bytes, &[][..]), |end| (&bytes[..end], &bytes[end + 1..]));
    Some((String::from_utf8_lossy(line.strip_suffix(b"\r").unwrap_or(line)), rest))
}

/// The words of a file's text part, each as text; a word that is no text cannot be a number and becomes an odd one.
fn words(bytes: &[u8]) -> impl Iterator<Item = &str> {
    (bytes.split(u8::is_ascii_whitespace))
        .filter(|word| !word.is_empty())
        .map(|word| std::str::from_utf8(word).unwrap_or("\u{fffd}"))
}

/// A word of the file, short enough for a message.
fn quoted(word: &str) -> String {
    let mut short: String = word.chars().take(40).collect();
    if short.len() < word.len() {
        short.push('…');
    }
    format!("'{short}'")
}
