//! Command line program: each subcommand has one file under `cli/`.

use std::process::ExitCode;

mod cli;

fn main() -> ExitCode {
    cli::run()
}
