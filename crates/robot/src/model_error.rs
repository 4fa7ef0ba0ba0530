//! Error of a robot description: the list of its faults, cut after twenty.

use super::{Fault, Place};

/// Maximum number of errors listed in one message.
const MOST_FAULTS: usize = 20;

/// Errors of a robot description: all of them, as far as one does not hide another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ModelError {
    /// The errors, at most a fixed number of them; the last one counts the rest.
    pub faults: Vec<Fault>,
}

impl std::fmt::Display for ModelError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (i, fault) in self.faults.iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            write!(f, "{fault}")?;
        }
        Ok(())
    }
}

impl std::error::Error for ModelError {}

impl From<Fault> for ModelError {
    fn from(fault: Fault) -> Self {
        Self { faults: vec![fault] }
    }
}

impl ModelError {
    /// `value`, if there are no errors.
    pub(super) fn unless_sound<T>(value: T, faults: Vec<Fault>) -> Result<T, Self> {
        if faults.is_empty() { Ok(value) } else { Err(Self::from(faults)) }
    }
}

impl From<Vec<Fault>> for ModelError {
    /// A thoroughly wrong text has thousands of errors; only the first ones are useful.
    fn from(mut faults: Vec<Fault>) -> Self {
        let more = faults.len().saturating_sub(MOST_FAULTS);
        faults.truncate(MOST_FAULTS);
        if more > 0 {
            faults.push(Fault { place: Place::default(), message: format!("and {more} more faults") });
        }
        Self { faults }
    }
}
