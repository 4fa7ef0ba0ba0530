//! Strings for C: texts with a final NUL, and lists of names.

use std::ffi::{CString, c_char};
use std::ptr;

/// A text with its final NUL. A NUL inside, which no name should have, becomes U+FFFD.
pub fn c_text(text: &str) -> CString {
    CString::new(text.replace('\0', "\u{fffd}")).unwrap_or_default()
}

/// Names by number.
#[derive(Debug, Default)]
pub struct Names(Vec<CString>);

impl Names {
    /// A copy of these names.
    pub fn new<'a>(names: impl IntoIterator<Item = &'a str>) -> Self {
        Self(names.into_iter().map(c_text).collect())
    }

    /// Adds texts; earlier ones stay where they are.
    pub fn extend<'a>(&mut self, texts: impl IntoIterator<Item = &'a str>) {
        self.0.extend(texts.into_iter().map(c_text));
    }

    /// Number of names.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// A name, valid as long as these names; null beyond the last.
    pub fn get(&self, index: usize) -> *const c_char {
        self.0.get(index).map_or(ptr::null(), |name| name.as_ptr())
    }
}
