//! Maximum length of all names.

use clearance_geometry::constants::LONGEST_NAME;

use super::decimal_numbers::shortened;

/// Checks that a name of a robot, link, joint, frame or object has at most [`LONGEST_NAME`] bytes.
///
/// # Errors
/// A clause with the start of the name, its length and the limit.
pub fn check_name_length(name: &str) -> Result<(), String> {
    if name.len() <= LONGEST_NAME {
        return Ok(());
    }
    let (start, bytes) = (shortened(name), name.len());
    Err(format!("the name '{start}' has {bytes} bytes, more than the limit of {LONGEST_NAME}"))
}
