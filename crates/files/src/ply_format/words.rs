//! Splits the text part of a file, such as a PLY header, into lines and words.

/// A line without its end, and what follows; `None` at the end.
pub fn next_line(bytes: &[u8]) -> Option<(std::borrow::Cow<'_, str>, &[u8])> {
    if bytes.is_empty() {
        return None;
    }
    let end = bytes.iter().position(|&b| b == b'\n');
    let (line, rest) = end.map_or((bytes, &[][..]), |end| (&bytes[..end], &bytes[end + 1..]));
    Some((String::from_utf8_lossy(line.strip_suffix(b"\r").unwrap_or(line)), rest))
}

/// The words of a file's text part, each as text; a word that is no text cannot be a number and becomes an odd one.
pub fn words(bytes: &[u8]) -> impl Iterator<Item = &str> {
    (bytes.split(u8::is_ascii_whitespace))
        .filter(|word| !word.is_empty())
        .map(|word| std::str::from_utf8(word).unwrap_or("\u{fffd}"))
}

/// A word of the file, short enough for a message.
pub fn quoted(word: &str) -> String {
    let mut short: String = word.chars().take(40).collect();
    if short.len() < word.len() {
        short.push('…');
    }
    format!("'{short}'")
}
