//! The file that a certificate is written to.

use std::path::Path;

use clearance::motion::Certificate;
use clearance_files::input_files;

use super::failure::Failure;

/// Checks that a certificate can be written there.
pub fn check(file: &Path) -> Result<(), Failure> {
    input_files::check_target(file).map_err(Failure::input)
}

/// Removes the file that a certificate will replace: without a new certificate, no older one must remain in its place.
pub fn remove(file: &Path) -> Result<(), Failure> {
    // standard output must not be removed, wherever it leads
    let is_device = ["/dev", "/proc"].iter().any(|folder| file.starts_with(folder));
    let Ok(existing) = file.canonicalize() else { return Ok(()) };
    if is_device || !existing.is_file() {
        return Ok(());
    }
    std::fs::remove_file(&existing).map_err(|e| Failure::Input(format!("{}: {e}", file.display())))
}

/// Writes a certificate as JSON.
pub fn write(file: &Path, certificate: &Certificate) -> Result<(), Failure> {
    let text = certificate.to_json() + "\n";
    input_files::write(file, text.as_bytes()).map_err(Failure::input)
}
