//! Where the shared truth and robots lie.

use std::path::{Path, PathBuf};

/// The folder of shared robots, cases and truths, beside the project.
///
/// # Panics
/// When it is not there: a test that cannot run must not pass.
pub fn shared() -> PathBuf {
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared");
    shared.canonicalize().unwrap_or_else(|e| {
        panic!("this test needs the folder {}, which is not there: {e}", shared.display())
    })
}

/// A JSON file of the shared folder.
pub fn shared_json(path: &str) -> serde_json::Value {
    let path = shared().join(path);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}
