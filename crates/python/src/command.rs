//! The command `clearance`: the same command line as that of the binary.

use std::ffi::OsString;
use std::io::Write;

use pyo3::prelude::*;

/// Runs the command line, program name first, and returns its exit code.
///
/// The caller has given SIGINT its default action, so that signals act as on the binary.
#[pyfunction]
#[pyo3(name = "_run_command")]
pub fn run_command(py: Python<'_>, command_line: Vec<OsString>) -> u8 {
    py.detach(|| {
        let code = clearance::cli::run(&command_line).code();
        // at the end of a Rust program its runtime does this; a closed pipe is not an error
        let _ = std::io::stdout().flush();
        code
    })
}
