//! Validation of single fields of requests: lengths of lists, numbers and timeouts.

use std::time::{Duration, Instant};

use crate::services::request_rejection::{RequestRejection, bad_request};

/// Rejects a list that does not have one number for each joint.
pub fn of_equal_length(what: &str, numbers: &[f64], joints: &[String]) -> Result<(), RequestRejection> {
    if numbers.len() == joints.len() {
        return Ok(());
    }
    Err(bad_request(format!(
        "{what} has {} numbers, but joint_names has {} names",
        numbers.len(),
        joints.len()
    )))
}

/// Rejects a number with the given unit that is negative or not finite.
pub fn not_negative(name: &str, unit: &str, value: f64) -> Result<(), RequestRejection> {
    if value.is_finite() && value >= 0.0 {
        return Ok(());
    }
    Err(bad_request(format!("{name} is {value} {unit}, but must be finite and not negative")))
}

/// Deadline of a timeout (s) that started at `started`. A timeout of 0 selects `usual`; one beyond the range of the
/// clock gives no deadline.
pub fn deadline(
    timeout: f64,
    usual: Option<Duration>,
    started: Instant,
) -> Result<Option<Instant>, RequestRejection> {
    not_negative("timeout", "s", timeout)?;
    // a tiny timeout becomes zero and ends at once
    let timeout = if timeout > 0.0 { Duration::try_from_secs_f64(timeout).ok() } else { usual };
    Ok(timeout.and_then(|timeout| started.checked_add(timeout)))
}
