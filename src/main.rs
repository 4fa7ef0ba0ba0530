//! The command line: one subcommand, one file under `cli/`.

use std::process::ExitCode;

mod cli;

fn main() -> ExitCode {
    cli::run()
}
