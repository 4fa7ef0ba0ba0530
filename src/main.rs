//! Command line program: each subcommand has one file under `cli/`.

use std::process::ExitCode;

fn main() -> ExitCode {
    #[cfg(unix)]
    block_file_size_signal();
    let command_line: Vec<_> = std::env::args_os().collect();
    clearance::cli::run(&command_line).into()
}

/// Blocks SIGXFSZ in this thread and in all threads that it starts. A write beyond the limit of file sizes (`ulimit -f`,
/// `LimitFSIZE` of systemd) then returns an error, as on a full disk, instead of ending the process: a recording ends,
/// and the node continues.
#[cfg(unix)]
fn block_file_size_signal() {
    use nix::sys::signal::{SigSet, Signal};
    let mut blocked = SigSet::empty();
    blocked.add(Signal::SIGXFSZ);
    // if it fails, such a write ends the process
    let _ = blocked.thread_block();
}
