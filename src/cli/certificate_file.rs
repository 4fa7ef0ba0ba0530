//! Writes a certificate to a file; replaces only an older certificate.

use std::path::Path;

use clearance::motion::Certificate;
use clearance_files::input_files::{self, STATES_LIMIT};

use super::failure::Failure;

/// How a certificate begins, of whatever kind and version.
const BEGINNING: &str = "{\"format\":\"clearance ";

/// Checks that a certificate can be written there: nothing is there, or another certificate. Any other file may be one of the user's.
pub fn check(file: &Path) -> Result<(), Failure> {
    input_files::check_target(file).map_err(Failure::input)?;
    let is_certificate =
        |text: String| text.is_empty() || text.starts_with(BEGINNING) && text.contains("certificate");
    if !file.is_file() || input_files::read_text(file, STATES_LIMIT).is_ok_and(is_certificate) {
        return Ok(());
    }
    let message = "is there already, and is no certificate: choose another name, or remove it";
    Err(Failure::Input(format!("{}: {message}", file.display())))
}

/// Removes the file that a certificate will replace: without a new certificate, no older one must remain in its place.
pub fn remove(file: &Path) -> Result<(), Failure> {
    let Ok(existing) = file.canonicalize() else { return Ok(()) };
    if is_device(file) || !existing.is_file() {
        return Ok(());
    }
    std::fs::remove_file(&existing).map_err(|e| Failure::Input(format!("{}: {e}", file.display())))
}

/// Writes a certificate as JSON.
pub fn write(file: &Path, certificate: &Certificate) -> Result<(), Failure> {
    let text = certificate.to_json() + "\n";
    let written = if is_device(file) {
        input_files::write(file, text.as_bytes())
    } else {
        input_files::replace(file, text.as_bytes())
    };
    written.map_err(Failure::input)
}

/// Standard output must not be removed or replaced, wherever it leads.
fn is_device(file: &Path) -> bool {
    ["/dev", "/proc"].iter().any(|folder| file.starts_with(folder))
}
