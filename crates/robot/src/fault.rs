//! Error in an input text and its source location: element, file and line.

use clearance_files::readable_text::on_one_line;

/// A location in an input: file, line, and the element concerned. Any part may be unknown.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// Name of the file.
    pub file: Option<String>,
    /// Line number, from 1.
    pub line: Option<u32>,
    /// Such as `link 'arm' collision 'tip'` or `joint 'j1'`.
    pub element: Option<String>,
}

/// An error in an input: location, cause, and what to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Location of the error.
    pub place: Place,
    /// Cause of the error, and what to do.
    pub message: String,
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (&self.file, self.line) {
            (Some(file), Some(line)) => write!(f, "{file}:{line}: ")?,
            (Some(file), None) => write!(f, "{file}: ")?,
            (None, Some(line)) => write!(f, "line {line}: ")?,
            (None, None) => {}
        }
        match &self.element {
            Some(element) => write!(f, "{element}: "),
            None => Ok(()),
        }
    }
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&on_one_line(&format!("{}{}", self.place, self.message)))
    }
}

impl std::error::Error for Fault {}
