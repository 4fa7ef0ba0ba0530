//! Quotes names in messages, and shortens names that are too long to be intended.

/// Maximum number of listed names; a message must not grow with hostile input.
const LISTED: usize = 8;

/// `'a', 'b' and 3 more`
#[must_use]
pub fn quoted_list(names: &[String]) -> String {
    let mut text: Vec<String> = names.iter().take(LISTED).map(|n| quoted(n)).collect();
    if names.len() > LISTED {
        text.push(format!("{} more", names.len() - LISTED));
    }
    match text.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, others)) => format!("{} and {last}", others.join(", ")),
        None => String::new(),
    }
}

/// A name in quotes, shortened if it is too long to be intended.
#[must_use]
pub fn quoted(name: &str) -> String {
    const LONGEST: usize = 80;
    match name.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("'{}…'", &name[..end]),
        None => format!("'{name}'"),
    }
}
