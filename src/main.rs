//! Command line program: each subcommand has one file under `cli/`.

use std::process::ExitCode;

fn main() -> ExitCode {
    clearance::cli::run(std::env::args_os().collect()).into()
}
