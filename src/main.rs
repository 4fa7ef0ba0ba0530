//! Command line program: each subcommand has one file under `cli/`.

use std::process::ExitCode;

fn main() -> ExitCode {
    let command_line: Vec<_> = std::env::args_os().collect();
    clearance::cli::run(&command_line).into()
}
