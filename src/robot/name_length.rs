//! The longest name that is read anywhere.

use super::numbers::shortened;
use crate::constants::LONGEST_NAME;

/// Checks that a name of a robot, link, joint, frame or object has at most [`LONGEST_NAME`] bytes.
///
/// # Errors
/// A clause with the start of the name, its length and the limit.
pub(crate) fn check_name_length(name: &str) -> Result<(), String> {
    if name.len() <= LONGEST_NAME {
        return Ok(());
    }
    let (start, bytes) = (shortened(name), name.len());
    Err(format!("the name '{start}' has {bytes} bytes, more than the limit of {LONGEST_NAME}"))
}
